# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run is drawn as: its load, and other curves that tell of it, as plain data thinned to what a screen can
show."""
import math

POINTS = 400  # of a curve
ENERGIES = ("work_J", "elastic_J", "kinetic_J", "friction_J", "damping_J", "fracture_J", "split_J",
            "macro_external_J", "macro_internal_J", "macro_kinetic_J", "macro_viscous_J", "macro_damped_J")
ERRORS = ("energy_error", "unbalanced_force", "inertial_number", "residual", "unbalanced_macro_force",
          "kinetic_over_internal", "worst_rve_energy_error")
COUNTS = ("breakages", "bonds_broken", "grains", "newton_iterations")


def is_macro(c):
    return "increment" in c


def along(c):
    """(values, name) of what a run is drawn against."""
    if is_macro(c):
        axis = max(("xx", "yy", "zz"), key=lambda k: span(c.get(f"mean_stress_{k}_Pa", [0.0])))
        strain = c.get(f"mean_strain_{axis}", [])
        if span(strain) > 0 and "macro_kinetic_J" not in c:
            return [-v for v in strain], f"mean strain {axis} (compression)"
        return c["time_s"], "load factor" if "newton_iterations" in c else "time (s)"
    if any(v for v in c.get("axial_strain", [])):
        return c["axial_strain"], "axial strain (compression)"
    return c.get("time_s", []), "time (s)"


def span(values):
    known = [v for v in values if math.isfinite(v)]
    return max(known) - min(known) if known else 0.0


def load(c):
    """(x, y, name of x, name of y): what the run is about."""
    if is_macro(c):
        pushed = [k for k in c if k.startswith("moved_") and "reaction_" + k[6:-2] + "_N" in c and span(c[k]) > 0]
        if pushed:
            way = max(pushed, key=lambda k: span(c["reaction_" + k[6:-2] + "_N"]))
            sense = math.copysign(1.0, max(c[way], key=abs))
            return ([1e3 * sense * v for v in c[way]], [sense * v for v in c["reaction_" + way[6:-2] + "_N"]],
                    f"displacement of {way[6:-4]} (mm)", "reaction (N)")
        axis = max(("xx", "yy", "zz"), key=lambda k: span(c[f"mean_stress_{k}_Pa"]))
        x, name = along(c)
        return x, [-v / 1e6 for v in c[f"mean_stress_{axis}_Pa"]], name, f"mean stress {axis} (MPa)"
    x, name = along(c)
    if "nominal_stress_Pa" in c and "displacement_m" in c:
        x, name = [1e3 * v for v in c["displacement_m"]], "displacement (mm)"
    return x, [v / 1e6 for v in c.get("nominal_stress_Pa", c.get("axial_stress_Pa", []))], name, "stress (MPa)"


def thinned(x, y):
    """At most POINTS of the points that are numbers, the last among them."""
    pairs = [(a, b) for a, b in zip(x, y) if math.isfinite(a) and math.isfinite(b)]
    step = max(1, math.ceil(len(pairs) / POINTS))
    kept = pairs[::-step][::-1]
    return {"x": [float(f"{a:.6g}") for a, _ in kept], "y": [float(f"{b:.6g}") for _, b in kept]}


def series(label, x, y):
    return {"label": label, **thinned(x, y)}


def plot(title, x, y, curves, log=False):
    return {"title": title, "x": x, "y": y, "log": log, "series": [s for s in curves if s["x"]]}


def of_loads(runs):
    """One plot of what runs, (name, columns) each, are about: side by side."""
    shown = [(name, load(c)) for name, c in runs if len(next(iter(c.values()), []))]
    if not shown:
        return []
    return [plot("Load", shown[0][1][2], shown[0][1][3], [series(name, *found[:2]) for name, found in shown])]


def of_run(c):
    """What is told of one run."""
    if not len(next(iter(c.values()), [])):
        return []
    x, name = along(c)
    told = lambda k: k.removesuffix("_J").removesuffix("_Pa").replace("_", " ")
    plots = []
    if any(v > 0 for v in c.get("void_ratio", [])):
        plots.append(plot("Void ratio", name, "void ratio", [series("void ratio", x, c["void_ratio"])]))
    energies = [series(told(k), x, c[k]) for k in ENERGIES if any(c.get(k, []))]
    plots.append(plot("Energy", name, "energy (J)", energies))
    counted = [series(told(k), x, c[k]) for k in COUNTS if span(c.get(k, [])) > 0]
    plots.append(plot("Counts", name, "number", counted))
    errors = [(k, [(a, abs(v)) for a, v in zip(x, c[k]) if v]) for k in ERRORS if any(c.get(k, []))]
    plots.append(plot("How far to trust it", name, "relative", [series(told(k), *zip(*rows)) for k, rows in errors],
                      log=True))
    return [p for p in plots if p["series"]]
