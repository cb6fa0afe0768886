#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a set of RVEs may leave out, in Python: adaptivity.py BUILD"""
import os
import sys
import tempfile

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import grus  # noqa: E402

from scene_tools import faults, need  # noqa: E402

SAND = os.path.join(source, "apps", "scenes", "sand_rve.toml")
WHOLE = ["material.sand.fracture="]
# Cells closer to rest than the errors that are looked for.
REST = {"unbalanced_force": 1e-4, "stress_change": 1e-4}


def increments(*strains):
    """Uniaxial compression along z."""
    dF = np.tile(np.eye(3), (len(strains), 1, 1))
    dF[:, 2, 2] -= strains
    return dF


def refused(words, work):
    try:
        work()
    except grus.InputError as e:
        need(all(w in str(e) for w in words) and "\n" not in str(e), f"'{e}' does not say {words}")
    else:
        need(False, f"accepted: {words}")


def pair(n, **adaptivity):
    """The same cells with and without it."""
    return (grus.RveSet(SAND, n, threads=1, set=WHOLE, adaptivity=adaptivity, **REST),
            grus.RveSet(SAND, n, threads=1, set=WHOLE, **REST))


def apart(less, plain, *strains):
    """Largest difference of two sets' stresses after an increment, relative to the stress, as reports measure it."""
    size = np.array([1, 1, 1, 2, 2, 2]) ** 0.5
    a, b = less.advance(increments(*strains))[0] * size, plain.advance(increments(*strains))[0] * size
    less.commit(), plain.commit()
    return (np.linalg.norm(a - b, axis=1) / np.linalg.norm(b, axis=1)).max()


# Off: the same bits and no device in the report.
off, plain = pair(3)
need(apart(off, plain, 1e-3, 2e-3, 1e-3) == 0, "with everything off other bits")
told = off.report()
need(told["asked"] == 3 and told["advanced"] == told["distinct"] == 2 and told["dem_steps"] > 100, f"report {told}")
need(told["errors"] == {}, f"errors of nothing: {told['errors']}")
every = grus.RveSet(SAND, 3, threads=1, set=WHOLE, exact_sharing=False, **REST)
need((every.advance(increments(1e-3, 2e-3, 1e-3))[0] == grus.RveSet(SAND, 3, threads=1, set=WHOLE, **REST).advance(
    increments(1e-3, 2e-3, 1e-3))[0]).all() and every.distinct == 3, "exact sharing changes bits, or is not off")

# Similar points: one RVE, until they part; the error is then what the plain set says it was.
shared, plain = pair(2, share=1e-3)
wrong = apart(shared, plain, 2e-3, 2.5e-3)
need(shared.distinct == 1 and plain.distinct == 2 and wrong > 0, f"{shared.distinct} RVEs, off by {wrong}")
unknown = shared.report()["errors"]["sharing"]
need(unknown["measured_at_replays"] == 0 and unknown["worst"] is unknown["mean"] is None, f"never measured: {unknown}")
refused(["similar sharing", "save"], lambda: shared.get_state(0))
apart(shared, plain, 1e-3, 4e-3)
told = shared.report()
errors = told["errors"]["sharing"]
need(told["similar"] == 1 and told["replayed"] == errors["measured_at_replays"] == 1, f"report {told}")
need(shared.distinct == 2, f"{shared.distinct} RVEs of points that have parted")
need(errors["tolerance_strain"] == 1e-3 and errors["largest_correction"] > wrong, f"sharing {errors}")
need(abs(errors["worst"] / wrong - 1) < 1e-6, f"an error of {errors['worst']} is told, it was {wrong}")

# Put off, and linear: less DEM; off by no more than what is told, and by what equilibrium leaves of two cells.
for device, tolerance, count, key in (("error", 0.2, "deferred", "deferral"), ("elastic", 0.1, "elastic", "elastic")):
    less, plain = pair(1, **{device: tolerance})
    apart(less, plain, 1e-3)
    wrong = max(apart(less, plain, 1e-4) for _ in range(8))
    state = less.get_state(0)
    apart(less, plain, 2e-3)  # the grains go to their place: measured
    told = less.report()
    errors = told["errors"][key]
    need(told[count] >= 4 and told["dem_steps"] < plain.report()["dem_steps"], f"{device}: {told}")
    need(errors["measured"] > 0 and 0 < errors["mean"] <= errors["worst"], f"{device}: {errors}")
    need(0 < wrong < errors["worst"] + 2e-3, f"{device}: off by {wrong}, told {errors['worst']}")
    ahead = less.advance(increments(1e-3))[0]
    again = grus.RveSet(SAND, 1, threads=1, set=WHOLE, adaptivity={device: tolerance}, **REST)
    again.set_state(0, state)
    again.advance(increments(2e-3)), again.commit()
    need((again.advance(increments(1e-3))[0] == ahead).all(), f"{device}: from its state it goes on otherwise")
    steps = f"{told['dem_steps']} of {plain.report()['dem_steps']} steps"
    print(f"{device}: off by {wrong:.2g}, told {errors['worst']:.2g}, {steps}")

# One file; a set that leaves out otherwise does not take it.
both = [grus.RveSet(SAND, 3, threads=1, set=WHOLE, adaptivity={"share": 1e-3, "error": 0.2}) for _ in range(2)]
both[0].advance(increments(2e-3, 2.5e-3, 1e-2)), both[0].commit()
both[0].advance(increments(1e-4, 1e-4, 1e-4)), both[0].commit()
with tempfile.TemporaryDirectory() as tmp:
    path = os.path.join(tmp, "both.h5")
    both[0].save(path), both[1].load(path)
    a, b = (rves.advance(increments(1e-4, 5e-3, 1e-3))[0] for rves in both)
    need((a == b).all() and both[0].report() == both[1].report(), "a set goes on otherwise after load")
    refused(["other settings"], lambda: grus.RveSet(SAND, 3, threads=1, set=WHOLE).load(path))
refused(["needs exact_sharing"], lambda: grus.Rve(SAND, exact_sharing=False, adaptivity={"share": 1e-3}))
refused(["adaptivity.error"], lambda: grus.Rve(SAND, adaptivity={"error": 2}))
refused(["adaptivity.err"], lambda: grus.Rve(SAND, adaptivity={"err": 0.1}))
refused(["adaptivity.error", "list"], lambda: grus.Rve(SAND, adaptivity={"error": [0.1]}))
refused(["adaptivity"], lambda: grus.Rve(SAND, adaptivity=0.1))
need(grus.Rve(SAND, set=WHOLE).report()["asked"] == 0, "an RVE has no report")
print(f"package adaptivity: {len(faults)} faults")
sys.exit(1 if faults else 0)
