# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plots of grus-bvp runs. A run is (name, columns of history.csv, summary)."""
import math

from grus.curves import driven, leader, pushed, way_of
from grus.figures import counts, decades, figure, legend, positive, unit_of
from grus.report import pictures


def loaded_axis(c, s):
    """The axis along which a scene moves a boundary; where it moves none, the one whose stress changes most."""
    if boundary := driven(c, s.get("scene", {})):
        return 2 * boundary[1]
    return max(("xx", "yy", "zz"), key=lambda k: max(c[f"mean_stress_{k}_Pa"]) - min(c[f"mean_stress_{k}_Pa"]))


def dynamic(c):
    return "macro_kinetic_J" in c and "load_rate" not in c


def along(c, s):
    """(values, name) of what a problem is drawn against: the way of the boundary that the scene moves farthest, or of
    the one that pushes most; the time of waves; the mean strain where nothing pushes."""
    if dynamic(c):
        return [1e6 * t for t in c["time_s"]], "time (µs)"
    if lead := leader(c, s.get("scene", {})):
        return way_of(*lead)
    axis = loaded_axis(c, s)
    return [-v for v in c[f"mean_strain_{axis}"]], f"mean strain {axis} (compression)"


def reaction(ax, name, curves):
    for boundary, component, way, force in curves:
        sense = math.copysign(1, max(way, key=abs))
        ax.plot(way_of(boundary, component, way)[0], [sense * v for v in force],
                marker="o" if len(way) < 80 else None, ms=3, label=f"{boundary}, {component}")
    ax.set(xlabel="displacement of the boundary (mm)", ylabel="reaction, along the displacement (N)",
           title=f"{name}: reaction and displacement")
    legend(ax)


def stress(ax, name, c, s):
    x, label = along(c, s)
    head = "grains_stress" if "grains_stress_xx_Pa" in c else "mean_stress"
    much, unit = unit_of(*(c[f"{head}_{k}_Pa"] for k in ("xx", "yy", "zz")))
    for k in ("xx", "yy", "zz"):
        ax.plot(x, [-v / much for v in c[f"{head}_{k}_Pa"]], marker="o" if len(x) < 80 else None, ms=3,
                label=f"stress {k}")
    where = "of the grains" if head.startswith("grains") else "mean"
    ax.set(xlabel=label, ylabel=f"stress ({unit})", title=f"{name}: stress, {where} (compression positive)")
    legend(ax)


def energies(ax, name, c, s):
    x, label = along(c, s)
    for k in ("external", "internal", "kinetic", "viscous", "damped", "scaled"):
        if f"macro_{k}_J" in c:
            ax.plot(x, c[f"macro_{k}_J"], label=k)
    ax.set(xlabel=label, ylabel="energy (J)",
           title=f"{name}: macro energy, largest error {100 * max(map(abs, c['energy_error'][1:] or [0])):.2f} %")
    legend(ax)


def gauges(ax, name, c, s):
    axis = loaded_axis(c, s)
    for k in [k for k in c if k.startswith("probe_") and k.endswith(f"_strain_{axis}")]:
        ax.plot(along(c, s)[0], [-1e6 * v for v in c[k]], label=k[6:-10])
    ax.set(xlabel=along(c, s)[1], ylabel=f"strain {axis} (µm/m, compression)", title=f"{name}: probes")
    legend(ax)


def convergence(ax, name, c):
    ax.bar(c["increment"], c["newton_iterations"], label="Newton iterations")
    counts(ax.xaxis), counts(ax.yaxis)
    ax.set(xlabel="increment", ylabel="Newton iterations", title=f"{name}: convergence")
    other = ax.twinx()
    other.plot(c["increment"], positive(c["residual"]), "C3.-", label="residual (right)")
    decades(other, [positive(c["residual"])])
    other.set_ylabel("relative residual")
    legend(ax, other)


def balance(ax, name, c, s):
    x, label = along(c, s)
    shown = {
        k: positive(c[k])[1:] for k in ("unbalanced_macro_force", "kinetic_over_internal", "energy_error",
                                        "inertial_number", "worst_rve_energy_error") if k in c
    }
    for k, v in shown.items():
        ax.plot(x[1:], v, label=k.replace("_", " "))
    decades(ax, shown.values())
    ax.set(xlabel=label, ylabel="relative", title=f"{name}: how far to trust it")
    legend(ax)


def of_run(run):
    name, c, summary = run
    plots = [figure(draw, height=5.0) for draw in pictures.macro(summary["folder"], name)]
    moved = pushed(c)
    if moved:
        plots.append(figure(lambda ax: reaction(ax, name, moved)))
    plots.append(figure(lambda ax: stress(ax, name, c, summary)))
    if not dynamic(c) and "p_Pa" in c and len(c["p_Pa"]) > 1:
        much, unit = unit_of(c["p_Pa"], c["q_Pa"])

        def path(ax):
            ax.plot([v / much for v in c["p_Pa"]], [v / much for v in c["q_Pa"]],
                    marker="o" if len(c["p_Pa"]) < 80 else None, ms=3)
            ax.set(xlabel=f"mean pressure p ({unit})", ylabel=f"deviator q ({unit})",
                   title=f"{name}: stress path of the means")
        plots.append(figure(path))

        def volume(ax):
            ax.plot(
                along(c, summary)[0], [100 * v for v in c["strain_volumetric"]],
                marker="o" if len(c["p_Pa"]) < 80 else None, ms=3)
            ax.set(xlabel=along(c, summary)[1], ylabel="volume strain (%, compression)", title=f"{name}: volume strain")
        plots.append(figure(volume))
    if c["breakages"][-1] > 0 or c.get("bonds_broken", [0])[-1] > 0:
        def breaks(ax):
            for key, label in (("breakages", "breakages"), ("bonds_broken", "bonds broken")):
                if c.get(key, [0])[-1] > 0:
                    ax.plot(along(c, summary)[0], c[key], label=label)
            counts(ax.yaxis)
            ax.set(xlabel=along(c, summary)[1], ylabel="number, all RVEs", title=f"{name}: breakage")
            legend(ax)
        plots.append(figure(breaks))
    if "macro_external_J" in c:
        plots.append(figure(lambda ax: energies(ax, name, c, summary)))
    if dynamic(c) and any(k.startswith("probe_") and k.endswith(f"_strain_{loaded_axis(c, summary)}") for k in c):
        plots.append(figure(lambda ax: gauges(ax, name, c, summary)))
    if "macro_kinetic_J" not in c:
        plots.append(figure(lambda ax: convergence(ax, name, c)))
    plots.append(figure(lambda ax: balance(ax, name, c, summary)))
    return plots
