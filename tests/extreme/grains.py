# SPDX-License-Identifier: LGPL-3.0-or-later
"""Packings: rates, friction, sizes, stiffness, rest, walls, breakage in masses and at seams."""
import math
import os
import random

from bench import Run, case, cell, material, uniaxial

WEAK = (
    "[material.m.fracture]\nmodel = \"polyellipsoid-split\"\n"
    "hoek_brown = {{ compressive_strength = {strength!r}, m = 20.56 }}\n"
    "contact_tension = {{ strength = {tension!r} }}\n")


def fracture(strength, tension=1.655e9, extra=""):
    return WEAK.format(strength=strength, tension=tension) + extra


def box(strain, rate, extra="", friction=0.5, side=0.003, numerics="", rows=50):
    return (
        material(60e9, 2650, 0.17, f"friction = {friction!r}\nrestitution = 0.5\n") + extra +
        f"[packing]\nkind = \"random\"\nbox = [{side!r}, {side!r}, {side!r}]\n"
        f"radius = {{ distribution = \"uniform\", min = 0.0002, max = 0.0004 }}\n"
        "solid_fraction = 0.48\n[boundary]\nkind = \"walls\"\nfriction = 0.0\n[numerics]\nmax_overlap = 0.8\n"
        f"safety = 0.4\n{numerics}\n"
        + uniaxial(strain, rate, rows))


def lattice(youngs, loading, extra=""):
    """Closest packing in a box of walls: no grain is loose, no path is left to chance."""
    return (material(youngs, 2650, 0.17, "friction = 0.3\nrestitution = 0.5\n" + extra) +
            "[packing]\nkind = \"hcp\"\nradius = { distribution = \"constant\", mean = 0.0003 }\nlayers = [5, 5, 4]\n"
            "[boundary]\nkind = \"walls\"\nfriction = 0.0\n[numerics]\nmax_overlap = 0.5\n" + loading)


@case("stiffness 1 MPa to 1 TPa, one packing, rate as E^1/2",
      "dimensionless stress the same to 1e-6, time step as E^-1/2 to 1e-6, energy error < 1 %")
def scaling(tmp):
    found = {}
    for youngs in (1e6, 1e8, 1e10, 1e12):
        r = Run(tmp, lattice(youngs, uniaxial(0.01, 0.4e-3 * math.sqrt(youngs))))
        found[youngs] = (r.last("axial_stress_Pa") / youngs, r.last("time_step_s") * math.sqrt(youngs),
                         r.energy) if r.exit == 0 else (math.nan,) * 3
    base = found[1e10]
    off = max(abs(v[k] / base[k] - 1) for v in found.values() for k in (0, 1))
    return (f"{off:.0e}; energy {max(v[2] for v in found.values()):.0e}", off < 1e-6
            and all(v[2] < 0.01 for v in found.values()))


@case("friction 0, 0.1, 0.5, 1, 2, 1000 in a sheared cell",
      "friction dissipates >= 0 in every row, nothing at 0; energy error < 1 %")
def friction(tmp):
    shear = ("[loading]\nkind = \"velocity-gradient\"\nvelocity_gradient = [[0, 0, 100.0], [0, 0, 0], [0, 0, 0]]\n"
             "duration = 1e-3\n")
    found, good = [], True
    for mu in (0.0, 0.1, 0.5, 1.0, 2.0, 1000.0):
        r = Run(tmp, cell(loading=shear).replace("friction = 0.5", f"friction = {mu}", 1))
        lost = r.columns["friction_J"] if r.exit == 0 else [math.nan]
        scale = max(r.columns["work_J"][-1], 1e-30)
        monotone = all(b >= a - 1e-9 * scale for a, b in zip(lost, lost[1:]))
        found.append(f"{mu:g}: {lost[-1]:.2g} J")
        good = good and r.exit == 0 and monotone and r.energy < 0.01 and (mu > 0 or lost[-1] == 0)
    return ", ".join(found), good


def rates(tmp, values):
    found, good = [], True
    for rate in values:
        r = Run(tmp, box(0.02, rate))
        found.append(f"{rate:g}/s: {r.energy:.1e}" if r.exit == 0 else f"{rate:g}/s: {r.error[-60:]}")
        good = good and r.exit == 0 and r.finite and r.energy < 0.02
    return ", ".join(found), good


@case("strain rates 100, 1e3, 1e4, 1e5 /s in a box of walls", "energy error < 2 %")
def fast(tmp):
    return rates(tmp, (1e2, 1e3, 1e4, 1e5))


@case("strain rates 1 and 10 /s", "energy error < 2 %", slow=True)
def slow_rates(tmp):
    return rates(tmp, (1.0, 10.0))


@case("a wall that moves more than a radius in a step; a wall faster than any wave in the grains",
      "stopped by the overlap guard with exit 3 before the wall has gone three radii; refused with the rate to ask for")
def wall_too_fast(tmp):
    faster = Run(tmp, box(0.3, 1e9))
    wave = float(faster.error.rsplit("less than ", 1)[-1].split(" ")[0]) if faster.exit == 2 else math.nan
    speed = 0.9 * wave * 0.003
    r = Run(tmp, box(0.3, 0.9 * wave, numerics=f"time_step = {3e-4 / speed!r}"))
    gone = float(r.error.split("at t = ")[1].split(" s")[0]) * speed if "at t = " in r.error else math.inf
    return (f"exit {r.exit}: {r.error.split(': ', 1)[-1][:70]}, {gone / 2e-4:.2f} radii; {wave:g}/s and more refused",
            r.stopped("overlap", "wall 5") and gone < 6e-4 and faster.refused("strain_rate", "faster than any wave"))


@case("walls that cross: strain beyond 1", "refused in one line that names final_strain and its bound")
def crossing(tmp):
    r = Run(tmp, box(1.3, 1000.0))
    return f"exit {r.exit}: {r.error.split(': ', 1)[-1][:70]}", r.refused("final_strain", "below 0.95")


def mixed_sizes(tmp, ratio):
    """One large grain in a bed of small ones on a grid around it, in a box whose lid comes down."""
    large, side = 1e-3, 3e-3
    small, draw, lines = large / ratio, random.Random(2), []
    pitch, n = 2.02 * small, int(side / (2.02 * large / ratio))
    lines.append((side / 2, side / 2, side / 2, large))
    for i in range(n):
        for j in range(n):
            for k in range(n):
                x = [pitch * (v + 0.5) for v in (i, j, k)]
                if math.dist(x, [side / 2] * 3) > large + 1.05 * small and max(x[0], x[1]) < side - small:
                    if abs(x[2] - side / 2) < large + 3 * small and math.dist(x, [side / 2] * 3) < large + 6 * small:
                        lines.append((*[v + draw.uniform(-0.004, 0.004) * small for v in x], small))
    path = os.path.join(tmp, f"mixed_{ratio}.txt")
    with open(path, "w") as f:
        f.writelines(" ".join(map(repr, g)) + "\n" for g in lines)
    text = (
        material(60e9, 2650, 0.17, "friction = 0.3\nrestitution = 0.7\n") +
        f"[packing]\nkind = \"file\"\npath = \"{path}\"\n[boundary]\nkind = \"periodic\"\n"
        f"box = [{side}, {side}, {side}]\n[numerics]\nmax_overlap = 0.5\nsafety = 0.4\n[loading]\n"
        "kind = \"uniaxial-strain\"\naxis = \"z\"\nstrain_rate = 2000.0\nfinal_strain = 0.06\n"
        "[output]\nhistory_interval = 0.006\n")
    return Run(tmp, text, timeout=300), len(lines)


@case("size ratio 1:50, one grain in a shell of thousands",
      "contacts form, energy error < 2 %, mass the same to the last bit")
def ratio_50(tmp):
    r, n = mixed_sizes(tmp, 50)
    ok = r.exit == 0 and r.finite and r.energy < 0.02 and r.mass == 0 and r.last("coordination") > 0
    return (f"{n} grains; " +
            (f"energy {r.energy:.0e}, coordination {r.last('coordination'):.2f}" if r.exit == 0 else r.error[-90:]), ok)


@case("10^6 steps of a settled cell at rest", "kinetic energy does not grow, pressure drifts < 1e-9", slow=True)
def rest(tmp):
    still = ("[loading]\nkind = \"velocity-gradient\"\nvelocity_gradient = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]\n"
             "duration = {d!r}\n")
    scene = lambda d: lattice(60e9, "[preparation]\npressure = 1e6\n" + still.format(d=d), "damping = 0.2\n").replace(
        "layers = [5, 5, 4]", "layers = [6, 6, 6]").replace("kind = \"walls\"\nfriction = 0.0", "kind = \"periodic\"")
    first = Run(tmp, scene(1e-4))
    dt = first.last("time_step_s")
    r = Run(tmp, scene(1.02e6 * dt))
    kinetic, p = r.columns["kinetic_J"], r.columns["mean_pressure_Pa"]
    n = len(p)
    drift = abs(p[-1] / p[n // 10] - 1)
    return (
        f"{r.summary['counts']['steps']} steps, kinetic {kinetic[n // 10]:.0e} -> {kinetic[-1]:.0e} J, pressure "
        f"{drift:.0e}",
        r.exit == 0 and r.summary["counts"]["steps"] > 1e6 and kinetic[-1] <= kinetic[n // 10] and drift < 1e-9)


@case(
    "a periodic cell squeezed to solid fraction 1 and beyond, nothing breaks",
    "stopped by the overlap guard past 0.7, results kept; with a wider guard it ends beyond 1, stress grows in every "
    "row, energy error < 2 %"
)
def beyond_solid(tmp):
    r = Run(tmp, cell(loading=uniaxial(0.6, 500.0)))
    solid = 1 / (1 + r.last("void_ratio")) if r.last("void_ratio") > -1 else math.inf
    wide = Run(
        tmp,
        cell(loading=uniaxial(0.45, 500.0), numerics="safety = 0.3").replace("max_overlap = 0.5", "max_overlap = 1.0"))
    top = 1 / (1 + wide.last("void_ratio"))
    p = wide.columns["mean_pressure_Pa"]
    grows = all(b > a for a, b in zip(p[5:], p[6:]))
    return (
        f"guard at solid fraction {solid:.2f} (exit {r.exit}); without it {top:.2f} (exit {wide.exit}, energy "
        f"{wide.energy:.0e})",
        r.stopped("overlap") and solid > 0.7 and wide.exit == 0 and wide.finite and wide.energy < 0.02 and top > 1
        and grows)


@case("a cell pulled apart until no contact is left", "stress exactly 0, energy error < 1 %")
def pulled_apart(tmp):
    pull = ("[loading]\nkind = \"velocity-gradient\"\n"
            "velocity_gradient = [[300.0, 0, 0], [0, 300.0, 0], [0, 0, 300.0]]\nduration = 1e-3\n")
    r = Run(tmp, cell(loading=pull))
    stress = max(abs(r.last(f"stress_{c}_Pa")) for c in ("xx", "yy", "zz", "yz", "xz", "xy"))
    return (f"stress {stress:g} Pa, coordination {r.last('coordination'):g}", r.exit == 0 and r.energy < 0.01
            and (stress == 0 if r.last("coordination") == 0 else False))


@case("thousands of breakages, many at once: strength 1/100 of sand's",
      "mass (fines counted) to 1e-12, energy ledger closed to 5 %")
def mass_breakage(tmp):
    r = Run(tmp, box(0.12, 500.0, fracture(2.75e6, 1.655e7), side=0.004, numerics="fracture_every = 50"), timeout=600)
    jumps = [b - a for a, b in zip(r.columns["breakages"], r.columns["breakages"][1:])]
    return (
        f"{r.last('breakages'):.0f} breakages, up to {max(jumps):.0f} a row, mass {r.mass:.0e}, energy {r.energy:.1e}, "
        f"exit {r.exit}",
        r.exit == 0 and r.finite and r.last("breakages") > 1000 and abs(r.mass) < 1e-12 and r.energy < 0.05)


@case("cascades: every test finds new breaks (strength 1/1000, tested in every step)",
      "ends at its strain: each line of descent stops at max_generations; mass to 1e-12, energy error < 5 %")
def cascade(tmp):
    r = Run(tmp, box(0.05, 1000.0, fracture(2.75e5, 1.655e6, "max_generations = 5\n"), numerics="fracture_every = 1"),
            timeout=600)
    return (f"{r.last('breakages'):.0f} breakages, exit {r.exit} {r.error.split(': ', 1)[-1][:50]}, mass {r.mass:.0e}",
            r.exit == 0 and r.finite and 300 < r.last("breakages") <= 31 * r.summary["counts"]["grains_start"]
            and abs(r.mass) < 1e-12 and r.energy < 0.05)


@case("breakage across the periodic seam, the cell sheared by 1.5 (past any flip of its lattice)",
      "ends at its shear: mass to 1e-12, energy error < 5 %, breaks found", slow=True)
def seam(tmp):
    shear = ("[loading]\nkind = \"velocity-gradient\"\n"
             "velocity_gradient = [[0, 0, 2000.0], [0, 0, 0], [0, 0, -200.0]]\n"
             "duration = 7.5e-4\n")
    r = Run(tmp, cell(loading=shear, fracture=fracture(100e6, 0.6e9)))
    return (
        f"{r.last('breakages'):.0f} breakages, mass {r.mass:.0e}, energy {r.energy:.1e}, exit {r.exit} "
        f"{r.error.split(': ', 1)[-1][:60]}",
        r.exit == 0 and r.finite and r.last("breakages") > 20 and abs(r.mass) < 1e-12 and r.energy < 0.05)


@case("neighbour skin of 1/1000 and of twice the mean radius",
      "stress as with the default to 1e-4 (the order of sums differs, by round-off)")
def skins(tmp):
    runs = [Run(tmp, cell(loading=uniaxial(0.005, 100.0), numerics=f"skin = {s}")) for s in (0.2, 0.001, 2.0)]
    off = max(abs(r.last("axial_stress_Pa") / runs[0].last("axial_stress_Pa") - 1) for r in runs[1:] if r.exit == 0)
    return f"{off:.0e}", all(r.exit == 0 for r in runs) and off < 1e-4


@case("thousands of grains that break in the same test: a lattice squeezed evenly, strength 1/100 of sand's",
      "more than 1,000 breakages between two rows of 1e-4 strain; mass to 1e-12, energy error < 5 %")
def all_at_once(tmp):
    text = lattice(60e9, uniaxial(0.004, 500.0, 40), "") + fracture(2.75e6, 1.655e7)
    text = text.replace("layers = [5, 5, 4]", "layers = [20, 20, 20]")
    r = Run(tmp, text.replace("max_overlap = 0.5", "max_overlap = 0.8\nsafety = 0.4"), timeout=300)
    jumps = [b - a for a, b in zip(r.columns["breakages"], r.columns["breakages"][1:])]
    return (
        f"{r.summary['counts']['grains_start']} grains, {r.last('breakages'):.0f} breakages, {max(jumps):.0f} between "
        f"two rows, mass {r.mass:.0e}, energy {r.energy:.1e}, exit {r.exit} {r.error.split(': ', 1)[-1][:60]}",
        r.exit == 0 and r.finite and max(jumps) > 1000 and abs(r.mass) < 1e-12 and r.energy < 0.05)
