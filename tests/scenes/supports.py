#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What holds and loads bonded cells, against beams and bars in closed form: supports.py BIN"""
import csv
import json
import os
import re
import sys
import tempfile

import h5py
import numpy as np

import scene_tools
from scene_tools import BRITTLE, ROCK, faults, history, need, run

rve = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-rve")
ELASTIC = ('modulus = "10 GPa"\npoissons_ratio = 0\ntension = "1 GPa"\ncohesion = "1 GPa"\n'
           'fracture_energy = "1e12 J/m^2"\n')
TENSION = ('[[clamp]]\nwhere = "z=min"\n{0}[[clamp]]\nwhere = "z=max"\nvelocity = ["0 m/s", "0 m/s", "10 mm/s"]\n'
           '{0}[loading]\nkind = "free"\nduration = "{1} ms"\n')


def box(size, cells):
    return (f'[numerics]\nsafety = 0.8\n[packing]\nkind = "voronoi"\nbox = {json.dumps([f"{x} mm" for x in size])}\n'
            f'cells = {cells}\n')


def test(tmp, name, text, *more):
    path, out = os.path.join(tmp, name + ".toml"), os.path.join(tmp, name)
    with open(path, "w") as f:
        f.write(text)
    r = run(rve, path, "-o", out, "--quiet", "--force", "--threads", "1", *more)
    need(r.returncode == 0, f"{name}: {r.stderr}")
    rows = [{k: float(v) for k, v in row.items()} for row in history(out)]
    worst = max(abs(x["energy_error"]) for x in rows)
    need(worst < 0.01, f"{name}: energy error {worst}")
    return rows, out


def cantilever(tmp):
    """A clamped beam of 160 cells under a dead load at its end: 0.977 of Euler's deflection (independent assembly)."""
    size, force = (50e-3, 5e-3, 5e-3), 0.1
    rows, _ = test(
        tmp, "cantilever",
        box((50, 5, 5), 160) + ROCK + ELASTIC +
        f'[[clamp]]\nwhere = "x=min"\n[[load]]\nwhere = "x=max"\nforce = ["0 N", "0 N", "{force} N"]\nramp = "1 ms"\n'
        '[loading]\nkind = "free"\nduration = "12 ms"\n'
    )
    last = rows[-1]
    euler = force * size[0]**3 / (3 * 10e9 * size[1] * size[2]**3 / 12)
    deflection = 2 * last["bond_J"] / force  # at rest half the load's work is held
    need(
        abs(last["displacement_m"] / deflection - 1) < 0.01,
        f"cantilever: its end moves by {last['displacement_m'] / deflection:.4f} of that")
    need(
        abs(last["load_N"] / force - 1) < 1e-9 and rows[1]["load_N"] < 0.1 * force,
        "cantilever: the load is not what was asked for")
    need(abs(deflection / euler - 0.977) < 0.01, f"cantilever: {deflection / euler:.4f} of Euler's deflection")
    need(
        abs(last["wall0_fz_N"] / force - 1) < 0.01,
        f"cantilever: the clamp bears {last['wall0_fz_N'] / force:.4f} of the load")
    # The dead load gave twice what is held: the rest is in the dampers.
    need(
        abs((last["damping_J"] + last["bond_J"] + last["kinetic_J"]) / last["work_J"] - 1) < 1e-3,
        "cantilever: work of the load is not where it should be")
    return deflection


def bar(tmp):
    """Between two clamps a network of ratio 1 has its modulus exactly, whether the ends may slide or not."""
    for slides in ("", "slides = true\n"):
        rows, _ = test(
            tmp, "bar" + slides[:1],
            box((5, 5, 10), 120) + ROCK.replace("0.3", "0.7") + ELASTIC + TENSION.format(slides, 0.3) +
            '[output]\nhistory_interval = "0.15 ms"\n')
        last = rows[-1]
        held = 0.5 * 10e9 * (last["displacement_m"] / 10e-3)**2 * 250e-9
        need(abs(last["bond_J"] / held - 1) < 1e-4, f"bar: holds {last['bond_J'] / held:.6f} of half of E strain^2")
        # Waves and dampers: the strain grows at 1/s, a wave passes in 5 us.
        stress = 10e9 * last["displacement_m"] / 10e-3
        need(
            abs(last["nominal_stress_Pa"] / stress - 1) < 0.03,
            f"bar: bears {last['nominal_stress_Pa'] / stress:.4f} of E strain")
        need(
            abs(last["wall0_fz_N"] + last["wall1_fz_N"]) < 0.02 * last["load_N"],
            "bar: its clamps bear different loads")


def one_cell(tmp):
    """A single cell between two clamps: two springs of 2 E A / L in a row, so E A / L."""
    rows, _ = test(
        tmp, "one",
        box((5, 5, 10), 1) + ROCK.replace("0.3", "0.7") + ELASTIC + TENSION.format("", 0.3) +
        '[output]\nhistory_interval = "0.15 ms"\n')
    last = rows[-1]
    held = 0.5 * 10e9 * (last["displacement_m"] / 10e-3)**2 * 250e-9
    need(
        abs(last["elastic_J"] / held - 1) < 0.01,
        f"one cell: holds {last['elastic_J'] / held:.4f} of half of E strain^2")
    stress = 10e9 * last["displacement_m"] / 10e-3
    need(
        abs(last["nominal_stress_Pa"] / stress - 1) < 0.03,
        f"one cell: bears {last['nominal_stress_Pa'] / stress:.4f} of E strain")


def few_cells(tmp):
    """Few cells across are stiffer than `modulus`, as the note says: by the fabric of their faces, against what the bar
    holds. One cell, and clusters that nothing bonds to each other, are no network, of which there is nothing to say."""
    for name, size, cells, poisson, noted_at_all, true, off in (("few", (3, 3, 6), 54, 0.2, True, None, 0.05),
                                                                ("thin", (3, 3, 6), 54, 0.1, True, None, 0.03),
                                                                ("single", (3, 3, 6), 1, 0.1425, False, 1 / 0.7150, 0),
                                                                ("exact", (3, 3, 6), 54, 0, False, 1, 0)):
        duration, elastic = 0.3, ELASTIC.replace("poissons_ratio = 0\n", f"poissons_ratio = {poisson}\n")
        rows, out = test(
            tmp, name,
            box(size, cells) + ROCK.replace("0.3", "0.7") + elastic + TENSION.format("slides = true\n", duration) +
            '[output]\nhistory_interval = "0.15 ms"\n')
        last = rows[-1]
        held = 0.5 * 10e9 * (last["displacement_m"] / (size[2] * 1e-3))**2 * size[0] * size[1] * size[2] * 1e-9
        stiffer = (last["bond_J"] if cells > 1 else last["elastic_J"]) / held
        noted = [
            re.search(r"along z these Voronoi cells are some (\d+) % stiffer", n)
            for n in json.load(open(os.path.join(out, "summary.json"))).get("notes", [])
        ]
        told = [1 + int(n[1]) / 100 for n in noted if n]
        need(len(told) == noted_at_all and all(abs(x - stiffer) < off for x in told),
             f"few cells, {name}: {told} told, {stiffer:.4f} held")
        need(true is None or abs(stiffer / true - 1) < 0.01,
             f"few cells, {name}: {stiffer:.4f} held, {true} by the moduli")
    path = os.path.join(tmp, "clusters.toml")
    with open(path, "w") as f:
        f.write(box((3, 3, 6), 54) + 'grains = "clusters"\nclusters = 8\n' + ROCK.replace("0.3", "0.7") +
                ELASTIC.replace("poissons_ratio = 0\n", "") + TENSION.format("slides = true\n", 0.3))
    for between in (0, 1):
        r = run(rve, path, "--check", *(["--set", 'material.rock.bond.between="1 GPa"'] if between else []))
        need(r.returncode == 0 and ("these Voronoi cells are some" in r.stdout) == between,
             f"clusters {'bonded' if between else 'apart'}: {r.stdout} {r.stderr}")


def tension(tmp):
    """Direct tension of 216 brittle cells: 0.69 to 0.70 of the bonds' strength (independent assembly); bursts are all
    that broke."""
    small_steps = ("--set", "numerics.safety=0.2")
    rows, out = test(tmp, "tension",
                     box((6, 6, 6), 216) + ROCK + BRITTLE + TENSION.format("", 0.6)
                     + '[output]\nbursts = "1 us"\nbroken_bonds = true\n',
                     *small_steps)
    peak = max(x["nominal_stress_Pa"] for x in rows) / 10e6
    need(0.63 < peak < 0.76, f"tension: peak {peak:.3f} of the bonds' strength")
    need(rows[-1]["nominal_stress_Pa"] < 2e6, "tension: it still bears the load")
    with open(os.path.join(out, "bursts.csv")) as f:
        bursts = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
    told = json.load(open(os.path.join(out, "summary.json")))["bursts"]
    need(
        sum(b["bonds"] for b in bursts) == rows[-1]["bonds_broken"] > 100,
        "tension: bursts do not sum to the broken bonds")
    need(
        abs(sum(b["energy_J"] for b in bursts) / rows[-1]["fracture_J"] - 1) < 1e-6,
        "tension: bursts do not sum to the fracture's energy")
    with open(os.path.join(out, "broken_bonds.csv")) as f:
        each = list(csv.DictReader(f))
    energy = sum(float(b["energy_J"]) for b in each)
    need(len(each) == rows[-1]["bonds_broken"] and abs(energy / rows[-1]["fracture_J"] - 1) < 1e-6,
         f"tension: {len(each)} broken bonds that took {energy} J")
    pairs = {(int(b["grain_a"]), int(b["grain_b"])) for b in each}
    need(len(pairs) == len(each) and all(0 <= min(p) < max(p) < 216 for p in pairs), "tension: pairs of broken bonds")
    need(sum(b["mode"] == "tension" for b in each) > 0.8 * len(each), "tension: bonds are not drawn apart")
    need(told["count"] == len(bursts) and told["largest"] == max(b["bonds"] for b in bursts), f"tension: {told}")
    need(1 < told["exponent"] < 3 and told["exponent_error"] < 0.5, f"tension: exponent {told['exponent']}")
    need(all(0 <= b[k] <= 6.1e-3 for b in bursts for k in ("x_m", "y_m", "z_m")),
         "tension: bursts outside of the sample")
    told = []
    for window in ("1 us", "100 us"):
        rows, out = test(
            tmp, "window",
            box((4, 4, 4), 64) + ROCK + BRITTLE + TENSION.format("", 0.4) + f'[output]\nbursts = "{window}"\n',
            *small_steps)
        with open(os.path.join(out, "bursts.csv")) as f:
            told.append((rows, len(f.readlines()) - 1))
    need(told[0][0] == told[1][0], "tension: the window of bursts changes the run")
    need(told[0][1] > 2 * told[1][1] > 0, f"tension: {told[0][1]} and {told[1][1]} bursts in windows of 1 and 100 us")


def rollers(tmp):
    """Four-point bending: the middle bends by M / E I, and the nominal stress is that of its fibre."""
    outer, inner, width, height = 60e-3, 20e-3, 5e-3, 10e-3
    rows, out = test(
        tmp, "rollers",
        box((66, 5, 10), 400) + ROCK + ELASTIC +
        '[loading]\nkind = "rollers"\nouter = "60 mm"\ninner = "20 mm"\nradius = "3 mm"\nspeed = "20 mm/s"\n'
        'final_displacement = "0.05 mm"\n[output]\nframes = 2\n'
    )
    last = rows[-1]
    arm = (outer - inner) / 2
    need(
        abs(last["nominal_stress_Pa"] / (3 * last["load_N"] * arm / (width * height**2)) - 1) < 1e-9,
        "rollers: nominal stress")
    with open(os.path.join(out, "grains.hdf.series")) as f:
        files = [x["name"] for x in json.load(f)["files"]]
    points = [np.array(h5py.File(os.path.join(out, name))["VTKHDF/Points"]) for name in (files[0], files[-1])]
    x, z = points[0][:, 0] - 33e-3, points[0][:, 2] - 5e-3
    middle = np.abs(x) < 0.4 * inner
    basis = np.stack([np.ones_like(x), x, z, x**2, x * z, z**2], axis=1)[middle]
    fit = np.linalg.lstsq(basis, (points[1] - points[0])[middle, 2], rcond=None)[0]
    wanted = 0.5 * last["load_N"] * arm / (10e9 * width * height**3 / 12)
    need(abs(2 * fit[3] / wanted - 1) < 0.05, f"rollers: curvature {2 * fit[3]:.4g} instead of {wanted:.4g}")
    three, _ = test(
        tmp, "three",
        box((66, 5, 10), 400) + ROCK + ELASTIC +
        '[loading]\nkind = "rollers"\nouter = "60 mm"\nradius = "3 mm"\nspeed = "20 mm/s"\n'
        'final_displacement = "0.05 mm"\n'
    )
    last = three[-1]
    need(
        abs(last["nominal_stress_Pa"] / (1.5 * last["load_N"] * outer / (width * height**2)) - 1) < 1e-9,
        "rollers: nominal stress of three points")


def constant_p(tmp):
    """True triaxial: the mean stress stays while all is whole, and the strength grows with it; cells glued to
    plates."""
    peaks = []
    for pressure in (40e6, 80e6):
        rows, _ = test(
            tmp, f"p{pressure:g}",
            box((10, 10, 10), 64) + '[boundary]\nkind = "walls"\nbonded = "normal"\nfriction = 0\n' + ROCK +
            'modulus = "20 GPa"\npoissons_ratio = 0\ncriterion = "strain-sum"\nstrain = 0.002\nrotation = 0.05\n'
            f'[loading]\nkind = "constant-p"\naxis = "z"\npressure = "{pressure:g} Pa"\nconsolidation = "0.3 ms"\n'
            'strain_rate = 10\nfinal_strain = 0.008\n',
            "--set", "numerics.safety=0.2")
        whole = [x for x in rows if x["time_s"] > 0.32e-3 and x["bonds_broken"] == 0]
        off = max(abs(x["p_Pa"] / pressure - 1) for x in whole)
        need(len(whole) > 8 and off < 0.01, f"constant-p: p is {off:.4f} off in {len(whole)} rows")
        need(all(abs(x["q_Pa"] - (x["wall_stress_xx_Pa"] - x["wall_stress_zz_Pa"])) < 0.02 * pressure for x in whole),
             "constant-p: q is not the difference of the stresses")
        # With equal stiffnesses a network is isotropic elastic on any mesh: 3 G on the deviatoric strain.
        modulus = (whole[-1]["q_Pa"] - whole[0]["q_Pa"]) / (whole[-1]["strain_deviatoric"] -
                                                            whole[0]["strain_deviatoric"])
        need(abs(modulus / 30e9 - 1) < 0.03, f"constant-p: 3 G is {modulus / 1e9:.2f} GPa instead of 30")
        peaks.append(max(x["q_Pa"] for x in rows[:-1]))
        need(rows[-1]["bonds_broken"] > 50, f"constant-p: {rows[-1]['bonds_broken']} bonds broken")
    need(peaks[1] > 1.2 * peaks[0], f"constant-p: peaks {peaks}")


with tempfile.TemporaryDirectory() as folder:
    for check in (cantilever, bar, one_cell, few_cells, tension, rollers, constant_p):
        check(folder)
print("supports:", len(faults), "faults")
sys.exit(bool(faults))
