#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots of the shipped macro problems: plots.py RESULTS, a folder with the runs that each page names; draws what is there."""
import csv
import math
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

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
    for name, label, pressure in (("tri5b", "5 MPa, grains break", 5e6), ("tri5n", "5 MPa, grains hold", 5e6), ("tri1b", "100 kPa, grains break", 1e5), ("tri1n", "100 kPa, grains hold", 1e5)):
        t = table(name, "history.csv")
        if not t:
            continue
        drawn = True
        strain = [-100 * e for e in t["mean_strain_yy"]]
        area = math.pi * 0.025**2
        a.plot(strain, [-r / area / pressure - 1 for r in t["reaction_platen_y_N"]], ".-", label=label)
        first = math.pi * 0.025**2 * 0.05
        b.plot(strain, [100 * (v / first - 1) for v in t["volume_m3"]], ".-", label=label)
    return drawn


def biaxial(a, b):
    t = table("biaxial", "history.csv")
    if not t:
        return False
    strain = [-100 * e for e in t["mean_strain_yy"]]
    a.plot(strain, [-r / 0.05 / 1e3 for r in t["reaction_top_y_N"]], ".-")
    first = 0.05 * 0.1
    b.plot(strain, [100 * (v / first - 1) for v in t["volume_m3"]], ".-")
    other = b.twinx()
    other.plot(strain, [100 * d / 512 for d in t["rves_distinct"]], "--", color="gray")
    other.set_ylabel("dashed: RVEs with a path of their own (% of 512)"), other.set_ylim(0, 100)
    return True


def footing(a, b):
    t = table("footing", "history.csv")
    if not t:
        return False
    settlement = [6 * x for x in t["time_s"]]
    a.plot(settlement, [-2 * r / 0.2 / 1e3 for r in t["reaction_footing_y_N"]], ".-")
    b.plot(settlement, [100 * d / 252 for d in t["rves_distinct"]], ".-")
    return True


def bars(a, b):
    t, h, alone = table("bars", "history.csv"), table("bars", "hopkinson.csv"), table("alone", "history.csv")
    if not t or not h:
        return False
    micro = [1e6 * x for x in t["time_s"]]
    a.plot(micro, [-1e6 * e for e in t["probe_incident_strain_yy"]], label="incident bar")
    a.plot(micro, [-1e6 * e for e in t["probe_transmitted_strain_yy"]], label="transmission bar")
    b.plot([100 * e for e in h["strain_3wave"]], [s / 1e6 for s in h["stress_3wave_Pa"]], label="three waves")
    b.plot([100 * e for e in h["strain_1wave"]], [s / 1e6 for s in h["stress_1wave_Pa"]], label="one wave")
    b.plot([100 * e for e in h["specimen_strain"]], [s / 1e6 for s in h["specimen_stress_Pa"]], label="the specimen's grains")
    if alone:
        b.plot([100 * e for e in alone["axial_strain"]], [s / 1e6 for s in alone["axial_stress_Pa"]], "--", label="one RVE alone, 500 /s")
    return True


page("oedometer_block", ("axial strain (%)", "stress (MPa)"), ("axial strain (%)", "breakages"), oedometer)
page("triaxial", ("axial strain (%)", "deviator / cell pressure"), ("axial strain (%)", "volume strain (%)"), triaxial)
page("biaxial_plane_strain", ("axial strain (%)", "axial stress (kPa)"), ("axial strain (%)", "volume strain (%)"), biaxial)
page("strip_footing", ("settlement (mm)", "footing pressure (kPa)"), ("settlement (mm)", "RVEs with a path of their own (% of 252)"), footing)
page("shpb_bars", ("time (µs)", "gauge strain (µm/m, compression)"), ("axial strain (%)", "axial stress (MPa)"), bars)
