# SPDX-License-Identifier: LGPL-3.0-or-later
"""What peers.py has each program do: input files of one problem, as that program's manual would write them for
speed."""
import math
import os
import random

WARM, DT, RATE = 200, 2e-8, 500.0


def read(packing):
    lines = open(packing).read().split("\n")
    n, size = lines[0].split()
    return float(size), [tuple(map(float, x.split())) for x in lines[1:int(n) + 1]]


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as f:
        f.write(text)


def grus(packing, steps, folder):
    size, grains = read(packing)
    write(folder, "grains.txt", "".join("%.12g %.12g %.12g %.12g\n" % g for g in grains))
    write(folder, "scene.toml", f"""
[material.sand]
density = 2650
youngs_modulus = 60e9
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5

[packing]
kind = "file"
path = "grains.txt"
box = [{size}, {size}, {size}]

[boundary]
kind = "walls"
material = "sand"

[loading]
kind = "uniaxial-strain"
axis = "z"
strain_rate = {RATE}
final_strain = {(steps + WARM) * DT * RATE:.9g}

[numerics]
time_step = {DT}
""")


def data(grains, size, columns):
    low, high = -0.1 * size, 1.1 * size
    head = f"packing\n\n{len(grains)} atoms\n1 atom types\n\n" + "".join(f"{low} {high} {k}lo {k}hi\n" for k in "xyz")
    return head + f"\nAtoms{columns}\n\n" + "".join(f"{i + 1} 1 {2 * r} 2650 {x} {y} {z}\n"
                                                    for i, (x, y, z, r) in enumerate(grains))


def plate(name, size, axis, at):
    a, b = -0.05 * size, 1.05 * size
    text = f"solid {name}\n"
    for corners in (((a, a), (b, a), (b, b)), ((a, a), (b, b), (a, b))):
        rows = [list(c) for c in corners]
        for row in rows:
            row.insert(axis, at)
        text += " facet normal 0 0 1\n  outer loop\n" + "".join(f"   vertex {x} {y} {z}\n"
                                                                for x, y, z in rows) + "  endloop\n endfacet\n"
    return text + f"endsolid {name}\n"


SIDES = (("xplane", 0), ("xplane", 1), ("yplane", 0), ("yplane", 1), ("zplane", 0))


def closing(size):
    """Stress of the sample, by pairs alone and over its volume at the start, once before and once after the steps."""
    return f"""fix integ all nve/sphere
compute sum all reduce sum c_st[3]
variable stress equal -c_sum/{size ** 3:.12g}
thermo_style custom step v_stress
thermo 100000000
thermo_modify lost error norm no
run {WARM}
run ${{more}}
"""


def opening(style, grains, modulus, law, step):
    """Of a LIGGGHTS deck."""
    return f"""atom_style {style}
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
hard_particles yes
{grains}
neighbor 1e-4 bin
neigh_modify delay 0 every 1 check yes
fix m1 all property/global youngsModulus peratomtype {modulus}
fix m2 all property/global poissonsRatio peratomtype 0.17
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran {law}
pair_coeff * *
timestep {step}
"""


def liggghts(packing, folder):
    size, grains = read(packing)
    write(folder, "data.in", data(grains, size, ""))
    write(folder, "top.stl", plate("top", size, 2, size))
    law = "model hertz tangential history"
    planes = "".join(f"fix p{k} all wall/gran {law} primitive type 1 {plane} {at * size}\n"
                     for k, (plane, at) in enumerate(SIDES))
    write(
        folder, "run.in",
        f"""{opening("granular", "read_data data.in", 60e9, law, DT)}fix top all mesh/surface/stress file top.stl type 1
fix w all wall/gran {law} mesh n_meshes 1 meshes top
fix mv all move/mesh mesh top linear 0. 0. {-RATE * size}
{planes}compute st all stress/atom pair
{closing(size)}""")


def lammps(packing, folder):
    size, grains = read(packing)
    write(folder, "data.in", data(grains, size, " # sphere"))
    law = "hertz/material 60e9 0.5 0.17 tangential mindlin NULL 1.0 0.5 damping tsuji"
    planes = "".join(f"fix p{k} all wall/gran granular {law} {plane} {low} {high}\n"
                     for k, (plane, low, high) in enumerate((("xplane", 0, size), ("yplane", 0, size),
                                                             ("zplane", 0, "NULL"))))
    write(folder, "run.in", f"""atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes
units si
read_data data.in
neighbor 1e-4 bin
neigh_modify delay 0 every 1 check yes
pair_style granular
pair_coeff * * {law}
timestep {DT}
variable zt equal {-RATE * size}*step*dt
variable z0 equal 0
region top plane 0 0 {size} 0 0 -1 side in move v_z0 v_z0 v_zt
fix wt all wall/gran/region granular {law} region top
{planes}compute st all stress/atom NULL pair
{closing(size)}""")


def yade(packing, steps, folder):
    """With its automatic Verlet distance, as its manual advises for speed."""
    write(
        folder, "run.py", f"""
import time
from yade import utils
lines = open({packing!r}).read().split(chr(10))
n, size = lines[0].split(); n = int(n); size = float(size)
m = O.materials.append(FrictMat(young=60e9, poisson=0.17, frictionAngle=atan(0.5), density=2650))
for l in lines[1:n + 1]:
    x, y, z, r = map(float, l.split())
    O.bodies.append(utils.sphere((x, y, z), r, material=m))
walls = [O.bodies.append(utils.wall(at, axis=k, sense=s, material=m))
         for k in range(3) for s, at in ((1, 0.), (-1, size))]
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=-0.1,
  targetInterv=-1),
  InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
  [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
  NewtonIntegrator(damping=0)]
O.dt = {DT}
O.bodies[walls[-1]].state.vel = (0, 0, -{RATE} * size)
O.run({WARM}, True)
start = time.monotonic()
if {steps}: O.run({steps}, True)
print('RESULT', time.monotonic() - start)
sum = 0.0
for i in O.interactions:
    if i.isReal and max(i.id1, i.id2) < n:
        sum += (i.phys.normalForce + i.phys.shearForce)[2] * (O.bodies[i.id2].state.pos - O.bodies[i.id1].state.pos)[2]
print('STRESS', sum / size ** 3)
""")


def yade_cell(grains, folder):
    """Packs without friction to 1 MPa, writes the cell, then ten increments as a FEM x DEM run takes them, and rests
    after each."""
    write(
        folder, "run.py", f"""
import os, statistics
from yade import pack, utils
m = O.materials.append(FrictMat(young=60e9, poisson=0.17, frictionAngle=0.0, density=2650))
r = 3e-4; size = ({grains} * 4 / 3. * pi * r ** 3 * 1.25 / 0.30) ** (1 / 3.)
O.periodic = True; O.cell.hSize = Matrix3(size, 0, 0, 0, size, 0, 0, 0, size)
sp = pack.SpherePack()
sp.makeCloud((0, 0, 0), (size, size, size), rMean=r, rRelFuzz=0.5, num={grains}, periodic=True, seed=1)
sp.toSimulation(material=m)
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=-0.1, targetInterv=-1,
  allowBiggerThanPeriod=True),
  InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()],
  [Law2_ScGeom_MindlinPhys_Mindlin()]),
  GlobalStiffnessTimeStepper(timeStepUpdateInterval=10, timestepSafetyCoefficient=0.5,
  defaultDt=.3 * utils.PWaveTimeStep(), maxDt=20 * utils.PWaveTimeStep()),
  PeriTriaxController(dynCell=True, goal=(-1e6,) * 3, stressMask=7, relStressTol=1e-3,
  maxUnbalanced=1e-3, maxStrainRate=(200., 200., 200.),
  doneHook='O.pause()', globUpdate=1,
    mass=0.5 * {grains} * 2650 * 4 / 3. * pi * r ** 3),
  NewtonIntegrator(damping=0.2)]
O.dt = .3 * utils.PWaveTimeStep()
O.run(200000, True)
for b in O.bodies: b.mat.frictionAngle = atan(0.5)
for i in O.interactions: i.phys.tangensOfFrictionAngle = 0.5
O.engines = O.engines[:4] + O.engines[5:]; O.cell.trsf = Matrix3.Identity; O.cell.velGrad = Matrix3.Zero
h = O.cell.hSize
with open('cell.txt', 'w') as f:
    f.write('%d %s\\n' % (len(O.bodies), ' '.join('%.17g' % h[i, j] for i in range(3) for j in range(3))))
    for b in O.bodies: f.write('%.17g %.17g %.17g %.17g\\n' % (*b.state.pos, b.shape.radius))
took, steps = [], []
for k in range(10):
    start = os.times().user; first = O.iter  # its wall time is that of a wait between runs
    O.cell.velGrad = Matrix3(0, 0, 0, 0, 0, 0, 0, 0, -1e-3 / (100 * O.dt))
    height = O.cell.hSize[2, 2]
    while O.cell.hSize[2, 2] > height * (1 - 1e-3): O.run(5, True)
    O.cell.velGrad = Matrix3.Zero
    while True:
        O.run(20, True)
        if utils.unbalancedForce() < 1e-3: break
    took.append(os.times().user - start); steps.append(O.iter - first)
print('RESULT', 1e3 * statistics.median(took))
print('STEPS', statistics.median(steps))
print('STRESS', -utils.getStress()[2, 2])
""")


def superquadrics(along, folder):
    """On a loose lattice, turned at random; six walls press them to 62 % of solid, then the top comes down."""
    axes, step, prepared, size = (3.6e-4, 3e-4, 2.5e-4), 4e-8, 6000, along * 2 * 3.6e-4 * 1.25
    dense = (along ** 3 * 8 * axes[0] * axes[1] * axes[2] * 0.75 / 0.62) ** (1 / 3)
    low, high, law = -0.2 * size, 1.2 * size, "model hertz tangential history surface superquadric"
    draw = random.Random(1)
    text = opening("superquadric",
                   f"region reg block {low} {high} {low} {high} {low} {high} units box\ncreate_box 1 reg", 6e9, law,
                   step)
    places = [(x, y, z) for x in range(along) for y in range(along) for z in range(along)]
    for i, place in enumerate(places):
        x, y, z = ((c + 0.5) * size / along for c in place)
        q = [draw.gauss(0, 1) for _ in range(4)]
        length = math.sqrt(sum(c * c for c in q))
        text += (f"create_atoms 1 single {x} {y} {z}\nset atom {i + 1} shape {axes[0]} {axes[1]} {axes[2]} blockiness "
                 f"3.0 2.0 density 2650 quat {q[0] / length} {q[1] / length} {q[2] / length} {360 * draw.random()}\n")
    names = [f"{axis}{side}" for axis in "xyz" for side in "lh"]
    speed = 0.5 * (size - dense) / (prepared * step)
    for k, name in enumerate(names):
        write(folder, f"{name}.stl", plate(name, 1.2 * size, k // 2, size if k % 2 else 0.0))
        text += f"fix m{name} all mesh/surface/stress file {name}.stl type 1\n"
    text += f"fix w all wall/gran {law} mesh n_meshes 6 meshes {' '.join('m' + n for n in names)}\n"
    for k, name in enumerate(names):
        way = [0.0, 0.0, 0.0]
        way[k // 2] = -speed if k % 2 else speed
        text += f"fix mv{name} all move/mesh mesh m{name} linear {way[0]} {way[1]} {way[2]}\n"
    text += ("fix integ all nve/superquadric integration_scheme 1\nfix visc all viscous 1e-3\nthermo 1000\n"
             f"run {prepared}\n") + "".join(
        f"unfix mv{n}\n" for n in names)
    write(folder, "run.in",
          text + f"run 500\nfix mvt all move/mesh mesh mzh linear 0. 0. {-RATE * dense}\nrun {WARM}\nrun ${{more}}\n")


def bonded_grus(packing, steps, folder):
    """Spheres that are bonded where they are no further apart than a tenth of a radius, by bonds that never break."""
    _, grains = read(packing)
    write(folder, "grains.txt", "".join("%.12g %.12g %.12g %.12g\n" % g for g in grains))
    write(folder, "scene.toml", f"""
[material.rock]
density = 2650
contact = "linear-modulus"
contact_modulus = 40e9
shear_ratio = 0.4
friction = 0.5
bond = {{ modulus = 40e9, shear_ratio = 0.4, tension = 1e20, shear = 1e20, gap = 0.1 }}

[packing]
kind = "file"
path = "grains.txt"

[loading]
kind = "free"
duration = {steps * DT:.9g}
gravity = [0, 0, -9.81]

[output]
history_interval = {steps * DT:.9g}

[numerics]
time_step = {DT}
""")


YADE_BONDS = {
    "JCFpm": ("JCFpmMat(young=40e9, poisson=0.4, density=2650, frictionAngle=0.46, tensileStrength=1e20, "
              "cohesion=1e20)", "Ig2_Sphere_Sphere_ScGeom",
              "Ip2_JCFpmMat_JCFpmMat_JCFpmPhys(cohesiveTresholdIteration=1)",
              "Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM()"),
    "moments": ("CohFrictMat(young=40e9, poisson=0.4, density=2650, frictionAngle=0.46, isCohesive=True, alphaKr=0.25, "
                "alphaKtw=0.25, normalCohesion=1e20, shearCohesion=1e20, momentRotationLaw=True)",
                "Ig2_Sphere_Sphere_ScGeom6D", "Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)",
                "Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=True)")
}


def bonded_yade(packing, steps, folder, law):
    """The same spheres, bonded in the first step by an interaction radius of 1.05."""
    material, geometry, physics, bond = YADE_BONDS[law]
    write(
        folder, "run.py", f"""
import time
from yade import utils
m = O.materials.append({material})
for l in open({packing!r}).read().split(chr(10))[1:]:
    if l.strip():
        x, y, z, r = map(float, l.split())
        O.bodies.append(utils.sphere((x, y, z), r, material=m))
box, near = Bo1_Sphere_Aabb(aabbEnlargeFactor=1.05), {geometry}(interactionDetectionFactor=1.05)
O.engines = [ForceResetter(), InsertionSortCollider([box], verletDist=-0.1),
  InteractionLoop([near], [{physics}], [{bond}]), NewtonIntegrator(damping=0, gravity=(0, 0, -9.81))]
O.dt = {DT}
O.step()
box.aabbEnlargeFactor = near.interactionDetectionFactor = -1
print('BONDS', len([i for i in O.interactions if i.isReal]))
start = time.monotonic()
if {steps}: O.run({steps}, True)
print('RESULT', time.monotonic() - start)
""")
