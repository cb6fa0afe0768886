#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Macro problems end to end: macro.py problems|resume|devices BIN"""
import csv
import glob
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

import scene_tools
from scene_tools import faults, here, history, interrupt_when, kill_at_random, need, run, shipped, without_wall

case, binaries = sys.argv[1:3]
bvp = scene_tools.program(binaries, "grus-bvp")
sets = lambda changes: [a for c in changes for a in ("--set", c)]
numbers = lambda rows: [{k: float(v) for k, v in row.items()} for row in rows]
summary = lambda folder: json.load(open(os.path.join(folder, "summary.json")))


def go(scene, out, *changes, threads="2", ranks=None, more=()):
    launch = ["mpirun", "-n", ranks] if ranks else []
    r = run(*launch, bvp, scene, "-o", out, "--quiet", "--threads", threads, *sets(changes), *more)
    need(r.returncode == 0, f"{os.path.basename(scene)} {changes}: exit {r.returncode}: {r.stderr.strip()[-300:]}")
    return numbers(history(out))


def problems(tmp):
    """The first increments of the shipped problems, against what equilibrium demands."""
    scene = lambda name: os.path.join(shipped, name + ".toml")
    out = lambda name: os.path.join(tmp, name)

    def balanced(folder, rows, name):
        """What every explicit run must show: balance, energy, and the work of the stresses as that of the cells."""
        late = [r for r in rows if r["time_s"] > 0.3]
        need(late and all(abs(r["energy_error"]) < 0.01 for r in late),
             f"{name}: energy error {max(abs(r['energy_error']) for r in late)}")
        need(all(r["kinetic_over_internal"] < 0.02 for r in late),
             f"{name}: kinetic energy {max(r['kinetic_over_internal'] for r in late)}")
        need(
            sum(r["unbalanced_macro_force"] for r in late) / len(late) < 0.02,
            f"{name}: unbalanced {max(r['unbalanced_macro_force'] for r in late)}")
        balance = summary(folder)["errors"]["hill_mandel"]
        need(0 < balance < 0.01, f"{name}: work of the stresses and of the cells differ by {balance}")
        devices, last = summary(folder)["errors"]["devices"], rows[-1]
        need(devices["local_damping_of_cells"] == 0 and 0 < devices["haste_of_cells"] < 0.05,
             f"{name}: devices {devices}")
        done = max(abs(last["macro_external_J"]), abs(last["rve_work_J"]))
        need(
            abs(devices["macro_damping"] - last["macro_damped_J"] / done) < 1e-9 and 0 < devices["macro_damping"] < 0.3,
            f"{name}: devices {devices}")

    rows = go(scene("triaxial"), out("triaxial"), "mesh.box.cells=[2, 4]", "rve.variants=1",
              "boundary.1.displacement=[0, '-0.4 mm']", "rve.set=['preparation.pressure=5 MPa']", "output.frames=2")
    last = rows[-1]
    balanced(out("triaxial"), rows, "triaxial")
    need(
        abs(last["mean_stress_xx_Pa"] + 5e6) < 0.1 * 5e6,
        f"triaxial: radial stress {last['mean_stress_xx_Pa']} against a cell pressure of 5 MPa")
    need(last["mean_stress_yy_Pa"] < 1.02 * last["mean_stress_xx_Pa"], "triaxial: no deviator")
    need(
        abs(last["reaction_platen_y_N"] + last["reaction_middle_y_N"]) < 0.03 * abs(last["reaction_platen_y_N"]),
        "triaxial: platen and middle disagree")
    need(abs(last["moved_platen_y_m"] + 4e-4) < 1e-9, f"triaxial: the platen moved by {last['moved_platen_y_m']}")
    volume = -sum(last[f"mean_strain_{k}"] for k in ("xx", "yy", "zz"))
    need(
        abs(last["strain_volumetric"] - volume) < 0.05 * abs(volume) + 1e-4,
        f"triaxial: volume {last['strain_volumetric']}, sum of the mean strains {volume}")
    need(last["p_Pa"] > 5e6 and 0 < last["q_Pa"] < 3 * last["p_Pa"], f"triaxial: p {last['p_Pa']} q {last['q_Pa']}")
    need(os.path.exists(os.path.join(out("triaxial"), "macro.hdf.series")), "triaxial: no frames")
    # A probe of the whole specimen tells the means of the run.
    whole = os.path.join(tmp, "whole.toml")
    text = open(scene("triaxial")).read().replace('"sand_rve.toml"',
                                                  f'"{os.path.join(shipped, "sand_rve.toml")}"').replace(
                                                      "../../meshes", os.path.join(here, "..", "..", "meshes"))
    open(whole,
         "w").write(text + '\n[[probe]]\nname = "all"\nwhere = "x>0"\n[[probe]]\nname = "upper"\nwhere = "y>0.025"\n')
    last = go(whole, out("whole"), "boundary.1.displacement=[0, '-0.1 mm']", "rve.set=['preparation.pressure=5 MPa']",
              "output.frames=0", "solve.crossings=20", "rve.damping=0.2")[-1]
    taken = summary(out("whole"))["errors"]["devices"]["local_damping_of_cells"]
    need(0 < taken < 1, f"damped cells: of the work a share of {taken} is taken by their damping")
    for k in ("xx", "yy", "zz", "yz", "xz", "xy"):
        half = 0.5 if k[0] != k[1] else 1
        need(abs(last[f"probe_all_strain_{k}"] - half * last[f"mean_strain_{k}"]) < 1e-12, f"probe of all: strain {k}")
        need(abs(last[f"probe_all_stress_{k}_Pa"] - last[f"mean_stress_{k}_Pa"]) < 1e-3, f"probe of all: stress {k}")
    need(
        last["probe_all_breakages"] == last["breakages"] > last["probe_upper_breakages"] >= 0
        and 0.4 < last["probe_all_void_ratio"] < 0.9, "probe of all: breakages, void ratio")
    rows = go(scene("biaxial_plane_strain"), out("biaxial"), "boundary.1.displacement=[0, '-0.5 mm']",
              "mesh.box.cells=[4, 8]", "rve.set=[]", "output.frames=0")
    last, area = rows[-1], 0.05
    balanced(out("biaxial"), rows, "biaxial")
    need(
        abs(last["reaction_top_y_N"] / area / last["mean_stress_yy_Pa"] - 1) < 0.05,
        f"biaxial: platen {last['reaction_top_y_N'] / area} Pa, mean {last['mean_stress_yy_Pa']} Pa")
    need(abs(last["mean_stress_xx_Pa"] + 1e5) < 0.1e5, f"biaxial: lateral stress {last['mean_stress_xx_Pa']}")
    need(abs(last["mean_strain_yy"] + 5e-3) < 3e-5, "biaxial: strain")
    newton = go(scene("biaxial_plane_strain"), out("newton"), "boundary.1.displacement=[0, '-0.5 mm']",
                "mesh.box.cells=[4, 8]", "rve.set=[]", "output.frames=0", "solve.kind=quasi-static",
                "solve.increments=5", "rve.unbalanced_force=5e-3", "rve.stress_change=5e-3", "rve.damping=0")
    need(
        abs(last["mean_stress_yy_Pa"] / newton[-1]["mean_stress_yy_Pa"] - 1) < 0.015,
        f"biaxial: {last['mean_stress_yy_Pa']} without iterations, {newton[-1]['mean_stress_yy_Pa']} with")
    rows = go(scene("strip_footing"), out("footing"), "boundary.0.displacement=[0, '-2 mm']", "output.frames=0",
              "solve.crossings=60")
    balanced(out("footing"), rows, "footing")
    need(rows[-1]["reaction_footing_y_N"] < -1e5 * 0.5 * 1.5,
         f"footing: {rows[-1]['reaction_footing_y_N']} N carries little more than the surcharge beside it")
    # The ground at rest: what is horizontal is k0 of what is vertical, and the weight of the bed is on its base.
    rest = go(scene("strip_footing"), out("rest"), "boundary.0.displacement=[0, '-0.01 mm']", "output.frames=0",
              "solve.crossings=20", "rve.set=['preparation.pressure=350 kPa', 'material.sand.fracture=']")
    first, depth = rest[0], 0.5
    need(
        abs(first["mean_stress_xx_Pa"] / first["mean_stress_yy_Pa"] - 0.5) < 0.05,
        f"footing: K0 {first['mean_stress_xx_Pa'] / first['mean_stress_yy_Pa']}")
    need(
        abs(first["reaction_bottom_y_N"] / (0.8 * (5e5 + 1500 * 9.81 * depth)) - 1) < 0.02,
        f"footing: {first['reaction_bottom_y_N']} N on the base of the bed")
    # Bars: before the wave has come back the gauge shows sigma / E; v = sigma / (rho c).
    rows = go(scene("shpb_bars"), out("bars"), "solve.duration=230 us", "output.frames=0")
    plateau = [r["probe_incident_strain_yy"] for r in rows if 1.9e-4 < r["time_s"] < 2.2e-4]
    need(
        abs(sum(plateau) / len(plateau) / (-120e6 / 200e9) - 1) < 0.02,
        f"bars: incident strain {sum(plateau) / len(plateau)}, sigma / E is {-120e6 / 200e9}")
    need(max(abs(r["macro_energy_error"]) for r in rows[20:]) < 0.02, "bars: energy")
    balance = summary(out("bars"))["errors"]["hill_mandel"]
    need(0 < balance < 5e-3, f"bars: work of the stresses and energy of the materials differ by {balance}")
    with open(os.path.join(out("bars"), "hopkinson.csv"), newline="") as f:
        need(len(next(csv.reader(f))) == 13, "bars: hopkinson.csv")


def resume(tmp):
    """Killed and interrupted at any moment, then resumed with other threads and ranks: the same history."""
    block = [
        os.path.join(shipped, "oedometer_block.toml"), "mesh.box.cells=[1,1,2]", "rve.variants=2",
        "boundary.0.displacement=['free','free',-3e-4]", "solve.increments=5", "rve.adaptivity.share=1e-3",
        "rve.adaptivity.error=0.02", "rve.adaptivity.elastic=0.02", "rve.tangent=quasi-newton", "output.frames=3",
        "output.checkpoint_interval=1e-3"
    ]
    impact = [os.path.join(here, "macro", "impact.toml"), "output.checkpoint_interval=1e-3"]
    steady = [
        os.path.join(shipped, "triaxial.toml"), "mesh.box.cells=[2, 4]", "rve.variants=1",
        "boundary.1.displacement=[0, '-0.5 mm']", "rve.set=['preparation.pressure=5 MPa']", "output.frames=3",
        "output.checkpoint_interval=0.1", "regularisation.length='2 mm'"
    ]

    def one(name, scene, *changes):
        whole, part = os.path.join(tmp, name + "_whole"), os.path.join(tmp, name + "_part")
        begin = time.time()
        rows = go(scene, whole, *changes, threads="1")
        within = 0.08 * (time.time() - begin)  # five kills leave time for more
        need(rows[-1]["breakages"] > 20, f"{name}: {rows[-1]['breakages']} breakages")
        checkpoint = os.path.join(part, "checkpoint.h5")
        command = [bvp, scene, "-o", part, "--quiet", *sets(changes)]
        seed = random.randrange(1 << 30)
        killed = kill_at_random(
            lambda k: (["mpirun", "-n", "2"]
                       if k % 2 else []) + [*command, "--threads", str(1 + (k + 1) % 2)] + (["--resume"] if k else []),
            lambda: os.path.exists(checkpoint), 5, random.Random(seed), within)
        need(killed >= 2, f"{name}: killed {killed} times before the end (seed {seed})")
        p = subprocess.Popen(["mpirun", "-n", "2", *command, "--threads", "1", "--resume"], stdout=subprocess.DEVNULL,
                             start_new_session=True)
        before = os.path.getmtime(checkpoint)
        interrupt_when(p, lambda: os.path.getmtime(checkpoint) != before, signal.SIGTERM)
        r = run(*command, "--threads", "2", "--resume")
        need(r.returncode == 0, f"{name}: resume: exit {r.returncode} {r.stderr}")
        need(without_wall(whole) == without_wall(part), f"{name}: history.csv differs after kill and resume")
        need(
            open(os.path.join(whole, "macro.hdf.series")).read() == open(os.path.join(part, "macro.hdf.series")).read(),
            f"{name}: other frames")
        r = run(*command, "--resume", "--set", "rve.unbalanced_force=0.02")
        need(r.returncode == 2 and "another scene: rve.unbalanced_force was" in r.stderr and r.stderr.count("\n") == 1,
             f"{name}: other settings: {r.stderr!r}")
        data = open(checkpoint, "rb").read()
        for spoiled in (data[: len(data) // 2], b"nothing", data[:60000] + bytes([data[60000] ^ 1]) + data[60001:]):
            open(checkpoint, "wb").write(spoiled)
            r = run(*command, "--resume")
            need(r.returncode == 2 and r.stderr.count("\n") == 1 and "checkpoint" in r.stderr,
                 f"{name}: damaged: exit {r.returncode} {r.stderr!r}")

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda what: one(*what), [("block", *block), ("impact", *impact), ("steady", *steady)]))
    in_midst(tmp)
    r = run(bvp, block[0], "-o", os.path.join(tmp, "nowhere"), "--resume")
    need(r.returncode == 2 and "no checkpoint" in r.stderr and not os.path.exists(os.path.join(tmp, "nowhere")),
         f"nothing to resume: {r.stderr!r}")


def in_midst(tmp):
    """Newton is stopped in the midst of an increment, at once: what was committed is kept, the rest begun anew, with
    the tangents and counts of a run that was never stopped. Where RVEs are put off, the increment is ended first."""
    scene = os.path.join(shipped, "oedometer_block.toml")
    block = ["mesh.box.cells=[1,1,2]", "rve.variants=2", "boundary.0.displacement=['free','free',-3e-4]",
             "solve.increments=5", "rve.tangent=quasi-newton", "output.frames=3"]
    whole = os.path.join(tmp, "midst_whole")
    rows = go(scene, whole, *block, threads="1")
    lasts = max(b["wall_s"] - a["wall_s"] for a, b in zip(rows, rows[1:]))
    within = first = 0
    for k, changes in enumerate((block, [*block, "rve.adaptivity.error=0.02"])):
        out = os.path.join(tmp, f"midst_{k}")
        done = lambda: len(history(out)) if os.path.exists(os.path.join(out, "history.csv")) else 0
        command = [bvp, scene, "-o", out, "--threads", "1", *sets(changes)]
        for share in (0.2, 0.5, 0.8):
            more = ["--resume"] if os.path.exists(os.path.join(out, "checkpoint.h5")) else ["--force"]
            p = subprocess.Popen([*command, *more], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                 start_new_session=True)
            before = done() if more == ["--resume"] else 0
            while p.poll() is None and done() <= before:
                time.sleep(0.005)
            time.sleep(share * lasts)
            then, begin = done(), time.time()
            p.send_signal(signal.SIGINT)
            said = p.communicate()[0]
            took = time.time() - begin
            if p.returncode == 0:
                continue  # it was over before
            need(p.returncode == 130, f"stopped in the midst: exit {p.returncode}")
            ended = "ends with this increment, as RVEs were put off" in said
            need(ended <= (k == 1), f"said {said[-300:]!r}")
            need(k == 1 or took < 2.5 + 0.5 * lasts, f"took {took} s to stop, an increment {lasts}")
            within += k == 0 and done() == then
            first += ended
        r = run(*command, "--resume")
        need(r.returncode == 0, f"stopped in the midst: resume: exit {r.returncode} {r.stderr}")
        need(k == 1 or without_wall(whole) == without_wall(out), "stopped in the midst: another history")
    need(within > 0, "no increment was stopped in its midst")
    need(first > 0, "no increment with RVEs that were put off was ended first")
    out = os.path.join(tmp, "midst_first")
    p = subprocess.Popen([bvp, scene, "-o", out, "--threads", "1", *sets([*block, "solve.increments=1"])],
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    said = next((line for line in p.stdout if "material sweeps" in line), "")
    children = "".join(open(path).read() for path in glob.glob(f"/proc/{p.pid}/task/*/children"))
    need(not children, f"one rank has started other processes: {children}")
    p.send_signal(signal.SIGTERM)
    said += p.communicate()[0]
    need(p.returncode == 130 and "within the first increment; nothing to go on from yet" in said
         and not os.path.exists(os.path.join(out, "checkpoint.h5")), f"first increment: {p.returncode} {said[-300:]!r}")


def devices(tmp):
    """What sharing and deferral leave out, what they say of their error, and that off is off; elastic regions;
    --check."""
    scene = os.path.join(shipped, "oedometer_block.toml")
    common = ("mesh.box.cells=[1,1,2]", "rve.variants=1", "boundary.0.displacement=['free','free',-4e-4]",
              "solve.increments=8", "probe=", "output.frames=0", "rve.stress_change=1e-3", "rve.unbalanced_force=1e-3")
    plain = go(scene, os.path.join(tmp, "plain"), *common)
    off = go(scene, os.path.join(tmp, "off"), *common, "rve.adaptivity.share=0", "rve.adaptivity.error=0")
    strip = lambda rows: [{k: v for k, v in r.items() if k != "wall_s"} for r in rows]
    need(strip(plain) == strip(off), "devices that are off change the result")
    lazy = go(scene, os.path.join(tmp, "lazy"), *common, "rve.adaptivity.share=1e-3", "rve.adaptivity.error=0.05")
    facts = summary(os.path.join(tmp, "lazy"))
    need(facts["counts"]["rves_advanced"] < 0.7 * facts["counts"]["rves_asked"], f"little left out: {facts['counts']}")
    need(facts["errors"]["sharing"]["tolerance_strain"] == 1e-3 and facts["errors"]["deferral"]["tolerance"] == 0.05,
         "errors are not reported")
    for device, count in (("sharing", "measured_at_replays"), ("deferral", "measured")):
        told = facts["errors"][device]
        need((told[count] > 0) == (told["worst"] is not None) == (told["mean"] is not None), f"{device}: {told}")
    need(
        abs(lazy[-1]["mean_stress_zz_Pa"] / plain[-1]["mean_stress_zz_Pa"] - 1) < 0.15,
        f"{lazy[-1]['mean_stress_zz_Pa']} against {plain[-1]['mean_stress_zz_Pa']}")
    # Half of the block is steel: stress is the same in both halves, the sand takes the strain.
    steel = os.path.join(tmp, "steel.toml")
    text = open(scene).read().replace('scene = "sand_rve.toml"', f'scene = "{os.path.join(shipped, "sand_rve.toml")}"')
    open(steel, "w").write(
        text +
        '\n[[region]]\nwhere = "z<0.01"\nmaterial = "elastic"\nyoungs_modulus = "200 GPa"\npoissons_ratio = 0.3\n')
    mixed = go(steel, os.path.join(tmp, "mixed"), *common[:2], "boundary.0.displacement=['free','free',-1e-4]",
               "solve.increments=2", "probe=", "output.frames=0", "solve.displacement_tolerance=0.02")
    last = mixed[-1]
    need(last["rves"] == 8 and abs(last["grains_strain_zz"] + 0.01) < 5e-4,
         f"steel and sand: {last['rves']} RVEs, strain of the sand {last['grains_strain_zz']}")
    need(abs(last["grains_stress_zz_Pa"] / last["mean_stress_zz_Pa"] - 1) < 0.05, "steel and sand: stresses differ")

    # Regions alone: a pressure on a confined block does p^2 V / 2 M, and the block holds it.
    done = 1e6**2 * 0.02**3 / (2 * 1e8 * 0.8 / (1.2 * 0.6))
    block = os.path.join(here, "macro", "regions.toml")
    last = go(block, os.path.join(tmp, "regions"))[-1]
    for name in ("macro_external_J", "macro_internal_J", "macro_work_J"):
        need(abs(last[name] / done - 1) < 1e-5, f"regions: {name} {last[name]}, p^2 V / 2 M is {done}")
    need(abs(last["energy_error"]) < 1e-6, f"regions: energy error {last['energy_error']}")
    told = summary(os.path.join(tmp, "regions"))["errors"]
    need(told["hill_mandel"] < 1e-6 and abs(told["macro_work_J"] / done - 1) < 1e-5, f"regions: {told}")
    out = os.path.join(tmp, "steps")
    last = go(block, out, "solve.kind=explicit-quasi-static", "solve.increments=")[-1]
    held, into = last["macro_internal_J"], last["macro_external_J"] - last["macro_damped_J"]
    need(abs(into / held - 1) < 0.01 and abs(held / done - 1) < 0.02, f"regions, explicit: {into} J in, {held} J held")
    counted = summary(out)["counts"]["material_sweeps"]
    need(counted == last["increment"] + 1, f"regions, explicit: {counted} sweeps in {last['increment']} steps")


with tempfile.TemporaryDirectory() as folder:
    {"problems": problems, "resume": resume, "devices": devices}[case](folder)
print(f"macro {case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
