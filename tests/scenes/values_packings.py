# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a packing is asked to be: densities and sizes by closed forms."""
import numpy as np
from scipy.stats import norm

from scene_tools import need

PACKED = """
[material.sand]
density = 2650
youngs_modulus = "6 GPa"
[packing]
kind = "random"
box = ["4 mm", "4 mm", "4 mm"]
{0}
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
strain_rate = 1
final_strain = 1e-7
{1}
[output]
frames = 1
grading = true
"""
CONSTANT = 'radius = { distribution = "constant", mean = "0.25 mm" }\n'


def relative(values):
    """A relative density between the loosest and the densest void ratio."""
    run = values.run("rve", "relative", PACKED.format(
        CONSTANT + "relative_density = 0.3\nvoid_ratio_max = 1.1\nvoid_ratio_min = 0.6", ""))
    values.same("rve.summary:sample.void_ratio", run.told["sample"]["void_ratio"], 1.1 - 0.3 * 0.5, 0.01)


def log_normal(values):
    """Radii of a cut log-normal distribution, by mass: mean and scatter of their logarithms."""
    low, middle, high, spread = 0.12, 0.15, 0.25, 0.2
    text = f'radius = {{ distribution = "log-normal", median = "{middle} mm", spread = {spread}, min = "{low} mm", '
    run = values.run("rve", "log_normal", PACKED.format(text + f'max = "{high} mm" }}\nsolid_fraction = 0.5', ""))
    radius = run.frames()[0].grains()["radius"]
    logs, share = np.log(radius / (middle * 1e-3)), radius**3 / (radius**3).sum()  # by mass
    a, b = np.log(low / middle) / spread, np.log(high / middle) / spread
    part = norm.cdf(b) - norm.cdf(a)
    mean = (norm.pdf(a) - norm.pdf(b)) / part
    off = spread * np.sqrt(1 + (a * norm.pdf(a) - b * norm.pdf(b)) / part - mean**2)
    found = (share * logs).sum()
    scatter = off * np.sqrt((share**2).sum())
    values.same("rve.grains:radius", found, spread * mean, 0, 3 * scatter)
    values.same("rve.grains:radius", np.sqrt((share * (logs - found)**2).sum()), off, 0.1)


def sieved(values):
    """Sieves and a scale: grains are that many times larger, gradings are told without the scale."""
    sieves = 'radius = { distribution = "sieve", passing = [["0.2 mm", 0], ["0.3 mm", 0.4], ["0.5 mm", 1]] }\n'
    run = values.run("rve", "sieved", PACKED.format(sieves + "void_ratio = 1", "scale = 1.5"))
    d = 2e3 * run.frames()[0].grains()["radius"]
    m = d**3
    # One grain of some 0.6 mm is 2 % of the mass.
    values.same("rve.grains:radius", m[d < 0.45].sum() / m.sum(), 0.4, 0, 0.06)
    values.same("rve.grains:radius", [d.min(), d.max()], [0.3, 0.75], 0.06)
    values.same("rve.columns:d50_m", run.last["d50_m"], 1e-3 * np.exp(
        np.log(0.3) + (0.5 - 0.4) / 0.6 * np.log(0.5 / 0.3)), 0.06)


PREPARED = """
seed = 3
[material.sand]
density = 2650
contact = "linear"
normal_stiffness = 4e5
shear_ratio = 0.5
friction = 0.3
restitution = 0.5
damping = 0.2
[packing]
kind = "random"
box = ["2 mm", "2.2 mm", "2.4 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.6
[boundary]
kind = "periodic"
"""


def overlapping(values):
    """Grains as they were packed: what the contacts find between them before anything moves."""
    run = values.run("rve", "overlapping", PREPARED + """
[loading]
kind = "free"
duration = 1e-12
[numerics]
time_step = 1e-13
""")
    found = run.told["errors"]["overlap_to_radius"]["last"]
    values.same("rve.summary:errors.packing_overlap", run.told["errors"]["packing_overlap"], found, 1e-3)


def falling(values):
    """Grains that fall into a box: the pressure of its walls rises and falls, and their error is of the largest so
    far."""
    run = values.run("rve", "falling_in", PREPARED.replace('"periodic"', '"walls"').replace("0.6", "0.5") + """
[loading]
kind = "free"
duration = "0.25 ms"
gravity = [0, 0, -5e4]
[output]
history_interval = "5 us"
""", "material.sand.damping=0", "material.sand.restitution=0.95")
    c, told = run.columns, run.told["errors"]["wall_minus_cell_pressure"]
    walls = -np.mean([c[f"wall_stress_{k}_Pa"] for k in ("xx", "yy", "zz")], 0)
    bear = walls != 0
    apart, largest = np.abs(walls - c["mean_pressure_Pa"])[bear], np.maximum.accumulate(np.abs(walls[bear]))
    need(np.abs(walls[-1]) < 0.9 * largest[-1], "the walls are pressed most at the end")
    values.same("rve.summary:errors.wall_minus_cell_pressure.last", told["last"], (apart / largest)[-1], 1e-4)
    values.same("rve.summary:errors.wall_minus_cell_pressure.worst", told["worst"], (apart / largest).max(), 1e-4)


def sought(values):
    """A cell that is prepared under a pressure, and seeks another one: by the stresses of the rows."""
    run = values.run("rve", "sought", PREPARED + """
[preparation]
pressure = "1 MPa"
friction = 0.2
unbalanced_force = 1e-2
stress_change = 1e-2
[loading]
kind = "isotropic-stress"
pressure = "1.5 MPa"
strain_rate = "50 1/s"
duration = "60 us"
[output]
history_interval = "2 us"
""")
    prepared, errors = run.told["preparation"], run.told["errors"]["sought_stress"]
    values.same("rve.summary:preparation.asked_stress_Pa", prepared["asked_stress_Pa"], [1e6] * 3)
    first = -np.array([run.columns[f"stress_{k}_Pa"][0] for k in ("xx", "yy", "zz")])
    values.same("rve.summary:preparation.stress_Pa", prepared["stress_Pa"], first, 1e-6)
    values.same("rve.summary:preparation.worst_stress_error", prepared["worst_stress_error"],
                np.abs(first / 1e6 - 1).max(), 1e-4)
    stress = -np.stack([run.columns[f"stress_{k}_Pa"] for k in ("xx", "yy", "zz")])
    off = np.abs(stress / 1.5e6 - 1).max(0)[1:]  # the first row is not of the test
    for name, value in (("last", off[-1]), ("mean", off.mean()), ("worst", off.max())):
        values.same(f"rve.summary:errors.sought_stress.{name}", errors[name], value, 1e-6)


def held(values):
    for check in (relative, log_normal, sieved, overlapping, falling, sought):
        check(values)
