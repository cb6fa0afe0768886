# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots of grus-rve runs. A run is (name, columns of history.csv, summary)."""
import csv
import math
import os

import numpy as np

from grus.figures import by_scale, counts, decades, figure, legend, plain, plt, positive, unit_of
from grus.report import pictures

# What is stored and what is dissipated, each once: bond_J is in elastic_J, bond_damping_J in damping_J; reshape_J is
# put in.
ENERGIES = ("elastic_J", "kinetic_J", "friction_J", "damping_J", "fracture_J", "handed_J", "split_J")


def loading(run):
    return run[2].get("scene", {}).get("loading", {})


def stages(run):
    return run[2].get("scene", {}).get("stage", [])


def axis_of(run):
    """x, y or z: the axis along which a sample is loaded."""
    return next((t["axis"] for t in [loading(run), *stages(run)] if t.get("axis") in ("x", "y", "z")), "z")


def strained(run):
    return max(map(abs, run[1]["axial_strain"])) > 0


def oedometric(run):
    """Pressed along one axis while the others keep their length."""
    if not stages(run):
        return loading(run).get("kind") in ("uniaxial-strain", "oedometric-stress")
    c, most = run[1], max(map(abs, run[1]["axial_strain"]))
    across = [k for k in "xyz" if k != axis_of(run)]
    return most > 0 and all(abs(v) <= 1e-6 * most for k in across for v in c[f"strain_{k * 2}"])


def sheared(run):
    kinds = ("triaxial", "constant-p", "true-triaxial", "velocity-gradient")
    return not oedometric(run) and ("q_Pa" in run[1] if stages(run) else loading(run).get("kind") in kinds)


def compressed(run):
    return oedometric(run) or (not sheared(run) if stages(run) else loading(run).get("kind") == "isotropic-stress")


def along(run):
    """What a run is drawn against, and its name."""
    return (run[1]["axial_strain"], "axial strain (compression)") if strained(run) else (run[1]["time_s"], "time (s)")


def onward(run):
    """The same of curves that would lie over one another where a test goes back: those go by the time."""
    x, name = along(run)
    goes = [(b - a) * math.copysign(1, x[-1] - x[0]) for a, b in zip(x, x[1:])]
    back = -sum(g for g in goes if g < 0) > 0.02 * max(map(abs, x))
    return (run[1]["time_s"], "time (s)") if back else (x, name)


def volume(c):
    """Volume strain, compression-positive: 1 - V/V0 of the stretches along the axes."""
    return [1 - (1 + x) * (1 + y) * (1 + z) for x, y, z in zip(c["strain_xx"], c["strain_yy"], c["strain_zz"])]


def deviator(c):
    """q = sqrt(3/2 s:s) of the Love-Weber stress."""
    q = []
    for xx, yy, zz, yz, xz, xy in zip(*(c[f"stress_{k}_Pa"] for k in ("xx", "yy", "zz", "yz", "xz", "xy"))):
        p = (xx + yy + zz) / 3
        q.append(math.sqrt(1.5 * ((xx - p) ** 2 + (yy - p) ** 2 + (zz - p) ** 2 + 2 * (yz * yz + xz * xz + xy * xy))))
    return q


def mobilised(c):
    """Mobilised friction angle, degrees: asin (s1 - s3) / (s1 + s3) of the principal stresses, pressed positive; NaN
    where nothing presses."""
    stress = -np.array([c[f"stress_{k}_Pa"] for k in ("xx", "xy", "xz", "xy", "yy", "yz", "xz", "yz", "zz")], float)
    principal = np.linalg.eigvalsh(stress.T.reshape(-1, 3, 3))
    both, apart = principal[:, 2] + principal[:, 0], principal[:, 2] - principal[:, 0]
    pressed = both > 0.02 * max(both.max(), 0.0)
    return np.degrees(np.arcsin(np.clip(np.where(pressed, apart / np.where(pressed, both, 1), math.nan), -1, 1)))


def lateral(run):
    """K0: mean lateral over axial stress of the grains."""
    c, axis = run[1], axis_of(run)
    ratio = []
    for k, total in enumerate(zip(c["stress_xx_Pa"], c["stress_yy_Pa"], c["stress_zz_Pa"])):
        axial = c[f"stress_{axis * 2}_Pa"][k]
        ratio.append(0.5 * (sum(total) - axial) / axial if axial < 0 else math.nan)
    return ratio


def stress_plots(title, runs, nominal):
    groups = by_scale(runs, lambda r: max(map(abs, r[1]["axial_stress_Pa"])))

    def drawn(group):
        much, unit = unit_of(*(c["axial_stress_Pa"] for _, c, _ in group))

        def draw(ax):
            for name, c, _ in group:
                ax.plot(c["axial_strain"], [v / much for v in c["axial_stress_Pa"]], label=name)
            ax.set(xlabel="axial strain (compression)", title=title,
                   ylabel=f"force over the square of the height ({unit})" if nominal else f"axial stress ({unit})")
            legend(ax)
        return figure(draw)
    return [drawn(group) for group in groups]


def sheared_plots(runs):
    """Of tests that shear: deviator and friction over the strain, stress path, volume; each on axes of its scale."""
    plots = []
    for group in by_scale(runs, lambda r: max(deviator(r[1]))):
        much, unit = unit_of(*(deviator(c) for _, c, _ in group))

        def rising(ax):
            for r in group:
                ax.plot(along(r)[0], [v / much for v in deviator(r[1])], label=r[0])
            ax.set(xlabel=along(group[0])[1], ylabel=f"deviator q ({unit})", title="Deviator and strain")
            legend(ax)

        def path(ax):
            for name, c, _ in group:
                ax.plot([v / much for v in c["mean_pressure_Pa"]], [v / much for v in deviator(c)], label=name)
            ax.set(xlabel=f"mean pressure p ({unit})", ylabel=f"deviator q ({unit})", title="Stress path",
                   xlim=(0, None), ylim=(0, None))
            legend(ax)
        plots += [figure(rising), figure(path)]

    def friction(ax):
        for r in runs:
            ax.plot(along(r)[0], mobilised(r[1]), label=r[0])
        ax.set(xlabel=along(runs[0])[1], ylabel="mobilised friction angle (degrees)", title="Mobilised friction",
               ylim=(0, None))
        legend(ax)

    def dilation(ax):
        for r in runs:
            ax.plot(along(r)[0], [100 * v for v in volume(r[1])], label=r[0])
        ax.set(xlabel=along(runs[0])[1], ylabel="volume strain (%, compression)", title="Volume strain")
        legend(ax)
    return plots + [figure(friction), figure(dilation)]


def void_ratios(ax, way, runs):
    """Over the logarithm of what presses: an oedometer's curve is read over the stress along its axis."""
    stress = {r[0]: r[1]["axial_stress_Pa" if way == "axial stress" else "mean_pressure_Pa"] for r in runs}
    much, unit = unit_of(*stress.values())
    for name, c, _ in runs:
        rows = [(p / much, e) for p, e in zip(stress[name], c["void_ratio"]) if p > 1e-4 * max(stress[name])]
        ax.semilogx(*zip(*rows), label=name) if rows else None
    plain(ax.xaxis)
    ax.set(xlabel=f"{way} ({unit})", ylabel="void ratio", title=f"Void ratio against the logarithm of the {way}")
    legend(ax)


def at_rest(ax, runs):
    for r in runs:
        p = r[1]["mean_pressure_Pa"]
        ax.plot(r[1]["axial_strain"], [v if q > 0.01 * max(p) else math.nan for v, q in zip(lateral(r), p)], label=r[0])
    ax.set(xlabel="axial strain (compression)", ylabel="K0, lateral over axial stress",
           title="Lateral stress at rest, K0", ylim=(0, None))
    legend(ax)


def overlays(runs):
    """What runs have in common, samples and single grains apart: a grain's strength is far above a sample's stress."""
    plots = []
    strained_runs = [r for r in runs if strained(r)]
    grains = [r for r in strained_runs if loading(r).get("kind") == "platens" and "bonds" not in r[1]]
    samples = [r for r in strained_runs if r not in grains]
    if samples:
        plots += stress_plots("Stress and strain (compression positive)", samples, False)
    if grains:
        plots += stress_plots("Single grains between platens", grains, True)
    boxes = [r for r in samples if loading(r).get("kind") != "rollers" and any(v > 0 for v in r[1]["void_ratio"])]
    pressed = [r for r in boxes if compressed(r)]
    for way, group in (("axial stress", [r for r in pressed if oedometric(r)]),
                       ("mean pressure", [r for r in pressed if not oedometric(r)])):
        if group:
            plots.append(figure(lambda ax: void_ratios(ax, way, group)))
    if any(oedometric(r) for r in pressed):
        plots.append(figure(lambda ax: at_rest(ax, [r for r in pressed if oedometric(r)])))
    if any(sheared(r) for r in boxes):
        plots += sheared_plots([r for r in boxes if sheared(r)])
    graded = [r for r in runs if r[2].get("grading")]
    if graded:
        plots.append(figure(lambda ax: gradings(ax, graded)))
    return plots


def told(strain):
    """Round-off of a start is 0."""
    return f"{strain if abs(strain) > 1e-9 else 0:.3g}"


def gradings(ax, runs):
    for k, (name, _, summary) in enumerate(runs):
        states = list(summary["grading"].items())
        for (strain, rows), style in ((states[0], ":"), (states[-1], "-"))[2 - min(2, len(states)):]:
            ax.semilogx([1e3 * r["diameter_m"] for r in rows], [100 * r["passing"] for r in rows], style,
                        color=f"C{k % 10}", label=f"{name}, strain {told(strain)}")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)", ylabel="passing by mass (%)",
           title="Gradings, first and last state (fines included)", ylim=(0, 100))
    legend(ax)


def grading_states(ax, name, states):
    for k, (strain, rows) in enumerate(states.items()):
        ax.semilogx([1e3 * r["diameter_m"] for r in rows], [100 * r["passing"] for r in rows],
                    color=plt.cm.viridis(k / max(1,
                                                 len(states) - 1)), label=f"strain {told(strain)}")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)", ylabel="passing by mass (%)", title=f"{name}: grading, fines included",
           ylim=(0, 100))
    legend(ax)


def by_size(ax, name, states):
    rows = [r for r in list(states.values())[-1] if r["grains"] > 0]
    d = [1e3 * r["diameter_m"] for r in rows]
    for key in ("coordination", "generation"):
        ax.semilogx(d, [r[key] for r in rows], marker=".", label=key)
    other = ax.twinx()
    for key, color in (("elongation", "C2"), ("flatness", "C3")):
        other.semilogx(d, [r[key] for r in rows], marker=".", color=color, label=f"{key} (right)")
    other.set(ylim=(0, 1.05), ylabel="elongation, flatness")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)", ylabel="mean of a size class", title=f"{name}: means by size, last state")
    legend(ax, other)


def energy(ax, run):
    c, (x, label) = run[1], onward(run)
    bottom = [0.0] * len(x)
    for part in stacked(c):
        top = [a + max(b, 0.0) for a, b in zip(bottom, c[part])]
        ax.fill_between(x, bottom, top, label=part[:-2].replace("_", " "), alpha=0.8)
        bottom = top
    ax.plot(x, c["work_J"], "k--", label="work in")
    ax.set(xlabel=label, ylabel="energy (J)", title=f"{run[0]}: where the work went")
    legend(ax)


def stacked(c):
    """The parts of the stack: their sum is what work has become and what was there at the start."""
    return [p for p in ENERGIES if p in c and max(c[p]) > 0]


def breakage(ax, run):
    c, (x, label) = run[1], onward(run)
    ax.plot(x, c["grains"], label="grains")
    ax.plot(x, c["breakages"], label="breakages")
    counts(ax.yaxis)
    ax.set(xlabel=label, ylabel="number", title=f"{run[0]}: breakage")
    if loading(run).get("kind") == "platens":  # no void ratio of a single grain
        return legend(ax)
    other = ax.twinx()
    other.plot(x, c["void_ratio"], "C2", label="void ratio (right)")
    other.set_ylabel("void ratio")
    legend(ax, other)


def trust(ax, run):
    c, (x, label) = run[1], onward(run)
    shown = {
        "|energy error|": c["energy_error"], "unbalanced force": c["unbalanced_force"],
        "inertial number": c["inertial_number"]
    }
    for name, values in shown.items():
        if any(values[1:]):
            ax.plot(x[1:], positive(values[1:]), label=name)
    decades(ax, [positive(v[1:]) for v in shown.values()])
    ax.set(xlabel=label, ylabel="relative", title=f"{run[0]}: how far to trust it")
    legend(ax)


def damage(ax, run):
    """Bonded Voronoi cells: the load, what broke."""
    c, (x, label) = run[1], along(run)
    if "nominal_stress_Pa" in c:
        x, label = [1e3 * v for v in c["displacement_m"]], "displacement (mm)"
    stress = c.get("nominal_stress_Pa", c["axial_stress_Pa"])
    much, unit = unit_of(stress)
    ax.plot(x, [v / much for v in stress], "k", label="stress")
    ax.set(xlabel=label, ylabel=f"nominal stress ({unit})" if "nominal_stress_Pa" in c else f"axial stress ({unit})",
           title=f"{run[0]}: load and damage")
    other = ax.twinx()
    other.plot(x, c["bonds_broken"], "C3", label="bonds broken (right)")
    other.plot(x, c["fragments"], "C0", label="fragments (right)")
    counts(other.yaxis)
    other.set_ylabel("number")
    legend(ax, other)


def bursts(ax, name, sizes):
    """Share of bursts at least as large as a size."""
    sizes = sorted(sizes)
    ax.loglog(sizes, [1 - k / len(sizes) for k in range(len(sizes))], ".")
    plain(ax.xaxis), plain(ax.yaxis)
    ax.set(xlabel="bonds broken in a burst", ylabel="share of bursts as large or larger", title=f"{name}: bursts")


def burst_sizes(folder):
    path = os.path.join(folder, "bursts.csv")
    if not os.path.isfile(path):
        return []
    with open(path, newline="") as f:
        rows = list(csv.DictReader(f))
    return [float(r["bonds"]) for r in rows if float(r["bonds"]) > 0]


def of_run(run):
    """The plots of one run."""
    name, c, summary = run
    plots = [figure(draw, height=6.0) for draw in (pictures.grains(summary["folder"], name),) if draw]
    plots += [figure(draw, height=4.6) for draw in pictures.cracked(summary["folder"], name)]
    plots.append(figure(lambda ax: energy(ax, run)))
    if c["breakages"][-1] > 0:
        plots.append(figure(lambda ax: breakage(ax, run)))
    if "bonds" in c:
        plots.append(figure(lambda ax: damage(ax, run)))
    sizes = burst_sizes(summary["folder"]) if "bursts" in summary else []  # of this run, not of one before it
    if len(sizes) > 3:
        plots.append(figure(lambda ax: bursts(ax, name, sizes)))
    states = summary.get("grading")
    if states:
        plots += [figure(lambda ax: grading_states(ax, name, states)), figure(lambda ax: by_size(ax, name, states))]
    plots.append(figure(lambda ax: trust(ax, run)))
    return plots
