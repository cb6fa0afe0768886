#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every key of a scene changes a result: keys.py BIN

A table of scene, key and another value. A run with the other value must end otherwise than the run without: another history, other files, another ending. Keys that the
readers in apps/scene know, and keys that the records of the runs show, must be in the table.
"""
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import scene_tools
from scene_tools import faults, here, need

binaries = os.path.abspath(sys.argv[1])
fem = os.path.exists(os.path.join(binaries, "grus-bvp"))
sys.path.insert(0, os.path.join(here, "..", "fuzz"))
import bases  # noqa: E402
import hull_bases  # noqa: E402

MATERIAL = """[material.sand]
density = 2650.0
youngs_modulus = "6 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0.2
"""
FRACTURE = """[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "9 MPa", m = 20.56 }
contact_tension = { strength = "30 MPa", critical_contacts = 3 }
weibull = { modulus = 3.1, reference_radius = "0.3 mm" }
cohesive_springs = { toughness = "0.2 MPa m^0.5" }
shape_transition = { ratio = 0.3, time = "5 us" }
fines = { dimension = 2.5, largest = 0.1 }
"""
RANDOM = """[packing]
kind = "random"
box = ["2.2 mm", "2.2 mm", "2.2 mm"]
radius = { distribution = "truncated-normal", mean = "0.3 mm", sd = "0.05 mm", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.5
material = "sand"
"""
UNIAXIAL = "[loading]\nkind = \"uniaxial-strain\"\naxis = \"z\"\nstrain_rate = \"2000 1/s\"\nfinal_strain = 0.06\n"
QUASI_STATIC = "strain_per_step = 1e-4\ninertial_number = 1e-2\nunbalanced_force = 2e-2\nstress_change = 2e-2\nwindow = 30\nmax_hold = 4000\n"
PREPARED = "[boundary]\nkind = \"periodic\"\n[preparation]\npressure = \"1 MPa\"\nfriction = 0.2\n" + QUASI_STATIC
OUTPUT = "[output]\nhistory_interval = 0.004\n"

BALLS = """[material.sand.fracture]
model = "apollonian-14"
contact_strength = { strength = "60 MPa", area = "angle", angle = "20 deg" }
scatter = { distribution = "log-normal", variation = 0.5, reference_diameter = "0.6 mm", size_exponent = 1 }
smallest_radius = "0.05 mm"
rest = 10
fines = { dimension = 2.5, smallest = "0.01 mm" }
"""
CYLINDER = "[boundary]\nkind = \"cylinder\"\nfriction = 0.1\n"
STRESSED = "[loading]\nkind = \"oedometric-stress\"\nfinal_stress = \"5 MPa\"\nstrain_rate = \"2000 1/s\"\nmax_strain = 0.1\n"

RVE = {
    "balls": "seed = 3\n" + MATERIAL + BALLS + RANDOM + "[boundary]\nkind = \"walls\"\nfriction = 0.1\n" + UNIAXIAL + "scale = 1\n[numerics]\nmax_overlap = 3\ninertia = { scaled_below = \"0.3 mm\" }\n" + OUTPUT + "grading = true\n",
    "modulus": MATERIAL + "contact = \"linear-modulus\"\ncontact_modulus = \"200 MPa\"\nrotation = false\n" + RANDOM + CYLINDER + UNIAXIAL + OUTPUT,
    "cylinder": MATERIAL + RANDOM + CYLINDER + STRESSED.replace("0.1", "0.3") + "control = \"stress\"\nstress_rate = \"1e11 Pa/s\"\n" + OUTPUT,
    "log-normal": MATERIAL + RANDOM.replace('"truncated-normal", mean = "0.3 mm", sd = "0.05 mm"', '"log-normal", median = "0.3 mm", spread = 0.2') + "[boundary]\nkind = \"walls\"\n" + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "sieve": MATERIAL + RANDOM.replace('"truncated-normal", mean = "0.3 mm", sd = "0.05 mm", min = "0.2 mm", max = "0.4 mm"', '"sieve", passing = [["0.4 mm", 0], ["0.6 mm", 0.4], ["0.8 mm", 1]]').replace(
        "solid_fraction = 0.5", "void_ratio = 1") + "[boundary]\nkind = \"walls\"\n" + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "mixed": MATERIAL + "[material.coal]\ndensity = 1400.0\nyoungs_modulus = \"2 GPa\"\nfriction = 0.9\n" + RANDOM.replace("material = \"sand\"\n", "").replace("0.5\n", "0.38\n") + "[[packing.mixture]]\nmaterial = \"sand\"\nshare = 3\n[[packing.mixture]]\n"
             "material = \"coal\"\nshare = 1\naspect = [1, 0.8, 0.6]\n[boundary]\nkind = \"walls\"\n" + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "relative": MATERIAL + RANDOM.replace("solid_fraction = 0.5", "relative_density = 0.3\nvoid_ratio_max = 1.1\nvoid_ratio_min = 0.6") + "[boundary]\nkind = \"walls\"\n" + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "crush": "title = \"crush\"\nseed = 3\n" + MATERIAL + FRACTURE + RANDOM + "[boundary]\nkind = \"walls\"\nfriction = 0.1\n" + UNIAXIAL + "[numerics]\nmax_overlap = 2\n" + OUTPUT + "grading = true\n",
    "cell": MATERIAL + RANDOM.replace("0.5\n", "0.58\n") + PREPARED + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "uniform": MATERIAL + RANDOM.replace('"truncated-normal", mean = "0.3 mm", sd = "0.05 mm"', '"uniform"') + "[boundary]\nkind = \"walls\"\nmaterial = \"sand\"\n" + UNIAXIAL.replace("0.06", "0.01") + OUTPUT,
    "lattice": MATERIAL + FRACTURE + "[packing]\nkind = \"simple-cubic\"\nradius = { distribution = \"constant\", mean = \"0.3 mm\" }\nlayers = [3, 3, 3]\norientation = \"aligned\"\n[boundary]\nkind = \"walls\"\n" +
               UNIAXIAL + "[numerics]\nmax_overlap = 2\n" + OUTPUT,
    "file": MATERIAL + "[packing]\nkind = \"file\"\npath = \"pack.txt\"\nbox = [\"2 mm\", \"2 mm\", \"2 mm\"]\n[boundary]\nkind = \"walls\"\n" + UNIAXIAL + OUTPUT,
    "linear": MATERIAL + "contact = \"linear\"\nnormal_stiffness = \"2e5 N/m\"\nshear_ratio = 0.5\n" + RANDOM + "[boundary]\nkind = \"walls\"\n" + UNIAXIAL + OUTPUT,
    "triaxial": MATERIAL + RANDOM.replace("0.5\n", "0.58\n") + PREPARED + "[loading]\nkind = \"triaxial\"\naxis = \"z\"\nstrain_rate = \"2000 1/s\"\nconfining_pressure = \"1 MPa\"\nfinal_strain = 0.01\n" + OUTPUT,
    "oedometric": MATERIAL + RANDOM.replace("0.5\n", "0.58\n") + PREPARED + "[loading]\nkind = \"oedometric-stress\"\nfinal_stress = \"5 MPa\"\nstrain_rate = \"2000 1/s\"\nmax_strain = 0.1\n" + OUTPUT,
    "isotropic": MATERIAL + RANDOM.replace("0.5\n", "0.58\n") + PREPARED + "[loading]\nkind = \"isotropic-stress\"\npressure = \"2 MPa\"\nstrain_rate = \"500 1/s\"\nduration = \"20 us\"\n",
    "gradient": MATERIAL + RANDOM.replace("0.5\n", "0.58\n") + PREPARED + "[loading]\nkind = \"velocity-gradient\"\nvelocity_gradient = [[0, 0, 500], [0, 0, 0], [0, 0, -100]]\nduration = \"20 us\"\n",
    "platens": MATERIAL + "[[grain]]\nshape = \"polyellipsoid\"\nsemi_axes = [\"0.3 mm\", \"0.2 mm\", \"0.25 mm\", \"0.3 mm\", \"0.2 mm\", \"0.2 mm\"]\nposition = [0, 0, 0]\norientation = [0.8, 0.6, 0, 0]\n"
               "spin = [0, 0, 100]\nmaterial = \"sand\"\n[loading]\nkind = \"platens\"\naxis = \"z\"\nstrain_rate = \"2000 1/s\"\nfinal_strain = 0.01\nfriction = 0.3\n[output]\nhistory_interval = 0.002\n",
    "speed": MATERIAL + "[[grain]]\nradius = \"0.3 mm\"\nposition = [0, 0, 0]\n[loading]\nkind = \"platens\"\nspeed = \"1 m/s\"\nfinal_strain = 0.01\n",
    "free": MATERIAL + "[material.other]\ndensity = 5000.0\nyoungs_modulus = \"2 GPa\"\nfriction = 0.9\n[[grain]]\nradius = \"1 mm\"\nposition = [0, 0, 0]\nvelocity = [3, 0.5, -1]\nspin = [0, 50, 0]\n"
            "[[grain]]\nradius = \"1 mm\"\nposition = [\"2.01 mm\", 0, 0]\n[[wall]]\npoint = [0, 0, \"-1 mm\"]\nnormal = [0, 0, 1]\nrigid = true\nfriction = 0.2\n"
            "[[wall]]\npoint = [0, 0, \"9 mm\"]\nnormal = [0, 0, -1]\nvelocity = [0, 0, 0]\nmaterial = \"sand\"\n[boundary]\nkind = \"open\"\n[loading]\nkind = \"free\"\nduration = \"50 us\"\ngravity = [0, 0, -9.81]\n"
            "[output]\nhistory_interval = \"5 us\"\n"}
ROCK, COHESIVE = hull_bases.ROCK, hull_bases.COHESIVE + "shear_energy = \"40 J/m^2\"\n"
DISC = "[packing]\nkind = \"voronoi\"\ncylinder = { diameter = \"10 mm\", length = \"2 mm\" }\ncells = 60\nextruded = true\nrelax = 2\n"
PRESSED = "[loading]\nkind = \"platens\"\naxis = \"y\"\nstrain_rate = \"100 1/s\"\nfinal_strain = 0.006\n[numerics]\nmax_energy_error = 0.5\n[output]\nhistory_interval = 0.001\n"
RVE["disc"] = ROCK + COHESIVE + DISC + PRESSED
RVE["brick"] = ROCK + "criterion = \"strain-sum\"\nlength = \"1 mm\"\nstrain = 0.0003\nrotation = 0.002\n" + DISC.replace("cylinder = { diameter = \"10 mm\", length = \"2 mm\" }\ncells = 60", "box = [\"8 mm\", \"8 mm\", \"8 mm\"]\ncell_size = \"2 mm\"").replace(
    "extruded = true\n", "") + PRESSED
RVE["stiff"] = ROCK.replace("modulus = \"20 GPa\"\npoissons_ratio = 0.2", "normal_stiffness = \"2e13 Pa/m\"\nshear_ratio = 0.3") + "criterion = \"parallel\"\ntension = \"6 MPa\"\nshear = \"18 MPa\"\n" + DISC + PRESSED
for name in ("beam", "rollers", "plates"):
    RVE[name] = bases.RVE[name]
IMPACT = "[numerics]\nsafety = 0.1\n[[wall]]\npoint = [0, 0, \"-0.1 mm\"]\nnormal = [0, 0, 1]\nvelocity = [0, 0, 20]\nrigid = true\n[loading]\nkind = \"free\"\nduration = \"20 us\"\n"
RVE["prisms"] = ROCK + hull_bases.COHESIVE + "[packing]\nkind = \"prisms\"\nbox = [\"9 mm\", \"9 mm\", \"2 mm\"]\nside = \"1 mm\"\nthickness = \"1 mm\"\ngap = \"0.1 mm\"\n" + IMPACT
RVE["outline"] = ROCK + hull_bases.COHESIVE + "[packing]\nkind = \"voronoi\"\nprism = { corners = [[0, 0, 0], [\"6 mm\", 0, 0], [0, \"6 mm\", 0]], height = \"3 mm\" }\ncells = 20\n" + IMPACT
RVE["egg"] = ROCK + hull_bases.COHESIVE + ("[packing]\nkind = \"voronoi\"\npolyellipsoid = { semi_axes = [\"3 mm\", \"2 mm\", \"2 mm\", \"2 mm\", \"2 mm\", \"2 mm\"] }\ncells = 20\n" +
                                        IMPACT.replace("-0.1 mm", "-2.1 mm").replace("20 us", "60 us"))
RVE["parents"] = ROCK + hull_bases.COHESIVE + ("[packing]\nkind = \"voronoi\"\ngrains = \"clusters\"\ncells = 10\nparents = { kind = \"simple-cubic\", radius = { distribution = \"constant\", mean = \"1 mm\" }, layers = [2, 1, 1] }\n" + IMPACT)
RVE["blocks"] = ("[material.rock]\ndensity = 2500.0\ncontact = \"overlap\"\nfoundation = \"1e12 Pa/m\"\n[[grain]]\nshape = \"hull\"\nbox = [\"2 mm\", \"2 mm\", \"2 mm\"]\nposition = [0, 0, 0]\nvelocity = [1, 0, 0]\n"
                 "[[grain]]\nshape = \"hull\"\nvertices = [[0, 0, 0], [\"2 mm\", 0, 0], [0, \"2 mm\", 0], [0, 0, \"2 mm\"]]\nposition = [\"1.8 mm\", 0, 0]\n[loading]\nkind = \"free\"\nduration = \"0.8 ms\"\n")
RVE["cleaving"] = hull_bases.RVE["cleaving"]
RVE["angular"] = bases.RVE["angular"]
RVE["tube"] = RVE["free"].replace("[boundary]", "[[wall]]\nshape = \"cylinder\"\naxis = \"z\"\nradius = \"3.345 mm\"\npoint = [\"1 mm\", \"-2.1 mm\", 0]\n[boundary]")
CELL = MATERIAL + FRACTURE.replace("9 MPa", "40 MPa") + """[packing]
kind = "random"
box = ["2 mm", "2 mm", "2 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.56
""" + PREPARED
BVP = {
    "block": """title = "block"
[mesh]
box = { size = ["20 mm", "20 mm", "20 mm"], cells = [1, 1, 2], cell = "hexahedron" }
dimension = "3d"
[rve]
scene = "cell.toml"
variants = 2
""" + QUASI_STATIC.replace("2e-2", "5e-3") + """[[boundary]]
where = "z=max"
displacement = ["free", "free", "-0.03 mm"]
name = "top"
[[boundary]]
where = "z=min"
displacement = ["free", "free", 0]
[[boundary]]
where = "x=min"
displacement = [0, "free", "free"]
[[boundary]]
where = "y=min and x<0.01"
displacement = ["free", 0, "free"]
[[boundary]]
where = "y=max"
displacement = ["free", 0, "free"]
[[boundary]]
where = "x=max"
displacement = [0, "free", "free"]
[[probe]]
name = "middle"
at = ["10 mm", "10 mm", "10 mm"]
[solve]
kind = "quasi-static"
increments = 2
tolerance = 5e-2
displacement_tolerance = 0.2
max_iterations = 20
max_cutbacks = 3
[output]
frames = 0
""", "plate": bases.BVP["plate"][0] if isinstance(bases.BVP["plate"], tuple) else bases.BVP["plate"], "bar": bases.BVP["bar"].replace("20 us", "30 us")}
BVP["ground"] = """title = "ground"
gravity = [0, -5000]
[mesh]
box = { size = ["40 mm", "40 mm"], cells = [2, 2] }
dimension = "plane-strain"
[element]
kind = "standard"
[rve]
scene = "cell.toml"
""" + QUASI_STATIC + """[initial_stress]
k0 = 0.6
surface = "40 mm"
surcharge = "1 MPa"
axis = "y"
[[region]]
where = "y<0.02"
material = "j2"
youngs_modulus = "300 MPa"
poissons_ratio = 0.2
yield_stress = "0.8 MPa"
hardening = "10 MPa"
density = 2000
[[boundary]]
where = "y=max"
displacement = ["free", "-0.8 mm"]
[[boundary]]
where = "y=min"
displacement = ["free", 0]
[[boundary]]
where = "x=min"
displacement = [0, "free"]
[[boundary]]
where = "x=max"
pressure = "0.6 MPa"
history = "constant"
[solve]
kind = "explicit-quasi-static"
balance = 0.2
crossings = 60
[output]
history_interval = 0.1
"""
FILES = {"pack.txt": bases.PACKING, "cell.toml": CELL, "mesh.msh": bases.MESH}

SAND, SPLIT = "material.sand.", "material.sand.fracture."
# Scene, key, another value. Several settings where one alone says nothing.
RVE_KEYS = [
    *[("balls", SPLIT + k, v) for k, v in (
        ("model", "polyellipsoid-split"), ("contact_strength.strength", 4e7), ("contact_strength.angle", 0.2), ("scatter.distribution", "normal"), ("scatter.variation", 0.2),
        ("scatter.reference_diameter", 8e-4), ("scatter.size_exponent", 0.5), ("smallest_radius", 1e-4), ("rest", 60), ("fines.dimension", 2.0), ("fines.largest", 0.1), ("fines.smallest", 3e-5),
        ("lost_mass", "density"))],
    ("balls", SPLIT + "lost_mass", "swell"),
    ("balls", SPLIT + "contact_strength.area", "hertz", SPLIT + "contact_strength.angle="),
    ("balls", SPLIT + "contact_strength.compressive_strength", 3e7, SPLIT + "contact_strength.strength=", SPLIT + "contact_strength.tensile_strength=2e6"),
    ("balls", SPLIT + "contact_strength.tensile_strength", 1e6, SPLIT + "contact_strength.strength=", SPLIT + "contact_strength.compressive_strength=3e7"),
    ("balls", "loading.scale", 1.2), ("balls", "numerics.inertia.scaled_below", 5e-4),
    ("modulus", SAND + "contact_modulus", 3e8), ("modulus", SAND + "rotation", "true"), ("modulus", "boundary.friction", 0.5), ("modulus", "boundary.kind", "walls"),
    ("cylinder", "loading.control", "strain", "loading.stress_rate="), ("cylinder", "loading.stress_rate", 2e11),
    ("log-normal", "packing.radius.median", 2.8e-4), ("log-normal", "packing.radius.spread", 0.1), ("sieve", "packing.radius.passing", "[[4e-4, 0], [6e-4, 0.6], [8e-4, 1]]"),
    ("mixed", "packing.mixture.0.share", 1), ("mixed", "packing.mixture.1.material", "sand"), ("mixed", "packing.mixture.1.aspect", "[1, 1, 0.6]"), ("crush", SAND + "rolling_friction", 0.2),
    ("sieve", "packing.void_ratio", 1.1), ("relative", "packing.relative_density", 0.5), ("relative", "packing.void_ratio_max", 1.2), ("relative", "packing.void_ratio_min", 0.7),
    ("crush", "title", "'another'"), ("crush", "seed", 4),
    *[("crush", SAND + k, v) for k, v in (("density", 3000.0), ("youngs_modulus", 7e9), ("poissons_ratio", 0.3), ("friction", 0.2), ("restitution", 0.9), ("damping", 0.0))],
    ("linear", SAND + "normal_stiffness", 3e5), ("linear", SAND + "shear_ratio", 0.2), ("linear", SAND + "contact", "hertz-mindlin"),
    *[("crush", SPLIT + k, v) for k, v in (
        ("hoek_brown.compressive_strength", 2e7), ("hoek_brown.m", 3.0), ("contact_tension.strength", 1e7), ("contact_tension.critical_contacts", 5), ("weibull.modulus", 9.0),
        ("weibull.reference_radius", 4e-4), ("weibull.size_exponent", 0.0), ("cohesive_springs.per_plane", 6), ("cohesive_springs.toughness", 1e6), ("cohesive_springs.max_opening", 0.002),
        ("cohesive_springs.stiffness_ratio", 0.01), ("break_plane", "average-stress"), ("turn_to_plane", "true"), ("slight_rotation", 0.2), ("rounding", 0.1), ("lost_mass", "density"),
        ("fines.dimension", 1.5), ("fines.largest", 0.9), ("shape_transition.ratio", 0.6), ("shape_transition.time", 5e-7), ("smallest_radius", 2.9e-4), ("max_generations", 1))],
    ("crush", SPLIT + "model", "'another'"),
    ("crush", "packing.box", "[2.2e-3, 2.2e-3, 2.3e-3]"), ("crush", "packing.solid_fraction", 0.45), ("crush", "packing.seed", 77), ("crush", "packing.kind", "hcp", "packing.radius={distribution='constant',mean=3e-4}",
                                                                                                                                "packing.solid_fraction=", "packing.seed="),
    ("crush", "packing.count", 20), ("crush", "packing.material", "'nothing'"), ("crush", "packing.orientation", "aligned"),
    ("crush", "packing.radius.mean", 3.3e-4), ("crush", "packing.radius.sd", 1e-5), ("crush", "packing.radius.min", 2.8e-4), ("crush", "packing.radius.max", 3.2e-4),
    ("crush", "packing.radius.distribution", "uniform", "packing.radius.mean=", "packing.radius.sd="), ("uniform", "packing.radius.min", 2.5e-4),
    ("lattice", "packing.layers", "[3, 3, 4]"), ("lattice", "packing.orientation", "random"), ("file", "packing.path", "'nowhere.txt'"),
    ("crush", "boundary.kind", "periodic", "boundary.friction="), ("crush", "boundary.friction", 0.6), ("uniform", "boundary.material", "'nothing'"),
    ("free", "boundary.kind", "walls"), ("free", "boundary.box", "[1, 1, 1]", "boundary.kind=periodic", "wall="),
    ("cell", "preparation.pressure", 2e6), ("cell", "preparation.friction", 0.0), ("cell", "preparation.inertial_number", 3e-3), ("cell", "preparation.unbalanced_force", 1e-4),
    ("cell", "preparation.stress_change", 1e-4, "preparation.unbalanced_force=1"), ("cell", "preparation.window", 90), ("cell", "preparation.max_hold", 20, "preparation.unbalanced_force=1e-6"),
    ("cell", "loading.axis", "x"), ("cell", "loading.strain_rate", 1000.0), ("cell", "loading.final_strain", 0.02), ("crush", "loading.gravity", "[0, 0, -1e5]"), ("cell", "loading.kind", "triaxial",
                                                                                                                                                       "loading.confining_pressure=1e6"),
    ("triaxial", "loading.confining_pressure", 2e6), ("oedometric", "loading.final_stress", 3e6), ("oedometric", "loading.max_strain", 1e-4), ("oedometric", "loading.strain_rate", 1000.0),
    ("isotropic", "loading.pressure", 3e6), ("isotropic", "loading.strain_rate", 50.0), ("isotropic", "loading.duration", 1e-5),
    ("gradient", "loading.velocity_gradient", "[[0, 0, 0], [0, 0, 500], [0, 0, -100]]"), ("gradient", "loading.duration", 1e-5),
    ("platens", "loading.axis", "x"), ("platens", "loading.strain_rate", 1000.0), ("platens", "loading.final_strain", 0.02), ("platens", "loading.friction", 0.0), ("speed", "loading.speed", 2.0),
    ("platens", "grain.0.semi_axes", "[4e-4, 2e-4, 2.5e-4, 3e-4, 2e-4, 2e-4]"), ("platens", "grain.0.orientation", "[0.8, 0, 0.6, 0]"), ("platens", "grain.0.spin", "[0, 0, 0]"),
    ("platens", "grain.0.shape", "sphere", "grain.0.semi_axes=", "grain.0.radius=3e-4"), ("free", "grain.0.radius", 1.2e-3), ("free", "grain.0.position", "[0, 1e-4, 0]"),
    ("free", "grain.0.velocity", "[2, 0, 0]"), ("free", "grain.0.spin", "[0, 0, 0]"), ("free", "grain.0.material", "other"),
    ("free", "wall.0.point", "[0, 0, -2e-3]"), ("free", "wall.0.normal", "[0.5, 0, 0.866]"), ("free", "wall.0.rigid", "false", "wall.0.friction=", "wall.0.material=other"), ("free", "wall.0.friction", 0.9),
    ("tube", "wall.2.axis", "x"), ("tube", "wall.2.radius", 3.4e-3), ("tube", "wall.2.shape", "plane", "wall.2.axis=", "wall.2.radius=", "wall.2.normal=[0, -1, 0]", "wall.2.point=[0, 1.003e-3, 0]"),
    ("free", "wall.1.velocity", "[0, 0, -200]"), ("free", "wall.0.material", "other", "wall.0.rigid=", "wall.0.friction="), ("free", "loading.gravity", "[0, 0, -9e4]"), ("free", "loading.duration", 3e-5),
    *[("disc", "material.rock.bond." + k, v) for k, v in (("modulus", 1e10), ("poissons_ratio", 0.1), ("tension", 3e6), ("cohesion", 9e6), ("friction_angle", 0.2), ("fracture_energy", 8.0), ("shear_energy", 15.0), ("weibull", 3), ("damping", 0.3))],
    ("disc", "material.rock.bond.criterion", "parallel", "material.rock.bond.cohesion=", "material.rock.bond.fracture_energy=", "material.rock.bond.shear_energy=", "material.rock.bond.shear=18e6"),
    *[("brick", "material.rock.bond." + k, v) for k, v in (("length", 5e-4), ("strain", 1e-4), ("rotation", 1e-4))], *[("stiff", "material.rock.bond." + k, v) for k, v in (("normal_stiffness", 1e13), ("shear_ratio", 0.6), ("shear", 4e6))],
    *[("beam", k, v) for k, v in (("clamp.0.where", "y=min"), ("clamp.0.slides", "true"), ("clamp.1.velocity", "[0.2, 0.02, 0]"), ("load.0.where", "y=max"), ("load.0.force", "[0, 0, 3]"), ("load.0.ramp", 0.0))],
    *[("rollers", "loading." + k, v) for k, v in (("axis", "y"), ("outer", 0.009), ("inner", 0.0), ("radius", 0.002), ("speed", 4.0), ("friction", 0.5), ("final_displacement", 2e-4))],
    ("rollers", "loading.span", "z", "loading.axis=x", "loading.outer=3e-3", "loading.inner=1e-3"), ("rollers", "packing.clusters", 4), ("rollers", "packing.grains", "one", "packing.clusters="),
    ("rollers", "material.rock.bond.between", 1e6), ("rollers", "output.bursts", 1e-4),
    *[("plates", k, v) for k, v in (("boundary.bonded", "full"), ("loading.axis", "x"), ("loading.pressure", 4e6), ("loading.consolidation", 3e-5), ("loading.strain_rate", 10.0), ("loading.final_strain", 0.002))],
    *[("prisms", "packing." + k, v) for k, v in (("side", 9e-4), ("thickness", 2e-3), ("gap", 0.0))], ("prisms", "packing.cylinder", "{ diameter = 9e-3, length = 2e-3 }", "packing.box="), ("outline", "packing.prism.corners", "[[0, 0, 0], [0.006, 0, 0], [0, 0.005, 0]]"),
    ("outline", "packing.prism.height", 0.002), ("egg", "packing.polyellipsoid.semi_axes", "[2e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3]"), *[("parents", "packing.parents." + k, v, *more) for k, v, *more in (("layers", "[1, 1, 1]"), ("radius.mean", 1.1e-3), ("seed", 5), ("radius.distribution", "uniform", "packing.parents.radius.mean=", "packing.parents.radius.min=9e-4",
                                                                       "packing.parents.radius.max=1e-3"), ("material", "nothing"), ("orientation", "aligned"),
                                                                      ("kind", "random", "packing.parents.layers=", "packing.parents.box=[5e-3,5e-3,5e-3]", "packing.parents.solid_fraction=0.3"))],
    *[("disc", "packing." + k, v) for k, v in (("cylinder.diameter", 0.012), ("cylinder.length", 0.001), ("cells", 70), ("extruded", "false"), ("relax", 0))], ("brick", "packing.cell_size", 0.0025),
    *[("cleaving", "material.rock.fracture." + k, v, *more) for k, v, *more in (
        ("toughness", 5e4), ("flaw", 3e-4), ("planes", "[[1, 0, 0]]"), ("offsets", "[0.2]"), ("crystal", "random"), ("crystal.axis", "[1, 0, 0]"), ("crystal.angles", "[0.3]"), ("geometry", 1.12), ("mode_ratio", 0.5),
        ("hydrostatic_gate", 0.0), ("cohesive", "false"), ("fracture_energy", 30.0), ("max_generations", 1), ("smallest_radius", 1e-3), ("rest", 40), ("toughness", "[5e4, 2e5]"))],
    ("cleaving", "material.rock.fracture.hoek_brown", "{compressive_strength=2e6,m=10}"), ("cleaving", "material.rock.fracture.contact_strength", "{strength=1e6,area='contact'}"),
    ("angular", "packing.hulls.relax", 0), ("angular", "packing.hulls.aspect", "[1, 1, 0.5]"),
    ("blocks", "material.rock.foundation", 2e12), ("blocks", "grain.0.box", "[2e-3, 3e-3, 2e-3]"), ("blocks", "grain.1.vertices", "[[0, 0, 0], [2e-3, 0, 0], [0, 3e-3, 0], [0, 0, 2e-3]]"),
    ("crush", "numerics.safety", 0.2), ("crush", "numerics.time_step", 2e-8), ("crush", "numerics.max_time_step", 1e-8), ("crush", "numerics.skin", 0.5), ("crush", "numerics.estimate_every", 3),
    ("crush", "numerics.fracture_every", 200), ("crush", "numerics.max_energy_error", 1e-9), ("crush", "numerics.max_overlap", 1e-3),
    ("crush", "output.history_interval", 0.01), ("crush", "output.frames", 2), ("crush", "output.contacts", "true", "output.frames=2"), ("crush", "output.grading", "false"), ("crush", "output.gradings", 2), ("crush", "output.split_statistics", "true"),
]
BVP_KEYS = [
    ("block", "title", "'another'"), ("block", "mesh.box.size", "[0.02, 0.02, 0.03]"), ("block", "mesh.box.cells", "[1, 1, 1]"), ("block", "mesh.box.cell", "tetrahedron"), ("plate", "mesh.file", "'nowhere.msh'"),
    ("plate", "mesh.dimension", "axisymmetric"), ("plate", "mesh.thickness", 0.02), ("plate", "mesh.unit", 2.0), ("plate", "element.order", 1), ("plate", "element.quadrature_degree", 1),
    ("plate", "region.0.where", "x<0.01"), ("plate", "region.0.tag", "'nothing'", "region.0.where="), ("plate", "region.0.material", "'nothing'"), ("plate", "region.0.youngs_modulus", 3e8),
    ("plate", "region.0.poissons_ratio", 0.1), ("bar", "region.0.density", 5000.0), ("plate", "boundary.0.tag", "top"), ("block", "boundary.0.where", "z>0.005"),
    ("block", "boundary.0.displacement", "['free','free',-2e-4]"), ("block", "boundary.0.name", "lid"), ("bar", "boundary.0.pressure", 2e8), ("bar", "boundary.0.history", "constant"),
    ("bar", "boundary.0.traction", "[0, 2e8]", "boundary.0.pressure="), ("block", "rve.scene", "'nowhere.toml'"), ("block", "rve.set", "['material.sand.friction=0.45']"), ("block", "rve.variants", 1),
    ("block", "rve.tangent", "network"), ("block", "rve.perturbation", 3e-5, "rve.tangent=perturbation"), ("block", "rve.perturbation_central", "true", "rve.tangent=perturbation"),
    ("block", "rve.exact_sharing", "false"), ("block", "rve.adaptivity.share", 0.1), ("block", "rve.adaptivity.error", 0.5), ("block", "rve.adaptivity.elastic", 0.9),
    ("block", "rve.strain_per_step", 1e-5), ("block", "rve.inertial_number", 2e-3), ("block", "rve.unbalanced_force", 1e-3), ("block", "rve.stress_change", 1e-4), ("block", "rve.window", 100),
    ("block", "rve.pressure_floor", 1e8), ("block", "rve.max_hold", 30, "rve.unbalanced_force=1e-3", "rve.stress_change=1e-3"), ("block", "probe.0.name", "other"), ("block", "probe.0.at", "[0, 0, 0]"), ("block", "probe.0.where", "z>0.01", "probe.0.at="),
    ("block", "probe.0.grading", "true"), ("block", "probe.0.frames", "true", "output.frames=1"), ("block", "solve.kind", "explicit-dynamic", "solve.duration=1e-6", "solve.increments=", "solve.tolerance=",
                                                                                                         "solve.displacement_tolerance=", "solve.max_iterations="),
    ("block", "solve.increments", 3), ("block", "solve.tolerance", 0.5, "solve.displacement_tolerance=0.9"), ("block", "solve.displacement_tolerance", 0.02), ("block", "solve.max_cutbacks", 0, "solve.max_iterations=1"),
    ("block", "solve.max_iterations", 1), ("block", "solve.acceleration", 0), ("block", "output.frames", 2), ("block", "output.costs", "true"),
    ("bar", "solve.duration", 2e-5), ("bar", "solve.safety", 0.4), ("bar", "solve.time_step", 1e-8), ("bar", "solve.linear_viscosity", 0.3), ("bar", "solve.quadratic_viscosity", 200.0),
    ("bar", "solve.max_energy_error", 1e-6, "solve.time_step=1e-7"), ("bar", "output.history_interval", 2e-6),
    *[("bar", "hopkinson." + k, v) for k, v in (("incident_gauge", "transmitted"), ("transmitted_gauge", "incident"), ("incident_distance", 0.01), ("transmitted_distance", 0.01), ("bar_modulus", 1e11),
                                                ("bar_density", 5000.0), ("bar_area", 1e-4), ("specimen_length", 1e-3), ("specimen_area", 1e-4), ("axis", "x"))],
    *[("ground", key, value) for key, value in (
        ("gravity", "[0, -1000]"), ("element.kind", "fbar"), ("element.kind", "serendipity"), ("initial_stress.k0", 0.5), ("initial_stress.surface", 0.06), ("initial_stress.surcharge", 1.1e6),
        ("initial_stress.axis", "x"), ("initial_stress.tolerance", 0.2), ("region.0.yield_stress", 2e6), ("region.0.hardening", 1e9), ("region.0.density", 4000), ("region.0.initial_stress", "[-6e5, -9e5, -6e5, 0, 0, 0]"),
        ("rve.damping", 0.3), ("solve.balance", 0.003), ("solve.kinetic", 1e-4), ("solve.inertial_number", 3e-3), ("solve.damping", 0.2), ("solve.safety", 0.6), ("solve.crossings", 80),
        ("output.history_interval", 0.2), ("rve.strain_per_step", 2e-5), ("rve.inertial_number", 3e-3))],
    ("ground", "region.0.material", "elastic", "region.0.yield_stress=", "region.0.hardening="), ("ground", "solve.max_energy_error", 1e-9),
    ("ground", "rve.on_failure", "elastic", "rve.set=['numerics.max_overlap=0.02']"),
]
# Keys whose effect is on what is not in a results folder, and where it is looked at.
ELSEWHERE = {"output.checkpoint_interval": "scenes_resume, macro_resume: a checkpoint of that age",
             "solve.estimate_every": "fem/dynamics counts; elastic bars keep their step",
             "preparation.strain_per_step": "physics/histories; a servo, not a strain, prepares", "output.wrapped": "scenes_frames: grains lie in the cell", "preparation.pressure_floor": "a tenth of the pressure always; refused in the scene"}


def outcome(folder, result):
    """What a run leaves, but for clocks: ending, files, tables."""
    left = {"exit": result.returncode, "error": re.sub(r"time [0-9.e+-]+", "", result.stderr)[-200:] if result.returncode else ""}
    for path in sorted(glob.glob(os.path.join(folder, "**"), recursive=True)):
        name = os.path.relpath(path, folder)
        if name.endswith((".csv", ".series")):
            text = open(path).read()
            if name == "history.csv" and "wall_s" in text.split("\n", 1)[0].split(","):
                at = text.split("\n", 1)[0].split(",").index("wall_s")
                text = "\n".join(",".join(v for k, v in enumerate(line.split(",")) if k != at) for line in text.split("\n"))
            left[name] = "there" if name == "costs.csv" else text
        elif not name.endswith((".json", ".h5")):
            left[name] = "there"
    summary = os.path.join(folder, "summary.json")
    if os.path.exists(summary):
        s = json.load(open(summary))
        left["title"], left["counts"], left["record"] = s.get("title"), s.get("counts"), s
    return left


def paths(record, at=""):
    for key, value in record.items() if isinstance(record, dict) else enumerate(record):
        path = f"{at}.{key}" if at else str(key)
        if isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
            yield from paths(value, path)
        else:
            yield path


def general(path):
    return re.sub(r"\.\d+\b", "", re.sub(r"^material\.\w+", "material.*", path))


def main(tmp):
    for name, text in FILES.items():
        open(os.path.join(tmp, name), "w").write(text)
    for name, text in (RVE | (BVP if fem else {})).items():
        open(os.path.join(tmp, name + ".toml"), "w").write(text)

    def run(scene, *sets):
        folder = os.path.join(tempfile.mkdtemp(dir=tmp), "out")
        program = os.path.join(binaries, "grus-rve" if scene in RVE else "grus-bvp")
        command = [program, os.path.join(tmp, scene + ".toml"), "-o", folder, "--quiet", "--threads", "1", *[a for s in sets for a in ("--set", s)]]
        try:
            return outcome(folder, subprocess.run(command, capture_output=True, text=True, timeout=120))
        except subprocess.TimeoutExpired:
            return {"exit": "timeout"}

    table = RVE_KEYS + (BVP_KEYS if fem else [])
    with ThreadPoolExecutor(4) as pool:
        scenes = sorted({row[0] for row in table})
        plain = dict(zip(scenes, pool.map(run, scenes)))
        for scene in scenes:
            need(plain[scene]["exit"] == 0, f"{scene}: exit {plain[scene]['exit']} {plain[scene].get('error')}")
        # Companions alone are not the key: where there are any, the run to compare with has them too if it can.
        others = list(pool.map(lambda row: run(row[0], *row[3:], f"{row[1]}={row[2]}"), table))
        without = list(pool.map(lambda row: run(row[0], *row[3:]) if len(row) > 3 else plain[row[0]], table))
    strip = lambda o: {k: v for k, v in o.items() if k != "record"}
    for row, other, base in zip(table, others, without):
        base = base if base["exit"] == 0 else plain[row[0]]
        need(strip(other) != strip(base), f"{row[0]}: {row[1]} = {row[2]} changes nothing")
    covered = {general(row[1]) for row in table} | set(ELSEWHERE)
    for scene in scenes:
        for path in paths(plain[scene].get("record", {}).get("scene", {})):
            need(general(path) in covered or general(path).rsplit(".", 1)[0] in covered, f"{path} (scene {scene}) is in no row of the table")
    words = {part for key in covered for part in key.split(".")}
    files = glob.glob(os.path.join(here, "..", "..", "apps", "scene", "*_scene.cpp"))
    readers = "".join(open(p).read() for p in files if fem or not os.path.basename(p).startswith(("bvp_", "mesh_")))
    for key in sorted(set(re.findall(r"\b(?:number|number_or|integer_or|flag_or|text|text_or|choice|choice_or|numbers|numbers_or|free_numbers|pairs|texts_or_none|matrix)\(\"([a-z_0-9]+)\"", readers))):
        need(key in words, f"{key}, which a reader asks for, is in no row of the table")
    print(f"{len(table)} keys and values")


with tempfile.TemporaryDirectory() as folder:
    main(folder)
print(f"keys: {len(faults)} faults")
sys.exit(1 if faults else 0)
