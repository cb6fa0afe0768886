# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of what a macro problem of grains leaves out or adds: by hand counts, by the cells alone, and by loads that
go back to where they began, so that what was put in is what devices have taken."""
import numpy as np

from values_cells import CELL, SQUARE
from values_crushing import SAND
from values_faces import shared_faces
from values_tools import Frame, table

LOAD = "[solve]\nkind = \"quasi-static\"\nincrements = 4\ntolerance = 5e-2\ndisplacement_tolerance = 0.3\n"
COSTS = "[output]\nframes = 2\ncosts = true\n"
WHOLE = CELL.partition("[material.sand.fracture]")[0] + CELL[CELL.index("[packing]"):]


def square(values, name, cell, *sets, replace=()):
    text = SQUARE[:SQUARE.index("[solve]")] + LOAD + COSTS
    for old, new in replace:
        text = text.replace(old, new)
    return values.run("bvp", name, text, *sets, files=(("cell.toml", cell),))


ONE = (("variants = 2", "variants = 1"), ("grading = true\n", ""))


def put_off(values):
    """Answers that are foretold: in each increment all after the first, and in later ones a point goes first where it
    was believed to be; costs.csv lists all that was done."""
    run = square(values, "put_off", WHOLE, "rve.adaptivity={error=0.3}")
    counts, told, done = run.told["counts"], run.told["errors"]["deferral"], table(run.path("costs.csv"))
    foretold = 2 * np.cumsum(run.columns["newton_iterations"] - 1)
    values.same("bvp.columns:rves_deferred", run.columns["rves_deferred"], foretold)
    values.same("bvp.summary:counts.rves_deferred", counts["rves_deferred"], foretold[-1])
    values.same("bvp.summary:errors.deferral.measured", told["measured"], 2 * (run.last["increment"] - 1))
    asked = 2 * counts["material_sweeps"]
    values.same("bvp.summary:counts.rves_advanced", len(done["slot"]), asked - foretold[-1] + told["measured"])


def riding(values):
    """A point that rides on another until they part, alone in its triangle: by who stands in costs.csv when."""
    run = square(values, "riding", WHOLE, "rve.adaptivity={share=0.01}", "boundary.1.displacement=[1e-3, -6e-4]",
                 replace=ONE)
    counts, told, done = run.told["counts"], run.told["errors"]["sharing"], table(run.path("costs.csv"))
    parted = done["sweep"][done["slot"] == 1][0]
    values.same("bvp.summary:counts.rves_similar", counts["rves_similar"], parted - 1)  # at first they are one
    values.same("bvp.summary:counts.rves_replayed", counts["rves_replayed"], counts["rves_distinct"] - 1)
    values.same("bvp.summary:counts.rves_distinct", counts["rves_distinct"], len(np.unique(done["slot"])))
    values.same("bvp.summary:errors.sharing.measured_at_replays", told["measured_at_replays"], 1)
    values.same("bvp.summary:errors.sharing.mean", told["mean"], told["worst"])  # of one


def linear(values):
    """Elastic answers: rows of costs.csv without a step; the truth comes out with the first step after them."""
    push = ("solve.increments=8", "boundary.1.displacement=['free', -5e-5]", "rve.strain_per_step=1e-5")
    run = square(values, "linear", WHOLE, "rve.adaptivity={elastic=0.05}", *push)
    counts, told, done = run.told["counts"], run.told["errors"]["elastic"], table(run.path("costs.csv"))
    still = [done["steps"][done["slot"] == k] == 0 for k in (0, 1)]
    values.same("bvp.summary:counts.rves_elastic", counts["rves_elastic"], sum(x.sum() for x in still))
    values.same("bvp.summary:errors.elastic.measured", told["measured"],
                sum((x[:-1] & ~x[1:]).sum() for x in still))
    values.same("bvp.summary:errors.elastic.tolerance_force_share", told["tolerance_force_share"], 0.05)


def one_error(values):
    """Of one error the mean is the worst: an element of one point."""
    for name, keys, *sets in (("elastic", "{elastic=0.05}", "solve.increments=8", "rve.strain_per_step=1e-5",
                               "boundary.1.displacement=['free', -5e-5]"),
                              ("deferral", "{error=0.3}", "solve.increments=2")):
        run = square(values, f"one_{name}", WHOLE, f"rve.adaptivity={keys}", *sets,
                     replace=(*ONE, ("triangle", "quadrilateral")))
        told = run.told["errors"][name]
        values.same(f"bvp.summary:errors.{name}.measured", told["measured"], 1)
        values.same(f"bvp.summary:errors.{name}.mean", told["mean"], told["worst"])


LATTICE = SAND.replace("friction = 0.5\nrestitution = 0.5", "friction = 0\nrestitution = 1") + """
[packing]
kind = "simple-cubic"
layers = [2, 2, 2]
radius = { distribution = "constant", mean = "0.25 mm" }
[boundary]
kind = "periodic"
[preparation]
pressure = "1 MPa"
"""
BONDED = """
[material.rock]
density = 2500
contact = "overlap"
friction = 0
damping = 0
[material.rock.bond]
modulus = "10 GPa"
poissons_ratio = 0
criterion = "cohesive"
tension = "6 GPa"
cohesion = "18 GPa"
fracture_energy = "1e9 J/m^2"
damping = 0.2
[packing]
kind = "voronoi"
box = ["1 mm", "1 mm", "1 mm"]
cells = 64
[boundary]
kind = "periodic"
"""
BACK = "history = [[0, 0], [0.5, 1], [1, 0]]\n"


def there_and_back(values):
    """A load that ends where it began: what holds energy has given it back, so that all of the work is what the one
    device has taken."""
    for name, cell, key in (("lattice", LATTICE, "local_damping_of_cells"), ("rock", BONDED, "bond_damping_of_cells")):
        text = SQUARE[:SQUARE.index("[[boundary]]\nwhere = \"x=max\"")] + """[[boundary]]
where = "x=max"
displacement = [0, "free"]
""" + LOAD
        text = text.replace('displacement = ["free", "-0.6 mm"]\n', f'displacement = ["free", "-30 um"]\n{BACK}')
        text = text.replace("variants = 2\n", "pressure_floor = \"1 MPa\"\n" if name == "rock" else "")
        run = values.run("bvp", name, text, files=(("cell.toml", cell),))
        done = max(abs(run.last["rve_work_J"]), abs(run.last["macro_external_J"]))
        values.same(f"bvp.summary:errors.devices.{key}", run.told["errors"]["devices"][key],
                    run.last["rve_work_J"] / done, 0.03)
    # A network of ratio 0 has its modulus: 1e-3 of strain in 6 cm^3, and what dashpots took on the way there.
    c, held_ = run.columns, 0.5 * 10e9 * 1e-3**2 * 6e-6
    values.same("bvp.columns:macro_external_J", c["macro_external_J"][1], held_, 1e-4)
    values.same("bvp.columns:rve_work_J", c["rve_work_J"][1], held_, 0.15)
    values.same("bvp.columns:mean_stress_yy_Pa", c["mean_stress_yy_Pa"][1], -1e7, 1e-4)


BLOCK = """
[mesh]
box = { size = ["10 mm", "10 mm", "10 mm"], cells = [1, 1, 1] }
[element]
quadrature_degree = 1
[rve]
scene = "cell.toml"
unbalanced_force = 2e-2
stress_change = 2e-2
window = 30
pressure_floor = 1e6
"""


def torn(values):
    """Brittle cells that are drawn to all sides: what has broken parts fragments, and hardly anything within them."""
    weak = BONDED.replace("cohesive", "parallel").replace("6 GPa", "0.1 MPa").replace(
        'cohesion = "18 GPa"\nfracture_energy = "1e9 J/m^2"', 'shear = "0.1 MPa"')
    alone = values.run("rve", "alone", weak + "[loading]\nkind = \"free\"\nduration = \"1 ns\"\n[output]\nframes = 1\n")
    frame = alone.frames()[0]
    faces = shared_faces(frame.grains()["points"], frame.lines()[1])
    values.same("rve.summary:cells.bonds_start", alone.told["cells"]["bonds_start"], len(faces))
    text = BLOCK + "".join(f"""[[boundary]]
where = "{axis}={side}"
displacement = {[way if k == axis else "free" for k in "xyz"]}
""" for axis in "xyz" for side, way in (("min", 0), ("max", 1e-5))) + LOAD + "[output]\nframes = 2\n" + """[[probe]]
name = "one"
at = [0, 0, 0]
frames = true
"""
    run = values.run("bvp", "torn", text, "solve.increments=1", files=(("cell.toml", weak),))
    part = Frame(run.path(run.series("grains_one")[-1])).grains()["fragment"]
    parted = sum(part[a] != part[b] for a, b, _ in faces)
    for where, told in (("columns", run.last), ("summary", run.told["counts"])):
        values.same(f"bvp.{where}:{'counts.' * (where == 'summary')}bonds_broken", told["bonds_broken"], parted)


def held(values):
    for check in (put_off, riding, linear, one_error, there_and_back, torn):
        check(values)
