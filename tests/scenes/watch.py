#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus watch: what it reads of runs that go on, what it tells of them and to whom, and when it ends: watch.py BIN"""
import fcntl
import http.client
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

import made_up
from made_up import near
from scene_tools import faults, need

binaries = os.path.abspath(sys.argv[1])
sys.path[:0] = [os.path.join(binaries, "..", "python"), os.path.join(os.path.dirname(__file__), "..", "tools")]
import browser  # noqa: E402
from grus import curves  # noqa: E402
from grus.watch import command, processes, progress  # noqa: E402
from grus.watch.following import Following, planned  # noqa: E402
from grus.watch.growing import Growing  # noqa: E402
from grus.watch.server import POLICY, Server  # noqa: E402

# Stands in for grus-rve: holds the lock of its folder, and writes a row for each line that it is given.
WRITER = r'''#!/usr/bin/python3 -SE
import fcntl, os, sys
out = sys.argv[sys.argv.index("-o") + 1]
os.makedirs(out, exist_ok=True)
mark = open(os.path.join(out, ".grus"), "w")
fcntl.flock(mark, fcntl.LOCK_EX)
print("at work", flush=True)
for line in sys.stdin:
    with open(os.path.join(out, "history.csv"), "a") as f:
        f.write(line)
    print("written", flush=True)
with open(os.path.join(out, "summary.json"), "w") as f:
    f.write('{"status": 0}')
'''


def histories(folder):
    """What has come is read once; half a line waits; a table in the place of another is read anew."""
    path = os.path.join(folder, "history.csv")
    table = Growing(path)
    need(not table.look() and len(table) == 0, "no table yet")

    def write(text, how="a"):
        with open(path, how) as f:
            f.write(text)
        return table.look()
    need(write("a,b\n1,2\n3,") and table.columns == {"a": [1], "b": [2]}, f"half a line: {table.columns}")
    need(not table.look(), "nothing new")
    need(write("4\n5,nan\n6,\n7\n") and len(table) == 4 and table.columns["a"] == [1, 3, 5, 6]
         and table.columns["b"][1] == 4 and all(map(math.isnan, table.columns["b"][2:])), f"more: {table.columns}")
    need(write("a,c\n9,8\n", "w") and table.columns == {"a": [9], "c": [8]}, f"a shorter one: {table.columns}")
    with open(path + ".new", "w") as f:
        f.write("d,e\n0,0\n1,1\n2,2\n")
    os.replace(path + ".new", path)  # as the programs do
    need(table.look() and table.columns == {"d": [0, 1, 2], "e": [0, 1, 2]}, f"another: {table.columns}")
    os.remove(path)
    need(table.look() and len(table) == 0 and not table.look(), "a table that has gone")


def locks(folder):
    """Who holds the lock is seen without taking it."""
    path = os.path.join(folder, ".grus")
    need(processes.locked_by(path) is None, "no marker")
    with open(path, "w") as mark, open(path + "2", "w"):
        need(processes.locked_by(path) is None, "nobody holds it")
        fcntl.flock(mark, fcntl.LOCK_EX)
        need(processes.locked_by(path) == os.getpid() and processes.locked_by(path + "2") is None, "who holds it")
        told = os.path.join(folder, "locks")
        inode = os.stat(path).st_ino
        with open(told, "w") as f:  # another device, as of folders laid over others: the holder's files tell
            f.write(f"1: POSIX  ADVISORY  WRITE 1 00:01:{inode} 0 EOF\n"
                    f"1: -> FLOCK ADVISORY WRITE 2 00:01:{inode} 0 EOF\n"
                    f"2: FLOCK  ADVISORY  WRITE {os.getpid()} 00:01:{inode} 0 EOF\n")
        need(processes.locked_by(path, told) == os.getpid(), "a folder over another")
        me = processes.writer(folder)
        need(me.number == os.getpid() and me.folder == os.getcwd() and "watch.py" in " ".join(me.words)
             and 0 <= me.since < 600, f"{me}")
        with open(path) as other:
            try:
                fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
                need(False, "the lock was lost")
            except BlockingIOError:
                pass
    need(processes.locked_by(path) is None, "let go of")


def parts(folder):
    """How far runs are: by strain, time, stress or load factor, as --set has it."""
    row = {"time_s": [0.0, 0.2], "axial_strain": [0.0, -0.06], "axial_stress_Pa": [0.0, 5e6]}
    loading = lambda **keys: progress.done_of({"loading": keys}, row)
    near([loading(final_strain=0.1), loading(duration="800 ms"), loading(final_stress="20 MPa"),
          loading(final_strain=0.1, duration=0.25), loading(final_strain=0.01)], [0.6, 0.25, 0.25, 0.8, 1], "parts")
    need([loading(), loading(duration="soon"), progress.done_of({}, row), progress.done_of({"loading": {}}, {})] ==
         [None] * 4, "what no scene tells")
    macro = lambda **solve: progress.done_of({"mesh": {}, "solve": solve}, {"time_s": [0.0, 0.25]})
    near([macro(), macro(kind="explicit-dynamic", duration="1 s"), macro(kind="quasi-static", duration=9)],
         [0.25, 0.25, 0.25], "of macro problems")
    need([progress.left_of(*of) for of in ((0.25, 30), (None, 1), (0, 1))] == [90, None, None], "what is left")
    with open(os.path.join(folder, "a.toml"), "w") as f:
        f.write("[loading]\nfinal_strain = 0.1\n")
    words = ["mpirun", "/x/grus-bvp", "--set", "loading.duration=1 s", "-o", "b.toml", "a.toml", "--set", "mesh.n=[1]"]
    found = progress.scene_of(processes.Process(1, words, folder, 0))
    need(found == {"loading": {"final_strain": 0.1, "duration": "1 s"}, "mesh": {"n": [1]}}, f"a scene: {found}")
    need(progress.scene_of(processes.Process(1, ["grus-rve", "no.toml"], folder, 0)) == {}, "no scene")


def drawn():
    """Curves in the units of their axes; errors without sign; thinned with the last point."""
    e = [0.0, 0.1, 0.2]
    c = {"time_s": e, "axial_strain": e, "axial_stress_Pa": [0, 1e6, 3e6], "void_ratio": [0.7, 0.6, math.nan],
         "work_J": [0, 1, 2], "kinetic_J": [0, 0, 0], "breakages": [0, 1, 4], "grains": [5, 5, 5],
         "energy_error": [0.0, -1e-3, 2e-3], "bonds_broken": [0, 0, 0]}
    load, = curves.of_loads([("r", c, {}), ("none", {}, {})])
    need(load["series"] == [{"label": "r", "x": e, "y": [0, 1, 3]}] and load["y"] == "stress (MPa)", f"{load}")
    plots = {p["title"]: {s["label"]: (s["x"], s["y"]) for s in p["series"]} for p in curves.of_run(c)}
    need(plots == {"Void ratio": {"void ratio": (e[:2], [0.7, 0.6])}, "Energy": {"work": (e, [0, 1, 2])},
                   "Counts": {"breakages": (e, [0, 1, 4])},
                   "How far to trust it": {"energy error": (e[1:], [1e-3, 2e-3])}}, f"{plots}")
    disc = {**c, "nominal_stress_Pa": [0, 2e6, 1e6], "displacement_m": [0, 1e-3, 2e-3]}
    need(curves.load(disc, {})[:2] == ([0, 1, 2], [0, 2, 1]), "a load over a way")
    macro = {"increment": [0, 1], "time_s": [0, 1], "newton_iterations": [0, 3], "moved_top_z_m": [0, -1e-3],
             "reaction_top_z_N": [0, -5.0], "moved_side_x_m": [0, 1e-3], "reaction_side_x_N": [0, 1.0],
             **{f"mean_{q}_{k}{u}": [0, v] for k, v in (("xx", 0.0), ("yy", 0.0), ("zz", -2e6))
                for q, u in (("stress", "_Pa"), ("strain", ""))}}
    pushes = curves.load(macro, {})
    need(pushes == ([0, 1], [0, 5], "displacement of top, z (mm)", "reaction (N)"), f"what pushes: {pushes}")
    # A side that the scene moves goes before one that pushes harder; of two of them the one that goes farther.
    for side in ({"name": "side"}, {"where": "si de"}, {"tag": "side"}):
        scene = {"boundary": [{"tag": "top", "pressure": "5 Pa"}, {**side, "displacement": ["1 mm", "free"]}]}
        moves = curves.load(macro, scene)
        need(moves == ([0, 1], [0, 1], "displacement of side, x (mm)", "reaction (N)"), f"what {side} moves: {moves}")
    held = {"boundary": [{"name": "side", "displacement": [0, "free"]},
                         {"where": "t.op", "displacement": ["free", "free", -1e-3]}]}
    need(curves.load(macro, held) == pushes, "a side that is held does not move")
    need(curves.name_of({"tag": 7}) == curves.name_of({"tag": [7, 8]}) == "tag7", "tags that are numbers")
    need(curves.along(macro)[1] == "mean strain zz (compression)", "along the load")
    many = curves.thinned(range(1001), range(1001))
    need(len(many["x"]) == 334 and many["x"][-1] == 1000 and many["x"][1] - many["x"][0] == 3, "thinned")


def asked(server, path="/data", host=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=10)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    return answer.status, answer.read(), answer.headers


def served(folder):
    """This machine alone is answered, by the names that it has for itself; the page asks for nothing else."""
    with Server(0) as server:
        server.begin()
        need(server.socket.getsockname()[0] == "127.0.0.1", "bound to more than this machine")
        try:
            socket.create_connection(("127.0.0.2", server.server_address[1]), 2).close()
            need(False, "another address of this machine is answered")
        except OSError:
            pass
        status, page, headers = asked(server, "/")
        text = page.decode()
        need(status == 200 and headers["Content-Security-Policy"] == POLICY and "default-src 'none'" in POLICY,
             "what the page may load")
        links = set(re.findall(r"https?://[^\"'\s)]+", text)) | set(re.findall(r"(?:src|href)=\"([^\"]*)\"", text))
        need(links == {"http://www.w3.org/2000/svg", "data:,"}, f"the page asks for {links}")
        need("/*plots.js*/" not in text and "const grusPlots" in text, "its script")
        need([asked(server, "/data", h)[0] for h in ("evil.org:80", "127.0.0.1.evil.org:80", "localhost:80")] ==
             [403, 403, 200], "pages of other names")
        need([asked(server, p)[0] for p in ("/etc/passwd", "/../x", "/data/x")] == [404] * 3, "other files")
        server.data = {"over": True}
        need(not server.told_over and asked(server)[1] == b'{"over": true}', "data")
        time.sleep(0.05)
        need(server.told_over, "a page that has heard of the end")
        server.shutdown()


def shown(address):
    """The page in a browser: what it draws; nothing in the console, no wider than a phone."""
    if not browser.found():
        return print("watch: chromium is not here: the page is not opened")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        b = browser.Browser(profile)
        try:
            b.width(390, phone=True)
            b.open(address)
            until = time.monotonic() + 20
            while "<polyline" not in (dom := b.ask("document.body.innerHTML")) and time.monotonic() < until:
                time.sleep(0.1)
            need("<polyline" in dom and ">stress (MPa)<" in dom and ">running<" in dom and 'value="0.25"' in dom,
                 f"the page: {dom[-900:]}")
            wide = b.ask("document.documentElement.scrollWidth")
            need(wide <= 390, f"the page is {wide} pixels wide on a phone of 390")
            strange = [url for url in b.requests if not url.startswith((address, "data:", "about:blank"))]
            need(b.errors == [] and strange == [], f"the page's console: {b.errors}; it asks for {strange}")
        finally:
            b.close()


def followed(folder):
    """A run from before it begins to its end, and a study's runs side by side; the page ends with it."""
    programs, out = os.path.join(folder, "bin"), os.path.join(folder, "out")
    os.makedirs(programs)
    rve = os.path.join(programs, "grus-rve")
    with open(rve, "w") as f:
        f.write(WRITER)
    os.chmod(rve, 0o755)
    with open(os.path.join(folder, "s.toml"), "w") as f:
        f.write("[loading]\nfinal_strain = 0.1\n")
    following = Following([out])

    def now():
        following.look()
        return following.told()
    need(now()["runs"][0]["state"] == "waiting" and not following.over(), "before it begins")
    start = lambda at: subprocess.Popen([rve, "s.toml", "-o", at, "--set", "loading.final_strain=0.2"], cwd=folder,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def add(run, line):
        run.stdin.write(line)
        run.stdin.flush()
        run.stdout.readline()
    run = start(out)
    run.stdout.readline()
    told = now()
    need(told["runs"][0]["state"] == "preparing" and told["plots"] == [] and not told["over"], f"{told}")
    add(run, "time_s,axial_strain,axial_stress_Pa,grains\n"), add(run, "0,0,0,5\n"), add(run, "1,0.05,2e6,6\n")
    told = now()
    r = told["runs"][0]
    need((r["state"], r["done"], r["rows"], r["last"]["grains"]) == ("running", 0.25, 2, 6) and r["left"] > 0, f"{r}")
    near(r["left"], 3 * r["since"], "what is left at this pace")
    need(told["plots"][0]["series"] == [{"label": "out", "x": [0, 0.05], "y": [0, 2]}], f"{told['plots']}")
    # The command: refuses what does not run, tells the page, ends with the run.
    idle = os.path.join(folder, "idle")
    os.makedirs(idle)
    with open(os.path.join(idle, "history.csv"), "w") as f:
        f.write("time_s\n0\n")
    status, _, errors = made_up.command(command.main, idle)
    need(status == 2 and "nothing runs there" in errors and errors.count("\n") == 1, f"{status} {errors}")
    status, _, errors = made_up.command(command.main, os.path.join(folder, "s.toml"))
    need(status == 2 and "is a file" in errors, f"{status} {errors}")
    watch = subprocess.Popen([os.path.join(binaries, "grus"), "watch", out], stdout=subprocess.PIPE,
                             stderr=subprocess.DEVNULL, text=True)
    address = re.match(r"http://127.0.0.1:(\d+)/", watch.stdout.readline())

    def page_asks():
        connection = http.client.HTTPConnection("127.0.0.1", int(address[1]), timeout=10)
        connection.request("GET", "/data")
        return json.load(connection.getresponse())
    need(page_asks()["runs"][0]["rows"] == 2, "what the page is told")
    shown(address[0])
    add(run, "2,0.1,3e6,7\n")
    run.stdin.close()
    run.wait()
    ended = time.monotonic()
    while watch.poll() is None and time.monotonic() < ended + 15:
        try:
            over = page_asks()["over"]
        except (OSError, http.client.HTTPException):  # it ends, perhaps in the midst of an answer
            break
        time.sleep(0.1)
    if watch.poll() is None and time.monotonic() >= ended + 15:
        watch.kill()
    need(over and watch.wait() == 0 and watch.stdout.read() == "out: finished\n", "it ends with the run")
    told = now()
    need(told["over"] and told["runs"][0]["state"] == "finished" and told["runs"][0]["rows"] == 3, f"{told['runs']}")
    # A study: its runs side by side, those that are done counted.
    study = os.path.join(folder, "study")
    for k in range(3):
        place = os.path.join(study, "runs", f"case@{k}")
        os.makedirs(place)
        with open(os.path.join(place, "history.csv"), "w") as f:
            f.write(f"time_s,axial_strain,axial_stress_Pa\n0,0,0\n1,0.1,{k}e6\n")
        if k:
            open(os.path.join(place, "study.key"), "w").close()
    following.__init__([study])
    told = now()
    need([(s["done"], s["of"], s["running"]) for s in told["studies"]] == [(2, 0, False)] and len(told["plots"]) == 1
         and [s["y"][-1] for s in told["plots"][0]["series"]] == [0, 1, 2], f"a study: {told['studies']}")
    need([r["name"] for r in told["runs"]] == ["case@0", "case@1", "case@2"], "its runs")
    with open(os.path.join(folder, "many.toml"), "w") as f:
        f.write("[study]\nscene = 's.toml'\nseeds = [1, 2]\n[[case]]\nname = 'a'\n"
                "[[case]]\nname = 'b'\nseeds = [1, 2, 3]\n")
    of = lambda *words: planned(processes.Process(1, ["python3", *words], folder, 0))
    need([of("/x/grus", "study", "-o", "out", "many.toml"), of("/x/grus-study", "many.toml"),
          of("grus-study", "s.toml")] == [5, 5, 0], "how many runs it will have")
    for sent in (signal.SIGINT,):
        watch = subprocess.Popen([os.path.join(binaries, "grus"), "watch", study, "--stay"], stdout=subprocess.PIPE,
                                 text=True)
        watch.stdout.readline()
        watch.send_signal(sent)
        need(watch.wait(10) == 130, "Ctrl-C")


drawn()
for part in (histories, locks, parts, served, followed):
    with tempfile.TemporaryDirectory() as place_:
        part(place_)
print(f"watch: {len(faults)} faults")
sys.exit(bool(faults))
