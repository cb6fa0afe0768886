# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grus from Python: cells of breakable grains as the material of your own finite elements, runs of scenes, and their results.

    import grus

    rves = grus.RveSet("sand_rve.toml", n=512, threads=8)    # one RVE for each Gauss point
    stress, tangent = rves.advance(dF)                       # dF = F_new F_old^-1, (512, 3, 3)
    rves.commit()                                            # the increment has converged

    run = grus.run("shpb_random.toml", set=["loading.final_strain=0.16"])
    run["axial_stress_Pa"], run.summary["status"]
    old = grus.load("results/shpb")

SI units; tensors are tension-positive, Voigt order xx yy zz yz xz xy with engineering shear. Scalars with `axial_` or `pressure` in
their name are compression-positive. Errors are one line each: `InputError` (a ValueError) says what to change, `Unstable` (a
RuntimeError) what went wrong and where; what raised one can be used afterwards.
"""
try:
    from ._core import InputError, Unstable, __version__
    from .results import Results, load, run
    from .rves import Rve, RveSet
except ModuleNotFoundError as error:  # in another Python than that of the module
    import os
    import sys
    files = os.listdir(os.path.dirname(__file__))
    built = ", ".join(f.split(".")[1] for f in files if f.startswith("_core.") and f.endswith(".so"))
    this = f"{sys.executable} is Python {sys.version_info[0]}.{sys.version_info[1]}"
    raise ModuleNotFoundError(f"{error}: {this}, Grus is built for {built}: use the Python that it was built with, "
                              "as a rule /usr/bin/python3", name=error.name) from None

__all__ = ["InputError", "Results", "Rve", "RveSet", "Unstable", "__version__", "load", "run"]
