# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots of bonded cells: the load, what broke, and a picture of the last frame by fragment."""
import glob
import os

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402


def last_frame(folder):
    """Triangles (n, 3, 3) and their fragments (n) of the last frame; None without frames, or without h5py."""
    files = sorted(glob.glob(os.path.join(folder, "grains", "grains_*.hdf")))
    try:
        import h5py
    except ImportError:
        return None
    if not files:
        return None
    with h5py.File(files[-1], "r") as f:
        grid = f["VTKHDF"]
        if "fragment" not in grid["CellData"]:
            return None
        points, triangles = grid["Points"][:], grid["Connectivity"][:].reshape(-1, 3)
        return points[triangles], grid["CellData/fragment"][:].astype(int)


def picture(folder, axis_names="xyz"):
    """draw(ax) of the last frame, seen along its shortest side; None where there is none."""
    frame = last_frame(folder)
    if frame is None:
        return None
    triangles, fragment = frame
    size = triangles.reshape(-1, 3).max(0) - triangles.reshape(-1, 3).min(0)
    along = int(np.argmin(size))
    across = [k for k in range(3) if k != along]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])[:, along]
    seen = np.flatnonzero(normal > 1e-3 * np.abs(normal).max())
    seen = seen[np.argsort(triangles[seen][:, :, along].mean(axis=1), kind="stable")]  # painter's order
    cells = np.bincount(fragment)
    alone = cells[fragment[seen]] <= cells.max() / 20
    colours = plt.cm.tab10(fragment[seen] % 10)
    colours[alone] = (0.55, 0.55, 0.55, 1)

    def draw(ax):
        ax.add_collection(PolyCollection(1e3 * triangles[seen][:, :, across], facecolors=colours, edgecolors=colours, linewidths=0.2))
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.set(xlabel=f"{axis_names[across[0]]} (mm)", ylabel=f"{axis_names[across[1]]} (mm)", title="fragments at the end (grey: small ones)")
    return draw


def load_plot(name, c):
    """draw(ax): nominal stress and bonds that are left."""
    def draw(ax):
        if "nominal_stress_Pa" in c:
            ax.plot([1e3 * v for v in c["displacement_m"]], [v / 1e6 for v in c["nominal_stress_Pa"]], "k")
            ax.set(xlabel="displacement of the platen (mm)", ylabel="nominal stress (MPa)")
            x = [1e3 * v for v in c["displacement_m"]]
        else:
            x = c["axial_strain"]
            ax.plot(x, [v / 1e6 for v in c["axial_stress_Pa"]], "k")
            ax.set(xlabel="axial strain", ylabel="axial stress (MPa)")
        other = ax.twinx()
        other.plot(x, c["bonds_broken"], "C3", label="bonds broken")
        other.plot(x, c["fragments"], "C0", label="fragments")
        other.legend(fontsize=8, loc="upper left")
        ax.set_title(f"{name}: load and damage")
    return draw
