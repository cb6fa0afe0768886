# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bonded cells, very many."""
from bench import Run, case

SIDE = 46e-3
STRUCK = (
    f"[packing]\nkind = \"voronoi\"\nbox = [{SIDE}, {SIDE}, {SIDE}]\ncells = 100000\nrelax = 2\n[material.rock]\n"
    "density = 2500\ncontact = \"overlap\"\nfriction = 0.5\n"
    "[material.rock.bond]\nmodulus = 20e9\npoissons_ratio = 0.2\ntension = 1e9\ncohesion = 1e9\nfriction_angle = 0.5\n"
    "fracture_energy = 1e6\n"
    "[[clamp]]\nwhere = \"z=min\"\n[[clamp]]\nwhere = \"z=max\"\nvelocity = [0, 0, -1.0]\n[loading]\nkind = \"free\"\n"
    "duration = 3e-6\n[output]\nhistory_interval = 2e-7\n"
)


@case("10^5 bonded cells between two clamps, one of which strikes at 1 m/s",
      "made, six to eight bonds a cell, the stress behind the wave rho c v to 3 %, energy error < 1 %", slow=True)
def many(tmp):
    r = Run(tmp, STRUCK, threads=2)
    if r.exit != 0:
        return r.error[-90:], False
    cells, bonds = r.summary["counts"]["grains_start"], r.last("bonds")
    # Plane wave: sigma = rho c v, c of confined compression, M = E (1 - v) / ((1 + v) (1 - 2 v)).
    stress = r.last("load_N") / SIDE ** 2 / (2500 * 20e9 * 0.8 / (1.2 * 0.6)) ** 0.5
    return f"{cells} cells, {bonds / cells:.2f} bonds each, stress {stress:.3f}, energy {r.energy:.0e}", \
        cells > 99000 and 6 < bonds / cells < 8 and abs(stress - 1) < 0.03 and r.energy < 0.01
