# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bonded cells: very many, and all their bonds at once."""
from bench import Run, case

ROCK = ("[packing]\nkind = \"voronoi\"\nbox = {box}\ncells = {cells}\nrelax = {relax}\n[material.rock]\ndensity = 2500\ncontact = \"overlap\"\nfriction = 0.5\n"
        "[material.rock.bond]\nmodulus = 20e9\npoissons_ratio = 0.2\ntension = {tension!r}\ncohesion = 18e6\nfriction_angle = 0.5\nfracture_energy = 15.0\n"
        "[[clamp]]\nwhere = \"z=min\"\n[[clamp]]\nwhere = \"z=max\"\nvelocity = [0, 0, {speed!r}]\n[loading]\nkind = \"free\"\nduration = {duration!r}\n")


@case("10^5 bonded cells between two clamps, one of which strikes at 1 m/s", "made, six to eight bonds a cell, the stress behind the wave E v / c to 3 %, energy error < 1 %", slow=True)
def many(tmp):
    side = 46e-3
    scene = ROCK.format(box=[side] * 3, cells=100000, relax=2, tension=1e9, speed=-1.0, duration=3e-6)
    r = Run(tmp, scene.replace("tension = 1000000000.0\ncohesion = 18e6", "tension = 1e9\ncohesion = 1e9").replace("fracture_energy = 15.0", "fracture_energy = 1e6"), "output.history_interval=\"0.2 us\"", threads=2)
    if r.exit != 0:
        return r.error[-90:], False
    cells, bonds = r.summary["counts"]["grains_start"], r.last("bonds")
    load = r.last("load_N") / side ** 2
    # Plane wave: sigma = rho c v, c of confined compression, M = E (1 - v) / ((1 + v) (1 - 2 v)).
    expected = (2500 * 20e9 * 0.8 / (1.2 * 0.6)) ** 0.5
    return f"{cells} cells, {bonds / cells:.2f} bonds each, stress {load / expected:.3f}, energy {r.energy:.0e}", \
        cells > 99000 and 6 < bonds / cells < 8 and abs(load / expected - 1) < 0.03 and r.energy < 0.01
