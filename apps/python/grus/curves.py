# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run is drawn as: its load, and other curves that tell of it, as plain data thinned to what a screen can
show."""
import math
import re

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


def driven(c, scene):
    """(boundary, component, displacement) of what a macro scene moves farthest; None where it moves nothing."""
    found = []
    for boundary in scene.get("boundary", []):
        name = name_of(boundary)
        for component, way in zip("xyz", boundary.get("displacement", [])):
            moved = c.get(f"moved_{name}_{component}_m", [])
            if is_given(way) and span(moved) > 0:
                found.append((max(map(abs, moved)), name, component, moved))
    return max(found, key=lambda f: f[0])[1:] if found else None


def is_given(way):
    """Whether a displacement is a number other than 0, with or without its unit."""
    found = re.match(r"\s*([-+]?\d*\.?\d+(?:[eE][-+]?\d+)?)", str(way))
    return found is not None and float(found[1]) != 0


def name_of(boundary):
    """The name that columns of a [[boundary]] have: its own, or made of its tag or its place."""
    tag = boundary.get("tag", "")
    made = tag if isinstance(tag, str) else f"tag{tag[0] if isinstance(tag, list) and tag else tag}"
    place = str(boundary.get("where", ""))
    return boundary.get("name", made or "".join(k for k in place if k.isascii() and k.isalnum()))


def pushed(c):
    """(boundary, component, displacement, reaction) of what pushes, the hardest first; sides that give way to a
    pressure move against theirs."""
    found = []
    for key in [k for k in c if k.startswith("moved_") and k.endswith("_m")]:
        name, component = key[6:-4], key[-3]
        way, force = c[key], c.get(f"reaction_{name}_{component}_N")
        if force and sum(f * math.copysign(1, max(way, key=abs)) for f in force) > 0 and max(map(abs, way)) > 0:
            found.append((max(map(abs, force)), name, component, way, force))
    found.sort(reverse=True)
    return [f[1:] for f in found if f[0] > 0.05 * found[0][0]]


def leader(c, scene):
    """(boundary, component, displacement) that a macro problem is drawn over: of what the scene moves farthest, or else
    of what pushes most; None where nothing does."""
    return driven(c, scene) or next((p[:3] for p in pushed(c)), None)


def way_of(boundary, component, way):
    """(mm along its largest displacement, name of that axis)."""
    sense = math.copysign(1.0, max(way, key=abs))
    return [1e3 * sense * v for v in way], f"displacement of {boundary}, {component} (mm)"


def load(c, scene):
    """(x, y, name of x, name of y): what the run is about. `scene`: its tables, {} where they are not known."""
    if is_macro(c):
        lead = leader(c, scene)
        force = c.get(f"reaction_{lead[0]}_{lead[1]}_N") if lead else None
        if force:
            x, name = way_of(*lead)
            sense = math.copysign(1.0, max(lead[2], key=abs))
            return x, [sense * v for v in force], name, "reaction (N)"
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
    """One plot of what runs, (name, columns, scene) each, are about: side by side."""
    shown = [(name, load(c, scene)) for name, c, scene in runs if len(next(iter(c.values()), []))]
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
