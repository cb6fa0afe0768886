# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small, fast files that the fuzzer starts from; together they hold every table of docs/scenes.md."""

import hull_bases

MATERIAL = """[material.sand]
density = "2650 kg/m^3"
youngs_modulus = "6 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0.2
contact = "hertz-mindlin"
"""
FRACTURE = """[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "50 MPa", m = 20.56 }
contact_tension = { strength = "300 MPa", critical_contacts = 3 }
weibull = { modulus = 3.1, reference_radius = "0.3 mm", size_exponent = 0.9677 }
cohesive_springs = { per_plane = 4, toughness = "1.77 MPa m^0.5", max_opening = 0.05, stiffness_ratio = 0.1 }
break_plane = "criterion"
turn_to_plane = true
slight_rotation = 0.1
rounding = 0.1
lost_mass = "fines"
fines = { dimension = 2.6, largest = 0.1 }
shape_transition = { ratio = 0.25, time = "10 us" }
smallest_radius = "0.05 mm"
max_generations = 5
"""
NUMERICS = """[numerics]
safety = 0.3
skin = 0.2
estimate_every = 50
fracture_every = 10
max_energy_error = 0.05
max_overlap = 0.9
"""
QUASI_STATIC = ("strain_per_step = 1e-4\ninertial_number = 1e-2\nunbalanced_force = 1e-1\nstress_change = 1e-1\n"
                "window = 50\nmax_hold = 2000\n")
UNIAXIAL = ("[loading]\nkind = \"uniaxial-strain\"\naxis = \"z\"\nstrain_rate = \"2000 1/s\"\nfinal_strain = 0.01\n"
            "gravity = [0, 0, -9.81]\n")
PERIODIC = """[packing]
kind = "random"
box = ["1.6 mm", "1.6 mm", "1.6 mm"]
radius = { distribution = "truncated-normal", mean = "0.25 mm", sd = "0.03 mm", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.5
seed = 1
material = "sand"
orientation = "random"
[boundary]
kind = "periodic"
[preparation]
pressure = "1 MPa"
friction = 0.2
""" + QUASI_STATIC
LOADINGS = {
    "triaxial": 'kind = "triaxial"\naxis = "z"\nstrain_rate = "2000 1/s"\nconfining_pressure = "1 MPa"\n'
                'final_strain = 0.01\n',
    "oedometric": 'kind = "oedometric-stress"\nfinal_stress = "5 MPa"\nstrain_rate = "2000 1/s"\nmax_strain = 0.01\n',
    "isotropic": 'kind = "isotropic-stress"\npressure = "2 MPa"\nstrain_rate = "500 1/s"\nduration = "10 us"\n',
    "gradient": 'kind = "velocity-gradient"\nvelocity_gradient = [[0, 0, 500], [0, 0, 0], [0, 0, -100]]\n'
                'duration = "10 us"\n'
}

RVE = {
    name:
    f'title = "{name}"\n' + MATERIAL + FRACTURE + PERIODIC + "[loading]\n" + text + NUMERICS + "[output]\nframes = 2\n"
    for name, text in LOADINGS.items()
}
RVE.update(hull_bases.RVE)
RVE["walls"] = 'title = "walls"\nseed = 3\n' + MATERIAL + FRACTURE + """[packing]
kind = "random"
box = ["2 mm", "2 mm", "2 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.42
count = 0
[boundary]
kind = "walls"
friction = 0.1
""" + UNIAXIAL + NUMERICS + """[output]
history_interval = 0.002
frames = 2
grading = true
gradings = 2
split_statistics = true
checkpoint_interval = "1 s"
"""
RVE["lattice"] = MATERIAL + FRACTURE + """[packing]
kind = "simple-cubic"
radius = { distribution = "constant", mean = "0.3 mm" }
layers = [3, 3, 3]
orientation = "aligned"
[boundary]
kind = "walls"
material = "sand"
""" + UNIAXIAL + NUMERICS
RVE["file"] = MATERIAL + """[packing]
kind = "file"
path = "pack.txt"
box = ["2 mm", "2 mm", "2 mm"]
[boundary]
kind = "walls"
""" + UNIAXIAL
RVE["platens"] = MATERIAL + FRACTURE + """[[grain]]
shape = "polyellipsoid"
semi_axes = ["0.3 mm", "0.2 mm", "0.25 mm", "0.3 mm", "0.2 mm", "0.2 mm"]
position = [0, 0, 0]
orientation = [1, 0, 0, 0]
spin = [0, 0, 1]
material = "sand"
[loading]
kind = "platens"
axis = "z"
strain_rate = "2000 1/s"
final_strain = 0.01
friction = 0.3
[numerics]
safety = 0.3
[output]
history_interval = 0.002
"""
RVE["two"] = MATERIAL.replace('contact = "hertz-mindlin"',
                              'contact = "linear"\nnormal_stiffness = "1e6 N/m"\nshear_ratio = 0.28') + """[[grain]]
radius = "1 mm"
position = [0, 0, 0]
velocity = [1, 0, 0]
[[grain]]
radius = "1 mm"
position = ["2.01 mm", 0, 0]
[[wall]]
point = [0, 0, "-1 mm"]
normal = [0, 0, 1]
rigid = true
friction = 0.2
[boundary]
kind = "open"
[loading]
kind = "free"
duration = "50 us"
gravity = [0, 0, -9.81]
[numerics]
time_step = "10 ns"
max_time_step = "1 us"
[output]
history_interval = "2 us"
frames = 2
"""
PACKING = "# x y z r\n" + "".join(f"{x * 0.6e-3 + 0.3e-3:g} {y * 0.6e-3 + 0.3e-3:g} {z * 0.6e-3 + 0.3e-3:g} 3e-4\n"
                                  for x in range(3) for y in range(3) for z in range(3))

CELL = MATERIAL + FRACTURE + """[packing]
kind = "simple-cubic"
radius = { distribution = "constant", mean = "0.3 mm" }
layers = [2, 2, 2]
[boundary]
kind = "periodic"
[preparation]
pressure = "1 MPa"
""" + QUASI_STATIC + UNIAXIAL + NUMERICS
BVP = {"block": """title = "block"
[mesh]
box = { size = ["20 mm", "20 mm", "20 mm"], cells = [1, 1, 2], cell = "hexahedron" }
dimension = "3d"
[element]
order = 1
quadrature_degree = 2
[rve]
scene = "cell.toml"
set = ["material.sand.friction=0.3"]
variants = 1
tangent = "network"
exact_sharing = true
adaptivity = { share = 1e-4, error = 0.01, elastic = 0.01 }
""" + QUASI_STATIC + """[[boundary]]
where = "z=max"
displacement = ["free", "free", "-0.1 mm"]
name = "top"
history = [[0, 0], [0.5, 1], [1, 0.5]]
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
where = "x=max"
pressure = "1 MPa"
history = "constant"
[[boundary]]
where = "y=max"
traction = ["0 MPa", "-1 MPa", 0]
history = "constant"
[[probe]]
name = "middle"
at = ["10 mm", "10 mm", "10 mm"]
grading = true
frames = true
[solve]
kind = "quasi-static"
increments = 2
tolerance = 1e-2
displacement_tolerance = 0.1
max_cutbacks = 3
max_iterations = 15
acceleration = 3
[output]
frames = 2
checkpoint_interval = "1 s"
costs = true
""", "plate": """[mesh]
file = "mesh.msh"
dimension = "plane-strain"
thickness = "10 mm"
unit = 1.0
[element]
order = 2
quadrature_degree = 4
[[region]]
where = "x<1"
material = "elastic"
youngs_modulus = "200 MPa"
poissons_ratio = 0.3
density = "2000 kg/m^3"
[[boundary]]
tag = "bottom"
displacement = [0, 0]
[[boundary]]
tag = "top"
displacement = [0, "-0.5 mm"]
[solve]
kind = "quasi-static"
increments = 2
[output]
frames = 2
checkpoint_interval = "1e-9 s"
""", "bar": """[mesh]
box = { size = ["10 mm", "100 mm"], cells = [1, 20], cell = "quadrilateral" }
dimension = "axisymmetric"
[[region]]
where = "y<1"
material = "elastic"
youngs_modulus = "200 GPa"
poissons_ratio = 0.3
density = "7800 kg/m^3"
[[boundary]]
where = "y=min"
pressure = "100 MPa"
history = [[0, 0], ["2 us", 1], ["10 us", 0]]
[[boundary]]
where = "x=min"
displacement = [0, "free"]
[[probe]]
name = "incident"
at = ["5 mm", "30 mm"]
[[probe]]
name = "transmitted"
at = ["5 mm", "70 mm"]
[hopkinson]
incident_gauge = "incident"
transmitted_gauge = "transmitted"
incident_distance = "30 mm"
transmitted_distance = "30 mm"
bar_modulus = "200 GPa"
bar_density = "7800 kg/m^3"
bar_area = "314 mm^2"
specimen_length = "6 mm"
specimen_area = "314 mm^2"
axis = "y"
[solve]
kind = "explicit-dynamic"
duration = "20 us"
safety = 0.8
linear_viscosity = 0.06
quadratic_viscosity = 1.2
estimate_every = 50
max_energy_error = 0.5
[output]
history_interval = "1 us"
frames = 2
"""}
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
1 1 "bottom"
1 2 "top"
2 3 "plate"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 0.01 0 0
3 0.02 0 0
4 0 0.01 0
5 0.01 0.01 0
6 0.02 0.01 0
$EndNodes
$Elements
6
1 1 2 1 1 1 2
2 1 2 1 1 2 3
3 1 2 2 2 4 5
4 1 2 2 2 5 6
5 3 2 3 1 1 2 5 4
6 3 2 3 1 2 3 6 5
$EndElements
"""
STUDY = {"cases": """title = "study"
[study]
scene = "two.toml"
seeds = [1, 2]
seed_key = "seed"
set = { "output.frames" = 0 }
at = [0.0]
quantities = ["kinetic_J"]
[[case]]
name = "a"
label = "first"
[[case]]
name = "b"
set = { "material.sand.friction" = 0.1 }
[[plot]]
name = "p"
title = "P"
x = "time_s"
y = "kinetic_J"
cases = ["a", "b"]
scale = 1.0
ylabel = "J"
[[check]]
claim = "below"
cases = ["a", "b"]
quantity = "errors.worst_energy_error"
below = 1.0
[[table]]
name = "t"
reference = "a"
cases = ["a", "b"]
""", "precision": """[study]
scene = "two.toml"
[[precision]]
name = "step"
quantity = "kinetic_J"
measure = "last"
vary = { "numerics.time_step" = ["20 ns", "10 ns", "5 ns"] }
reference = "finest"
paired = true
scale = 1.0
"""}
