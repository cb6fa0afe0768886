#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run of grus-rve tells of itself is so: strengths, stresses held and ended at, what a preparation made, energy;
told.py BIN"""
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

import checkpoint_bytes
import scene_tools
from scene_tools import BRITTLE, ROCK, faults, history, need, run, shipped, write

rve = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-rve")
report = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-report")
SAND = """
[material.s]
density = 2650
youngs_modulus = "{modulus}"
poissons_ratio = 0.2
friction = 0.5
restitution = {restitution}
damping = 0.2
[packing]
kind = "random"
box = ["{box}", "{box}", "{box}"]
radius = {{ distribution = "uniform", min = "{low}", max = "{high}" }}
solid_fraction = {fraction}
[boundary]
kind = "periodic"
"""
STIFF = SAND.format(modulus="10 GPa", restitution=0.9, box="8 mm", low="0.8 mm", high="1.2 mm",
                    fraction=0.53) + '[preparation]\npressure = "1 MPa"\nfriction = 0.2\n'
TRIAXIAL = STIFF + '[loading]\nkind = "triaxial"\nconfining_pressure = "1 MPa"\nstrain_rate = 20\nfinal_strain = 0.05\n'
SOFT = SAND.format(modulus="1 GPa", restitution=0.5, box="5 mm", low="0.4 mm", high="0.6 mm", fraction=0.56)
DROP = """
[material.glass]
density = "2500 kg/m^3"
youngs_modulus = "10 MPa"
[[grain]]
radius = "5 mm"
position = [0, 0, "0.02 m"]
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
[loading]
kind = "free"
duration = "0.4 s"
gravity = [0, 0, -9.81]
"""


def test(tmp, name, text, *more, status=0):
    path, out = os.path.join(tmp, name + ".toml"), os.path.join(tmp, name)
    with open(path, "w") as f:
        f.write(text)
    r = run(rve, path, "-o", out, "--force", "--threads", "1", *more)
    need(r.returncode == status, f"{name}: exit {r.returncode} {r.stderr}")
    with open(os.path.join(out, "summary.json")) as f:
        return json.load(f), r.stdout, out


def strengths(tmp):
    """A grain that did not break has no strength; one that did has that of the step in which it did, whatever the
    rows."""
    with open(os.path.join(shipped, "single_grain.toml")) as f:
        scene = f.read()
    whole, _, out = test(tmp, "whole", scene, "--set", "loading.final_strain=0.01", "--set", "output.frames=0")
    results = whole["results"]
    need(whole["counts"]["breakages"] == 0 and "peak_before_breakage_Pa" not in results, f"a whole grain: {results}")
    rows = [float(x["axial_stress_Pa"]) for x in history(out)]
    need(results["peak_axial_stress_is_last"] and abs(results["final_axial_stress_Pa"] / rows[-1] - 1) < 1e-9,
         f"a whole grain's last row: {results}")
    need("final_void_ratio" not in results, "a void ratio without a volume")
    broken, _, out = test(tmp, "broken", scene, "--set", "loading.final_strain=0.1", "--set", "output.frames=0")
    rows = [float(x["axial_stress_Pa"]) for x in history(out)]
    intact = max(p for p, x in zip(rows, history(out)) if float(x["breakages"]) == 0)
    results = broken["results"]
    need(broken["counts"]["breakages"] > 0 and intact <= results["peak_before_breakage_Pa"] < 1.02 * intact,
         f"a broken grain: {results}, {intact}")
    need(results["peak_axial_stress_Pa"] >= max(rows), "the peak is below a row")
    need(results["peak_axial_stress_is_last"] == (abs(results["peak_axial_stress_Pa"] / rows[-1] - 1) < 1e-8),
         "a broken grain's peak and last row")
    found = [test(tmp, f"rows{interval}", scene, "--set", "loading.final_strain=0.05", "--set", "output.frames=0",
                  "--set", f"output.history_interval={interval}", "--set", "numerics.fracture_every=1")[0]["results"]
             for interval in (2e-4, 0.05)]
    seldom, often = (f["peak_before_breakage_Pa"] for f in found)
    need(abs(seldom / often - 1) < 1e-3, f"a strength by its rows: {seldom}, {often}")
    need(found[1]["peak_axial_stress_Pa"] >= often, f"a peak that is seen in no row: {found[1]}")


def lateral(tmp):
    """The lateral stress is held to 1 % of what is asked; where inertia forbids it, that is said everywhere."""
    s, said, out = test(tmp, "held", TRIAXIAL)
    told = s["errors"]["lateral_stress"]
    rows = history(out)[1:]
    off = [max(abs(-float(x[f"stress_{k}_Pa"]) / 1e6 - 1) for k in ("xx", "yy")) for x in rows]
    need(
        abs(told["mean"] - sum(off) / len(off)) < 1e-6 and abs(told["worst"] - max(off)) < 1e-6 and
        abs(told["last"] - off[-1]) < 1e-6,
        f"held: told {told}, rows {sum(off) / len(off)}")
    need(max(abs(float(x["lateral_stress_error"]) - o) for x, o in zip(rows, off)) < 1e-6, "held: another column")
    need(told["mean"] < 0.01 and "lateral stress" not in said, f"held at 20/s: {told} {said}")
    walls = TRIAXIAL.replace('"periodic"', '"walls"').replace('[preparation]\npressure = "1 MPa"\nfriction = 0.2\n', "")
    s, said, out = test(tmp, "walls", walls.replace("= 20\n", "= 50\n"), "--set", "numerics.safety=0.2")
    told, rows = s["errors"]["lateral_stress"], history(out)
    late = rows[len(rows) // 4:]  # the walls have found the sample
    off = [abs(-float(x[f"wall_stress_{k}_Pa"]) / 1e6 - 1) for x in late for k in ("xx", "yy")]
    need(told["mean"] < 0.01 and max(off) < 0.005 and "lateral stress" not in said,
         f"held between walls at 50/s: {told}, then {max(off)} {said}")
    s, said, out = test(tmp, "fast",
                        walls.replace("= 20\n", "= 100\n").replace("final_strain = 0.05", "final_strain = 0.01"),
                        "--set", "output.history_interval=0.001")
    need(
        s["errors"]["lateral_stress"]["mean"] > 0.01 and any("lateral stress" in n for n in s["notes"])
        and "note: the lateral stress" in said, f"too fast: {s['errors']} {said}")
    if report:
        r = run(report, out)
        need(r.returncode == 0 and "the lateral stress was off" in open(os.path.join(out, "report.html")).read(),
             f"report: {r.stderr}")


def preparation(tmp):
    """A void ratio that the preparation has changed is told by --check, console, summary, before and after a resume."""
    path = os.path.join(tmp, "held.toml")
    r = run(rve, path, "--check", "--threads", "1")
    need(r.returncode == 0 and "preparation: the packing has a void ratio of 0.887" in r.stdout, f"--check: {r.stdout}")
    s, said, out = test(tmp, "prepared", TRIAXIAL, "--set", "output.checkpoint_interval=0.01", "--set",
                        "output.grading=true")
    row = history(out)[0]
    first = float(row["void_ratio"])
    shown = re.search(r"  d10 (\S+) mm   d50 (\S+) mm   d90 (\S+) mm   Cu = d60/d10 (\S+)\n", r.stdout)
    sizes = [1e3 * float(row[f"d{k}_m"]) for k in (10, 50)]
    need(shown and shown[0] in said and all(abs(float(a) / b - 1) < 1e-3 for a, b in zip(shown.groups(), sizes)) and
         sizes[1] < float(shown[4]) * sizes[0] < float(shown[3]), f"sizes of grains: {shown}, {sizes}")
    p = s["preparation"]
    need(
        abs(p["packed_void_ratio"] - (1 / 0.53 - 1)) < 0.01 and abs(p["void_ratio"] - first) < 1e-6
        and abs(s["sample"]["void_ratio"] - first) < 1e-6, f"prepared: {p} {s['sample']} {first}")
    need(max(abs(got / 1e6 - 1) for got in p["stress_Pa"]) <= 0.03 and "note: preparation:" in said, f"prepared: {p}")
    resumed = run(rve, os.path.join(tmp, "prepared.toml"), "-o", out, "--resume", "--quiet", "--threads", "1", "--set",
                  "output.checkpoint_interval=0.01", "--set", "output.grading=true")
    again = json.load(open(os.path.join(out, "summary.json")))
    need(again["seconds"]["cpu"] > 0.98 * s["seconds"]["cpu"],  # what came after the last checkpoint is run again
         f"CPU time of both parts: {again['seconds']}, {s['seconds']}")
    need(resumed.returncode == 0 and all(again.get(k) == s.get(k) for k in ("notes", "preparation", "sample")),
         f"resumed: {again.get('notes')}")


def pressed(tmp):
    """A pressure that contacts cannot bear: refused where no packing could bear it, else told when it shows."""
    high, small = STIFF.replace('"1 MPa"', '"1 GPa"') + TRIAXIAL[len(STIFF):], "numerics.max_overlap=2"
    soft, less = high.replace('"10 GPa"', '"1 GPa"'), high.replace('"1 GPa"', '"300 MPa"')
    for name, scene, more, status, words in (
            ("beforehand", soft, (), 2, "preparation.pressure: 1e+03 MPa is too high for this contact stiffness: at "),
            ("too_deep", less, (), 3, "a radius (limit 20 %, numerics.max_overlap); lower the pressure, or make the "),
            ("no_voids", high, ("--set", small), 3, "grains have filled all voids; lower the pressure")):
        path, out = write(tmp, scene, name + ".toml"), os.path.join(tmp, name)
        for how in (("--check",), ("-o", out)) if status == 2 else (("-o", out),):
            r = run(rve, path, *how, "--threads", "1", *more)
            place = re.match(re.escape(path) + r":\d+:\d+: preparation\.pressure: ", r.stderr)
            told = words in r.stderr and r.stderr.count("\n") == 1 and place
            need(r.returncode == status and told, f"{name}: exit {r.returncode} {r.stderr}")
            need("void ratio" not in r.stdout and not os.path.exists(out), f"{name}: {r.stdout}")
            if status == 3:  # it stops soon after the limit, not when all is over
                at = float(re.search(r"at (\S+) MPa", r.stderr)[1])
                deepest = float((re.search(r"overlap by (\d+) %", r.stderr) or (0, 20))[1])
                need(at < 0.75 * float(re.search(r"of (\S+) MPa", r.stderr)[1]) and deepest < 25, f"{name}: {r.stderr}")


def cells(tmp):
    """What the preparation makes of a cell is told of a macro problem's as of the cell alone: the same numbers."""
    bvp = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-bvp")
    if not bvp:
        return
    write(tmp, TRIAXIAL, "cell.toml")
    block, out, often = write(tmp, BLOCK), os.path.join(tmp, "block"), ("--set", "output.checkpoint_interval=1e-9")
    alone = run(rve, os.path.join(tmp, "cell.toml"), "--check", "--threads", "1", "--set", "numerics.safety=0.7").stdout
    note = re.search(r"preparation: the packing has a void ratio of 0\.887 .*begins the test at (\S+) .*", alone)
    checked = run(bvp, block, "--check", "--threads", "1").stdout
    ran = run(bvp, block, "-o", out, "--threads", "1", *often)
    told = scene_tools.summary(out)
    for where, said in (("--check", checked), ("run", ran.stdout), ("notes", str(told.get("notes")))):
        need(note and said.count("unit cell: " + note[0]) == 1, f"a cell of grus-bvp, {where}: {said} {alone}")
    sums = told["preparation"]
    near = note and abs(sums["void_ratio"][0] - float(note[1])) < 6e-4
    near = near and abs(sums["packed_void_ratio"][1] - (1 / 0.53 - 1)) < 0.01 and sums["worst_stress_error"] < 0.03
    need(near and sums["starts"] == 1 and sums["asked_pressure_Pa"] == [1e6, 1e6], f"a cell of grus-bvp: {sums}")
    errors = told["errors"]
    known = set(NEWTON) <= set(errors) and errors["last_worst_unbalanced_force"] > 0
    need(known and re.search("run: .* to .* sweeps", checked), f"errors of increments: {errors} {checked}")
    # A mesh of 1 mm is smaller than a grain of 2 mm; the mesh's sides are told. Of an element alone that is no fault.
    need("mesh 0.001 x 0.001 x 0.001 m" in checked and "larger than the whole mesh, which measures 0.001" in checked,
         f"the mesh's size: {checked}")
    need(told["mesh"] == {"low_m": [0, 0, 0], "high_m": [0.001] * 3}, f"the mesh's size: {told['mesh']}")
    # A resumed run knows it from preparation.h5, and has solved for as long as both parts together.
    need(os.path.exists(os.path.join(out, "preparation.h5")), "no preparation.h5")
    pretended = {"wall": 70, "cpu": 80, "sweeps_wall": 90, "worst_residual": 9}
    checkpoint_bytes.pretend_seconds(os.path.join(out, "checkpoint.h5"), **pretended)
    again = run(bvp, block, "-o", out, "--resume", "--threads", "1", *often)
    after = scene_tools.summary(out)
    same = (after["preparation"], after["notes"], after["errors"]["worst_residual"]) == (sums, told["notes"], 9)
    need(again.returncode == 0 and same, f"resumed: {again.stderr} {after.get('preparation')} {after['notes']}")
    now = after["seconds"]
    longer = now["solve_wall"] >= 70 and now["cpu_rank0"] >= 80 and now["rve_sweeps_wall"] >= 90
    need(longer and now["solve_wall"] >= float(history(out)[-1]["wall_s"]) > 0, f"seconds of both parts: {now}")


def ends(tmp):
    """A final stress is met within a step, and the time that is left is told from the stress; also when interrupted."""
    for name, more, box in (
            ("by_strain", "strain_rate = 20\n", "periodic"),
            ("by_stress", 'strain_rate = 100\ncontrol = "stress"\nstress_rate = "200 MPa/s"\n', "periodic"),
            ("between_walls", "strain_rate = 20\n", "walls")):
        scene = SOFT.replace('"periodic"', f'"{box}"').replace(
            "0.56", "0.53") + f'[loading]\nkind = "oedometric-stress"\nfinal_stress = "2 MPa"\n{more}'
        s, said, out = test(tmp, name, scene)
        final = s["results"]["final_axial_stress_Pa"] / 2e6 - 1
        need(0 <= final < 0.005, f"{name}: ends {100 * final:.2f} % above what is asked")
        rows = [float(x["axial_stress_Pa"]) for x in history(out)]
        need(
            max(rows[:-1]) < 2e6 <= rows[-1] and abs(rows[-1] / s["results"]["final_axial_stress_Pa"] - 1) < 1e-9,
            f"{name}: another last row")
    command = [rve, os.path.join(tmp, "by_strain.toml"), "-o", os.path.join(tmp, "part"), "--quiet", "--threads", "1",
               "--set", "output.checkpoint_interval=0.02"]
    kept = os.path.join(tmp, "part", "checkpoint.h5")
    for k in range(4):  # interrupted anywhere, once there is something to go on from
        p = subprocess.Popen(command + (["--resume"] if k else []))
        while p.poll() is None and not os.path.exists(kept):
            time.sleep(0.01)
        time.sleep(0.3)
        p.send_signal(signal.SIGINT)
        if p.wait() == 0:
            break
    need(p.returncode == 0 or run(*command, "--resume").returncode == 0, "interrupted: does not end")
    whole, part = (json.load(open(os.path.join(tmp, d, "summary.json"))) for d in ("by_strain", "part"))
    need(whole["counts"] == part["counts"] and whole["results"] == part["results"],
         f"interrupted: {whole['counts']} {part['counts']}")


def energy(tmp):
    """A ball that bounces is no energy error: what it has exchanged is m g h."""
    s, _, out = test(tmp, "drop", DROP)
    worst = s["errors"]["worst_energy_error"]
    need(worst < 1e-3, f"drop: energy error {worst}")
    rows = history(out)
    need(
        max(float(x["work_J"]) for x in rows) > 10 * min(abs(float(x["work_J"])) for x in rows[20:]),
        "drop: it does not bounce")


NEWTON = ("last_correction", "last_worst_unbalanced_force", "last_worst_stress_change")
BLOCK = """
[mesh]
box = { size = ["1 mm", "1 mm", "1 mm"], cells = [1, 1, 1] }
[rve]
scene = "cell.toml"
unbalanced_force = 5e-3
stress_change = 5e-3
[solve]
kind = "quasi-static"
increments = 1
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
where = "z=max"
displacement = [0, 0, -1e-7]
"""
CUT = """
[numerics]
safety = 0.5
[packing]
kind = "voronoi"
box = ["5 mm", "5 mm", "10 mm"]
cells = 60""" + ROCK + BRITTLE + """[[load]]
where = "z=min"
force = [0, 0, -250]
RAMP
[[load]]
where = "z=max"
force = [0, 0, 250]
RAMP
[loading]
kind = "free"
duration = "10 us"
[output]
history_interval = "0.05 us"
"""


def cut(tmp):
    """A bar that dead loads tear apart is looked at from its first step on: half a kick is no error, and its balance
    closes."""
    for name, ramp in (("cut", ""), ("cut_ramp", 'ramp = "5 us"')):
        s, said, out = test(tmp, name, CUT.replace("RAMP", ramp))
        rows = history(out)
        first, last = rows[1], rows[-1]
        need(
            float(first["work_J"]) < 1e-6 * float(last["work_J"]) and int(float(first["steps"])) < 3,
            f"{name}: it is not looked at from its first step on")
        need(float(last["bonds_broken"]) > 20, f"{name}: {last['bonds_broken']} bonds broken")
        taken = sum(float(last[k]) for k in ("kinetic_J", "elastic_J", "fracture_J", "damping_J", "friction_J"))
        need(abs(taken / float(last["work_J"]) - 1) < 0.02, f"{name}: {taken} J of {last['work_J']}")
        need(s["errors"]["worst_energy_error"] < 0.05, f"{name}: energy error {s['errors']['worst_energy_error']}")
        # What the guard does not look at yet is told as 0; then it is the balance, here by hand.
        early, late = ([r for r in rows if (float(r["steps"]) < 20) == new] for new in (True, False))
        need(len(early) > 3 and all(float(r["energy_error"]) == 0 for r in early), f"{name}: energy errors {early}")
        need(any(float(r["energy_error"]) != 0 for r in late), f"{name}: no energy error at all")
        # Dead loads have no section: their force is told, no stress.
        results = s["results"]
        need("MPa" not in said and re.search("finished: .*, load 250 N, ", said), f"{name}: {said}")
        loaded = abs(results["final_load_N"] / 250 - 1) < 1e-9
        # Two loads against each other: their work is force x how far they have moved apart, the ledger's.
        way = [float(r["displacement_m"]) for r in rows]
        work = sum(0.5 * (float(a["load_N"]) + float(b["load_N"])) * (y - x)
                   for a, b, x, y in zip(rows, rows[1:], way, way[1:]))
        need(abs(work / float(last["work_J"]) - 1) < 0.02, f"{name}: {work} J by loads and ways of {last['work_J']} J")
        need(loaded and "peak_axial_stress_Pa" not in results, f"{name}: {results}")


def left(tmp):
    """What is told of the time that is left of a test that a stress ends, in steps: within a factor of two from the
    half on."""
    for name, more in (("left_stress", 'strain_rate = 30\ncontrol = "stress"\nstress_rate = "200 MPa/s"\n'),
                       ("left_strain", "strain_rate = 20\n")):
        scene = SOFT.replace("0.56", "0.53") + f'[loading]\nkind = "oedometric-stress"\nfinal_stress = "2 MPa"\n{more}'
        log = os.path.join(tmp, name + ".log")
        _, _, out = test(tmp, name, scene, "--log", log)
        steps = {float(x["time_s"]): float(x["steps"]) for x in history(out)}
        total, seen = max(steps.values()), 0
        with open(log) as f:
            for part, t in re.findall(r"(\d+) %  t (\S+) s  strain", f.read()):
                at = steps[min(steps, key=lambda x: abs(x - float(t)))]
                if 0.5 * total <= at <= 0.9 * total and int(part) > 0:
                    told, true = at * (100 - int(part)) / int(part), total - at
                    seen += 1
                    need(0.5 < told / true < 2, f"{name}: at {at} of {total} steps {told:.0f} are told to be left")
        need(seen > 2, f"{name}: {seen} lines of progress in the second half")


def dynamic(tmp):
    """The steps that --check tells of bars around a specimen, whose elements differ by 30 in size, are those of the
    run."""
    bvp = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-bvp")
    if not bvp:
        return
    scene, short = os.path.join(shipped,
                                "shpb_bars.toml"), ["--set", 'solve.duration="20 us"', "--set", "output.frames=0"]
    r = run(bvp, scene, "--check", *short)
    told = re.search(r"([\d.e+]+) steps, ", r.stdout)
    out = os.path.join(tmp, "bars")
    ran = run(bvp, scene, "-o", out, "--quiet", *short)
    need(told and ran.returncode == 0, f"bars: {r.stdout} {r.stderr} {ran.stderr}")
    steps = float(history(out)[-1]["increment"])
    need(abs(float(told[1]) / steps - 1) < 0.1, f"bars: --check tells {told[1]} steps of {steps}")
    # And the time is the least: that of this machine, which has other things to do, within a factor of three.
    least, seconds = re.search(r"run: at least about (\S+) s ", r.stdout), scene_tools.summary(out)["seconds"]
    need(least and float(least[1]) < 3 * seconds["solve_wall"], f"bars: {r.stdout} {seconds}")
    errors = scene_tools.summary(out)["errors"]  # no residual, no equilibrium of cells is computed
    need("last_energy_error" in errors and not {"worst_residual", *NEWTON} & set(errors), f"bars: {errors}")


def main():
    with tempfile.TemporaryDirectory() as tmp:
        for part in (strengths, lateral, preparation, pressed, cells, ends, energy, cut, left, dynamic):
            part(tmp)
    print("FAULTS" if faults else "all is told")
    sys.exit(1 if faults else 0)


main()
