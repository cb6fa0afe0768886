# SPDX-License-Identifier: LGPL-3.0-or-later
"""Single contacts and small groups: closed forms and conservation laws."""
import math
import random
import re

from bench import Run, case, collision, free, material, sphere


def chain(fraction):
    """Ten grains between two walls, linear contacts squeezed by 1 %, one grain kicked: the fastest mode has omega = 2
    sqrt(k/m) but for the ends, so the critical step is sqrt(m/k)."""
    r, k, density, n = 1e-3, 1e6, 2500.0, 10
    m = density * 4 / 3 * math.pi * r ** 3
    pitch = 2 * r * 0.99
    text = f"[material.m]\ndensity = {density}\nyoungs_modulus = 1e9\ncontact = \"linear\"\nnormal_stiffness = {k}\n"
    for i in range(n):
        text += sphere(r, (0, 0, 0.99 * r + i * pitch), (0, 0, 1e-3 if i == 4 else 0))
    top = 0.99 * r * 2 + (n - 1) * pitch
    for z, normal in ((0, 1), (top, -1)):
        text += f"[[wall]]\npoint = [0, 0, {z!r}]\nnormal = [0, 0, {normal}]\nmaterial = \"m\"\n"
    dt = fraction * math.sqrt(m / k)
    return text + (f"[loading]\nkind = \"free\"\nduration = {20000 * dt!r}\n[numerics]\ntime_step = {dt!r}\n[output]\n"
                   f"history_interval = \"{200 * dt!r} s\"\n")


@case("time step 0.1, 0.3, 0.5, 0.8, 0.95 x critical, undamped chain, 20,000 steps",
      "energy error < fraction^2 (leapfrog's shadow energy) and below 5 %, not growing")
def below_critical(tmp):
    worst, grows = {}, False
    for fraction in (0.1, 0.3, 0.5, 0.8, 0.95):
        r = Run(tmp, chain(fraction))
        worst[fraction] = r.energy if r.exit == 0 and r.finite else math.inf
        if r.exit == 0:
            errors = [abs(v) for v in r.columns["energy_error"]]
            half = len(errors) // 2
            grows = grows or max(errors[half:]) > 1.2 * max(errors[:half])
    good = not grows and all(w < min(f * f, 0.05) for f, w in worst.items())
    return ", ".join(f"{f}: {w:.1e}" for f, w in worst.items()), good


@case("time step 1.05, 1.2, 1.5 x critical", "found within 20,000 steps, exit 3, one line, results kept")
def above_critical(tmp):
    runs = {f: Run(tmp, chain(f)) for f in (1.05, 1.2, 1.5)}
    return ("; ".join(f"{f}: exit {r.exit}, {re.split(' at t = |, more', r.error.split(': ', 1)[-1])[0]}"
                      for f, r in runs.items()), all(r.stopped() for r in runs.values()))


@case("restitution 0.05 to 1", "rebound / impact speed as asked, within 2 % (0.005 at most)")
def restitution(tmp):
    found, good = [], True
    for e in (0.05, 0.2, 0.5, 0.9, 1.0):
        r = Run(tmp, collision(extra=f"restitution = {e}"))
        back = r.last("g1_vz_m_s")
        found.append(f"{e}: {back:.4f}")
        good = good and r.exit == 0 and abs(back - e) < max(0.005, 0.02 * e)
    return ", ".join(found), good


@case("Young's modulus 1 MPa to 1 TPa, the same impact", "rebound speed 1 within 1e-3")
def stiffness(tmp):
    found, good = [], True
    for youngs in (1e6, 1e8, 1e10, 1e12):
        r = Run(tmp, collision(youngs=youngs, speed=0.02))
        off = abs(r.last("g1_vz_m_s") / 0.01 - 1)
        found.append(f"{youngs:.0e}: {off:.0e}")
        good = good and r.exit == 0 and off < 1e-3
    return ", ".join(found), good


@case("Poisson's ratio 0 and 0.499; 0.6 and -2", "rebound 1 within 1e-3; refused")
def poisson(tmp):
    off = [abs(Run(tmp, collision(poisson=v)).last("g1_vz_m_s") - 1) for v in (0.0, 0.499)]
    bad = [Run(tmp, collision().replace("poissons_ratio = 0.25", f"poissons_ratio = {v}")) for v in (0.6, -2.0)]
    return (f"{off[0]:.0e}, {off[1]:.0e}; exit {bad[0].exit}, {bad[1].exit}", max(off) < 1e-3
            and all(r.refused("poissons_ratio") for r in bad))


@case("grains of 1 um and of 1 km", "rebound 1 within 1e-3, energy error < 1e-3")
def scales(tmp):
    runs = [Run(tmp, collision(radius=r)) for r in (0.5e-6, 500.0)]
    off = [abs(r.last("g1_vz_m_s") - 1) for r in runs]
    return ", ".join(f"{o:.0e}" for o in off), max(off) < 1e-3 and all(r.exit == 0 and r.energy < 1e-3 for r in runs)


@case("a grain ten times (and a million times) denser than its neighbour",
      "velocities after an elastic impact from momentum and energy, within 1e-3")
def densities(tmp):
    found, good = [], True
    for ratio in (10.0, 1e6):
        t = 60e-6
        text = material(60e9, 2500) + material(60e9, 2500 * ratio).replace("[material.m]", "[material.heavy]")
        text += sphere(0.01, (0, 0, -0.01001), (0, 0, 1)) + sphere(0.01, (0, 0, 0.01001), (0, 0, 0), "heavy")
        text += free(4 * t)
        r = Run(tmp, text)
        light, heavy = (1 - ratio) / (1 + ratio), 2 / (1 + ratio)
        off = max(abs(r.last("g0_vz_m_s") - light), abs(r.last("g1_vz_m_s") - heavy))
        found.append(f"{ratio:g}: {off:.0e}")
        good = good and r.exit == 0 and off < 1e-3
    return ", ".join(found), good


@case("a dozen grains without gravity or walls, random impacts, no friction, no damping",
      "momentum to 1e-9 of the sum of its parts (history.csv has ten digits), energy error < 1e-4")
def cloud(tmp):
    draw = random.Random(1)
    cells = [(i, j, k) for i in range(6) for j in range(6) for k in range(6)]
    draw.shuffle(cells)
    text = material(60e9, 2500)
    for i, j, k in cells[:16]:
        p = [2.2e-3 * v for v in (i % 3, j % 3, k % 3)]
        v = [-40 * (x - 2.2e-3) / 2.2e-3 + draw.uniform(-5, 5) for x in p]
        text += sphere(1e-3, p, v)
    seen, unique = set(), material(60e9, 2500)
    for block in text.split("[[grain]]")[1:]:
        key = block.split("position = ")[1].split("\n")[0]
        if key not in seen:
            seen.add(key)
            unique += "[[grain]]" + block
    r = Run(tmp, unique + free(4e-4))
    n = min(16, len(seen))
    start = [sum(r.columns[f"g{i}_v{a}_m_s"][0] for i in range(n)) for a in "xyz"]
    end = [sum(r.columns[f"g{i}_v{a}_m_s"][-1] for i in range(n)) for a in "xyz"]
    size = sum(abs(r.columns[f"g{i}_vz_m_s"][0]) for i in range(n))
    changed = sum(abs(r.columns[f"g{i}_vz_m_s"][0] - r.last(f"g{i}_vz_m_s")) > 1 for i in range(n))
    off = max(abs(a - b) for a, b in zip(start, end)) / size  # history.csv has ten digits
    return (f"{n} grains, {changed} deflected, momentum {off:.0e}, energy {r.energy:.0e}", r.exit == 0 and changed > 4
            and off < 1e-9 and r.energy < 1e-4)


@case(
    "grains created with an overlap of a radius",
    "pushed apart: kinetic energy is what the overlap held (Hertz), within 1 %; with the usual limit stopped by the "
    "overlap"
)
def created_overlapping(tmp):
    radius, density, youngs = 0.01, 2500, 1e8
    text = material(youngs, density) + sphere(radius, (0, 0, 0)) + sphere(
        radius, (0, 0, 0.01)) + free(4e-3) + "[numerics]\nmax_overlap = 1\n"
    r = Run(tmp, text)
    k = 4 / 3 * youngs / (2 * (1 - 0.25 ** 2)) * math.sqrt(radius / 2)
    held = 0.4 * k * 0.01 ** 2.5
    got = r.last("kinetic_J") if r.exit == 0 else math.nan
    plain = Run(tmp, text.replace("max_overlap = 1", "max_overlap = 0.2"))
    return (f"{got / held - 1:+.1e}; with the usual limit: exit {plain.exit}, {plain.error.split(': ', 1)[-1][:50]}",
            r.exit == 0 and abs(got / held - 1) < 0.01 and plain.stopped("overlap"))


@case("two grains at the same place",
      "refused in one line that names both; moved apart by 1e-9 of a radius, they part along that line, momentum 1e-9")
def coincident(tmp):
    same = material(1e8, 2500) + 2 * sphere(0.01, (0, 0, 0)) + free(4e-3) + "[numerics]\nmax_overlap = 1\n"
    same = Run(tmp, same)
    near = Run(tmp, (material(1e8, 2500) + sphere(0.01, (0, 0, 0)) + sphere(0.01, (1e-11, 0, 0)) + free(4e-3) +
                     "[numerics]\nmax_overlap = 2.1\n"))
    vx = [near.last(f"g{i}_vx_m_s") for i in (0, 1)] if near.exit == 0 else [math.nan] * 2
    return (f"{same.error.split(': ', 1)[-1][:50]}; near: exit {near.exit}, {vx[1]:.3g} m/s",
            same.refused("grains 0 and 1", "same centre") and near.exit == 0 and vx[1] > 1
            and abs(vx[0] + vx[1]) < 1e-9 * vx[1] and near.energy < 0.02)


@case("one contact carries everything: an unbreakable grain between platens",
      "force = Hertz's k d^1.5 within 1 % until the overlap guard stops it, exit 3, results kept")
def one_contact(tmp):
    r = Run(tmp, "single_grain.toml", "material.sand.fracture=", "loading.final_strain=0.5", "output.frames=0",
            "numerics.max_overlap=0.2", "loading.strain_rate=20")
    k = 4 / 3 * 60e9 / (1 - 0.17 ** 2) * math.sqrt(0.3e-3)  # rigid platens
    x, y = r.columns["axial_strain"], r.columns["axial_stress_Pa"]
    at = max(i for i in range(len(x)) if x[i] < 0.1)
    hertz = k * (x[at] * 0.3e-3) ** 1.5 / 0.6e-3 ** 2
    return (f"{y[at] / hertz - 1:+.1e}; {r.error.split(': ', 1)[-1][:60]}", r.stopped("overlap")
            and abs(y[at] / hertz - 1) < 0.01)


@case("poly-ellipsoids 1:9 in each of the three axes, askew, elastic impact", "they meet and part; energy error < 1e-3")
def slender(tmp):
    found, good = [], True
    unit = lambda q: [x / math.sqrt(sum(y * y for y in q)) for x in q]
    for axis in range(3):
        long = [1e-3] * 6
        long[2 * axis] = 9e-3
        grain = lambda z, v, q: (
            f"[[grain]]\nshape = \"polyellipsoid\"\nsemi_axes = {long}\nposition = [{0.3e-3 if z > 0 else 0}, 0, {z}]\n"
            f"velocity = [0, 0, {v}]\n"
            f"orientation = {unit(q)}\nmaterial = \"m\"\n")
        text = material(1e9, 2500) + grain(-5e-3, 1.0, [0.9, 0.3, 0.2, 0.1]) + grain(
            5e-3, -1.0, [0.5, -0.5, 0.6, 0.2]) + free(1.5e-2, 60)
        r = Run(tmp, text)
        met = max(r.columns["elastic_J"]) > 0 or abs(r.last("g0_vz_m_s") - 1) > 1e-6
        found.append(f"{'xyz'[axis]}: {r.energy:.0e}")
        good = good and r.exit == 0 and met and r.energy < 1e-3
    return ", ".join(found), good


@case(
    "rolling friction 0, 1e-6, 0.3, 1e3, 1e4 in a box of 500 grains squeezed at 200 1/s",
    "energy balance within 1 %; 1e-6 within 5 % of none; 0.3 carries 5 % more at least; 1e3 and 1e4, hardly ever at "
    "their limit, agree within 1 %"
)
def rolling_resistance(tmp):
    box = (
        "[packing]\nkind = \"random\"\nbox = [\"4 mm\", \"4 mm\", \"4 mm\"]\n"
        "radius = { distribution = \"uniform\", min = \"0.2 mm\", max = \"0.3 mm\" }\nsolid_fraction = 0.55\nseed = 4\n"
        "[boundary]\nkind = \"walls\"\n[loading]\nkind = \"uniaxial-strain\"\naxis = \"z\"\nstrain_rate = \"200 1/s\"\n"
        "final_strain = 0.06\n[output]\nhistory_interval = 0.01\n"
    )
    found, good, stress = [], True, {}
    for value in (0, 1e-6, 0.3, 1e3, 1e4):
        r = Run(
            tmp,
            "[material.m]\ndensity = 2650.0\nyoungs_modulus = \"6 GPa\"\npoissons_ratio = 0.2\nfriction = 0.5\n"
            f"restitution = 0.5\nrolling_friction = {value}\n"
            + box)
        good = good and r.exit == 0 and r.finite and r.energy < 0.01
        stress[value] = r.last("axial_stress_Pa") if r.exit == 0 else math.nan
        found.append(f"{value}: {stress[value] / 1e6:.3f} MPa, {r.energy if r.exit == 0 else math.nan:.0e}")
    good = good and abs(stress[1e-6] / stress[0] -
                        1) < 0.05 and stress[0.3] > 1.05 * stress[0] and abs(stress[1e3] / stress[1e4] - 1) < 0.01
    return "; ".join(found), good
