#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Frames of a run as meshio and pyvista themselves take them, and what `grus export` writes as they read it, as far as
they are installed: others.py BUILD, or others.py PYTHON RESULTS with the folder of a package and of a run that has
frames of grains and contacts."""
import importlib.util
import os
import subprocess
import sys
import tempfile

build = os.path.abspath(sys.argv[1])
package = build if len(sys.argv) > 2 else os.path.join(build, "python")
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [package, os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import grus  # noqa: E402

from scene_tools import faults, need  # noqa: E402

found = {name: importlib.util.find_spec(name) is not None for name in ("meshio", "pyvista")}


def area(points, corners):
    a, b, c = (points[corners[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def look(frame, vtu, tmp, what):
    """The same points, cells, data and surface in all of them; `vtu`: the frame as it was exported."""
    corners, at = frame.triangles()
    whole = area(frame.points, corners) if len(at) else 0
    names = set(frame.cells)
    if found["meshio"]:
        import meshio
        mesh = frame.meshio()
        written = os.path.join(tmp, "by_meshio.vtu")
        mesh.write(written)
        for m, how in ((mesh, "given"), (meshio.read(written), "written"), (meshio.read(vtu), "exported")):
            cells = sum(len(block.data) for block in m.cells)
            need(len(m.points) == len(frame.points) and cells == len(frame.types) and names <= set(m.cell_data),
                 f"{what}, meshio, {how}: {m}")
            flat = [block.data for block in m.cells if block.type == "triangle"] or [np.empty((0, 3), int)]
            told = np.concatenate(flat)
            need(abs(area(m.points, told) - whole) <= 1e-6 * whole, f"{what}, meshio, {how}: surface")
            for name in names:
                mine, theirs = frame.cells[name], np.concatenate(m.cell_data[name])
                need(mine.shape == theirs.shape, f"{what}, meshio, {how}: {name} {mine.shape} {theirs.shape}")
                mine, theirs = np.sort(mine.ravel()), np.sort(theirs.ravel())
                need(np.allclose(mine, theirs, rtol=1e-6, equal_nan=True), f"{what}, meshio, {how}: {name}")
    if found["pyvista"]:
        import pyvista
        for m, how in ((frame.pyvista(), "given"), (pyvista.read(vtu), "exported")):
            need(m.n_points == len(frame.points) and m.n_cells == len(frame.types) and names <= set(m.cell_data.keys()),
                 f"{what}, pyvista, {how}: {m}")
            need(abs(m.compute_cell_sizes()["Area"].sum() - whole) <= 1e-6 * whole, f"{what}, pyvista, {how}: surface")
            for name in names:
                need(np.allclose(frame.cells[name], m.cell_data[name], rtol=1e-6, equal_nan=True),
                     f"{what}, pyvista, {how}: {name}")


def main():
    with tempfile.TemporaryDirectory() as tmp:
        if len(sys.argv) > 2:
            run = grus.load(sys.argv[2])
        else:
            scene = grus.read_scene(os.path.join(source, "apps", "scenes", "sand_box.toml"), loading__final_strain=0.1,
                                    output__frames=2, output__contacts=True)
            run = grus.run(scene, out=os.path.join(tmp, "ran"), threads=1)
        for what in ("grains", "contacts"):
            frame = getattr(run, what)(-1)
            need(len(frame.types) > 10, f"{what}: {frame}")
            vtu = os.path.join(tmp, what + ".vtu")
            subprocess.run([sys.executable, "-m", "grus", "export", run.folder, "--what", what, "-o", vtu], check=True,
                           env={**os.environ, "PYTHONPATH": package})
            look(frame, vtu, tmp, what)
    for name, there in found.items():
        if not there:
            print(f"others: {name} is not here: nobody has asked it (Debian: python3-{name})")
    by = " and ".join(name for name, there in found.items() if there)
    print("FAULTS" if faults else f"frames are read by {by or 'none'}")
    sys.exit(1 if faults else 0 if any(found.values()) else 77)


main()
