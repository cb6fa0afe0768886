# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of a macro problem's cells against what the same cells show of themselves: their grains and contacts, made
again from the places of the grains; what grus-rve prepares of the same scene."""
import numpy as np

from values_cells import CELL, SQUARE
from values_devices import BLOCK, LOAD, WHOLE
from values_samples import K
from values_tools import PARTS, Frame, voigt

LINEAR = WHOLE.replace(
    'youngs_modulus = "6 GPa"\npoissons_ratio = 0.17',
    f'contact = "linear"\nnormal_stiffness = {K}\nshear_ratio = 0.5').replace(
    "friction = 0.5\nrestitution = 0.5", "friction = 0\nrestitution = 1")
SHOWN = '[[probe]]\nname = "one"\nat = [0, 0, 0]\nframes = true\n'
REST = '[loading]\nkind = "free"\nduration = "1 ns"\n'


def sheared(values):
    """A cube of grains under an elastic one, sheared in all ways: its mean strain by the nodes that a frame shows."""
    text = BLOCK.replace("pressure_floor = 1e6\n", "")
    text = text.replace('"10 mm"], cells = [1, 1, 1]', '"20 mm"], cells = [1, 1, 2]')
    text += """[[region]]
where = "z>0.01"
material = "elastic"
youngs_modulus = "200 MPa"
poissons_ratio = 0.2
density = 1500
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
where = "z=max"
displacement = ["60 um", "-40 um", "-0.1 mm"]
""" + LOAD + "[output]\nframes = 2\n"
    run = values.run("bvp", "sheared_cube", text, "solve.increments=2", files=(("cell.toml", LINEAR),))
    frame = run.frames("macro")[-1]
    x, u = frame.points, frame.nodes["displacement_m"].reshape(-1, 3)
    corners = frame.connectivity.reshape(-1, 8)
    low = corners[np.argmin(x[corners].mean(1)[:, 2])]
    gradient = np.linalg.lstsq(x[low] - x[low].mean(0), u[low], rcond=None)[0].T  # of a box: that of its middle
    strain = 0.5 * (gradient + gradient.T)
    for k, part in enumerate(PARTS):
        values.same(f"bvp.columns:grains_strain_{part}", run.last[f"grains_strain_{part}"],
                    (1 if k < 3 else 2) * voigt(strain)[k], 1e-3, 1e-7)


def balance_of(grains, edges):
    """Mean resultant of spheres over the mean force of their linear springs, without friction and dashpots."""
    x, r = grains["centre"], grains["radius"]
    apart = x[None] - x[:, None]
    away = np.linalg.solve(edges, apart.reshape(-1, 3).T)
    apart = (edges @ (away - np.round(away))).T.reshape(apart.shape)
    distance = np.linalg.norm(apart, axis=2) + 1e3 * np.eye(len(r))
    force = K * np.maximum(0, r[:, None] + r[None] - distance)
    sums = np.einsum("ij,ijk->ik", force / distance, apart)
    return np.linalg.norm(sums, axis=1).mean() / force[force > 0].mean()


def resting(values):
    """How far the cells are from rest, by the overlaps of their grains."""
    text = SQUARE[:SQUARE.index("[solve]")].replace("grading = true\n", "").replace(
        'pressure = "1 MPa"\nhistory = "constant"', 'displacement = [0, "free"]') + LOAD + "[output]\nframes = 2\n"
    run = values.run("bvp", "at_rest", text, files=(("cell.toml", LINEAR),))
    worst = []
    for name in ("one", "two"):
        frame = Frame(run.path(run.series(f"grains_{name}")[-1]))
        worst.append(balance_of(frame.grains(), frame.lines()[1]))
    values.same("bvp.columns:worst_unbalanced_force", run.last["worst_unbalanced_force"], max(worst), 0.02)


def prepared(values):
    """The stress that each packing was prepared to, and the grading that it begins with, by grus-rve alone."""
    text = SQUARE[:SQUARE.index("[solve]")] + LOAD + "[output]\nframes = 2\n"
    run = values.run("bvp", "prepared", text, "solve.increments=2", files=(("cell.toml", CELL),))
    off, shown = [], run.series("grains_one")[-1].replace("grains_one", "grains_{}")
    for variant, name in enumerate(("one", "two")):
        alone = values.run("rve", f"variant{variant}", CELL + REST + "[output]\nframes = 1\n",
                           f"packing.seed={3 + variant}", "numerics.safety=0.5")  # that of a macro problem's cells
        stress = [alone.columns[f"stress_{k}_Pa"][0] for k in ("xx", "yy", "zz")]
        off.append(np.abs(np.array(stress) / -1e6 - 1).max())
        # Of fines, up to a tenth of what has broken, the mean of ln(d_ref / d) is ln(d_ref / top) + 1 / (3 - 2.6).
        now, first = (f.grains()["radius"] for f in (Frame(run.path(shown.format(name))), alone.frames()[0]))
        d, m, whole = (2 * first, 2 * now), (first**3, now**3), (first**3).sum()
        fines = whole - m[1].sum()
        logs = [(x * np.log(d[0].max() / y)).sum() / whole for x, y in zip(m, d)]
        logs[1] += fines / whole * (np.log(d[0].max() / (0.1 * d[0].mean())) + 2.5)
        values.same(f"bvp.columns:probe_{name}_breakage_einav", run.last[f"probe_{name}_breakage_einav"],
                    (logs[1] - logs[0]) / (2.5 - logs[0]), 0.01)
    values.same("bvp.summary:preparation.worst_stress_error", run.told["preparation"]["worst_stress_error"], max(off),
                1e-4)


def held(values):
    for check in (sheared, resting, prepared):
        check(values)
