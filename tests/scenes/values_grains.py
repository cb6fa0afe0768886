# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of single grains against closed forms."""
import numpy as np
from scipy.optimize import brentq

R, RHO, K = 1e-3, 2650.0, 2e5
MASS, INERTIA = 4 / 3 * np.pi * R**3 * RHO, 0.4 * 4 / 3 * np.pi * R**5 * RHO
SAND = f"""
[material.sand]
density = {RHO}
contact = "linear"
normal_stiffness = {K}
shear_ratio = 0.5
friction = 0.25
restitution = 1
damping = 0
"""
FREE = """
[loading]
kind = "free"
duration = {0}
gravity = {1}
[numerics]
time_step = {2}
[output]
history_interval = {3}
"""


def listed(*grains):
    return "".join(f"[[grain]]\nradius = {R}\n" + "".join(f"{k} = {list(map(float, v))}\n" for k, v in g.items())
                   for g in grains)


def columns(run, g, *names):
    return np.stack([run.columns[f"g{g}_{n}"] for n in names])


MOTION = {"x": ("x_m", "y_m", "z_m"), "v": ("vx_m_s", "vy_m_s", "vz_m_s"), "w": ("wx_rad_s", "wy_rad_s", "wz_rad_s"),
          "f": ("fx_N", "fy_N", "fz_N"), "t": ("tx_N_m", "ty_N_m", "tz_N_m")}


def motion(values, run, g, rtol=1e-6, **expected):
    """Parts of a listed grain's motion, each by its column."""
    for what, rows in expected.items():
        for name, row in zip(MOTION[what], rows):
            values.same(f"rve.columns:g{g}_{name}", run.columns[f"g{g}_{name}"], row, rtol, 1e-9 * np.abs(row).max())


def falling(values):
    """Two grains that fly: position, velocity and turning by time; energy and work of gravity."""
    g, step = np.array([3.0, -5.0, -9.81]), 2.0**-20
    x = np.array([[0.01, 0.02, 0.03], [-0.02, 0.04, -0.05]])
    v = np.array([[0.5, -0.25, 1.0], [1.5, 0.75, -0.5]])
    w = np.array([[300.0, -100.0, 200.0], [-50.0, 150.0, 250.0]])
    text = SAND + listed(*({"position": a, "velocity": b, "spin": c} for a, b, c in zip(x, v, w)))
    run = values.run("rve", "falling", text + FREE.format(10240 * step, g.tolist(), step, 2048 * step) +
                     "frames = 6\n")
    t = np.arange(6) * 2048 * step
    values.same("rve.columns:time_s", run.columns["time_s"], t)
    values.same("rve.columns:steps", run.columns["steps"], t / step)
    values.same("rve.columns:time_step_s", run.columns["time_step_s"], step)
    values.same("rve.summary:counts.steps", run.told["counts"]["steps"], 10240)
    values.same("rve.summary:counts.grain_steps", run.told["counts"]["grain_steps"], 20480)
    values.same("rve.summary:counts.history_rows", run.told["counts"]["history_rows"], 6)
    values.same("rve.summary:counts.grains_start", run.told["counts"]["grains_start"], 2)
    values.same("rve.summary:results.final_time_s", run.told["results"]["final_time_s"], t[-1])
    values.same("rve.columns:grains", run.columns["grains"], 2)
    for k in (0, 1):
        motion(values, run, k, x=x[k][:, None] + v[k][:, None] * t + 0.5 * g[:, None] * t**2,
               v=v[k][:, None] + g[:, None] * t, w=w[k][:, None] + 0 * t)
        half = 0.5 * np.linalg.norm(w[k]) * t
        for name, part in zip(("qw", "qx", "qy", "qz"), [np.cos(half)] +
                              [np.sin(half) * u for u in w[k] / np.linalg.norm(w[k])]):
            values.same(f"rve.columns:g{k}_{name}", run.columns[f"g{k}_{name}"], part, 1e-5, 1e-5)
    shown = [f.grains() for f in run.frames()]
    values.same("rve.grains:velocity", [x["velocity"] for x in shown], v + g * t[:, None, None], 1e-5)
    values.same("rve.grains:speed", [x["speed"] for x in shown], np.linalg.norm(v + g * t[:, None, None], axis=2), 1e-5)
    values.same("rve.grains:radius", [x["radius"] for x in shown], R, 1e-6)
    speeds = v[:, :, None] + g[:, None] * t
    turning = 0.5 * INERTIA * (w**2).sum()
    values.same("rve.columns:kinetic_J", run.columns["kinetic_J"], 0.5 * MASS * (speeds**2).sum((0, 1)) + turning)
    way = v.sum(0)[:, None] * t + g[:, None] * t**2
    values.same("rve.columns:work_J", run.columns["work_J"], MASS * (g[:, None] * way).sum(0), 1e-6, 1e-16)
    last = run.told["energy"]
    values.same("rve.summary:energy.work_J", last["work_J"], MASS * (g * way[:, -1]).sum(), 1e-6)
    values.same("rve.summary:energy.kinetic_J", last["kinetic_J"], 0.5 * MASS * (speeds[..., -1]**2).sum() + turning)
    values.same("rve.summary:energy.start_J", last["start_J"], 0.5 * MASS * (v**2).sum() + turning)
    values.same("rve.summary:mass.start_kg", run.told["mass"]["start_kg"], 2 * MASS)


def damped(values):
    """Local damping takes its share of gravity's work."""
    run = values.run("rve", "damped", SAND.replace("damping = 0", "damping = 0.2") +
                     listed({"position": [0, 0, 0], "velocity": [0, 0, -0.1]}) +
                     FREE.format(1e-2, [0, 0, -9.81], 1e-6, 2e-3))
    t = 1e-2
    taken = 0.2 * MASS * 9.81 * (0.1 * t + 0.5 * 0.8 * 9.81 * t**2)
    values.same("rve.columns:damping_J", run.last["damping_J"], taken, 1e-5)
    for name in ("damping_J", "local_damping_J"):
        values.same(f"rve.summary:energy.{name}", run.told["energy"][name], taken, 1e-5)
    begun, work = 0.5 * MASS * 0.1**2, taken / 0.2  # of the larger of work and what is held
    values.same("rve.summary:errors.local_damping", run.told["errors"]["local_damping"], taken / (begun + work - taken),
                1e-5)


def bouncing(values):
    """A head-on impact leaves restitution^2 of the energy; meanwhile the spring holds what has not gone."""
    text = SAND.replace("restitution = 1", "restitution = 0.6") + listed(
        {"position": [0, 0, R], "velocity": [0, 0, -1]}) + "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
    period = np.pi * np.sqrt(MASS / K)
    run = values.run("rve", "bouncing", text + FREE.format(3 * period, [0, 0, 0], period / 4000, period / 40))
    values.same("rve.columns:damping_J", run.last["damping_J"], (1 - 0.36) * 0.5 * MASS, 5e-3)
    values.same("rve.columns:elastic_J", run.columns["elastic_J"],
                0.5 * K * np.maximum(0, R - run.columns["g0_z_m"])**2, 1e-5, 1e-12)
    values.same("rve.columns:g0_vz_m_s", run.last["g0_vz_m_s"], 0.6, 2e-3)
    values.same("rve.summary:errors.overlap_to_radius.worst", run.told["errors"]["overlap_to_radius"]["worst"],
                1 - run.columns["g0_z_m"].min() / R, 1e-5)
    # The dashpot of ratio b that leaves 0.6 of the speed where the force is cut at zero.
    left = lambda b: np.exp(-b / np.sqrt(1 - b * b) * (np.pi - np.arctan(2 * b * np.sqrt(1 - b * b) / (1 - 2 * b * b))))
    b = brentq(lambda b: left(b) - 0.6, 0.01, 0.5)
    overlap, speed = R - run.columns["g0_z_m"], run.columns["g0_vz_m_s"]
    force = np.where(overlap > 0, np.maximum(0, K * overlap - 2 * b * np.sqrt(K * MASS) * speed), 0)
    values.same("rve.columns:g0_fz_N", run.columns["g0_fz_N"][1:], force[1:], 1e-3, 1e-3 * force.max())


def sliding(values):
    """A grain that slides over a tilted wall: Coulomb's force and its moment, in all parts; what friction takes."""
    n = np.array([1.0, 2.0, 2.0]) / 3
    along = np.array([0.6, -0.5, 0.2])
    along -= n * (along @ n)
    v, along, weight = np.linalg.norm(along), along / np.linalg.norm(along), MASS * 9.81
    at = n * (R - weight / K)
    text = SAND + listed({"position": at, "velocity": v * along})
    text += f"[[wall]]\npoint = [0, 0, 0]\nnormal = {n.tolist()}\n"
    run = values.run("rve", "sliding", text + FREE.format(2e-2, (-9.81 * n).tolist(), 1e-6, 4e-3))
    t, a = run.columns["time_s"], 0.25 * 9.81
    spin = np.cross(n, along)  # rolls forward
    rate = 0.25 * weight * R / INERTIA
    one = np.ones_like(t[1:])
    motion(values, run, 0, 2e-3, v=along[:, None] * (v - a * t), w=spin[:, None] * rate * t)
    later = {k: c[1:] for k, c in run.columns.items()}
    force, moment = -0.25 * weight * along, 0.25 * weight * R * spin
    normal = weight * n
    for part, axis in enumerate("xyz"):
        # The grain's resultant, its weight included, and what it lays on the wall.
        values.same(f"rve.columns:g0_f{axis}_N", later[f"g0_f{axis}_N"], force[part] * one, 1e-2, 1e-3 * weight)
        values.same(f"rve.columns:g0_t{axis}_N_m", later[f"g0_t{axis}_N_m"], moment[part] * one, 1e-2,
                    1e-3 * weight * R)
        values.same(f"rve.columns:wall0_f{axis}_N", later[f"wall0_f{axis}_N"], -(force + normal)[part] * one, 1e-2,
                    1e-3 * weight)
    slid = v * t - 0.5 * (a + rate * R) * t**2
    values.same("rve.columns:friction_J", run.columns["friction_J"][1:], 0.25 * weight * slid[1:], 2e-2)
    values.same("rve.summary:energy.friction_J", run.told["energy"]["friction_J"], 0.25 * weight * slid[-1], 2e-2)
    values.same("rve.summary:energy.elastic_J", run.told["energy"]["elastic_J"],
                0.5 * weight**2 / K + 0.5 * (0.25 * weight)**2 / (0.5 * K), 2e-2)


def pressed(values):
    """A grain between platens by Hertz."""
    E, nu = 6e9, 0.2
    text = f"""
[material.sand]
density = {RHO}
youngs_modulus = {E}
poissons_ratio = {nu}
friction = 0
damping = 0.7
""" + listed({"position": [0, 0, 0]}) + """
[loading]
kind = "platens"
axis = "z"
strain_rate = 5
final_strain = 0.004
[numerics]
safety = 0.5
[output]
history_interval = 0.0005
"""
    run = values.run("rve", "pressed", text)
    c, strain = run.columns, run.columns["axial_strain"]
    values.same("rve.columns:axial_strain", strain, 5 * c["time_s"], 1e-6, 1e-9)
    overlap = strain * R  # at each end
    late = strain > 0.001
    force = 4 / 3 * E / (1 - nu**2) * np.sqrt(R) * overlap**1.5  # of a rigid wall
    stress = force / (2 * R)**2
    for name in ("axial_stress_Pa", "stress_front_Pa", "stress_back_Pa"):
        values.same(f"rve.columns:{name}", c[name][late], stress[late], 2e-2)
    values.same("rve.columns:elastic_J", c["elastic_J"][late], (2 * 0.4 * force * overlap)[late], 2e-2)
    values.same("rve.summary:results.final_axial_stress_Pa", run.told["results"]["final_axial_stress_Pa"], stress[-1],
                2e-2)
    values.same("rve.summary:results.peak_axial_stress_Pa", run.told["results"]["peak_axial_stress_Pa"],
                c["axial_stress_Pa"].max(), 1e-9)


def held(values):
    for check in (falling, damped, bouncing, sliding, pressed):
        check(values)
