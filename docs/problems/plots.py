#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots of the shipped macro problems: plots.py RESULTS, a folder with the runs that each page names; draws what is
there."""
import csv
import math
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

results = sys.argv[1]
images = os.path.join(os.path.dirname(os.path.abspath(__file__)), "images")


def table(*path):
    file = os.path.join(results, *path)
    if not os.path.exists(file):
        print("not there:", file)
        return None
    with open(file, newline="") as f:
        rows = list(csv.DictReader(f))
    return {k: [float(r[k]) for r in rows] for k in rows[0]}


def page(name, left, right, draw):
    figure, axes = plt.subplots(1, 2, figsize=(10, 4))
    if draw(*axes):
        for axis, (x, y) in zip(axes, (left, right)):
            axis.set_xlabel(x), axis.set_ylabel(y), axis.grid(alpha=0.3)
            if axis.get_legend_handles_labels()[0]:
                axis.legend(fontsize=8)
        figure.tight_layout()
        figure.savefig(os.path.join(images, name + ".png"), dpi=110)
    plt.close(figure)


def oedometer(a, b):
    t = table("oedometer_block", "history.csv")
    if not t:
        return False
    strain = [-100 * e for e in t["mean_strain_zz"]]
    a.plot(strain, [-s / 1e6 for s in t["mean_stress_zz_Pa"]], "o-", label="axial")
    a.plot(strain, [-s / 1e6 for s in t["mean_stress_xx_Pa"]], "o-", label="lateral")
    b.plot(strain, t["breakages"], "o-")
    return True


def triaxial(a, b):
    drawn = False
    for name, label in (("tri5b", "5 MPa, grains break"), ("tri5h", "5 MPa, grains hold"),
                        ("tri1b", "100 kPa, grains break"), ("tri1h", "100 kPa, grains hold")):
        t = table(name, "history.csv")
        if not t:
            continue
        drawn = True
        strain = [-u / 0.05 * 100 for u in t["moved_platen_y_m"]]
        a.plot(strain, [q / p for q, p in zip(t["q_Pa"], t["p_Pa"])], label=label)
        b.plot(strain, [100 * v for v in t["strain_volumetric"]], label=label)
    return drawn


def biaxial(a, b):
    drawn = False
    for name, label in (("bi3", "packing 3"), ("bi4", "packing 4"), ("bi5", "packing 5"),
                        ("bi12", "packing 3, 12 x 24 elements")):
        t = table(name, "history.csv")
        if not t:
            continue
        drawn = True
        strain = [-u / 0.1 * 100 for u in t["moved_top_y_m"]]
        a.plot(strain, [-r / 0.05 / 1e3 for r in t["reaction_top_y_N"]], label=label)
        b.plot(strain, [100 * v for v in t["strain_volumetric"]], label=label)
    return drawn


def block(a, b):
    t = table("block", "history.csv")
    if not t:
        return False
    strain = [-u / 0.1 * 100 for u in t["moved_top_z_m"]]
    a.plot(strain, [-r / 0.05**2 / 1e3 for r in t["reaction_top_z_N"]])
    b.plot(strain, [100 * v for v in t["strain_volumetric"]])
    return True


def footing(a, b):
    t = table("foot", "history.csv")
    if not t:
        return False
    settlement = [-1e3 * u for u in t["moved_footing_y_m"]]
    a.plot(settlement, [-2 * r / 0.2 / 1e6 for r in t["reaction_footing_y_N"]])
    b.plot(settlement, t["breakages"])
    return True


def pile(a, b):
    t = table("pile", "history.csv")
    if not t:
        return False
    depth = [-1e3 * u for u in t["moved_pile_y_m"]]
    a.plot(depth, [-r / (math.pi * 0.01**2) / 1e6 for r in t["reaction_pile_y_N"]])
    b.plot(depth, t["breakages"])
    return True


def middle_layer(x, corners):
    """Of hexahedra: those that the plane through the middle of y cuts, as quadrilaterals of x and z."""
    centre = x[corners].mean(axis=1)
    middle = 0.5 * (x[:, 1].min() + x[:, 1].max())
    depth = abs(centre[:, 1] - middle)
    kept = [k for k in range(len(corners)) if depth[k] < 1.5 * depth.min() and centre[k, 1] > middle]
    quads = []
    for k in kept:
        near = sorted(corners[k], key=lambda node: x[node, 1])[:4]
        quads.append(
            sorted((x[node][[0, 2]] for node in near),
                   key=lambda p: math.atan2(p[1] - centre[k, 2], p[0] - centre[k, 0])))
    return quads, kept


def field(name, run, frame, what, label):
    """A macro field of one frame on the mesh as it stands, from macro/*.hdf (needs python3-h5py)."""
    file = os.path.join(results, run, "macro", f"macro_{frame:05}.hdf")
    try:
        import h5py
    except ImportError:
        return print("no h5py: no picture of", name)
    if not os.path.exists(file):
        return print("not there:", file)
    with h5py.File(file) as f:
        g = f["VTKHDF"]
        x = g["Points"][:] + g["PointData/displacement_m"][:]
        value = g["CellData"][what][:]
        corners = g["Connectivity"][:].reshape(len(value), -1)
    figure, axis = plt.subplots(figsize=(5, 6))
    quads = x[corners][:, :, :2]
    if corners.shape[1] == 8:
        quads, kept = middle_layer(x, corners)
        value = value[kept]
    from matplotlib.collections import PolyCollection

    patches = PolyCollection(quads, array=value, cmap="viridis", edgecolor="none")
    axis.add_collection(patches), axis.autoscale(), axis.set_aspect("equal")
    figure.colorbar(patches, label=label, shrink=0.7)
    figure.tight_layout()
    figure.savefig(os.path.join(images, name + ".png"), dpi=100)
    plt.close(figure)


def bars(a, b):
    t, h, alone = table("bars", "history.csv"), table("bars", "hopkinson.csv"), table("alone", "history.csv")
    if not t or not h:
        return False
    micro = [1e6 * x for x in t["time_s"]]
    a.plot(micro, [-1e6 * e for e in t["probe_incident_strain_yy"]], label="incident bar")
    a.plot(micro, [-1e6 * e for e in t["probe_transmitted_strain_yy"]], label="transmission bar")
    b.plot([100 * e for e in h["strain_3wave"]], [s / 1e6 for s in h["stress_3wave_Pa"]], label="three waves")
    b.plot([100 * e for e in h["strain_1wave"]], [s / 1e6 for s in h["stress_1wave_Pa"]], label="one wave")
    b.plot([100 * e for e in h["specimen_strain"]], [s / 1e6 for s in h["specimen_stress_Pa"]],
           label="the specimen's grains")
    if alone:
        b.plot([100 * e for e in alone["axial_strain"]], [s / 1e6 for s in alone["axial_stress_Pa"]], "--",
               label="one RVE alone, 500 /s")
    return True


page("oedometer_block", ("axial strain (%)", "stress (MPa)"), ("axial strain (%)", "breakages"), oedometer)
page("triaxial", ("axial strain (%)", "q / p, means of the specimen"),
     ("axial strain (%)", "volume strain (%, contraction +)"), triaxial)
page("biaxial_plane_strain", ("axial strain (%)", "axial stress (kPa)"),
     ("axial strain (%)", "volume strain (%, contraction +)"), biaxial)
page("triaxial_block", ("axial strain (%)", "axial stress (kPa)"),
     ("axial strain (%)", "volume strain (%, contraction +)"), block)
page("strip_footing", ("settlement (mm)", "footing pressure (MPa)"), ("settlement (mm)", "breakages"), footing)
page("pile_tip", ("tip displacement (mm)", "head force / area (MPa)"), ("tip displacement (mm)", "breakages"), pile)
field("biaxial_field", "bi3", 20, "void_ratio", "void ratio")
field("block_field", "block", 10, "void_ratio", "void ratio, middle plane")
field("footing_field", "foot", 10, "broken_fraction", "breakages a starting grain")
field("pile_field", "pile", 10, "broken_fraction", "breakages a starting grain")
field("triaxial_field", "tri5b", 10, "broken_fraction", "breakages a starting grain")
page("shpb_bars", ("time (µs)", "gauge strain (µm/m, compression)"), ("axial strain (%)", "axial stress (MPa)"), bars)
