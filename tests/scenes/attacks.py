#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What users trip over and what breaks under attack: attacks.py inputs|folders|signals BIN"""
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

from attack_tools import (BALL, FREE, MATERIAL, UNIAXIAL, box, bvp, calibrate, grus, interrupted, limited, refused,
                          report, rve, study)
from scene_tools import column, faults, history, need, run, shipped, summary, write

case = sys.argv[1]


def inputs(tmp):
    """Numbers, units and words that cannot be meant."""
    r = run(rve, write(tmp, BALL + FREE + MATERIAL.replace("sand", "spare")), "--check")
    said = "note: material.spare: no grain and no wall is of it" in r.stdout and "material.sand:" not in r.stdout
    need(r.returncode == 0 and said, f"a material of nothing: {r.stdout!r} {r.stderr!r}")
    refused(tmp, BALL.replace('"60 GPa"', '"0x10 GPa"') + FREE, "youngs_modulus")
    refused(tmp, BALL.replace('"1 mm"', "1e308", 1) + FREE, "grain[0].radius", "out of all bounds")
    refused(tmp, box(loading=UNIAXIAL.replace("500.0", "2e-9")), "steps", "out of all bounds")
    refused(tmp, BALL + FREE.replace('"free"', '"uniaxial"'), 'did you mean "uniaxial-strain"')
    refused(tmp, BALL.replace('"1 mm"', '"1 mm\\n2"', 1) + FREE, "radius")
    refused(tmp, BALL + FREE, "not one of 1 entries", arguments=("--set", "grain.99999999999999999999.radius=1"))
    for absent, near in (("material.sand.fractur=", "did you mean 'fracture'"), ("material.snad=", "'snad'"),
                         ("loading.gravit=", "did you mean 'gravity'")):
        refused(tmp, BALL + FREE, "to leave out", near, arguments=("--set", absent))
    need(
        run(rve, write(tmp, BALL + FREE), "--check", "--set", "packing=", "--set",
            "material.sand.rolling_friction=").returncode == 0, "what is not there, and might be, is left out")
    refused(
        tmp, MATERIAL +
        "[packing]\nkind = \"hcp\"\nradius = { distribution = \"uniform\", min = 1e-4, max = 2e-4 }\n"
        "layers = [3, 3, 3]\n[boundary]\nkind = \"walls\"\n"
        + UNIAXIAL, "packing.radius", "lattice")
    refused(
        tmp, MATERIAL +
        "[packing]\nkind = \"simple-cubic\"\nradius = { distribution = \"constant\", mean = 1e-4 }\n"
        "layers = [30000, 30000, 30000]\n[boundary]\nkind = \"walls\"\n"
        + UNIAXIAL, "packing.layers", "five million")
    # Dashpots so strong that a servo swung about the pressure for ever: the sample comes to rest.
    hulls = os.path.join(shipped, "zhu2019", "oedometer_60.toml")
    r = run(rve, hulls, "--check", "--threads", "1", "--set", "material.sand.restitution=0.012", timeout=100)
    need(r.returncode == 0 and "begins the test at" in r.stdout, f"a restitution of 0.012: {r.returncode} {r.stderr!r}")
    refused(tmp, box(fraction=0.7), "scene.toml:11:18: packing.solid_fraction", "densest random packing")
    tension = ("[material.sand.fracture]\nmodel = \"polyellipsoid-split\"\n"
               "contact_tension = { strength = \"300 MPa\" }\n")
    refused(tmp, (MATERIAL + "contact = \"linear\"\nnormal_stiffness = 1e6\n" + tension) + BALL[len(MATERIAL):] + FREE,
            "contact_tension", "linear")
    refused(
        tmp,
        BALL + "".join(f"[[wall]]\npoint = [0, 0, {-1 - k}]\nnormal = [0, 0, 1]\nrigid = true\nfriction = {k / 1000}\n"
                       for k in range(300)) + FREE, "wall[", "materials")
    packing = write(tmp, "0 0 0 secret-word\n", "pack.txt")
    r = run(
        rve,
        write(
            tmp, MATERIAL +
            f"[packing]\nkind = \"file\"\npath = \"{packing}\"\nbox = [1, 1, 1]\n[boundary]\nkind = \"walls\"\n" +
            UNIAXIAL), "-o", os.path.join(tmp, "no"))
    need(r.returncode == 2 and "packing.path" in r.stderr and "pack.txt:1" in r.stderr and "secret" not in r.stderr,
         f"packing file: {r.stderr!r}")
    # Spheres that lie in one another, also through the period, and out of the box: limits of the physics say so too
    # late.
    for kind, rows, said in (("periodic", "0 2 2 .5\n4 2 2 .5", "line 1, or an image of it, overlap by 2 of"),
                             ("periodic", "1 1 1 .5\n5 1 1 .5", "an image of it"),
                             ("periodic", "3.9 3.9 3.9 .5\n2 2 2 .3\n0 0.1 0 .4", "line 1, or an image of it, overlap"),
                             ("walls", "1 1 1 .5\n1 1 1.2 .1", "line 1 overlap by 4 of the smaller radius"),
                             ("walls", ".1 1 1 .5\n2 2 2 .5", "sticks out")):
        write(tmp, "".join(" ".join(f"{float(v)}e-3" for v in row.split()) + "\n" for row in rows.split("\n")),
              "pack.txt")
        scene = write(
            tmp, MATERIAL +
            "[packing]\nkind = \"file\"\npath = \"pack.txt\"\nbox = [4e-3, 4e-3, 4e-3]\n[boundary]\n"
            f"kind = \"{kind}\"\n"
            + UNIAXIAL)
        r = run(rve, scene, "--check")
        need(r.returncode == 2 and "pack.txt:" in r.stderr and said in r.stderr and r.stderr.count("\n") == 1,
             f"{kind} {rows!r}: exit {r.returncode} {r.stderr!r}")
    # Many walls that are alike are one material: the last of 300 still bounces a grain as the first does.
    below = "".join(f"[[wall]]\npoint = [0, 0, {-5 - k / 100}]\nnormal = [0, 0, 1]\nrigid = true\n" for k in range(299))
    last = BALL + below + FREE
    behind = (BALL.replace("point = [0, 0, 0]", "point = [0, 0, -9]") + below
              + "[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nrigid = true\n" + FREE)
    speeds = []
    for k, text in enumerate((last, behind)):
        r = run(rve, write(tmp, text), "-o", os.path.join(tmp, f"walls{k}"), "--quiet")
        need(r.returncode == 0, f"300 walls: exit {r.returncode} {r.stderr}")
        speeds.append(column(os.path.join(tmp, f"walls{k}"), "g0_vz_m_s")[-1])
    need(
        abs(speeds[0] - 0.5) < 0.01 and abs(speeds[1] - speeds[0]) < 1e-6,
        f"rebound from the first and the last of 300 walls: {speeds}")
    # Sizes that differ by 23 orders of magnitude: an answer or a refusal, no crash.
    giant = BALL + "[[grain]]\nradius = 1e20\nposition = [0, 0, 3e20]\n" + FREE
    r = run(rve, write(tmp, giant), "-o", os.path.join(tmp, "giant"), "--quiet", timeout=60)
    need(r.returncode in (0, 2, 3) and r.stderr.count("\n") <= 1,
         f"radius 1e20 beside 1e-3: exit {r.returncode} {r.stderr!r}")
    # More frames than rows: said.
    r = run(rve, write(tmp, BALL + FREE + "[output]\nframes = 100000\n"), "--check")
    need("note: output: 100000 frames" in r.stdout and "201" in r.stdout, f"frames: {r.stdout!r}")
    # A seed for scenes that list their grains: Weibull's draw follows it.
    grain = (
        "seed = {seed}\n" + MATERIAL +
        "[material.sand.fracture]\nmodel = \"polyellipsoid-split\"\n"
        "hoek_brown = {{ compressive_strength = \"50 MPa\", m = 20.0 }}\n"
        "weibull = {{ modulus = 3.0, reference_radius = \"0.3 mm\" }}\n[[grain]]\nradius = \"0.3 mm\"\n"
        "position = [0, 0, 0]\n[loading]\nkind = \"platens\"\nstrain_rate = 200.0\nfinal_strain = 0.06\n[numerics]\n"
        "safety = 0.3\n"
    )
    first = []
    for seed in (1, 1, 2):
        out = os.path.join(tmp, f"seed{len(first)}")
        r = run(rve, write(tmp, grain.format(seed=seed)), "-o", out, "--quiet")
        need(r.returncode == 0, f"seed {seed}: {r.stderr}")
        first.append(next((i for i, b in enumerate(column(out, "breakages")) if b > 0), None))
    need(first[0] == first[1] and first[0] != first[2] and None not in first,
         f"rows of the first breakage by seed: {first}")
    fines = summary(os.path.join(tmp, "seed0"))["fines"]
    need(
        abs(fines["mass_kg"] - summary(os.path.join(tmp, "seed0"))["mass"]["lost_kg"]) == 0 and fines["mass_kg"] > 0
        and len(fines["momentum_kg_m_s"]) == 3 and any(fines["angular_momentum_kg_m2_s"])
        and any(fines["momentum_kg_m_s"]), f"fines: {fines}")
    # A bar test's equilibrium: the moving face feels the load first, and axial stress is the mean of both.
    out = os.path.join(tmp, "faces")
    r = run(
        rve,
        write(
            tmp,
            box(
                fraction=0.58, side="4 mm", loading=UNIAXIAL.replace("500.0", "20000.0").replace("0.02", "0.2") +
                "[numerics]\nmax_overlap = 10.0\n[output]\nhistory_interval = 0.001\n")), "-o", out, "--quiet")
    need(r.returncode == 0, f"faces: {r.stderr}")
    front, back, axial = (column(out, name) for name in ("stress_front_Pa", "stress_back_Pa", "axial_stress_Pa"))
    need(all(abs(0.5 * (f + b) - a) <= 1e-8 * max(abs(f), abs(b)) for f, b, a in zip(front, back, axial)),
         "axial stress is not the mean of the two faces")
    quarter = len(front) // 4
    need(
        sum(front[:quarter]) > 2 * sum(back[:quarter]) >= 0 and sum(back) > 0.2 * sum(front),
        f"front {sum(front[:quarter]):.3g} against back {sum(back[:quarter]):.3g} Pa while the wave is on its way")
    # A cell squeezed below its largest grain: unstable, its rows kept.
    big = MATERIAL + ("[packing]\nkind = \"file\"\npath = \"big.txt\"\nbox = [1e-3, 1e-3, 1e-3]\n[boundary]\n"
                      "kind = \"periodic\"\n") + UNIAXIAL.replace(
        "0.02", "0.9").replace("500.0", "200.0") + "[numerics]\nmax_overlap = 10.0\n"
    write(tmp, "0 0 0 0.3e-3\n5e-4 5e-4 5e-4 0.1e-3\n", "big.txt")
    r = run(rve, write(tmp, big), "-o", os.path.join(tmp, "big"), "--quiet")
    rows = history(os.path.join(tmp, "big")) if os.path.exists(os.path.join(tmp, "big", "history.csv")) else []
    need(
        r.returncode == 3 and "smaller than its largest grain" in r.stderr and r.stderr.count("\n") == 1
        and len(rows) > 50 and summary(os.path.join(tmp, "big"))["status"] == 3,
        f"squeezed cell: exit {r.returncode}, {len(rows)} rows, {r.stderr!r}")
    source = os.path.join(shipped, "..", "..")
    version = re.search(r"^version: (\S+)", open(os.path.join(source, "CITATION.cff")).read(), re.M)[1]
    need(
        f"project(grus VERSION {version} " in open(os.path.join(source, "CMakeLists.txt")).read()
        and f"\n## {version}" in open(os.path.join(source, "CHANGELOG.md")).read(),
        f"{version} of CITATION.cff is not that of CMakeLists.txt or CHANGELOG.md")
    for program in (rve, bvp, study, report):
        if program:
            r = run(program, "--version")
            need(r.returncode == 0 and version in r.stdout.split(), f"{program} --version: {r.stdout!r}")


def folders(tmp):
    """Whose folder it is, who writes there, and a disk that is full."""
    out, scene = os.path.join(tmp, "out"), write(tmp, BALL + FREE)
    need(
        run(rve, scene, "-o", out, "--quiet").returncode == 0
        and run(rve, scene, "-o", out, "--quiet", "--force").returncode == 0, "--force in a folder that Grus has made")
    mine = os.path.join(tmp, "mine")
    os.makedirs(os.path.join(mine, "grains"))
    write(mine, "precious", "history.csv")
    r = run(rve, scene, "-o", mine, "--quiet", "--force")
    need(
        r.returncode == 2 and "not made by Grus" in r.stderr and sorted(os.listdir(mine)) == ["grains", "history.csv"]
        and open(os.path.join(mine, "history.csv")).read() == "precious", f"--force in another's folder: {r.stderr!r}")
    # Two programs, one folder: the second is refused, and the first ends as if alone.
    slow = write(
        tmp,
        box(loading=UNIAXIAL.replace("0.02", "0.2").replace("500.0", "20.0"),
            more="[numerics]\nmax_overlap = 10.0\n[output]\nframes = 5\n"), "slow.toml")
    both = os.path.join(tmp, "both")
    p = subprocess.Popen([rve, slow, "-o", both, "--quiet", "--threads", "1"])
    while p.poll() is None and not os.path.exists(os.path.join(both, ".grus")):
        time.sleep(0.01)
    p.send_signal(signal.SIGSTOP)  # on a fast machine it would be done before the second has begun
    r = run(rve, slow, "-o", both, "--quiet", "--force")
    need(p.poll() is None, "the first run was too short for the test")
    p.send_signal(signal.SIGCONT)
    need(r.returncode == 2 and "another run is writing" in r.stderr,
         f"second program: exit {r.returncode} {r.stderr!r}")
    need(p.wait() == 0 and len(os.listdir(os.path.join(both, "grains"))) == 5, "the first of two programs lost frames")
    # Studies: names are words, and nothing outside is touched.
    victim = os.path.join(tmp, "victim")
    os.mkdir(victim)
    write(victim, "precious", "history.csv")
    for name in ("../../victim", victim, "..", ".hidden", "a/b", "a b", ""):
        for text in (
                f"[[case]]\nname = {json.dumps(name)}\n",
                f"[[case]]\nname = \"a\"\n[[plot]]\nname = {json.dumps(name)}\ny = \"kinetic_J\"\ncases = [\"a\"]\n"):
            r = run(study, write(tmp, f"[study]\nscene = \"scene.toml\"\n{text}", "study.toml"), "-o",
                    os.path.join(tmp, "deep", "study"))
            need(r.returncode == 2 and "must be a word" in r.stderr and r.stderr.count("\n") == 1,
                 f"name {name!r}: exit {r.returncode} {r.stderr!r}")
    r = run(
        study,
        write(tmp,
              "[study]\nscene = \"scene.toml\"\nat = [0.0]\nquantities = [\"kinetic_J\"]\n[[case]]\nname = \"a\"\n",
              "study.toml"), "-o", victim)
    need(r.returncode == 2 and "not made by Grus" in r.stderr and os.listdir(victim) == ["history.csv"],
         f"a study in another's folder: {r.stderr!r}")
    for text, word in (
        ("[study]\nscene = \"scene.toml\"\nquantities = [\"no_such\"]\n[[case]]\nname = \"a\"\n",
         "no_such"), ("[study]\nscene = \"scene.toml\"\nseeds = \"x\"\n[[case]]\nname = \"a\"\n",
                      "seeds"), ("[study]\nscene = 3\n[[case]]\nname = \"a\"\n", "study.scene"),
        ("[study]\nscene = \"scene.toml\"\nset = { \"loading.durationn\" = 1 }\n[[case]]\nname = \"a\"\n", "duration")):
        r = run(study, write(tmp, text, "study.toml"), "-o", os.path.join(tmp, "bad"), "--quiet")
        need(r.returncode == 2 and word in r.stderr and r.stderr.count("\n") == 1 and "Traceback" not in r.stderr,
             f"{word}: exit {r.returncode} {r.stderr!r}")
    keyless = ("[study]\nscene = \"scene.toml\"\nquantities = [\"kinetic_J\"]\nat = [0.0]\nseeds = [1, 2, 3]\n"
               "seed_key = \"seed\"\n[[case]]\nname = \"a\"\n[[check]]\nclaim = \"c\"\ncase = \"a\"\n"
               "quantity = \"errors.lateral_stress.mean\"\nbelow = 1\n")
    r = run(study, write(tmp, keyless, "study.toml"), "-o", os.path.join(tmp, "keyless"), "--quiet", "--threads", "1")
    need(
        r.returncode == 1 and "errors.lateral_stress.mean" in r.stderr and r.stderr.count("\n") == 1
        and len(os.listdir(os.path.join(tmp, "keyless", "runs"))) < 3,
        f"a key that this summary has not: exit {r.returncode} {r.stderr!r}")
    # Results that are none: one line.
    for content in ("", "a,b\n1,2\n", "time_s\nx\n", "time_s,axial_strain\n1\n", "\x00\n\x00\n"):
        bad = tempfile.mkdtemp(dir=tmp)
        write(bad, content, "history.csv")
        write(bad, "[1, 2" if "b" in content else "[]", "summary.json")
        r = run(report, bad)
        need(r.returncode == 2 and r.stderr.count("\n") == 1 and "Traceback" not in r.stderr,
             f"report of {content!r}: exit {r.returncode} {r.stderr!r}")
    taken = os.path.join(tmp, "taken")
    need(run(rve, write(tmp, BALL + FREE), "-o", taken, "--quiet").returncode == 0, "a run to report")
    os.mkdir(os.path.join(taken, "report.html"))
    for arguments in ((), ("-o", os.path.join(tmp, "nowhere", "r.html"))):
        r = run(report, taken, *arguments)
        need(r.returncode == 2 and r.stderr.count("\n") == 1 and ": cannot write: " in r.stderr,
             f"report where it cannot be written: exit {r.returncode} {r.stderr!r}")
    # A file-size limit stands for a full disk: one line, the old file or the new one, nothing half.
    many = write(tmp, box(fraction=0.5, side="4 mm", more="[output]\nframes = 10\ngrading = true\n"), "many.toml")
    for limit in (1, 3000, 60000):
        full = os.path.join(tmp, f"full{limit}")
        r = subprocess.run([rve, many, "-o", full, "--quiet", "--set", "output.checkpoint_interval=1e-3"],
                           capture_output=True, text=True, preexec_fn=limited(resource.RLIMIT_FSIZE, limit),
                           timeout=120)
        need(r.returncode == 1 and r.stderr.count("\n") == 1 and "cannot write" in r.stderr,
             f"file size {limit}: exit {r.returncode} {r.stderr[:400]!r}")
        left = [os.path.join(d, f) for d, _, files in os.walk(full) for f in files]
        need(not any(f.endswith(".new") for f in left) and all(os.path.getsize(f) < limit for f in left),
             f"file size {limit}: left {left}")
        heads = [open(f, "rb").read(4) for f in left if f.endswith((".hdf", ".h5"))]
        need(all(h == b"\x89HDF" for h in heads), "a damaged HDF5 file")
    # Threads that the system does not give; cores that this process may not use.
    r = subprocess.run([rve, scene, "-o", os.path.join(tmp, "threads"), "--threads", "1000"], capture_output=True,
                       text=True, preexec_fn=limited(resource.RLIMIT_AS, 1 << 30), timeout=60)
    need(r.returncode == 1 and "threads" in r.stderr and r.stderr.count("\n") == 1,
         f"1000 threads in 1 GiB: exit {r.returncode} {r.stderr!r}")
    one = os.path.join(tmp, "one")
    core = min(os.sched_getaffinity(0))
    r = subprocess.run([rve, scene, "-o", one, "--quiet"], preexec_fn=lambda: os.sched_setaffinity(0, {core}))
    need(r.returncode == 0 and summary(one)["threads"] == 1, "threads do not follow the affinity mask")


def signals(tmp):
    """Interruptions are heard at once: while a sample is packed, while it is prepared, in the middle of a row."""
    large = write(tmp, box(kind="periodic", fraction=0.63, side="40 mm"), "large.toml")
    out = os.path.join(tmp, "large")
    code, said, err = interrupted(tmp, "packing", [rve, large, "-o", out], "packing", signal.SIGINT, 20)
    need(code == 130 and err.count("\n") == 1 and "interrupted" in err and not os.path.exists(out),
         f"packing: exit {code} {err!r}")
    need("packing" in said and "ETA" in said, f"no progress of the packing: {said!r}")
    r = run(rve, large, "--check", timeout=100)
    told = re.search(r"from a piece of .*\n(.*\n)*.*run time .* to .*(rehearsed|gone through)", r.stdout)
    need(r.returncode == 0 and told, f"--check of a large sample: {r.stdout!r} {r.stderr!r}")
    prepared = write(
        tmp,
        box(kind="periodic", fraction=0.5, side="12 mm",
            more="[preparation]\npressure = \"1 MPa\"\ninertial_number = 1e-5\n"), "prepared.toml")
    code, said, err = interrupted(tmp, "preparation", [rve, prepared, "-o", out], "preparation", signal.SIGTERM, 20)
    need(code == 130 and "interrupted" in err and "preparation" in said and not os.path.exists(out),
         f"preparation: exit {code} {err!r} {said!r}")
    # A tool that loads: a module of its interrupts it, also where Python ignores exceptions.
    loading = os.path.join(tmp, "loading")
    os.mkdir(loading)
    now, ignored = "os.kill(os.getpid(), signal.SIGINT)\n", "class Late:\n    def __del__(self):\n        "
    for text in (now, ignored + now + "Late()\n"):
        write(loading, "import os\nimport signal\n" + text, "argparse.py")
        for tool in (study, calibrate, report):
            r = subprocess.run([tool, "any"], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": loading})
            need(r.returncode == 130 and r.stderr.count("\n") == 1 and "interrupted" in r.stderr,
                 f"{tool} while it loads: exit {r.returncode} {r.stderr!r}")
    # A tool that has said its last: Python, which takes its handlers away as it ends, is interrupted there.
    ending = os.path.join(tmp, "ending")
    os.mkdir(ending)
    write(ending, "import os\nimport signal\nimport sys\n\n\nclass Late:\n"
          "    def __del__(self, kill=os.kill, pid=os.getpid(), stop=signal.SIGINT):\n        kill(pid, stop)\n\n\n"
          "sys.late = Late()\n", "sitecustomize.py")
    for command in ([study, "any"], [calibrate, "any"], [report, "any"], [grus, "export", "any"],
                    [grus, "watch", "--any"]):
        plain, r = (subprocess.run(command, capture_output=True, text=True, env={**os.environ, **more})
                    for more in ({}, {"PYTHONPATH": ending}))
        need(plain.returncode > 0 and (r.returncode, r.stderr) == (plain.returncode, plain.stderr),
             f"{command} as it ends: exit {r.returncode} {r.stderr!r}, {plain.returncode} {plain.stderr!r} else")
    # A row that lasts: stopped in its middle, gone on with, the same bytes. SIGHUP is a request like the others.
    rows = write(
        tmp,
        box(fraction=0.52, loading=UNIAXIAL.replace("0.02", "0.3").replace("500.0", "25.0"),
            more="[numerics]\nmax_overlap = 10.0\n[output]\nhistory_interval = 0.15\n"), "rows.toml")
    whole, part = os.path.join(tmp, "whole"), os.path.join(tmp, "part")
    need(run(rve, rows, "-o", whole, "--quiet", "--threads", "1").returncode == 0, "the whole run")
    for k, sent in enumerate((signal.SIGHUP, signal.SIGTERM)):
        code, _, err = interrupted(
            tmp, "row",
            [rve, rows, "-o", part, "--quiet", "--threads", str(2 - k)] + (["--resume"] if k else []), 0.3, sent, 20)
        need(code == 130 and os.path.exists(os.path.join(part, "checkpoint.h5")), f"signal {sent}: exit {code} {err!r}")
    need(len(history(part)) < 3, "not stopped within a row")
    r = run(rve, rows, "-o", part, "--quiet", "--resume")
    need(
        r.returncode == 0
        and open(os.path.join(whole, "history.csv")).read() == open(os.path.join(part, "history.csv")).read(),
        f"history.csv differs after stops within rows: {r.returncode} {r.stderr}")
    spinning = write(tmp, (BALL + FREE).replace("velocity =",
                                                "spin = [0, 0, 1e8]\nvelocity =").replace('"2 ms"', '"0.2 s"'),
                     "spin.toml")
    code, said, err = interrupted(tmp, "spin", [rve, spinning, "-o", os.path.join(tmp, "spin")], "%  t", signal.SIGINT,
                                  20)
    need(code == 130 and "ETA" in said, f"a grain that spins for ever: exit {code} {said[-200:]!r}")
    need(
        run(rve, write(tmp, BALL + FREE + "[output]\nframes = 0\n"), "-o", os.path.join(tmp, "default"),
            "--quiet").returncode == 0
        and summary(os.path.join(tmp, "default"))["scene"]["output"]["checkpoint_interval"] == 300,
        "checkpoints are not kept every five minutes by default")


with tempfile.TemporaryDirectory() as tmp:
    {"inputs": inputs, "folders": folders, "signals": signals}[case](tmp)
print(f"attacks {case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
