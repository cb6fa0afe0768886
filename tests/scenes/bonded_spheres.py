#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/bonded_spheres.md as a user takes it: agglomerates that crush, with `rock` the granite: ... BIN [rock]"""
import csv
import os
import re
import sys
import tempfile

from scene_tools import faults, history, need, run, shipped, summary, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
page = open(os.path.join(shipped, "..", "..", "docs", "bonded_spheres.md")).read()


def numbers(folder):
    return [{k: float(v) for k, v in row.items()} for row in history(folder)]


def go(scene, folder, *options):
    r = run(rve, scene, "-o", folder, "--quiet", "--threads", "1", *options)
    need(r.returncode == 0, f"{os.path.basename(folder)}: exit {r.returncode} {r.stderr[-300:]}")
    return numbers(folder), summary(folder)


def granule(tmp):
    """The page's granule: each break has its line; their energies are what fracture took."""
    scene = re.search(r"One granule between two platens.*?```toml\n(.*?)```", page, re.S)[1]
    write(tmp, scene + "[output]\nbroken_bonds = true\n", "granule.toml")
    rows, told = go(os.path.join(tmp, "granule.toml"), os.path.join(tmp, "granule"))
    with open(os.path.join(tmp, "granule", "broken_bonds.csv"), newline="") as f:
        broken = [{k: v if k == "mode" else float(v) for k, v in r.items()} for r in csv.DictReader(f)]
    last = rows[-1]
    need(len(broken) == last["bonds_broken"] > 20, f"{len(broken)} lines, {last['bonds_broken']} bonds broken")
    energy = sum(b["energy_J"] for b in broken)
    need(abs(energy / last["fracture_J"] - 1) < 1e-6, f"lines have {energy} J, fracture took {last['fracture_J']} J")
    need(told["cells"]["bonds_start"] == last["bonds"] + last["bonds_broken"], "bonds at the start, left and broken")
    need({b["mode"] for b in broken} == {"tension", "shear"}, "bonds break by one mode only")
    need(max(abs(r["energy_error"]) for r in rows) < 0.01, "energy of the granule")
    peak = max(r["load_N"] for r in rows)
    first = min(b["time_s"] for b in broken)
    loaded = [r["load_N"] for r in rows if r["time_s"] < first]
    need(max(loaded) < peak and last["load_N"] < 0.8 * peak, "a granule that is broken before, or never gives way")


def bed(tmp):
    """Agglomerates in a box, to the page's numbers."""
    rows, told = go(os.path.join(shipped, "agglomerate_crush.toml"), os.path.join(tmp, "bed"))
    said = re.search(r"the (\d+) agglomerates of ([\d,]+) bonds have become (\d+) fragments", page)
    parts, bonds, fragments = (int(x.replace(",", "")) for x in said.groups())
    need(told["cells"]["bonds_start"] == bonds, f"{told['cells']['bonds_start']} bonds, said {bonds}")
    need(abs(told["counts"]["fragments"] / fragments - 1) < 0.1, f"{told['counts']['fragments']}, said {fragments}")
    need(rows[0]["fragments"] == parts, f"{rows[0]['fragments']} agglomerates, said {parts}")
    need(rows[-1]["mass_kg"] == rows[0]["mass_kg"] and rows[-1]["mass_lost_kg"] == 0, "mass of the agglomerates")
    need(max(abs(r["energy_error"]) for r in rows) < 0.01, "energy of the bed")


def rock(tmp):
    """The granite: moduli and strengths in proportion, by the page's two commands."""
    commands = re.search(r"```sh\n(grus-rve apps/scenes/sphere_rock.toml -o granite.*?)```", page, re.S)[1]
    for line in commands.splitlines():
        words = line.split()
        scene, options = os.path.join(shipped, os.path.basename(words[1])), words[4:]
        rows, _ = go(scene, os.path.join(tmp, words[3]), *options, "--set", "output.frames=0")
        peak = max(r["nominal_stress_Pa"] for r in rows)
        need(max(abs(r["energy_error"]) for r in rows) < 0.005, f"energy of {words[3]}")
        if words[3] != "granite":
            need(abs(peak / 21.6e6 - 1) < 0.02, f"tensile strength {peak} Pa")
            continue
        low, high = (next(r for r in rows if r["nominal_stress_Pa"] > share * peak) for share in (0.05, 0.3))
        way = lambda key: high[key] - low[key]
        modulus = -way("nominal_stress_Pa") / way("gauge_strain_zz")
        ratio = -0.5 * (way("gauge_strain_xx") + way("gauge_strain_yy")) / way("gauge_strain_zz")
        # The targets are Lac du Bonnet granite's; seeds scatter by a few per cent.
        need(abs(modulus / 69e9 - 1) < 0.06, f"modulus {modulus} Pa")
        need(abs(ratio - 0.26) < 0.02, f"Poisson's ratio {ratio}")
        need(abs(peak / 200e6 - 1) < 0.06, f"UCS {peak} Pa")


with tempfile.TemporaryDirectory() as tmp_:
    for check in (rock,) if "rock" in sys.argv else (granule, bed):
        check(tmp_)
print(f"bonded spheres: {len(faults)} faults")
sys.exit(1 if faults else 0)
