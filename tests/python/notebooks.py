#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus in notebooks and environments of its own: results that draw and show themselves, scenes changed by keyword, what
can be pickled, stubs that tell what the core has, a wheel: notebooks.py BUILD"""
import ast
import base64
import copy
import csv
import hashlib
import io
import json
import os
import pickle
import re
import subprocess
import sys
import tempfile
import types
import zipfile

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes"),
                os.path.join(source, "apps", "python")]

import matplotlib  # noqa: E402

matplotlib.use("Agg")
import numpy as np  # noqa: E402

import grus  # noqa: E402
from grus.asked import Lacking  # noqa: E402

import scene_tools  # noqa: E402
import wheel_of_build  # noqa: E402
from scene_tools import faults, need, shipped  # noqa: E402

E = [0.0, 0.1, 0.2]


def refused(words, work, kind=grus.InputError):
    scene_tools.refused(words, work, kind)


def folder_of(tmp, name, **columns):
    folder = os.path.join(tmp, name)
    os.makedirs(folder)
    with open(os.path.join(folder, "history.csv"), "w") as f:
        f.write(",".join(columns) + "\n" + "".join(",".join(map(str, row)) + "\n" for row in zip(*columns.values())))
    with open(os.path.join(folder, "summary.json"), "w") as f:
        json.dump({"status": 0, "title": "a <b>", "ending": "finished", "results": {"peak_axial_stress_Pa": 3e6}}, f)
    return folder


def shown(tmp):
    """Curves and tables of results, value by value; frames are read, or told to be lacking."""
    r = grus.load(folder_of(tmp, "run", time_s=E, axial_strain=E, axial_stress_Pa=[0, 1e6, 3e6],
                            void_ratio=[0.7, 0.6, 0.5]))
    curve = lambda ax: [list(map(float, v)) for v in ax.get_lines()[-1].get_data()] + [ax.get_xlabel(), ax.get_ylabel()]
    ax = r.plot()
    need(curve(ax) == [E, [0, 1, 3], "axial strain (compression)", "stress (MPa)"], f"{curve(ax)}")
    need(ax.get_lines()[0].get_label() == "run", "whose curve")
    again = r.plot("void_ratio", ax=ax, color="k", label="e")
    need(again is ax and curve(ax) == [E, [0.7, 0.6, 0.5], "axial strain (compression)", "void_ratio"]
         and ax.get_lines()[-1].get_color() == "k" and ax.get_lines()[-1].get_label() == "e", f"{curve(ax)}")
    need(curve(r.plot("axial_strain", "time_s"))[2:] == ["time_s", "axial_strain"], "a column over another")
    refused("did you mean 'void_ratio'?", lambda: r.plot("void_ratoi"), Lacking)
    text = r._repr_html_()
    need("a &lt;b&gt;" in text and "<td>3e+06</td>" in text and "<summary>4 columns</summary>" in text, text)
    points = re.search(r'polyline points="(.*?)"', text)[1]
    need(points == "50.0,140.0 170.0,100.0 290.0,20.0", f"a curve of 0, 1/3 and 1 of its height: {points}")
    need(">0.2</text>" in text and ">3</text>" in text, "its ends")
    one = grus.load(folder_of(tmp, "one", time_s=[0], axial_strain=[0], axial_stress_Pa=[0]))
    need("<svg" not in one._repr_html_(), "a curve of one point")
    refused("output.frames", r.grains), refused("output.contacts", lambda: r.contacts(0)), refused("no frames", r.macro)
    gone = copy.copy(one)
    gone.folder = os.path.join(tmp, "nowhere")
    refused("out=", gone.grains)
    for thing in (r, grus.Material(density=2650, youngs_modulus=60e9),
                  grus.read_scene(os.path.join(shipped, "sand_box.toml"), packing__seed=3)):
        back = pickle.loads(pickle.dumps(thing))
        need(type(back) is type(thing) and repr(back) == repr(thing), f"{thing!r} comes back as {back!r}")
    back = pickle.loads(pickle.dumps(r))
    need(back.summary["results"]["peak_axial_stress_Pa"] == 3e6 and (back["void_ratio"] == r["void_ratio"]).all()
         and back._repr_html_() == text, "results that were pickled")
    for error in (Lacking("w", "x", ["y"]), grus.InputError("a"), grus.Unstable("b")):
        back = pickle.loads(pickle.dumps(error))
        need(type(back) is type(error) and str(back) == str(error), f"{error!r} comes back as {back!r}")


def for_others(tmp):
    """What pyvista and meshio are given, by modules in their place."""
    import h5py
    folder = folder_of(tmp, "frames", time_s=E, axial_strain=E, axial_stress_Pa=E)
    os.makedirs(os.path.join(folder, "grains"))
    with h5py.File(os.path.join(folder, "grains", "grains_00000.hdf"), "w") as f:
        grid = f.create_group("VTKHDF")
        grid["Points"] = np.arange(15.0).reshape(5, 3)
        grid["Connectivity"], grid["Offsets"] = [0, 1, 2, 3, 4, 1, 2, 3], [0, 3, 5, 8]
        grid["Types"] = np.array([5, 3, 5], "u1")
        grid["CellData/id"], grid["PointData/u"] = [1.0, -1.0, 2.0], np.ones((5, 3))
    frame = grus.load(folder).grains(-1)
    given = []

    class Grid(dict):
        def __init__(self, *arguments, **more):
            given.append((arguments, more))
            self.cell_data, self.point_data = {}, {}
    sys.modules["pyvista"] = types.SimpleNamespace(UnstructuredGrid=Grid)
    sys.modules["meshio"] = types.SimpleNamespace(Mesh=Grid)
    grid = frame.pyvista()
    joined, kinds, points = given.pop()[0]
    need(list(joined) == [3, 0, 1, 2, 2, 3, 4, 3, 1, 2, 3] and list(kinds) == [5, 3, 5] and points.shape == (5, 3)
         and list(grid.cell_data["id"]) == [1, -1, 2] and grid.point_data["u"].shape == (5, 3), f"pyvista: {joined}")
    frame.meshio()
    (points, blocks), data = given.pop()
    need([(kind, corners.tolist()) for kind, corners in blocks] ==
         [("line", [[3, 4]]), ("triangle", [[0, 1, 2], [1, 2, 3]])], f"meshio: {blocks}")
    need([v.tolist() for v in data["cell_data"]["id"]] == [[-1], [1, 2]] and "u" in data["point_data"], f"{data}")


def scenes(tmp):
    """Scenes with changes: what is read is what runs."""
    path = os.path.join(shipped, "sand_box.toml")
    scene = grus.read_scene(path, {"output.frames": 2}, loading__final_strain=0.001, packing__box=["3 mm"] * 3,
                            material__sand__fracture=None, packing__seed=np.int64(5))
    need(scene.changes == ("output.frames=2", "loading.final_strain=0.001", 'packing.box=["3 mm", "3 mm", "3 mm"]',
                           "material.sand.fracture=", "packing.seed=5"), f"{scene.changes}")
    need(scene["packing"]["seed"] == 5 and scene["packing"]["box"] == ["3 mm"] * 3 and scene["output"]["frames"] == 2
         and "fracture" not in scene["material"]["sand"] and scene.program == "grus-rve", "its tables")
    more = scene.with_(packing__seed=6)
    seeds = more["packing"]["seed"], scene["packing"]["seed"], more["output"]["frames"]
    need(seeds == (6, 5, 2) and repr(scene).startswith("<grus.Scene of "), "a scene that is changed is another")
    need("axial_stress_Pa" in scene.columns(), "its columns")
    run = grus.run(scene, ["loading.final_strain=0.0005"], out=os.path.join(tmp, "ran"), threads=1)
    told = run.summary["scene"]
    need(told["packing"]["seed"] == 5 and told["packing"]["box"] == [0.003] * 3 and told["loading"]["final_strain"] ==
         0.0005 and "fracture" not in told["material"]["sand"], f"what ran: {told['packing']}")
    need(abs(run.grains().time - 1e-6) < 1e-12 and len(run.grains().grains()["id"]) == run["grains"][-1], "its grains")
    refused(["sand_box.toml", "packing.sed"], grus.read_scene(path, packing__sed=1).columns)
    refused("did you mean 'packing'?", lambda: scene["packin"], Lacking)
    refused("no such scene file", lambda: grus.read_scene("nowhere.toml"))
    refused("expected a number", lambda: grus.read_scene(path, packing__seed=object()))


def stubs():
    """The stub of the core names what it has, and no more."""
    from grus import _core
    with open(os.path.join(build, "python", "grus", "_core.pyi")) as f:
        tree = ast.parse(f.read())
    told = {n.name: {m.name for m in n.body if isinstance(m, ast.FunctionDef)} if isinstance(n, ast.ClassDef) else None
            for n in tree.body if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
    own = lambda thing: {n for n in vars(thing) if not n.startswith("_") or n in ("__init__", "__len__")}
    has = {n: own(v) if isinstance(v, type) else None for n, v in vars(_core).items() if not n.startswith("_")}
    need(told == has, f"stub and core: {set(told) ^ set(has)} "
         f"{[(n, told[n] ^ has[n]) for n in told if n in has and told[n] != has[n] and told[n]]}")
    need(os.path.exists(os.path.join(build, "python", "grus", "py.typed")), "no py.typed")


def wheels(tmp):
    """The wheel of this build: whole by its own record; its grus runs by itself, with its program; pip installs it."""
    made = wheel_of_build.build_wheel(tmp, {"build-dir": build})
    with zipfile.ZipFile(os.path.join(tmp, made)) as z:
        record = list(csv.reader(io.StringIO(z.read(f"grus-{grus.__version__}.dist-info/RECORD").decode())))
        need({r[0] for r in record} == set(z.namelist()), "what the record names")
        for name, told, size in record:
            if told:
                found = base64.urlsafe_b64encode(hashlib.sha256(z.read(name)).digest()).rstrip(b"=").decode()
                need(told == f"sha256={found}" and int(size) == len(z.read(name)), f"{name} is not as recorded")
        names = set(z.namelist())
        need({"grus/__init__.py", "grus/py.typed", "grus/_core.pyi", "grus/watch/page.html", "grus/files/plots.js",
              f"grus-{grus.__version__}.data/scripts/grus-rve"} <= names and
             any(re.fullmatch(r"grus/_core\..*\.so", n) for n in names), f"{sorted(names)[:9]}")
        need(not any("__pycache__" in n for n in names), "compiled modules")
        before = wheel_of_build.prepare_metadata_for_build_wheel(tmp)
        for file in ("METADATA", "WHEEL", "entry_points.txt"):
            with open(os.path.join(tmp, before, file), "rb") as f:
                need(f.read() == z.read(f"{before}/{file}"), f"{file} is told before otherwise")
        told = z.read(f"{before}/METADATA").decode()
        need(f"\nVersion: {grus.__version__}\n" in told and "\nRequires-Dist: numpy\n" in told, "what it needs")
    try:
        wheel_of_build.build_wheel(tmp, {"build-dir": tmp})
        need(False, "a build that is none")
    except SystemExit as e:
        need("no grus-rve" in str(e), str(e))
    if subprocess.run(["/usr/bin/python3", "-m", "pip", "--version"], capture_output=True).returncode:
        print("notebooks: pip is not here: the wheel is not installed")
        return
    place = os.path.join(tmp, "env")
    call = lambda *words: subprocess.run(words, cwd=tmp, capture_output=True, text=True,
                                         env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"})
    call("/usr/bin/python3", "-m", "venv", "--system-site-packages", "--without-pip", place)
    python = os.path.join(place, "bin", "python")
    r = call(python, "-m", "pip", "install", "--no-index", "--no-deps", os.path.join(tmp, made))
    need(r.returncode == 0, r.stderr[-300:])
    r = call(python, "-c", "import grus; from grus.runs.programs import found; print(grus.__file__, found('grus-rve'), "
             "grus.Rve.__name__)")
    need([w.startswith(place) for w in r.stdout.split()] == [True, True, False], f"{r.stdout} {r.stderr[-300:]}")
    need(call(os.path.join(place, "bin", "grus"), "--version").stdout == f"grus {grus.__version__}\n", "its command")
    need(call(os.path.join(place, "bin", "grus-report"), "--version").stdout == f"grus-report {grus.__version__}\n",
         "grus-report")


stubs()
for part in (shown, scenes, wheels, for_others):
    with tempfile.TemporaryDirectory() as place_:
        part(place_)
print(f"notebooks: {len(faults)} faults")
sys.exit(bool(faults))
