# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grus from Python: RVEs of breakable grains as the material of your own finite elements, runs of scenes, and their
results.

    import grus

    rves = grus.RveSet("sand_rve.toml", n=512, threads=8)    # one RVE for each Gauss point
    stress, tangent = rves.advance(dF)                       # dF = F_new F_old^-1, (512, 3, 3)
    rves.commit()                                            # the increment has converged

    run = grus.run("shpb_random.toml", set=["loading.final_strain=0.16"])
    run["axial_stress_Pa"], run.summary["status"]
    old = grus.load("results/shpb")
    old.plot(), old.grains(-1).pyvista()

    scene = grus.read_scene("oedometer.toml", packing__seed=7)
    run = grus.run(scene)

    sand = grus.Material(density=2650, youngs_modulus=60e9, friction=0.5, restitution=0.7)    # no scene file
    cell = grus.Sample(sand, grus.RandomPacking(radius=0.2e-3, solid_fraction=0.6), box=[4e-3] * 3, pressure=1e6)
    rves = grus.RveSet(cell, n=512)

SI units; tensors are tension-positive, Voigt order xx yy zz yz xz xy with engineering shear. Scalars with `axial_` or
`pressure` in their name are compression-positive. Errors are one line each: `InputError` (a ValueError) says what to
change, `Unstable` (a RuntimeError) what went wrong and where; what raised one can be used afterwards.
"""
from grus._version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from grus.bands import ShearBand
    from grus.errors import InputError, Unstable
    from grus.frames import Frame
    from grus.results import Results, load
    from grus.runs.run import run
    from grus.runs.scene import Scene, read_scene
    from grus.rves import Rve, RveSet
    from grus.samples import Bond, Grain, Lattice, Material, RandomPacking, Sample, Spheres, Voronoi

__all__ = ["Bond", "Frame", "Grain", "InputError", "Lattice", "Material", "RandomPacking", "Results", "Rve", "RveSet",
           "Sample", "Scene", "ShearBand", "Spheres", "Unstable", "Voronoi", "__version__", "load", "read_scene",
           "run"]

# Each is loaded when it is first asked for: the commands need no compiled core, and nothing that takes a second to
# load.
_HOMES = {"InputError": "errors", "Unstable": "errors", "Results": "results", "load": "results", "run": "runs.run",
          "Scene": "runs.scene", "read_scene": "runs.scene", "Frame": "frames", "ShearBand": "bands", "Rve": "rves",
          "RveSet": "rves"}
_HOMES |= dict.fromkeys(
    ["Bond", "Grain", "Lattice", "Material", "RandomPacking", "Sample", "Spheres", "Voronoi"], "samples")


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'grus' has no attribute {name!r}")
    import importlib
    try:
        globals()[name] = found = getattr(importlib.import_module("grus." + _HOMES[name]), name)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(f"{error}: {_advice(error.name)}", name=error.name) from None
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})


def _advice(missing: str | None) -> str:
    """What to do where a module is not there: another Python than that of the compiled core, or one without NumPy."""
    import os
    import sys
    if missing and not missing.startswith("grus"):
        return f"{sys.executable} has no {missing}: install it there, or take a Python that has it, as /usr/bin/python3"
    files = os.listdir(os.path.dirname(__file__))
    built = ", ".join(f.split(".")[1] for f in files if f.startswith("_core.") and f.endswith(".so"))
    if not built:
        return "RVEs in Python need Debian's python3-grus, or a build where python3-dev and pybind11-dev are there"
    this = f"{sys.executable} is Python {sys.version_info[0]}.{sys.version_info[1]}"
    return f"{this}, Grus is built for {built}: use the Python that it was built with, as a rule /usr/bin/python3"
