#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/stages.md, walls.md and howto/from_other_programs.md as a user takes them: their scenes, of the first two
shipped ones, run, and show what the pages say: recipes.py BUILD"""
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import neper_cells
from scene_tools import faults, history, need, shipped, summary

build = os.path.abspath(sys.argv[1])
DOCS = os.path.join(shipped, "..", "..", "docs")
text, walls = (open(os.path.join(DOCS, page)).read() for page in ("stages.md", "walls.md"))
environment = {**os.environ, "PATH": os.path.join(build, "bin") + os.pathsep + os.environ["PATH"]}


def rows_of(folder):
    return [{k: float(v) for k, v in row.items()} for row in history(folder)]


def slope(rows):
    """Modulus (Pa) between the ends of some rows."""
    first, last = rows[0], rows[-1]
    return (last["axial_stress_Pa"] - first["axial_stress_Pa"]) / (last["axial_strain"] - first["axial_strain"])


def told(pattern, page=text):
    found = re.search(pattern, page)
    need(found is not None, f"the page does not say {pattern}")
    return [float(x) for x in found.groups()] if found else []


def oedometer(folder):
    rows = rows_of(folder)
    stage = lambda k: [r for r in rows if r["stage"] == k]
    up, down = slope(stage(4)[-6:]), slope(stage(4)[-1:] + stage(5)[:5])
    said = told(r"modulus of (\d+) MPa, the first of the way down (\d+) MPa")
    need(all(abs(1e6 * s / x - 1) < 0.02 for s, x in zip(said, (up, down))), f"moduli {up}, {down} Pa; said {said}")
    for k, asked in ((1, 1e6), (2, 0.2e6), (3, 1e6), (4, 4e6), (5, 0.8e6), (6, 4e6)):
        end = stage(k)[-1]["axial_stress_Pa"]
        need(abs(end / asked - 1) < 2e-3, f"stage {k}: {end} Pa")
    need(abs(rows[-1]["energy_error"]) < 1e-3, f"energy error {rows[-1]['energy_error']}")
    asked, told_of = 0.79 - 0.4 * (0.79 - 0.58), summary(folder)["preparation"]
    need(abs(rows[0]["void_ratio"] - asked) < 0.003 and abs(told_of["asked_void_ratio"] - asked) < 1e-12, f"{told_of}")


def cyclic(folder):
    rows, ends = rows_of(folder), summary(folder)["stages"]
    need([s["ended_by"] for s in ends] == ["unbalanced_force", "strain"], f"{ends}")
    first, least, cycles = told(r"from (\d+) kPa to ([\d.]+) kPa; after ([\d.]+) cycles")
    last = rows[-1]
    need(last["cycle"] == cycles, f"{last['cycle']} cycles, said {cycles}")
    lowest = min(r["p_Pa"] for r in rows)
    need(abs(lowest / 1e3 - least) < 0.5 and abs(rows[0]["p_Pa"] / 1e3 - first) < 0.5,
         f"mean stress from {rows[0]['p_Pa']} down to {lowest} Pa, said {first} and {least} kPa")
    ratios = [r["void_ratio"] for r in rows if r["stage"] == 2]
    need(max(ratios) - min(ratios) < 1e-5, f"volume: {min(ratios)} to {max(ratios)}")


def lid(folder):
    """The lid presses with its stress on 16 mm^2; the friction that the page tells."""
    rows = [r for r in rows_of(folder) if r["time_s"] >= 2e-3]
    off, most = told(r"within ([\d.]+) % on average. .* at most (\d\.\d+)", walls)
    need(all(abs(r["force_zmax_z_N"] / (1e5 * 16e-6) - 1) < 1e-3 for r in rows), "the lid does not press with 100 kPa")
    loose, solid = rows_of(folder)[0]["void_ratio"], rows[0]["mass_kg"] / 2650 / 16e-6  # m of solid under the lid
    need(all(abs(r["way_zmax_m"] - (loose - r["void_ratio"]) * solid) < 1e-10 for r in rows), "the lid's way")
    mean = 100 * summary(folder)["errors"]["sought_stress"]["mean"]
    need(mean < 1.5 * off, f"mean error {mean} %, said {off}")
    found = max(-r["force_zmax_x_N"] / r["force_zmax_z_N"] for r in rows)
    need(abs(found - most) < 0.006, f"friction {found}, said {most}")
    need(abs(rows[-1]["energy_error"]) < 1e-3, f"energy error {rows[-1]['energy_error']}")


def rough(folder):
    """Lid and floor press alike, one with what is asked, and are sheared alike; the friction that is told."""
    rows = [r for r in rows_of(folder) if r["time_s"] >= 5e-3]
    friction, before, after = told(r"mean friction is (0\.\d+), .*? void ratio goes from (0\.\d+) to (0\.\d+)", walls)
    area = 9e-6
    need(all(abs(r["force_zmax_z_N"] / (1e5 * area) - 1) < 2e-3 for r in rows), "the lid does not press with 100 kPa")
    mean = lambda key: sum(r[key] for r in rows) / len(rows)
    need(abs(mean("force_zmin_z_N") / mean("force_zmax_z_N") + 1) < 5e-3, "floor and lid do not press alike")
    need(abs(mean("force_zmin_x_N") / mean("force_zmax_x_N") + 1) < 0.01, "floor and lid are not sheared alike")
    found = -mean("force_zmax_x_N") / mean("force_zmax_z_N")
    need(abs(mean("stress_zz_Pa") * area / mean("force_zmax_z_N") + 1) < 5e-3, "Love and Weber's stress is another")
    need(abs(found - friction) < 0.006, f"friction {found}, said {friction}")
    first, last = rows_of(folder)[0]["void_ratio"], mean("void_ratio")
    need(abs(first - before) < 0.006 and abs(last - after) < 0.006, f"void ratio {first}, {last}")
    need(abs(rows[-1]["energy_error"]) < 1e-3, f"energy error {rows[-1]['energy_error']}")
    need(sum("grains move with the wall" in n for n in summary(folder)["notes"]) == 2, "no word of fixed grains")


def hopper(folder):
    """It bears its grains, then the floor does; what the page says of when it is empty."""
    rows = rows_of(folder)
    weight = rows[0]["mass_kg"] * 9.81
    last = rows[-1]
    need(abs(last["wall1_fz_N"] / weight + 1) < 0.03, f"the floor bears {last['wall1_fz_N']} N of {weight}")
    need(abs(last["wall0_fz_N"]) < 1e-3 * weight, "the hopper is not empty")
    need(min(r["wall0_fz_N"] for r in rows) < -0.5 * weight, "the hopper has borne nothing")
    empty, = told(r"It is empty after ([\d.]+) s", walls)
    at = max(r["time_s"] for r in rows if r["wall0_fz_N"] != 0)
    need(abs(at - empty) < 0.006, f"empty at {at} s, said {empty}")
    need(abs(last["energy_error"]) < 5e-3, f"energy error {last['energy_error']}")
    need(os.path.exists(os.path.join(folder, "walls.hdf.series")), "no frames of the hopper")


def three_stresses(folder):
    """A straight path: Lode's angle of b = 0.5 and the mean stress stay; stresses of the walls."""
    rows = [r for r in rows_of(folder) if r["axial_strain"] > 0.01]
    most, angle, mean = told(r"largest q is (\d+) kPa.*? within ([\d.]+) of π/6 and the mean stress within ([\d.]+) %",
                             walls)
    need(abs(max(r["q_Pa"] for r in rows) / 1e3 - most) < 0.6, f"q {max(r['q_Pa'] for r in rows)}, said {most} kPa")
    need(all(abs(r["lode_angle_rad"] - math.pi / 6) < angle for r in rows), "Lode's angle")
    need(all(abs(100 * (r["p_Pa"] / 1e5 - 1)) < mean for r in rows), "mean stress")
    for r in rows:
        x, y, z = (-r[f"wall_stress_{k}_Pa"] for k in ("xx", "yy", "zz"))
        need(abs(y - x - 0.5 * (z - x)) < 1e-3 * z, f"b at a strain of {r['axial_strain']}")
    need(abs(rows[-1]["energy_error"]) < 1e-3, f"energy error {rows[-1]['energy_error']}")


def foreign(folder, page):
    """Spheres of a dump by their closed-form mass; two blocks in a row by theirs."""
    mass = rows_of(os.path.join(folder, "dump"))[0]["mass_kg"]
    balls = lambda density, *radii: density * 4 / 3 * math.pi * sum(r**3 for r in radii)
    sand, steel = balls(2650, 0.4e-3, 0.5e-3), balls(7800, 0.5e-3, 0.45e-3)
    need(abs(mass / (sand + steel) - 1) < 1e-9, f"{mass} kg of {sand} and {steel}")
    said = re.search(r"`mass_kg` is (\S+): (\S+) mg of sand and (\S+) mg", page)
    need(all(abs(float(s) / x - 1) < 3e-4 for s, x in zip(said.groups(), (mass, 1e6 * sand, 1e6 * steel))), "masses")
    rows = rows_of(os.path.join(folder, "blocks"))
    half = [r for r in rows if r["displacement_m"] > 1e-6]
    stiffness = [r["nominal_stress_Pa"] / r["displacement_m"] for r in half]
    # 3 mm of 10 GPa and 5 mm of 50 GPa: 4e-13 m/Pa. A wave passes in some 3 us and leaves 25 kPa of 2.5 MPa and more.
    need(all(abs(s * (3e-3 / 10e9 + 5e-3 / 50e9) - 1) < 0.01 for s in stiffness), f"stiffness {stiffness[0]} Pa/m")
    need(rows[-1]["bonds"] == 1 and rows[-1]["bonds_broken"] == 0, "one face is shared")


def rock(folder, page):
    """Strength, modulus, ratio and dilatancy of cells that SciPy has made, by the rows; the elasticity asked for."""
    rows = rows_of(folder)
    stress = [r["nominal_stress_Pa"] for r in rows]
    peak = max(stress)
    low, high = (next(r for r in rows if r["nominal_stress_Pa"] > share * peak) for share in (0.03, 0.2))
    way = lambda key: high[key] - low[key]
    along, across = way("gauge_strain_zz"), way("gauge_strain_xx") + way("gauge_strain_yy")
    modulus, ratio = -way("nominal_stress_Pa") / along, -0.5 * across / along
    need(abs(modulus / 20e9 - 1) < 0.12 and abs(ratio - 0.2) < 0.05, f"{modulus} Pa, {ratio}: asked for 20 GPa, 0.2")
    volume = [sum(r[f"gauge_strain_{k}"] for k in ("xx", "yy", "zz")) for r in rows]
    least = stress[volume.index(min(volume))] / peak
    said = re.search(r"gave (\S+) MPa, (\S+) GPa and (\S+), .*?The volume was least at (\d+) % of the peak", page, re.S)
    need(all(abs(float(s) - x) < by for s, x, by in zip(said.groups(), (peak / 1e6, modulus / 1e9, ratio, 100 * least),
                                                        (2, 0.6, 0.02, 4))),
         f"the page says {said.groups()}: {peak}, {modulus}, {ratio}, {least}")
    need(stress[-1] < 0.9 * peak and abs(summary(folder)["results"]["peak_stress_Pa"] / peak - 1) < 1e-6,
         "no peak")
    need(any("60 bodies share 290 faces, of which 290 are bonded" in n for n in summary(folder)["notes"]), "faces")


def take(page, tmp):
    """Its named blocks are files; its commands run beside them."""
    for kind, name, block in re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```", page, re.S | re.M):
        if name:
            if page in (text, walls):
                need(block == open(os.path.join(shipped, name)).read(), f"{name} of the page is not the shipped one")
            open(os.path.join(tmp, name), "w").write(block)
        for line in block.splitlines() if kind == "sh" else ():
            r = subprocess.run(["bash", "-c", line], cwd=tmp, env=environment, capture_output=True, text=True)
            need(r.returncode == 0 and r.stderr == "", f"{line}: exit {r.returncode} {r.stderr[-300:]}")


with tempfile.TemporaryDirectory() as tmp:
    page_ = open(os.path.join(DOCS, "howto", "from_other_programs.md")).read()
    shutil.copy(os.path.join(DOCS, "..", "meshes", "rock.tess"), tmp)
    neper_cells.write(os.path.join(tmp, "made.tess"), (4, 4, 8), 60)
    cells = [re.findall(r"^ \d+ (\S+) (\S+) (\S+) 0\.0+$", open(os.path.join(tmp, f)).read(), re.M)
             for f in ("rock.tess", "made.tess")]
    need(len(cells[0]) == 60 and np.allclose(*(np.array(c, float) for c in cells), atol=1e-9), "rock.tess is another")
    take(page_, tmp)
    foreign(tmp, page_)
    rock(os.path.join(tmp, "rock"), page_)
    take(text, tmp)
    oedometer(os.path.join(tmp, "oedometer_loops"))
    cyclic(os.path.join(tmp, "cyclic_triaxial"))
    shutil.copy(os.path.join(shipped, "hopper.stl"), tmp)
    take(walls, tmp)
    lid(os.path.join(tmp, "sheared_lid"))
    rough(os.path.join(tmp, "rough_shear"))
    hopper(os.path.join(tmp, "hopper"))
    three_stresses(os.path.join(tmp, "true_triaxial"))
print(f"recipes: {len(faults)} faults")
sys.exit(1 if faults else 0)
