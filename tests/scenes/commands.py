#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command grus: who does what is asked, what it says, what shells complete, what it exports: commands.py BIN"""
import csv
import io
import json
import os
import pty
import re
import resource
import select
import shutil
import struct
import subprocess
import sys
import tempfile

import numpy as np

import scene_tools
from scene_tools import faults, need

binaries = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(binaries, "..", "python"))
from grus.commands import command, completion, words  # noqa: E402
from grus.errors import InputError  # noqa: E402
from grus.export import command as export, formats  # noqa: E402
from grus.files.folders import of_a_run  # noqa: E402
from grus.frames import Frame, frame, frames  # noqa: E402
from grus.study.kinds import KINDS  # noqa: E402

import made_up  # noqa: E402

FEM = os.path.exists(os.path.join(binaries, "grus-bvp"))


def become(folder):
    """Who is called for what, with which words."""
    asked, kept = [], (command.become, command.module, command.found)

    def note(*what):
        asked.append(what)
        raise SystemExit(7)
    command.become, command.found = note, lambda name: name
    command.module = lambda name, arguments: note("module", name, *arguments)
    text = {"sand": "[packing]\nkind = 'hcp'\n", "block": "[mesh]\nfile = 'a.msh'\n", "many": "[[sweep]]\nname = 'a'\n",
            "fit": "[calibrate]\nbudget = 3\n", "bad": "[[["}
    path = {name: os.path.join(folder, name + ".toml") for name in text}
    for name, words_ in text.items():
        with open(path[name], "w") as f:
            f.write(words_)
    sand, block = path["sand"], path["block"]
    for given, wanted in (
            (["run", sand, "-o", "x"], ("grus-rve", sand, "-o", "x")),
            (["run", "-o", block, "--set", block, sand], ("grus-rve", "-o", block, "--set", block, sand)),
            (["run", "--quiet", block], ("grus-bvp", "--quiet", block)),
            (["run", "--ranks", "3", block, "--resume"], ("mpirun", "-n", "3", "grus-bvp", block, "--resume")),
            (["run", block, "--ranks=2"], ("mpirun", "-n", "2", "grus-bvp", block)),
            (["run", "--ranks", "1", sand], ("grus-rve", sand)), (["run", path["bad"]], ("grus-rve", path["bad"])),
            (["run", "--help"], ("grus-rve", "--help")), (["run"], ("grus-rve",)),
            (["check", block, "--threads", "2"], ("grus-bvp", block, "--threads", "2", "--check")),
            (["check", path["many"]], ("module", "study", path["many"], "--check")),
            (["check", path["fit"]], ("module", "calibrate", path["fit"], "--check")),
            (["new", "triaxial", "a.toml"], ("grus-rve", "--new", "triaxial", "a.toml")),
            (["new", "pile"], ("grus-bvp", "--new", "pile")),
            (["keys", "--macro", "mesh"], ("grus-bvp", "--keys", "mesh")),
            (["report", "a", "b"], ("module", "report", "a", "b")), (["watch", "a"], ("module", "watch", "a")),
            (["help", "study"], ("module", "study", "--help"))):
        asked.clear()
        try:
            command.work(given)
        except SystemExit as e:
            need(e.code == 7 and asked == [wanted], f"{given[:2]}: {asked}")
        else:
            need(False, f"{given}: nobody was asked")
    for given, text_ in ((["run", path["many"]], f"has many runs: grus study {path['many']}"),
                         (["run", path["fit"]], "has many runs: grus calibrate"), (["rum"], "did you mean 'run'?"),
                         (["run", "--ranks", "2", sand], "has no [mesh]"), (["run", "--ranks"], "--ranks : expected"),
                         (["run", "--ranks", "0", block], "--ranks 0: expected"), ([sand], f"grus run {sand}"),
                         (["keys", "a", "b"], "expected [TEXT]"),
                         (["new", "foo"], ["no scene of the kind 'foo'", "triaxial", "pile", "block-dolfinx"])):
        scene_tools.refused(text_, lambda: command.work(given), InputError)
    command.become, command.module, command.found = kept
    need({k.NAME for k in KINDS} <= set(words.STUDIES), "a kind of table by which no study is known")


def told():
    """What the command says; what the programs' help says is what is completed."""
    call = lambda *given, **more: subprocess.run([os.path.join(binaries, given[0]), *given[1:]], capture_output=True,
                                                 text=True, env={**os.environ, **more})
    r = call("grus", "--help")
    need(r.returncode == 0 and all(f"\n  {name} {w.given}" in r.stdout for name, w in words.WORDS.items()), r.stdout)
    need(max(map(len, r.stdout.splitlines())) <= 116, "lines of the help that no terminal has room for")
    need(call("grus").returncode == 2 and re.fullmatch(r"grus [0-9.]+\n", call("grus", "--version").stdout),
         "without a word; a version")
    r = call("grus", "rum")
    need((r.returncode, r.stderr) == (2, "grus: no command 'rum' (did you mean 'run'?); grus --help lists them\n"),
         r.stderr)
    r = call("grus", "keys", "rolling_friction")
    need(r.stdout == call("grus-rve", "--keys", "rolling_friction").stdout != "", "keys of a sample")
    if FEM:
        need("regularisation.length" in call("grus", "keys", "regularisation.length").stdout, "keys of a macro problem")
        r = call("/bin/bash", "-c", f"{binaries}/grus keys --macro | head -1")
        need(r.stdout.count("\n") == 1 and r.stderr == "", f"output that nobody reads to its end: {r.stderr[:300]}")
    for name, options in completion.PROGRAMS.items():
        if name == "grus-bvp" and not FEM:
            continue
        r = call(name, "--help")
        shown = set(re.findall(r"(?<![\w\"-])(--[a-z][a-z-]*|-o)\b", r.stdout.partition("\nSIG")[0]))
        shown -= {"--jobs"}  # another name of --threads
        need(shown == set(options), f"{name} has, or is completed with, {sorted(shown ^ set(options))}")
        if "--new" in options:
            kinds = re.search(r"--new KIND:{(.*?)}", r.stdout)[1].split(",")
            expected = words.KINDS if name == "grus-rve" else words.PROBLEMS
            need(set(kinds) == set(expected), f"{name}: kinds of new scenes: {kinds}")
    for word in ("watch", "export"):
        shown = set(re.findall(r"(?<![\w\"-])(--[a-z]+|-o)\b", call("grus", word, "--help").stdout)) - {"--version"}
        need(shown == set(words.WORDS[word].options), f"grus {word}: {shown}")


def completed(folder):
    """bash completes words, options, files, keys and kinds; zsh reads its script where it is installed."""
    script = os.path.join(folder, "bash")
    with open(script, "w") as f:
        f.write(completion.script("bash"))
    with open(os.path.join(binaries, "..", "completion", "grus.bash")) as f:
        need(f.read() == completion.script("bash"), "the build's script is another")
    for name in ("one.toml", "two.csv"):
        open(os.path.join(folder, name), "w").close()
    os.makedirs(os.path.join(folder, "results"))
    cases = {"grus ru": "run", "grus new shp": "shpb", "grus run --ran": "--ranks", "grus run o": "one.toml",
             "grus report r": "results", "grus report two": "", "grus run x --set material.*.dens": "",
             "grus run x --set packing.laye": "packing.layers=", "grus-rve --new bo": "bonded",
             "grus export results --what c": "contacts", "grus study --stri": "--strict",
             "grus-report -": "-o --force --help "
             "--version", "grus run --threads o": "", "/usr/bin/grus wat": "watch"}
    lines = ["compopt() { :; }", f"source {script}"]
    for line in cases:
        given = line.split(" ")
        quoted = " ".join(f"'{w}'" for w in given)
        lines.append(f"COMP_WORDS=({quoted}); COMP_CWORD={len(given) - 1}; _grus; echo \"${{COMPREPLY[*]}}\"")
    r = subprocess.run(["bash", "-c", "\n".join(lines)], capture_output=True, text=True, cwd=folder,
                       env={**os.environ, "PATH": binaries + os.pathsep + os.environ["PATH"]})
    found = r.stdout.split("\n")[:-1]
    need(r.stderr == "" and len(found) == len(cases), f"bash: {r.stderr}")
    for (line, wanted), got in zip(cases.items(), found):
        need(got == wanted, f"'{line}' is completed by '{got}', not '{wanted}'")
    zsh = completion.script("zsh")
    need(all(f"'{name}:" in zsh for name in words.WORDS) and zsh.startswith("#compdef grus grus-rve "), "words of zsh")
    if shutil.which("zsh") is None:
        print("commands: zsh is not here: its script is looked at, not tried")
    else:
        typed(folder, zsh)


def typed(folder, script):
    """What zsh makes of words and a tab, at a terminal. A folder's name is asked for where there is none: it then
    offers files, as it does for all commands."""
    with open(os.path.join(folder, "rc"), "w") as f:
        f.write(f"autoload -U compinit; compinit -u -D; unsetopt automenu autolist beep; PS1=\n{script}\n"
                "told() { print -r -- \"<<$BUFFER>>\"; BUFFER= }; zle -N told; bindkey '^X' told\nprint READY\n")
    cases = {"grus ru": "grus run ", "grus new shp": "grus new shpb ", "grus run --ran": "grus run --ranks ",
             "grus run o": "grus run one.toml ", "grus report r": "grus report results/",
             "grus run x --set packing.laye": "grus run x --set packing.layers=",
             "grus-rve --new bo": "grus-rve --new bonded ", "/usr/bin/grus wat": "/usr/bin/grus watch ",
             "grus export results --what c": "grus export results --what contacts ",
             "grus run --threads o": "grus run --threads o", "grus run -o r": "grus run -o results/"}
    process, terminal = pty.fork()
    if process == 0:
        os.chdir(folder)
        path = binaries + os.pathsep + os.environ["PATH"]
        os.execvpe("zsh", ["zsh", "-f", "-i"], {**os.environ, "TERM": "dumb", "PATH": path})

    def until(pattern, said=""):
        while not re.search(pattern, said) and select.select([terminal], [], [], 20)[0]:
            said += os.read(terminal, 4096).decode()
        return re.findall(pattern, said)

    os.write(terminal, b"source ./rc\n")
    until("READY\r")
    for line, wanted in cases.items():
        os.write(terminal, f"{line}\t\x18".encode())
        got = until("<<(.*)>>")
        need(got == [wanted], f"zsh completes '{line}' by {got}, not '{wanted}'")
    os.write(terminal, b"exit\n")
    os.close(terminal)
    os.waitpid(process, 0)


def tetrahedra(folder):
    """A frame of two tetrahedra, the second three times as large and far off, and a line."""
    import h5py
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    os.makedirs(os.path.join(folder, "grains"))
    for k in range(2):
        with h5py.File(os.path.join(folder, "grains", f"grains_0000{k}.hdf"), "w") as f:
            grid = f.create_group("VTKHDF")
            grid["Points"] = np.concatenate([corners + k, 3 * corners + 100, [[0, 0, 0], [9, 0, 0]]]).astype("f4")
            grid["Connectivity"] = np.concatenate([faces.ravel(), faces.ravel() + 4, [8, 9]])
            grid["Offsets"] = np.array([*range(0, 25, 3), 26])
            grid["Types"] = np.array([5] * 8 + [3], "u1")
            grid["CellData/id"] = np.array([7] * 4 + [2] * 4 + [-1], "f4")
            grid["CellData/radius"] = np.array([0.5] * 4 + [1.5] * 4 + [np.nan], "f4")
            grid["CellData/velocity"] = np.array([[1, 2, 3]] * 4 + [[4, 5, 6]] * 4 + [[0, 0, 0]], "f4")
    with open(os.path.join(folder, "grains.hdf.series"), "w") as f:
        json.dump({"files": [{"name": f"grains/grains_0000{k}.hdf", "time": 0.25 * k} for k in range(2)]}, f)
    with open(os.path.join(folder, "history.csv"), "w") as f:
        f.write("time_s,axial_strain,grains\n0,0,2\n0.25,0.125,\n")


def with_box(folder):
    """Spheres are written from the corner of the box on that is drawn around them, with its lengths."""
    found = frame(folder, "grains", 0)
    need(found.box() is None, "one line is no box")
    low, edges, first = np.array([-2, 1, 3.0]), np.diag([4, 5, 6.0]), len(found.points)
    corners = [np.array([k & 1, k >> 1 & 1, k >> 2]) for k in range(8)]
    pairs = [(k, k | bit) for k in range(8) for bit in (1, 2, 4) if not k & bit]
    found.connectivity = np.concatenate([found.connectivity[:-2], first + np.ravel(pairs)])
    found.offsets = np.concatenate([found.offsets[:-1], found.offsets[-2] + 2 * np.arange(1, 13)])
    found.types = np.array([5] * 8 + [3] * 12)
    for lean, boxed in ((0, True), (0.5, False)):
        edges[0, 1] = lean
        points = found.points[:first] if lean == 0 else found.points[:first].copy()
        found.points = np.concatenate([points, [low + edges.T @ c for c in corners]])
        need((found.box() is not None) == boxed, f"a box that leans by {lean}")
        lines = formats.spheres(found).decode().splitlines()
        need((lines[1] == "#box 4 5 6") == boxed, f"lines of a box that leans by {lean}: {lines[:2]}")
        made_up.near([float(v) for v in lines[-1].split()[:3]], np.array([0.25] * 3) - (low if boxed else 0), "a place")


def exported(folder):
    """Frames and histories, number by number, in each format."""
    tetrahedra(folder)
    need([t for _, t in frames(folder, "grains")] == [0, 0.25] and np.isnan(Frame(frames(folder, "grains")[0][0]).time),
         "times of frames")
    last = frame(folder, "grains")
    need(last.path.endswith("00001.hdf") and frame(folder, "grains", 0).points[0, 0] == 0 and last.time == 0.25 and
         frame(folder, "grains", -2).points[0, 0] == 0, "which frame")
    for number in (2, -3):
        scene_tools.refused(["no frame", "there are 2"], lambda: frame(folder, "grains", number), InputError)
    for number in (0.5, "a"):
        scene_tools.refused("whole numbers", lambda: frame(folder, "grains", number), InputError)
    scene_tools.refused("output.contacts", lambda: frame(folder, "contacts"), InputError)
    grains = last.grains()
    made_up.near([grains["volume_m3"], grains["id"], grains["radius"]], [27 / 6, 1 / 6, 2, 7, 1.5, 0.5], "tetrahedra")
    made_up.near(grains["position_m"], [[100.75] * 3, [1.25] * 3], "their centres")
    made_up.near(grains["velocity"], [[4, 5, 6], [1, 2, 3]], "their velocities")
    out = lambda *given: made_up.command(export.main, folder, "-o", *given)
    place = lambda name: os.path.join(folder, name)
    read = lambda name: open(place(name), "rb").read()
    need(out(place("h.csv"))[0] == 0 and read("h.csv") == b"time_s,axial_strain,grains\n0,0,2\n0.25,0.125,\n", "a copy")
    status, said, errors = out(place("h.csv"))
    need(status == 2 and errors == f"grus export: {place('h.csv')}: is there already; use another -o FILE, or --force\n"
         and read("h.csv").startswith(b"time_s,"), f"an export over another file: {errors}")
    need([out(place("h.csv"), "--force", *more)[1].split(": ")[1]
          for more in ((), ("--what", "grains"), ("--what", "grains", "--frame", "0"))] ==
         ["history\n", "grains of the last frame\n", "grains of frame 0\n"], "what was written")
    out(place("c.csv"), "--columns", "grains, time_s")
    before = read("history.csv")
    with open(place(".grus"), "w") as f:
        f.write("grains/grains_*.hdf\nnotes.csv\nreport.html\n")
    for name in ("history.csv", "notes.csv", ".grus"):
        target = place(name)
        need(of_a_run(target), f"{name} is a run's")
        if name != ".grus":
            need("is a file of a run" in out(target, "--force")[2], f"an export over {name}")
    need(of_a_run(place("grains/grains_00001.hdf")) and not of_a_run(place("report.html")) and
         not of_a_run(place("summary.csv")) and read("history.csv") == before, "files of a run")
    os.remove(place(".grus"))
    need(read("c.csv") == b"grains,time_s\n2,0\n,0.25\n", f"columns asked for: {read('c.csv')}")
    out(place("h.json"))
    need(json.loads(read("h.json")) == {"time_s": [0, 0.25], "axial_strain": [0, 0.125], "grains": [2, None]}, "JSON")
    out(place("h.npz"))
    made_up.near(np.load(place("h.npz"))["axial_strain"], [0, 0.125], "npz")
    out(place("h.mat"))
    from scipy.io import loadmat
    made_up.near(loadmat(place("h.mat"))["grus"]["axial_strain"][0, 0], [0, 0.125], "mat")
    out(place("g.csv"), "--what", "grains")
    rows = list(csv.DictReader(io.StringIO(read("g.csv").decode())))
    need([r["id"] for r in rows] == ["2", "7"] and rows[1]["velocity_y"] == "2" and rows[0]["position_m_z"] == "100.75",
         f"grains: {rows}")
    out(place("g.stl"), "--frame", "0")
    data = read("g.stl")
    need(len(data) == 84 + 8 * 50 and struct.unpack("<I", data[80:84]) == (8,), "triangles of STL")
    made_up.near(struct.unpack("<12f", data[84 + 100:84 + 148]), [3 ** -0.5] * 3 + [1e3, 0, 0, 0, 1e3, 0, 0, 0, 1e3],
                 "the third: its normal outward, millimetres", 1e-6)
    need("no line #box" in out(place("g.txt"), "--frame", "0")[1], "what a frame without a box lacks")
    lines = read("g.txt").decode().splitlines()
    need(lines[0].startswith("#") and len(lines) == 3, f"spheres: {lines}")
    made_up.near([[float(v) for v in line.split()] for line in lines[1:]],
                 np.column_stack([frame(folder, "grains", 0).grains()[k] for k in ("position_m", "radius")]), "spheres")
    with_box(folder)
    need("#box" not in out(place("g.obj"))[1], "a note of spheres alone")
    told_, corners, volumes = read("g.obj").decode().split("\n"), [], {}
    for line in told_:
        kind, *words_ = line.split() or [""]
        if kind == "o":
            volumes[words_[0]] = 0
        elif kind == "v":
            corners.append([float(v) for v in words_])
        elif kind == "f":
            a, b, c = (np.array(corners[int(v) - 1]) - 100 for v in words_)
            volumes[list(volumes)[-1]] += a @ np.cross(b, c) / 6
    need(list(volumes) == ["grain2", "grain7"] and len(corners) == 8, f"objects: {volumes} of {len(corners)} corners")
    made_up.near(list(volumes.values()), grains["volume_m3"], "their volumes")
    out(place("g.vtu"))
    text = read("g.vtu").decode()
    need('NumberOfPoints="10" NumberOfCells="9"' in text, "sizes of VTK's XML")
    import base64
    found = {m[2]: np.frombuffer(base64.b64decode(m[4])[8:], {"Float32": "<f4", "Int64": "<i8", "UInt8": "u1"}[m[1]])
             for m in re.finditer(r'type="(\w+)" Name="(\w+)"( NumberOfComponents="3")? format="binary">(.*?)<', text)}
    made_up.near(found["Points"], last.points, "points"), made_up.near(found["offsets"], last.offsets[1:], "offsets")
    made_up.near(found["connectivity"], last.connectivity, "corners"), made_up.near(found["types"], last.types, "kinds")
    made_up.near(found["velocity"], last.cells["velocity"], "fields")
    need(set(found) == {"Points", "connectivity", "offsets", "types", "id", "radius", "velocity"}, f"{set(found)}")
    for given, text_ in (([place("x.xyz")], "ends with none of .csv"), ([place("x.csv"), "--columns", "tyme_s"],
                                                                        "did you mean 'time_s'?"),
                         ([place("x.csv"), "--what", "macro"], "no frames of macro"),
                         ([place("x.txt"), "--what", "macro"], "no frames of macro"),
                         ([place("x.vtu"), "--what", "history"], "name frames with --what"),
                         ([place("x.csv"), "--frame", "1"], "--frame: a history has no frames"),
                         ([place("x.csv"), "--columns", " ,"], "--columns: names no column"),
                         ([place("x.csv"), "--columns", "radius", "--what", "grains"], "--columns: is of the history"),
                         ([place("no/x.csv")], "No such file"), ([place("x.stl"), "--frame", "5"], "there are 2")):
        status, said, errors = out(*given)
        need(status == 2 and text_ in errors and errors.count("\n") == 1 and said == "", f"{given}: {status} {errors}")
    most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, most[1]))  # as a disk that is full
    status, said, errors = out(place("x.csv"))
    resource.setrlimit(resource.RLIMIT_FSIZE, most)
    need((status, errors) == (2, f"grus export: {place('x.csv')}: File too large\n"), f"no room: {errors}")
    need(not [n for n in os.listdir(folder) if n.startswith("x.")], "what is refused is written")
    need({*formats.TABLES, *formats.FRAMES} == set(re.findall(r"\.\w+", words.WORDS["export"].about)) |
         {".json"}, "endings that the help names")


for part in (become, completed, exported):
    with tempfile.TemporaryDirectory() as place_:
        part(place_)
told()
print(f"commands: {len(faults)} faults")
sys.exit(bool(faults))
