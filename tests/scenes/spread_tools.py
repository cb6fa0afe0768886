# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scene of a macro problem that is spread over ranks, and how it is started."""
import glob
import os
import sys

import scene_tools
from scene_tools import need, shipped, without_wall

bvp = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-bvp")
SIDES = "".join(f'[[boundary]]\nname = "{n}"\nwhere = "{w}"\npressure = "100 kPa"\nhistory = "constant"\n'
                for n, w in (("left", "x=min"), ("right", "x=max"), ("front", "y=min"), ("back", "y=max")))
# A block of random cells, which are chaotic: a bit that differs anywhere tells runs apart.
BLOCK = f"""
[mesh]
box = {{ size = ["50 mm", "50 mm", "100 mm"], cells = [2, 2, 3] }}
[element]
kind = "fbar"
[rve]
scene = "{os.path.join(shipped, "sphere_rve.toml")}"
set = ["packing.box=[0.027, 0.027, 0.027]", "numerics.max_overlap=0.3"]
strain_per_step = 1e-5
inertial_number = 2e-3
variants = 2
[[boundary]]
name = "bottom"
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
name = "top"
where = "z=max"
displacement = [0, 0, "-0.3 mm"]
{SIDES}
[[region]]
where = "z<0.02"
material = "j2"
youngs_modulus = "50 MPa"
poissons_ratio = 0.3
density = "2000 kg/m^3"
yield_stress = "80 kPa"
hardening = "1 MPa"
initial_stress = ["-100 kPa", "-100 kPa", "-100 kPa", 0, 0, 0]
[[probe]]
name = "middle"
at = ["25 mm", "25 mm", "50 mm"]
frames = true
grading = true
[[probe]]
name = "upper"
where = "z>0.06"
[solve]
kind = "explicit-quasi-static"
spread = true
crossings = 8
kinetic = 0.1
balance = 0.2
[output]
frames = 3
history_interval = 0.05
costs = true
[regularisation]
length = "20 mm"
"""
whole = sys.argv[2:] == ["whole"]


def command(ranks, scene, out, *settings, more=()):
    launch = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    changes = [a for s in settings for a in ("--set", s)]
    return [*launch, bvp, scene, "-o", out, "--threads", "1", "--quiet", *more, *changes]


def frames(folder):
    names = sorted(glob.glob("*/*.hdf", root_dir=folder) + glob.glob("*.series", root_dir=folder))
    return {name: open(os.path.join(folder, name), "rb").read() for name in names}


def same(name, a, b):
    need(without_wall(a) == without_wall(b), f"{name}: another history.csv")
    one, other = frames(a), frames(b)
    need(len(one) > 6 and one == other, f"{name}: other frames: {[k for k in one if one[k] != other.get(k)]}")
