#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Dense Hertz-Mindlin spheres in a box, the top wall coming down at 500/s: Grus, LIGGGHTS and Yade on the same packing, the
same time step, one after the other, several times; medians.   peers.py GRUS_BENCH [results.csv] [repeats]
Peers that are not installed are left out (Debian: liggghts, yade). One core each."""
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

bench, out, repeats = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None, int(sys.argv[3]) if len(sys.argv) > 3 else 3
SIZES = {1000: 4000, 10000: 1000, 50000: 200}
WARM, DT, RATE = 100, 2e-8, 500.0


def cpu(command, folder):
    """User seconds of a command, and what it printed."""
    before = os.times().children_user
    r = subprocess.run(["taskset", "-c", "0"] + command, cwd=folder, capture_output=True, text=True, timeout=1800, env=dict(os.environ, OMP_NUM_THREADS="1"))
    if r.returncode:
        sys.exit(f"{command[0]}: exit {r.returncode}: {r.stderr[-500:]}{r.stdout[-500:]}")
    return os.times().children_user - before, r.stdout


def read(packing):
    lines = open(packing).read().split("\n")
    n, size = lines[0].split()
    return float(size), [tuple(map(float, x.split())) for x in lines[1:int(n) + 1]]


def grus(packing, steps, folder):
    text = subprocess.run(["taskset", "-c", "0", bench, "--packing", packing, str(steps)], capture_output=True, text=True, check=True).stdout
    return float(re.search(r"psps=(\S+)", text).group(1))


def liggghts(packing, steps, folder):
    """Two whole runs, with and without the steps: set-up drops out."""
    size, grains = read(packing)
    low, high, a, b = -0.1 * size, 1.1 * size, -0.05 * size, 1.05 * size
    with open(os.path.join(folder, "data.in"), "w") as f:
        f.write(f"packing\n\n{len(grains)} atoms\n1 atom types\n\n{low} {high} xlo xhi\n{low} {high} ylo yhi\n{low} {high} zlo zhi\n\nAtoms\n\n")
        f.writelines(f"{i + 1} 1 {2 * r} 2650 {x} {y} {z}\n" for i, (x, y, z, r) in enumerate(grains))
    with open(os.path.join(folder, "top.stl"), "w") as f:
        f.write("solid top\n")
        for corners in (((a, a), (b, a), (b, b)), ((a, a), (b, b), (a, b))):
            f.write(" facet normal 0 0 1\n  outer loop\n" + "".join(f"   vertex {x} {y} {size}\n" for x, y in corners) + "  endloop\n endfacet\n")
        f.write("endsolid top\n")
    wall = "model hertz tangential history"
    planes = "".join(f"fix p{k} all wall/gran {wall} primitive type 1 {n} {at}\n"
                     for k, (n, at) in enumerate((("xplane", 0), ("xplane", size), ("yplane", 0), ("yplane", size), ("zplane", 0))))
    with open(os.path.join(folder, "run.in"), "w") as f:
        f.write(f"""atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
hard_particles yes
read_data data.in
neighbor 1e-4 bin
neigh_modify delay 0 every 1 check yes
fix m1 all property/global youngsModulus peratomtype 60e9
fix m2 all property/global poissonsRatio peratomtype 0.17
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.5
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style gran model hertz tangential history
pair_coeff * *
timestep {DT}
fix top all mesh/surface/stress file top.stl type 1
fix w all wall/gran {wall} mesh n_meshes 1 meshes top
fix mv all move/mesh mesh top linear 0. 0. {-RATE * size}
{planes}fix integ all nve/sphere
thermo 1000000
thermo_modify lost error norm no
run {WARM}
run ${{more}}
""")
    took = [cpu(["liggghts", "-in", "run.in", "-var", "more", str(s)], folder)[0] for s in (0, steps)]
    return len(grains) * steps / (took[1] - took[0])


def yade(packing, steps, folder):
    """Tuned: its automatic Verlet distance, as its manual advises for speed."""
    script = os.path.join(folder, "run.py")
    with open(script, "w") as f:
        f.write(f"""
import os
from yade import utils
lines = open({packing!r}).read().split(chr(10))
n, size = lines[0].split(); n = int(n); size = float(size)
m = O.materials.append(FrictMat(young=60e9, poisson=0.17, frictionAngle=atan(0.5), density=2650))
for l in lines[1:n + 1]:
    x, y, z, r = map(float, l.split())
    O.bodies.append(utils.sphere((x, y, z), r, material=m))
walls = [O.bodies.append(utils.wall(at, axis=k, sense=s, material=m)) for k in range(3) for s, at in ((1, 0.), (-1, size))]
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=-0.1, targetInterv=-1),
  InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
  NewtonIntegrator(damping=0)]
O.dt = {DT}
O.bodies[walls[-1]].state.vel = (0, 0, -{RATE} * size)
O.run({WARM}, True)
start = os.times().user
O.run({steps}, True)
print('RESULT', n * {steps} / (os.times().user - start))
""")
    return float(re.search(r"RESULT (\S+)", cpu(["yade", "-n", "-x", "-j1", script], folder)[1]).group(1))


codes = [("Grus", grus)] + [(name, f) for name, f in (("LIGGGHTS", liggghts), ("Yade", yade)) if shutil.which(f.__name__)]
lines = ["work;figure;who"]
with tempfile.TemporaryDirectory() as folder:
    for grains, steps in SIZES.items():
        packing = os.path.join(folder, f"packing_{grains}.txt")
        subprocess.run([bench, "--make-packing", str(grains), packing], check=True)
        speed = {name: [] for name, _ in codes}
        for _ in range(repeats):
            for name, f in codes:
                speed[name].append(f(packing, steps, folder) / 1e6)
        for name, _ in codes:
            median = statistics.median(speed[name])
            ratio = statistics.median(speed["Grus"]) / median
            print(f"dense spheres {grains}: {name:<9} {median:7.3f} million grain-steps/s   ({min(speed[name]):.3f} to {max(speed[name]):.3f})   Grus is {ratio:.1f} x", flush=True)
            if name != "Grus":
                lines.append(f"dense spheres {grains}, 1 thread;{median:.4g};{name}")
if out:
    open(out, "w").write("\n".join(lines) + "\n")
