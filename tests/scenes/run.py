#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes end to end: run.py refused|shipped|same_bits|golden|resume|shpb_full BIN"""
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
from scene_tools import faults, here, history, kill_at_random, need, run, shipped, without_wall

case, binaries = sys.argv[1:3]


def program(name):
    return scene_tools.program(binaries, name)


def refused(tmp):
    """Every bad file: exit 2, one line that holds what its first line expects, nothing created."""
    files = sorted(glob.glob(os.path.join(here, "refused", "*.toml")))
    need(len(files) >= 15, f"only {len(files)} refused scenes")

    def refusal(path):
        name, expected = open(path).readline()[1:].split(":", 1)
        binary, target = program(name.strip()), os.path.join(tmp, os.path.basename(path) + "_out")
        return (path, expected.strip(), target, run(binary, path, "-o", target)) if binary else None

    with ThreadPoolExecutor(4) as pool:  # MPI sleeps more than it works
        tried = list(filter(None, pool.map(refusal, files)))
    for path, expected, target, r in tried:
        what = os.path.basename(path)
        need(r.returncode == 2, f"{what}: exit {r.returncode}, expected 2: {r.stderr.strip()}")
        need(r.stderr.count("\n") == 1, f"{what}: {r.stderr.count(chr(10))} lines of error: {r.stderr!r}")
        need(expected in r.stderr, f"{what}: expected {expected!r} in {r.stderr!r}")
        need(not os.path.exists(target), f"{what}: created {target}")
    rve = program("grus-rve")
    scene = os.path.join(shipped, "single_grain.toml")
    for arguments, expected in ((["nowhere.toml"], "no such scene file"),
                                ([scene, "--set", "grain.0.radius=3 parsec"], "unknown unit 'parsec'"),
                                ([scene, "--set", "grain.7.radius=1"], "not one of 1 entries"),
                                ([scene, "--bogus"], "--bogus"), ([scene, "--resume"], "no checkpoint to resume from"),
                                ([scene, "--threads", "0"], "--threads")):
        r = run(rve, *arguments, "-o", os.path.join(tmp, "refused"))
        need(r.returncode == 2 and expected in r.stderr and r.stderr.count("\n") == 1,
             f"{arguments}: exit {r.returncode}: {r.stderr!r}")
    full = os.path.join(tmp, "full")
    os.mkdir(full)
    open(os.path.join(full, "keep.txt"), "w").write("mine")
    r = run(rve, scene, "-o", full)
    need(r.returncode == 2 and "not empty" in r.stderr, f"folder in use: exit {r.returncode} {r.stderr!r}")
    need(os.listdir(full) == ["keep.txt"], "a folder in use was changed")


def shipped_scenes(tmp):
    rve, bvp, report = program("grus-rve"), program("grus-bvp"), program("grus-report")
    shorter = {
        "shpb_random": ["loading.final_strain=0.02", "output.frames=2"], "single_grain": [],
        "rve_periodic": ["loading.final_strain=0.01", "output.frames=2"], "sand_rve": ["loading.final_strain=0.01"]
    }
    for name, changes in shorter.items():
        out = os.path.join(tmp, name)
        arguments = [a for c in changes for a in ("--set", c)]
        r = run(rve, os.path.join(shipped, name + ".toml"), "-o", out, *arguments)
        need(r.returncode == 0, f"{name}: exit {r.returncode}: {r.stderr}")
        if r.returncode:
            continue
        rows, summary = history(out), json.load(open(os.path.join(out, "summary.json")))
        last = {k: float(v) for k, v in rows[-1].items() if v != "nan"}
        need(abs(last["energy_error"]) < 0.01, f"{name}: energy error {last['energy_error']}")
        need(
            abs(last["energy_unexplained_J"]) < 5e-3 * last["work_J"],
            f"{name}: {last['energy_unexplained_J']} J unexplained of {last['work_J']}")
        need(
            abs(last["mass_kg"] + last["mass_lost_kg"] - float(rows[0]["mass_kg"])) < 1e-9 * last["mass_kg"],
            f"{name}: mass is lost silently")  # ten digits in the file
        need(summary["counts"]["breakages"] == last["breakages"] and last["breakages"] > 0,
             f"{name}: {last['breakages']} breakages")
        need(last["grains"] == summary["counts"]["grains_start"] + last["breakages"],
             f"{name}: grains {last['grains']}")
        need(("frames" in json.dumps(summary["scene"].get("output", {}))) == os.path.isdir(os.path.join(out, "grains"))
             or summary["scene"]["output"]["frames"] == 0, f"{name}: frames without being asked")
    grain = [{k: float(v) for k, v in r.items()} for r in history(os.path.join(tmp, "single_grain"))]
    peak = max(r["wall1_fz_N"] for r in grain if r["breakages"] == 0)
    need(0.97 * 51.8 < peak < 1.01 * 51.8, f"single grain breaks at {peak} N, 2 pi R^2 strength / 3 = 51.8 N")
    out = os.path.join(tmp, "cohesive_powder")
    r = run(rve, os.path.join(shipped, "cohesive_powder.toml"), "-o", out, "--set", "loading.final_strain=0.012",
            "--set", "output.frames=0")
    need(r.returncode == 0, f"cohesive_powder: exit {r.returncode}: {r.stderr}")
    drawn = [{k: float(v) for k, v in x.items()} for x in history(out)]
    # Rumpf: contacts x solid fraction / pi x pull-off / d^2, were all contacts to part at once; some two fifths of it.
    rumpf = drawn[0]["coordination"] * drawn[0]["solid_fraction"] / 3.14159 * 1.5 * 3.14159 * 0.05 * 25e-6 / 1e-8
    strength = max(x["stress_zz_Pa"] for x in drawn)
    need(0.25 * rumpf < strength < 0.6 * rumpf, f"cohesive_powder: strength {strength} Pa, Rumpf has {rumpf}")
    need(drawn[-1]["stress_zz_Pa"] < 0.9 * strength,
         f"cohesive_powder: {drawn[-1]['stress_zz_Pa']} Pa are left of {strength}")
    need(drawn[-1]["adhesion_J"] > 0 and abs(drawn[-1]["energy_error"]) < 2e-3,
         f"cohesive_powder: energy error {drawn[-1]['energy_error']}")
    need(abs(drawn[-1]["energy_unexplained_J"]) < 5e-3 * drawn[-1]["friction_J"],
         f"cohesive_powder: {drawn[-1]['energy_unexplained_J']} J unexplained")
    for path in sorted(glob.glob(os.path.join(shipped, "zhang2015", "*.toml"))):
        is_study = "[study]" in open(path).read()
        r = run(program("grus-study") if is_study else rve, path, "--check")
        need(r.returncode == 0, f"{path} --check: exit {r.returncode}: {r.stderr}")
    check = run(rve, os.path.join(shipped, "sand_rve.toml"), "--check", "-o", os.path.join(tmp, "unused"))
    need(check.returncode == 0 and "time step" in check.stdout and not os.path.exists(os.path.join(tmp, "unused")),
         "--check")
    folders = [os.path.join(tmp, "shpb_random"), os.path.join(tmp, "single_grain")]
    if bvp:
        out = os.path.join(tmp, "oedometer")
        r = run(bvp, os.path.join(shipped, "oedometer_block.toml"), "-o", out, "--set",
                "boundary.0.displacement=['free','free',-2e-4]", "--set", "solve.increments=2", "--set",
                "rve.variants=2", "--set", "output.frames=2")
        need(r.returncode == 0, f"oedometer: exit {r.returncode}: {r.stderr}")
        rows = history(out)
        last = {k: float(v) for k, v in rows[-1].items()}
        need(abs(last["mean_strain_zz"] + 0.01) < 1e-4, f"oedometer: strain {last['mean_strain_zz']}")
        need(
            abs(last["reaction_zmax_z_N"] + last["reaction_zmin_z_N"]) < 0.05 * abs(last["reaction_zmax_z_N"]),
            "oedometer: top and bottom reactions differ")
        area = 4e-4
        need(
            abs(last["reaction_zmax_z_N"] / area / last["mean_stress_zz_Pa"] - 1) < 0.05,
            "oedometer: reaction and mean stress differ")
        need(0 < abs(last["energy_unexplained_J"]) < 0.01 * abs(last["rve_work_J"]),
             f"oedometer: {last['energy_unexplained_J']} J unexplained of {last['rve_work_J']}")
        need(os.path.exists(os.path.join(out, "macro.hdf.series")), "oedometer: no macro frames")
        need(
            os.path.exists(os.path.join(out, "grains_middle.hdf.series"))
            and len(os.listdir(os.path.join(out, "grains_middle"))) == 2, "oedometer: no frames of the probe")
        probe = sum(last[f"probe_middle_stress_{k}_Pa"] for k in ("xx", "yy", "zz")) / 3
        need(-5e7 < probe < -1e6 and abs(last["probe_middle_strain_zz"] + 0.01) < 0.005,
             f"probe: mean stress {probe}, strain {last['probe_middle_strain_zz']}")
        need(0.3 < last["probe_middle_void_ratio"] < 1 and 5e-4 < last["probe_middle_d50_m"] < 8e-4,
             "probe: void ratio or grading")
        folders.append(out)
    page = os.path.join(tmp, "report.html")
    r = run(report, *folders, "-o", page)
    need(r.returncode == 0 and os.path.getsize(page) > 1e5, f"report: {r.stderr}")
    r = run(report, os.path.join(tmp, "nothing"))
    need(r.returncode == 2 and r.stderr.count("\n") == 1, "report of a missing folder")


def same_bits(tmp):
    """The same history for 1 and 2 threads, for any width of the kernels, and for 1 and 2 ranks."""
    rve, bvp = program("grus-rve"), program("grus-bvp")
    for rolling in ("0", "0.2"):
        texts = []
        for threads, lanes in (("1", "8"), ("2", "4"), ("1", "1")):
            out = os.path.join(tmp, "t" + threads + lanes + rolling)
            r = run("env", "GRUS_LANES=" + lanes, rve, os.path.join(shipped, "shpb_random.toml"), "-o", out,
                    "--threads", threads, "--quiet", "--set", "loading.final_strain=0.04", "--set", "output.frames=0",
                    "--set", f"material.sand.rolling_friction={rolling}")
            need(r.returncode == 0, r.stderr)
            texts.append(open(os.path.join(out, "history.csv")).read())
        need(texts[0] == texts[1] == texts[2],
             f"history.csv differs with the number of threads or the width of the kernels, rolling friction {rolling}")
        need(float(history(os.path.join(tmp, "t18" + rolling))[-1]["breakages"]) > 10, "nothing broke")
    if not bvp:
        return
    rows = []
    for shared in ("true", "false"):
        out = os.path.join(tmp, "s" + shared)
        r = run(bvp, os.path.join(shipped, "oedometer_block.toml"), "-o", out, "--threads", "2", "--quiet", "--set",
                "mesh.box.cells=[1,1,1]", "--set", "rve.variants=2", "--set",
                "boundary.0.displacement=['free','free',-4e-4]", "--set", "solve.increments=2", "--set",
                f"rve.exact_sharing={shared}")
        need(r.returncode == 0, r.stderr)
        counts = json.load(open(os.path.join(out, "summary.json")))["counts"]
        need(counts["rves_advanced"] == counts["rves_asked"] / (4 if shared == "true" else 1),
             f"sharing {shared}: {counts}")
        rows.append([{k: v for k, v in x.items() if k not in ("wall_s", "rves_advanced", "rves_distinct", "dem_steps")}
                     for x in history(out)])
    need(rows[0] == rows[1] and float(rows[0][-1]["breakages"]) > 0, "exact sharing changes the result")
    rows = []
    for ranks in ("1", "2"):
        out = os.path.join(tmp, "r" + ranks)
        r = run("mpirun", "-n", ranks, bvp, os.path.join(shipped, "oedometer_block.toml"), "-o", out, "--threads", "1",
                "--quiet", "--set", "boundary.0.displacement=['free','free',-1e-4]", "--set", "solve.increments=1",
                "--set", "rve.variants=2", "--set", "output.costs=true", "--set", "rve.tangent=network")
        need(r.returncode == 0, r.stderr)
        costs, counts = list(csv.DictReader(open(os.path.join(out, "costs.csv")))), json.load(
            open(os.path.join(out, "summary.json")))["counts"]
        need(
            len(costs) == counts["rves_advanced"] and sum(int(c["steps"]) for c in costs) == counts["dem_steps"],
            f"costs.csv: {len(costs)} rows, {counts}")
        need({c["rank"] for c in costs} == {str(k) for k in range(int(ranks))}, "costs.csv: not on all ranks")
        need(all((float(c["message_seconds"]) > 0) == (c["rank"] != "0") for c in costs),
             "costs.csv: messages are of other ranks alone")
        need(all(0 < float(c["tangent_seconds"]) < float(c["seconds"]) for c in costs),
             "costs.csv: the tangent is a part of the evaluation")
        rows.append(without_wall(out))
    need(rows[0] == rows[1], "history.csv differs between 1 and 2 ranks")
    for changes, safety in (([], 0.5), (["material.sand.fracture="], 0.7)):  # the step of a unit cell that does not say
        steps = []
        for said in ([], [f"numerics.safety={safety}"], ["numerics.safety=0.3"]):
            out = os.path.join(tmp, "step")
            r = run(bvp, os.path.join(shipped,
                                      "oedometer_block.toml"), "-o", out, "--force", "--threads", "2", "--quiet",
                    "--set", "mesh.box.cells=[1,1,1]", "--set", "boundary.0.displacement=['free','free',-1e-4]",
                    "--set", "solve.increments=1", "--set", f"rve.set={json.dumps(changes + said)}")
            need(r.returncode == 0, r.stderr)
            steps.append(json.load(open(os.path.join(out, "summary.json")))["counts"]["dem_steps"])
        need(steps[0] == steps[1] < steps[2],
             f"DEM steps of a cell at its default, at safety {safety} and at 0.3: {steps}")


FRACTURE = "material.sand.fracture."
GOLDEN = {  # scene, settings: short runs that pass through every technique
    "techniques": ("shpb_random.toml",
                   ["loading.final_strain=0.06", "output.frames=0", "output.grading=true",
                    FRACTURE + "turn_to_plane=true", FRACTURE + "slight_rotation=0.1974",
                    "output.split_statistics=true"]),
    "exact_halves": ("shpb_random.toml",
                     ["loading.final_strain=0.04", "output.frames=0", FRACTURE + "rounding=0",
                      "output.split_statistics=true"]),
    "transition": ("zhang2015/single_grain.toml",
                   [FRACTURE + "shape_transition.ratio=0.25", "loading.strain_rate=1000.0",
                    FRACTURE + "lost_mass=density", FRACTURE + "smallest_radius='0.05 mm'"]),
    "cubic": ("zhang2015/cubic.toml",
              ["loading.final_strain=0.06", FRACTURE + "break_plane=critical-contacts", "output.grading=true"]),
    "single_grain": ("zhang2015/single_grain.toml", []),
}
GOLDEN_COLUMNS = [
    "axial_strain", "axial_stress_Pa", "mean_pressure_Pa", "void_ratio", "breakages", "bonds_broken", "mass_kg",
    "fracture_J", "friction_J", "work_J"
]


def golden(tmp):
    """Short histories against those kept in git. Up to the first breakage to 1e-6 (round-off of another compiler);
    after it a packing of a thousand grains is chaotic, so sums over the run are held to 10 %, counts to 15 %. What this
    compiler and library make of them is the same to the last digit (physics/bits)."""
    write = len(sys.argv) > 3 and sys.argv[3] == "--write"
    for name, (scene, settings) in GOLDEN.items():
        out = os.path.join(tmp, name)
        r = run(program("grus-rve"), os.path.join(shipped, scene), "-o", out, "--quiet",
                *[a for s in settings for a in ("--set", s)])
        need(r.returncode == 0, f"{name}: {r.stderr}")
        if r.returncode:
            continue
        rows = [{k: float(x[k]) for k in GOLDEN_COLUMNS} for x in history(out)]
        rows = rows[::max(1, len(rows) // 40)]
        path = os.path.join(here, "golden", name + ".csv")
        if write:
            with open(path, "w", newline="") as f:
                w = csv.DictWriter(f, GOLDEN_COLUMNS)
                w.writeheader()
                w.writerows({k: f"{v:.9g}" for k, v in x.items()} for x in rows)
            continue
        with open(path, newline="") as f:
            kept = [{k: float(v) for k, v in x.items()} for x in csv.DictReader(f)]
        need(len(kept) == len(rows), f"{name}: {len(rows)} rows, {len(kept)} kept")
        for k in GOLDEN_COLUMNS:
            before = [(a[k], b[k]) for a, b in zip(rows, kept) if b["breakages"] == 0 and a["breakages"] == 0]
            scale = max(abs(b[k]) for b in kept)
            need(all(abs(a - b) <= 1e-6 * scale for a, b in before), f"{name}: {k} differs before the first breakage")
            total, kept_total = sum(a[k] for a in rows), sum(b[k] for b in kept)
            slack = (0.15 if k in ("breakages", "bonds_broken") else 0.1) * abs(kept_total)
            need(abs(total - kept_total) <= slack, f"{name}: sum of {k} is {total:.6g}, kept {kept_total:.6g}")


def resume(tmp):
    """Killed, interrupted and resumed with other threads, a run past hundreds of breakages writes the same bytes."""
    rve, scene = program("grus-rve"), os.path.join(shipped, "shpb_random.toml")
    settings = [
        a for s in ("loading.final_strain=0.08", "output.frames=3", "output.gradings=3", "output.grading=true",
                    "output.checkpoint_interval=0.1", "material.sand.fracture.shape_transition.ratio=0.25")
        for a in ("--set", s)
    ]
    whole, part = os.path.join(tmp, "whole"), os.path.join(tmp, "part")
    begin = time.time()
    need(run(rve, scene, "-o", whole, "--threads", "1", "--quiet", *settings).returncode == 0, "the run itself")
    within = 0.08 * (time.time() - begin)  # five kills leave time for more
    checkpoint = os.path.join(part, "checkpoint.h5")
    command = [rve, scene, "-o", part, "--quiet", *settings]
    seed = random.randrange(1 << 30)
    killed = kill_at_random(lambda k: [*command, "--threads", str(1 + k % 2)] + (["--resume"] if k else []),
                            lambda: os.path.exists(checkpoint), 5, random.Random(seed), within)
    need(killed >= 4 and os.path.exists(checkpoint), f"killed {killed} times before the end (seed {seed})")
    p = subprocess.Popen([*command, "--threads", "1", "--resume"])
    time.sleep(0.3)
    p.send_signal(signal.SIGINT)
    need(p.wait() in (0, 130), f"Ctrl-C: exit {p.returncode}")
    r = run(*command, "--threads", "2", "--resume")
    need(r.returncode == 0, f"resume: exit {r.returncode} {r.stderr}")
    for name in ("history.csv", "grading.csv", "grains.hdf.series"):
        need(
            open(os.path.join(whole, name)).read() == open(os.path.join(part, name)).read(),
            f"{name} differs after kill and resume (seed {seed})")
    need(float(history(part)[-1]["breakages"]) > 50, "nothing broke")
    r = run(*command, "--resume", "--set", "packing.seed=9")
    need(r.returncode == 2 and "another scene: packing.seed was 1, is 9; set it back" in r.stderr,
         f"another scene: {r.stderr!r}")
    r = run(*command, "--resume", "--set", "packing.seed=9", "--set", "material.sand.friction=0.25", "--set",
            "output.grading=false")
    told = [
        f"{key} was {was}, is {now}" for key, was, now in (("material.sand.friction", 0.5, 0.25),
                                                           ("output.grading", "true", "false"), ("packing.seed", 1, 9))
    ]
    need(r.returncode == 2 and "; ".join(told) in r.stderr and r.stderr.count("\n") == 1,
         f"three changes: {r.stderr!r}")
    r = run(*command, "--resume", "--set", "title=Renamed")
    need(r.returncode == 0 and json.load(open(os.path.join(part, "summary.json")))["title"] == "Renamed",
         f"another title: exit {r.returncode} {r.stderr!r}")
    data = bytearray(open(checkpoint, "rb").read())
    for spoiled in (data[:len(data) // 2], data[:-200] + bytes(200), b"nothing",
                    data[:40000] + bytes([data[40000] ^ 1]) + data[40001:]):
        open(checkpoint, "wb").write(spoiled)
        before = sorted(os.listdir(part))
        r = run(*command, "--resume")
        need(r.returncode == 2 and r.stderr.count("\n") == 1 and "checkpoint" in r.stderr,
             f"damaged: exit {r.returncode} {r.stderr!r}")
        need(sorted(os.listdir(part)) == before, "a refused resume changed the folder")


def shpb_full(tmp):
    out = os.path.join(tmp, "shpb")
    r = run(program("grus-rve"), os.path.join(shipped, "shpb_random.toml"), "-o", out, "--set", "output.frames=0",
            timeout=3500)
    need(r.returncode == 0, r.stderr)
    rows = [{k: float(v) for k, v in row.items()} for row in history(out)]
    need(abs(rows[-1]["axial_strain"] - 0.45) < 1e-9, "does not reach strain 0.45")
    need(max(abs(x["energy_error"]) for x in rows) < 0.01, "energy error above 1 %")
    e = json.load(open(os.path.join(out, "summary.json")))["energy"]
    surface = 1.77e6 ** 2 * (1 - 0.17 ** 2) / 60e9 * e["fracture_area_m2"]
    need(
        abs((e["fracture_J"] + e["fracture_left_in_springs_J"]) / surface - 1) < 0.01,
        "surface energy booked is not G_c x new area")
    need(e["split_added_J"] <= 1e-12 * e["work_J"], "a breakage added energy")
    print("stress at 10, 20, 30, 45 %:", [
        round(min(rows, key=lambda x: abs(x["axial_strain"] - e))["axial_stress_Pa"] / 1e6, 1)
        for e in (0.1, 0.2, 0.3, 0.45)
    ], "MPa")


with tempfile.TemporaryDirectory() as folder:
    {
        "refused": refused, "shipped": shipped_scenes, "same_bits": same_bits, "golden": golden, "resume": resume,
        "shpb_full": shpb_full
    }[case](folder)
print(f"{case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
