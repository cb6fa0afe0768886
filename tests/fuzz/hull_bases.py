# SPDX-License-Identifier: LGPL-3.0-or-later
"""Those of polyhedra, with bonds and without."""

RVE = {}
RVE["angular"] = """[material.sand]
density = 2650.0
contact = "overlap"
youngs_modulus = "2 GPa"
friction = 0.5
[packing]
kind = "random"
box = ["5 mm", "5 mm", "5 mm"]
radius = { distribution = "uniform", min = "0.4 mm", max = "0.6 mm" }
solid_fraction = 0.12
hulls = { relax = 3, aspect = [1, 0.8, 0.6] }
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
axis = "z"
strain_rate = "500 1/s"
final_strain = 0.3
[output]
history_interval = 0.1
grading = true
"""
ROCK = """[material.rock]
density = "2500 kg/m^3"
contact = "overlap"
friction = 0.5
damping = 0.1
[material.rock.bond]
modulus = "20 GPa"
poissons_ratio = 0.2
"""
COHESIVE = """criterion = "cohesive"
tension = "6 MPa"
cohesion = "18 MPa"
friction_angle = "30 deg"
fracture_energy = "15 J/m^2"
weibull = 6
"""
CLEAVAGE = """[material.rock.fracture]
model = "cleavage"
toughness = "0.1 MPa m^0.5"
flaw = "0.1 mm"
planes = [[1, 0, 0], [0, 1, 0]]
offsets = [0, 0.3]
crystal = { axis = [0, 0, 1], angles = ["0 deg", "30 deg"] }
max_generations = 2
"""
RVE["cleaving"] = ROCK + COHESIVE + CLEAVAGE + """[packing]
kind = "voronoi"
cylinder = { diameter = "10 mm", length = "2 mm" }
cells = 30
extruded = true
[loading]
kind = "platens"
axis = "y"
strain_rate = "100 1/s"
final_strain = 0.006
[numerics]
max_energy_error = 0.5
[output]
history_interval = 0.001
"""
PERIDYNAMICS = """[material.sand.fracture]
model = "peridynamics"
platen_strength = "8 MPa"
weibull = { modulus = 3.1, reference_radius = "0.5 mm", law = "linear", inherit = true }
points = 300
smallest_radius = "0.15 mm"
test = { unbalanced_force = 0.5, unbalanced_moment = 1 }
"""
RVE["cracking"] = """[material.sand]
density = 2650.0
contact = "overlap"
youngs_modulus = "3 GPa"
friction = 0.5
damping = 0.3
""" + PERIDYNAMICS + """[packing]
kind = "random"
box = ["2.8 mm", "2.8 mm", "2.8 mm"]
radius = { distribution = "uniform", min = "0.4 mm", max = "0.5 mm" }
solid_fraction = 0.2
hulls = { balls = 32 }
[boundary]
kind = "periodic"
[preparation]
pressure = "1 MPa"
friction = 0.2
unbalanced_force = 0.02
[loading]
kind = "uniaxial-strain"
axis = "z"
strain_rate = "200 1/s"
final_strain = 0.03
[numerics]
max_energy_error = 0.5
[output]
history_interval = 0.015
grading = true
"""
RVE["disc"] = ROCK + COHESIVE + """[packing]
kind = "voronoi"
cylinder = { diameter = "10 mm", length = "2 mm" }
cells = 40
extruded = true
relax = 2
[loading]
kind = "platens"
axis = "y"
strain_rate = "100 1/s"
final_strain = 0.003
[numerics]
max_energy_error = 0.5
[output]
frames = 1
"""
BAR = ROCK + COHESIVE + "[packing]\nkind = \"voronoi\"\nbox = [\"12 mm\", \"3 mm\", \"4 mm\"]\ncells = 40\n"
RVE["beam"] = BAR + (
    "[[clamp]]\nwhere = \"x=min\"\n[[clamp]]\nwhere = \"x=max\"\nvelocity = [0.1, 0.02, 0]\n[[load]]\n"
    "where = \"z=max\"\nforce = [0, 0, \"-3 N\"]\nramp = \"10 us\"\n"
    "[loading]\nkind = \"free\"\nduration = \"50 us\"\n")
RVE["rollers"] = BAR.replace("weibull = 6\n", "weibull = 6\nbetween = \"3 MPa\"\n").replace(
    "cells = 40", "cells = 30\ngrains = \"clusters\"\nclusters = 3"
) + (
    "[loading]\nkind = \"rollers\"\naxis = \"z\"\nspan = \"x\"\nouter = \"10 mm\"\ninner = \"4 mm\"\n"
    "radius = \"1 mm\"\nspeed = \"2 m/s\"\nfriction = 0.1\nfinal_displacement = \"0.1 mm\"\n[output]\n"
    "bursts = \"1 us\"\n"
)
RVE["plates"] = ROCK + COHESIVE + (
    "[packing]\nkind = \"voronoi\"\nbox = [\"4 mm\", \"4 mm\", \"4 mm\"]\ncells = 30\n[boundary]\nkind = \"walls\"\n"
    "bonded = \"normal\"\n[loading]\nkind = \"constant-p\"\naxis = \"z\"\n"
    "pressure = \"5 MPa\"\nconsolidation = \"20 us\"\nstrain_rate = 20\nfinal_strain = 0.001\n")
RVE["blocks"] = """[material.rock]
density = 2500.0
contact = "overlap"
foundation = "1e12 Pa/m"
[[grain]]
shape = "hull"
box = ["2 mm", "2 mm", "2 mm"]
position = [0, 0, 0]
velocity = [1, 0, 0]
[[grain]]
shape = "hull"
vertices = [[0, 0, 0], ["2 mm", 0, 0], [0, "2 mm", 0], [0, 0, "2 mm"]]
position = ["1.8 mm", 0, 0]
[loading]
kind = "free"
duration = "0.2 ms"
"""
