#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What callers of the Python package do wrong is told in one line, and what they do in another way is read right:
callers.py CASE BUILD, CASE one of arguments, names, types, interrupts, precice"""
import copy
import inspect
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import time

case, build = sys.argv[1], os.path.abspath(sys.argv[2])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import grus  # noqa: E402

from scene_tools import faults, need  # noqa: E402

SAND = os.path.join(source, "apps", "scenes", "sand_rve.toml")
WHOLE = ["material.sand.fracture="]


def refused(words, work, kind=grus.InputError):
    """At once, by one line of one kind of error that says `words`."""
    begin = time.perf_counter()
    try:
        work()
    except Exception as e:
        need(type(e) is kind, f"{type(e).__name__} instead of {kind.__name__}: {e}")
        need(all(w in str(e) for w in ([words] if isinstance(words, str) else words)), f"'{e}' does not say {words}")
        need("\n" not in str(e), f"more than a line: {e}")
        need(time.perf_counter() - begin < 2, f"refused late: {e}")
    else:
        need(False, f"accepted: {words}")


def case_arguments(tmp):
    rves = grus.RveSet(SAND, 4, threads=1, set=WHOLE)
    dF = np.tile(np.eye(3), (4, 1, 1))
    dF[:, 2, 2] -= [1e-3, 2e-3, 3e-3, 4e-3]
    dF[:, 0, 1] = 1e-3
    right, stiff = (a.copy() for a in rves.advance(dF))
    need(len(set(right[:, 2])) == 4 and right[3, 2] < right[0, 2] < 0, f"four points, {right[:, 2]} Pa along z")
    # Every layout that says the same numbers in the same places gives the same bits.
    for name, same in {
            "Fortran order": np.asfortranarray(dF), "with gaps": np.repeat(dF, 2, axis=0)[::2],
            "points by two axes": dF.reshape(2, 2, 3, 3), "a row": dF.reshape(-1), "rows of nine": dF.reshape(4, 9),
            "a list": dF.tolist(), "the other byte order": dF.astype(">f8"),
            "backwards": np.ascontiguousarray(dF[::-1])[::-1], "long double": dF.astype(np.longdouble)
    }.items():
        need((rves.advance(same, tangent=False)[0] == right).all(), f"dF {name} is read as something else")
    for shape in ((4, 6), (24,), (2, 2, 6), (2, 12)):
        room = np.full(shape, 7.0)
        if shape == (2, 12):
            refused(["(2, 12)", "points come first"], lambda: rves.advance(dF, room))
        else:
            rves.advance(dF, room, np.zeros((4, 36) if shape == (24,) else (2, 2, 6, 6)))
            need((room.reshape(4, 6) == right).all(), f"stress in an array of shape {shape}")
    # The other order is refused: nothing is written, nothing read as something else.
    room = np.full((6, 4), 7.0)
    refused(["(6, 4)", "(4, 6)", "points come first"], lambda: rves.advance(dF, room))
    refused("C order", lambda: rves.advance(dF, room.T))
    refused("C order", lambda: rves.advance(dF, np.asfortranarray(np.zeros((4, 6)))))
    refused(["(6, 6, 4)", "(4, 6, 6)"], lambda: rves.advance(dF, None, np.zeros((6, 6, 4))))
    refused("shares memory", lambda: rves.advance(dF, (both := np.zeros(160))[:24], both[:144]))
    refused("C order", lambda: rves.advance(dF, np.frombuffer(bytearray(24 * 8 + 1), np.float64, 24, 1)))
    refused("float64", lambda: rves.advance(dF, np.zeros((4, 6), ">f8")))
    refused("float64", lambda: rves.advance(dF, np.zeros((4, 6), complex)))
    refused("float64", lambda: rves.advance(dF, np.ma.zeros((4, 6))))
    need((room == 7).all(), "a refused buffer was written into")
    refused("(3, 3, 4)", lambda: rves.advance(dF.transpose(1, 2, 0)))
    refused("(9, 4)", lambda: rves.advance(dF.reshape(4, 9).T))
    for value in (np.nan, np.inf, -np.inf):
        bad = dF.copy()
        bad[2, 0, 1] = value
        refused(["point 2", "not a finite"], lambda: rves.advance(bad))
    refused("complex128", lambda: rves.advance(dF.astype(complex)))
    refused("bool", lambda: rves.advance(dF > 0))
    refused("object", lambda: rves.advance(dF.astype(object)))
    refused("different lengths", lambda: rves.advance([[1, 2, 3], [1, 2]]))
    refused("masked", lambda: rves.advance(np.ma.array(dF, mask=dF == 1)))
    # Increments that no cell can follow, at once: the first would take some 10^11 steps.
    big = dF * np.array([1, 1, 1e6, 1])[:, None, None]
    refused(["point 2", "stretches by", "take a smaller one"], lambda: rves.advance(big), grus.Unstable)
    sheared = dF.copy()
    sheared[1, 0, 1] = 1e6
    refused(["point 1", "stretches"], lambda: rves.advance(sheared), grus.Unstable)
    refused(["point 0", "det F = -"], lambda: rves.advance(dF * [[[1], [1], [-1]]]))
    refused(["point 0", "det F = 0"], lambda: rves.advance(dF * [[[1], [1], [0]]]))
    need((rves.advance(dF)[0] == right).all(), "what was refused has left a trace")
    # What is no array.
    rves.commit()
    state = rves.get_state(1)
    rves.set_state(np.int64(2), bytearray(state))
    refused(["state", "str"], lambda: rves.set_state(0, "text"))
    refused(["state", "None"], lambda: rves.set_state(0, None))
    refused(["point", "1.5"], lambda: rves.grains(1.5))
    refused(["point", "True"], lambda: rves.cell(True))
    refused("point -1 of 4", lambda: rves.contacts(-1), IndexError)
    for path, word in {"a\0b": "zero byte", "": "empty"}.items():
        for work in (rves.save, rves.load, grus.load, grus.Rve, grus.run, lambda p: grus.run(SAND, out=p)):
            refused(word, lambda: work(path))
    for work in (rves.save, rves.load, grus.load, grus.Rve, grus.run):
        refused(["expected a path", "int 3"], lambda: work(3))
        refused("expected a path", lambda: work(b"bytes"))
    need(os.listdir(tmp) == [] and not os.path.exists("a"), "a refused path has made a file")
    rves.save(pathlib.Path(tmp, "rves.h5"))
    rves.load(pathlib.Path(tmp, "rves.h5"))
    for comm in (True, 1, "world", object()):
        refused(["comm", "mpi4py"], lambda: grus.RveSet(SAND, comm=comm))
    refused(["n", "2.5"], lambda: grus.RveSet(SAND, 2.5))
    refused(["n", "True"], lambda: grus.RveSet(SAND, True))
    refused("threads = 0", lambda: grus.RveSet(SAND, threads=0))
    refused(["threads", "str"], lambda: grus.RveSet(SAND, threads="2"))
    refused(["threads", "2.0"], lambda: grus.run(SAND, threads=2.0))
    refused("ranks = 0", lambda: grus.run(SAND, ranks=0))
    for wrong in ("a=1", {"a": 1}, ["a"], [1], None, ["a=\0"]):
        refused("KEY=VALUE", lambda: grus.Rve(SAND, set=wrong))
        refused("KEY=VALUE", lambda: grus.run(SAND, set=wrong))
    refused("variant", lambda: grus.RveSet(SAND, 1, variant=[0.5]))
    refused("variant", lambda: grus.RveSet(SAND, 1, variant=[True]))
    refused("window", lambda: grus.Rve(SAND, window=[1]))
    refused("strain_per_step", lambda: grus.Rve(SAND, strain_per_step=float("nan")))
    refused("unknown key", lambda: grus.Rve(SAND, **{"a\nb": 1}))
    stepped = dict(set=WHOLE, strain_per_step=np.float64(2e-5), window=np.int32(40))
    need(grus.Rve(pathlib.Path(SAND), **stepped).advance(dF[0])[0].shape == (6,), "NumPy's numbers and paths")


def case_names(tmp):
    rves = grus.RveSet(SAND, 2, threads=1, set=WHOLE)
    run = grus.run(os.path.join(source, "apps", "scenes", "sand_box.toml"),
                   ["loading.final_strain=0.002", "output.gradings=1"], out=os.path.join(tmp, "out"))
    need(repr(rves) == f"<grus.RveSet of {SAND}: 2 points, 1 RVEs>", repr(rves))
    rve = grus.Rve(SAND, set=WHOLE)
    need(
        repr(rve).startswith(f"<grus.Rve of {SAND}: {rve.facts()['grains']} grains, 0 breakages, void ratio 0."),
        repr(rve))
    rows = len(run["axial_strain"])
    need(repr(run) == f"<grus.Results of {tmp}/out: {rows} rows of {len(run)} columns, finished>", repr(run))
    for name in grus.__all__:
        member = getattr(grus, name)
        if inspect.isclass(member) and not issubclass(member, Exception):
            need(member.__repr__ is not object.__repr__, f"{name} has no __repr__")

    def lacks(words, work):
        try:
            work()
        except KeyError as e:
            need(
                all(w in str(e) for w in words) and "\n" not in str(e) and str(e)[0] != '"',
                f"'{e}' does not say {words}")
        else:
            need(False, f"found: {words}")

    lacks(["history.csv", "did you mean", "'axial_stress_Pa'"], lambda: run["axial_stress"])
    lacks(["did you mean", "'axial_strain'"], lambda: run["Axial_Strain"])
    lacks(["history.csv: no 3"], lambda: run[3])
    lacks(["summary.json", "did you mean 'status'"], lambda: run.summary["statuss"])
    lacks(["summary.json", "did you mean 'final_strain'"], lambda: run.summary["scene"]["loading"]["finalstrain"])
    lacks(["grading.csv: no 0.7; there are"], lambda: run.grading[0.7])
    lacks(["grains", "did you mean 'position'"], lambda: rves.grains(0)["positions"])
    lacks(["contacts", "did you mean 'overlap'"], lambda: rves.contacts(0)["overlaps"])
    lacks(["facts", "did you mean 'void_ratio'"], lambda: rves.facts()["void"])
    lacks(["facts", "did you mean 'breakages'"], lambda: rve.facts()["breakage"])
    lacks(["scene", "did you mean 'material'"], lambda: rves.scene["materials"])
    need("axial" not in run and run.get("axial") is None and dict(rves.facts()).keys() == rves.facts().keys(),
         "is still a mapping")
    again = pickle.loads(pickle.dumps(rves.facts()))
    need((again["grains"] == rves.facts()["grains"]).all() and copy.copy(again).keys() == again.keys(),
         "facts cannot be kept")


def case_types(tmp):
    """Told to type checkers: the mark, and a type of every argument and answer that is public."""
    need(os.path.exists(os.path.join(os.path.dirname(grus.__file__), "py.typed")), "no py.typed")
    from grus import precice
    public = [grus.load, grus.run]
    for cls in (grus.RveSet, grus.Rve, grus.Results, precice.MicroSimulation):
        public += [
            m.fget if isinstance(m, property) else m for name, m in vars(cls).items()
            if (inspect.isfunction(m) or isinstance(m, property)) and (
                not name.startswith("_") or name in ("__init__", "__getitem__"))
        ]
    for f in public:
        told = inspect.signature(f)
        lacking = [
            p.name for p in told.parameters.values() if p.name != "self" and p.annotation is inspect.Parameter.empty
        ]
        lacking += ["its answer"] if told.return_annotation is inspect.Signature.empty else []
        need(lacking == [], f"{f.__qualname__}: no types of {lacking}")
    need(len(public) > 30, f"{len(public)} public functions")
    stub = open(os.path.join(os.path.dirname(grus.__file__), "_core.pyi")).read()
    for cls in (grus._core.Cells, grus._core.Set):
        for name in vars(cls):
            need(name.startswith("_") or f"def {name}(" in stub, f"_core.pyi lacks {cls.__name__}.{name}")
    text = subprocess.run([sys.executable, "-m", "pydoc", "grus.rves", "grus.results", "grus"], capture_output=True,
                          text=True, env={**os.environ, "PYTHONPATH": os.path.join(build, "python")}).stdout
    for word in ("RveSet", "tension-positive", "F_new F_old^-1", "(n, 6, 6)", "Unstable", "summary.json",
                 "--set of grus-rve"):
        need(word in text, f"pydoc does not say {word}")
    for cls in (grus.RveSet, grus.Rve, grus.Results):
        for name, member in vars(cls).items():
            need(
                name.startswith("_") or isinstance(member, (property,)) and member.__doc__
                or getattr(member, "__doc__", None), f"{cls.__name__}.{name} has no docstring")


def case_interrupts(tmp):
    """Ctrl-C stops one long advance of one cell, with one thread and with two, and a preparation; what was there
    stands."""
    program = f"""import sys, time, grus, numpy as np
what, threads = sys.argv[1], int(sys.argv[2])
def told(work):
    print("begin", flush=True)
    begin = time.perf_counter()
    try:
        work(); print("finished")
    except KeyboardInterrupt:
        return time.perf_counter() - begin
if what == "preparation":
    took = told(lambda: grus.Rve({SAND!r}, set=["preparation.unbalanced_force=1e-14",
                                            "preparation.max_hold=100000000"]))
    print("stopped", took < 3)
else:
    rves = grus.RveSet({SAND!r}, 2, threads=threads, set={WHOLE!r})
    dF = np.tile(np.eye(3), (2, 1, 1)); dF[:, 2, 2] -= [1e-3, 2e-3]
    before = rves.advance(dF)[0].copy()
    took = told(lambda: rves.advance(np.array([np.eye(3) * 9.8, np.eye(3) * 9.9])))  # 15 s each
    print("stopped", took < 3, (rves.advance(dF)[0] == before).all())
"""
    for what, threads in (("advance", 1), ("advance", 2), ("preparation", 1)):
        p = subprocess.Popen([sys.executable, "-c", program, what, str(threads)], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True,
                             env={**os.environ, "PYTHONPATH": os.path.join(build, "python")})
        p.stdout.readline()
        time.sleep(0.3)
        p.send_signal(signal.SIGINT)
        try:
            said, errors = p.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            p.kill()
            said, errors = p.communicate()
        right = "stopped True" + (" True" if what == "advance" else "")
        need(said.strip() == right and errors == "", f"Ctrl-C in {what}, {threads} threads: {said!r} {errors[-300:]}")
    program = f"""import os, signal, subprocess, grus
class Slow(subprocess.Popen):
    \"\"\"Ctrl-C comes when the program runs and its caller does not yet know it.\"\"\"
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        print(self.pid)
        os.kill(os.getpid(), signal.SIGINT)
subprocess.Popen = Slow
try:
    grus.run({SAND!r}, set={WHOLE!r} + ["loading.final_strain=0.9"])
except KeyboardInterrupt:
    print("stopped")
"""
    r = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60,
                       env={**os.environ, "PYTHONPATH": os.path.join(build, "python")})
    pid, *said = r.stdout.split() or [""]
    need(said == ["stopped"] and not os.path.exists(f"/proc/{pid}"),
         f"Ctrl-C as a run begins: {r.stdout!r} {r.stderr[-300:]}")


class Manager:
    """The calls of preCICE's Micro Manager (0.4 to 0.8), in their order, with adaptivity over `data` or without."""

    def __init__(self, cls, points, data):
        self.asked = data
        self.data = {name: [0] * points for name in data or ()}
        self.micro_names = [name for name in self.data if not name.startswith("deformation")]
        self.sims = [cls(k) for k in range(points)]
        if len(inspect.getfullargspec(cls.initialize).args) != 1:
            raise Exception("initialize() wants initial data, which preCICE has not given")
        for k, sim in enumerate(self.sims):
            told = sim.initialize()
            if told is None or data is None:
                continue
            if not set(told) <= set(self.data):
                raise Exception(
                    "The initialize() method needs to return data which is required for the adaptivity calculation.")
            for name in self.micro_names:
                self.data[name][k] = told[name]

    def similar(self, tolerance):
        """Which point stands for each: the first one that is near it in all data."""
        stands = []
        for k in range(len(self.sims)):
            near = [j for j in sorted(set(stands))
                    if all(np.abs(np.subtract(v[k], v[j])).max() <= tolerance for v in self.data.values())]
            stands.append(near[0] if near else k)
        return stands

    def window(self, F, iterations):
        rows = [{f"deformation-gradient-{r + 1}": f[r] for r in range(3)} for f in F]
        for name in set(self.data) - set(self.micro_names):
            self.data[name] = [row[name] for row in rows]
        stands = self.similar(1e-9) if self.asked else list(range(len(rows)))
        for k, j in enumerate(stands):
            if self.asked and self.sims[
                    k] is None and j == k:  # woken: a new one, in the state of the one that stood for it
                self.sims[k] = type(self.sims[self.stood[k]])(k)
                self.sims[k].set_state(pickle.loads(pickle.dumps(self.sims[self.stood[k]].get_state())))
            if j != k:
                self.sims[k] = None
        before = [sim and sim.get_state() for sim in self.sims]
        for iteration in range(iterations):
            if iteration:
                for sim, state in zip(self.sims, before):
                    if sim:
                        sim.set_state(state)
            answers = [sim and sim.solve(row, 1.0) for sim, row in zip(self.sims, rows)]
        answers = [dict(answers[j]) for j in stands]
        for name in self.micro_names:
            self.data[name] = [a[name] for a in answers]
        for sim in filter(None, self.sims):
            sim.output(), sim.set_global_id(sim.get_global_id())
        self.stood = stands
        return answers, len(set(stands))


def case_precice(tmp):
    os.environ["GRUS_SCENE"] = SAND
    from grus.precice import MicroSimulation
    F = np.tile(np.eye(3), (3, 1, 1))
    answers, active = {}, {}
    for name, data in {
            "none": None, "macro": ["deformation-gradient-3"], "both": ["deformation-gradient-3", "void-ratio"],
            "stress": ["deformation-gradient-3", "stress-normal", "breakages"]
    }.items():
        manager = Manager(MicroSimulation, 3, data)
        F[:, 2, 2] = 1 - 1e-3
        first, few = manager.window(F, 2)
        F[2, 2, 2] = 1 - 3e-3  # the third leaves the others, with their past
        second, more = manager.window(F, 1)
        answers[name], active[name] = first + second, (few, more)
    need(active["none"] == (3, 3), f"without adaptivity all are solved: {active['none']}")
    need(all(active[name] == (1, 2) for name in ("macro", "both", "stress")), f"one stands for all, then two: {active}")
    rve = grus.Rve(SAND)
    rve.advance(np.diag([1, 1, 1 - 1e-3])), rve.commit()
    right = rve.advance(np.diag([1, 1, (1 - 3e-3) / (1 - 1e-3)]))[0]
    for name, told in answers.items():
        need((told[5]["stress-normal"] == right[:3]).all(),
             f"adaptivity {name}: {told[5]['stress-normal']} Pa, the cell alone {right[:3]}")
        need((told[3]["stress-normal"] == answers["none"][3]["stress-normal"]).all(),
             f"adaptivity {name} changes an answer")
    sim = MicroSimulation(7)
    need(sim.initialize() is None and repr(sim).startswith("<grus.precice.MicroSimulation 7: <grus.Rve of "), repr(sim))
    refused(["deformation-gradient-2", "read_data_names"],
            lambda: sim.solve({"deformation-gradient-1": [1, 0, 0], "deformation-gradient": [0, 1, 0]}, 1.0),
            grus.asked.Lacking)
    refused(["deformation-gradient-1", "(2,)", "3D"],
            lambda: sim.solve({f"deformation-gradient-{r}": [1, 0] for r in (1, 2, 3)}, 1.0))


with tempfile.TemporaryDirectory() as tmp:
    globals()[f"case_{case}"](tmp)
print(f"callers {case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
