#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What frames show, held against history.csv and the grains themselves: frames.py BIN"""
import os
import shutil
import sys
import tempfile

import h5py
import numpy as np

from scene_tools import faults, history, need, run, shipped

rve, report = (os.path.join(os.path.abspath(sys.argv[1]), name) for name in ("grus-rve", "grus-report"))


def frame(path):
    with h5py.File(path, "r") as f:
        grid = f["VTKHDF"]
        return grid["Points"][:].astype(float), grid["Connectivity"][:], grid["Offsets"][:], grid["Types"][:], {
            k: v[:].astype(float) for k, v in grid["CellData"].items()
        }


def grains(path):
    """Centre, volume and fields of every grain from its triangles, and the outline's corners."""
    points, connectivity, offsets, types, fields = frame(path)
    lines = types == 3
    need(lines.sum() == 12 and all(np.isnan(v[lines]).all() and not np.isnan(v[~lines]).any() for v in fields.values()),
         f"{path}: {lines.sum()} lines of the outline, or fields that say something of them")
    corners = connectivity[offsets[:-1][~lines][:, None] + np.arange(3)]
    x = points[corners]
    ids, owner = np.unique(fields["id"][~lines], return_inverse=True)
    middle = np.stack([np.bincount(owner, weights=x[:, :, k].sum(1))
                       for k in range(3)], 1) / np.bincount(owner)[:, None] / 3
    volume = np.bincount(
        owner, weights=np.einsum("ni,ni->n", x[:, 0] - middle[owner],
                                 np.cross(x[:, 1] - middle[owner], x[:, 2] - middle[owner]))) / 6
    first = np.unique(owner, return_index=True)[1]
    return middle, volume, {k: v[~lines][first] for k, v in fields.items()
                            }, points[np.unique(connectivity[offsets[:-1][lines][:, None] + np.arange(2)])]


REST = """
[material.ball]
density = 2500
youngs_modulus = "5 MPa"
poissons_ratio = 0.2
friction = 0.4
restitution = 0.05
[[grain]]
radius = "5 mm"
position = ["1 mm", "2 mm", "4.99 mm"]
[[wall]]
point = [0, 0, "-1 m"]
normal = [0, 0, 1]
[[wall]]
shape = "mesh"
path = "floor.stl"
point = [0, 0, 0]
velocity = ["1 um/s", 0, 0]
[loading]
kind = "free"
gravity = [0, 0, -9.81]
duration = "200 ms"
[output]
history_interval = "100 ms"
frames = 2
"""


def walls_of_triangles(tmp):
    """A ball at rest on two triangles: their number, their speed, and its weight on both."""
    corners = ((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1))
    with open(os.path.join(tmp, "floor.stl"), "w") as f:
        f.write("solid floor\n" + "".join("facet normal 0 0 1\nouter loop\n" + "".join(
            "vertex %g %g 0\n" % corners[k] for k in of) + "endloop\nendfacet\n" for of in ((0, 1, 2), (0, 2, 3)))
            + "endsolid floor\n")
    with open(os.path.join(tmp, "rest.toml"), "w") as f:
        f.write(REST)
    out = os.path.join(tmp, "rest")
    r = run(rve, os.path.join(tmp, "rest.toml"), "-o", out, "--quiet")
    need(r.returncode == 0, f"a ball on triangles: {r.stderr}")
    points, _, _, types, fields = frame(os.path.join(out, "walls", "walls_00001.hdf"))
    weight = 2500 * 4 / 3 * np.pi * 0.005**3 * 9.81
    need(list(types) == [5, 5] and list(fields["wall"]) == [1, 1], f"triangles of wall 1: {types} {fields['wall']}")
    need(np.allclose(fields["wall_force_N"], [[0, 0, -weight]] * 2, rtol=1e-3, atol=2e-3 * weight),
         f"the ball's weight {weight} on its wall: {fields['wall_force_N']}")
    need(np.allclose(fields["velocity"], [[1e-6, 0, 0]] * 2) and np.ptp(points[:, 0]) > 0.19,
         "the floor's speed and size")


def main(tmp):
    # A periodic cell that is sheared: grains leave it, and are drawn inside where that is asked for.
    cell = [
        rve,
        os.path.join(shipped, "sand_rve.toml"), "--quiet", "--set", "material.sand.fracture=", "--set",
        "loading.kind=velocity-gradient", "--set", "loading.velocity_gradient=[[0, 0, 400], [0, 0, 0], [0, 0, -100]]",
        "--set", "loading.duration=0.4 ms", "--set", "loading.strain_rate=", "--set", "loading.final_strain=", "--set",
        "loading.axis=", "--set", "output.history_interval=0.1 ms", "--set", "output.frames=2", "--set",
        "output.contacts=true"
    ]
    seen = {}
    for name, wrapped in (("open", "false"), ("wrapped", "true")):
        out = os.path.join(tmp, name)
        r = run(*cell, "-o", out, "--set", "output.wrapped=" + wrapped)
        need(r.returncode == 0, f"{name}: {r.stderr}")
        need(
            sorted(os.listdir(os.path.join(out, "contacts"))) == ["contacts_00000.hdf", "contacts_00001.hdf"]
            and "contacts/contacts_00001.hdf" in open(os.path.join(out, "contacts.hdf.series")).read(),
            f"{name}: contact frames")
        last = {k: float(v) for k, v in history(out)[-1].items()}
        middle, volume, fields, outline = grains(os.path.join(out, "grains", "grains_00001.hdf"))
        vectors = np.stack([outline[k] - outline[0] for k in (1, 2, 4)], 1)
        cell_volume = abs(np.linalg.det(vectors))
        # 512 triangles have 0.977 of the sphere's volume; a float's ends and h5 singles leave 1e-4.
        solid = (4 / 3 * np.pi * fields["radius"] ** 3).sum()
        need(
            abs(solid / cell_volume / last["solid_fraction"] - 1) < 1e-4,
            f"{name}: solid {solid / cell_volume} of the outline, {last['solid_fraction']} in history.csv")
        need(0.97 < volume.sum() / solid < 0.985, f"{name}: triangles hold {volume.sum() / solid} of the grains")
        need(np.allclose(np.linalg.norm(fields["velocity"], axis=1), fields["speed"], rtol=1e-5),
             f"{name}: velocity and speed")
        place = np.linalg.solve(vectors, (middle - outline[0]).T)
        need((place.min() > -1e-3 and place.max() < 1 + 1e-3) == (name == "wrapped"),
             f"{name}: grains from {place.min()} to {place.max()} of the cell")
        # Love-Weber: the network's forces and branches are the stress. Damped contacts and single precision leave 1e-4.
        points, connectivity, offsets, types, force = frame(os.path.join(out, "contacts", "contacts_00001.hdf"))
        branch = points[connectivity[1::2]] - points[connectivity[0::2]]
        stress = -np.einsum("ci,cj->ij", force["force_N"], branch) / cell_volume
        told = np.array([[last["stress_" + "xyz"[min(i, j)] + "xyz"[max(i, j)] + "_Pa"] for j in range(3)]
                         for i in range(3)])
        need(
            np.abs(0.5 * (stress + stress.T) - told).max() < 2e-3 * np.abs(told).max(),
            f"{name}: stress of the network\n{stress}\nof history.csv\n{told}")
        need(
            abs(2 * len(types) / len(volume) / last["coordination"] - 1) < 0.2,
            f"{name}: {len(types)} contacts of {len(volume)} grains, coordination {last['coordination']}")
        size = np.linalg.norm(force["force_N"], axis=1)
        need(
            np.allclose(np.hypot(force["normal_force_N"], force["tangential_force_N"]), size, rtol=1e-4,
                        atol=1e-9 * size.max()), f"{name}: parts of the force")
        seen[name] = force["normal_force_N"]
    need(np.array_equal(seen["open"], seen["wrapped"]), "wrapping changes forces")
    # A test that ends at its stress shows its last state; a box of walls has its outline.
    out = os.path.join(tmp, "box")
    r = run(rve, os.path.join(shipped, "sand_box.toml"), "-o", out, "--quiet", "--set",
            "loading.kind=oedometric-stress", "--set", "loading.final_stress=2 MPa", "--set", "loading.final_strain=",
            "--set", "output.frames=3", "--set", "output.gradings=3")
    need(r.returncode == 0, f"box: {r.stderr}")
    last = float(history(out)[-1]["time_s"])
    need(
        abs(float(open(os.path.join(out, "grading.csv")).read().splitlines()[-1].split(",")[0]) / last - 1) < 1e-6,
        "grading.csv does not hold the last state of a test that ended early")
    middle, volume, fields, outline = grains(os.path.join(out, "grains", "grains_00001.hdf"))
    size = np.ptp(outline, axis=0)
    need(
        np.allclose(size[:2], 6e-3, rtol=1e-5)
        and abs(1 - size[2] / 6e-3 - float(history(out)[-1]["axial_strain"])) < 1e-5, f"box: outline {size}")
    for changes, words in ((["output.contacts=true"], "give frames"),
                           (["output.wrapped=true", "output.frames=2"], "periodic")):
        r = run(rve, os.path.join(shipped, "sand_box.toml"), "--check", *[a for c in changes for a in ("--set", c)])
        need(r.returncode == 2 and words in r.stderr, f"{changes}: exit {r.returncode} {r.stderr!r}")
    pvpython = ([] if os.environ.get("DISPLAY") else ["xvfb-run", "-a"]) + ["pvpython"]
    if all(map(shutil.which, [c for c in pvpython if not c.startswith("-")])):
        picture = os.path.join(tmp, "picture.png")
        r = run(*pvpython, os.path.join(shipped, "..", "paraview", "render.py"), os.path.join(tmp, "wrapped"), picture)
        need(r.returncode == 0 and os.path.exists(picture) and os.path.getsize(picture) > 20000,
             f"render.py: exit {r.returncode} {r.stderr[-300:]}")
        print("ParaView has rendered")
    else:
        print("ParaView, or a screen for it, is not installed: its script was not run")


with tempfile.TemporaryDirectory() as folder:
    main(folder)
    walls_of_triangles(folder)
print(f"frames: {len(faults)} faults")
sys.exit(1 if faults else 0)
