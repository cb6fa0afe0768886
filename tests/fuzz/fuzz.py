#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mutated scenes, meshes, packings, studies and checkpoints, seeded: fuzz.py BIN COUNT SEED [--sanitized] [--keep DIR]
No signal, no hang, one line on standard error, nothing left behind by what is refused, nothing touched elsewhere."""
import contextlib
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor

import bases

binaries, count, seed = os.path.abspath(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
sanitized = "--sanitized" in sys.argv
keep = sys.argv[sys.argv.index("--keep") + 1] if "--keep" in sys.argv else None
fem = os.path.exists(os.path.join(binaries, "grus-bvp"))
# MPI leaks what it never needed to free; a thing too large to be had is an error of ours, not of the sanitizer.
os.environ.update(ASAN_OPTIONS="detect_leaks=0:allocator_may_return_null=1",
                  UBSAN_OPTIONS="print_stacktrace=1:halt_on_error=1")
ENOUGH, END = (20, 60) if sanitized else (4, 6)  # s until a run is asked to stop, and that it then may take
STRANGE = [
    0, -1, 1, 3, -0.0, 1e-320, 1e-30, 1e30, 1e300,
    float("nan"),
    float("inf"), 2**63 - 1, -2**63, 10**6, 0.999999, "", " ", "nan", "inf GPa", "1e999 m", "60 GPa", "1 mm", "-1 mm",
    "1 m/s", "0x10 m", "1 m^1e9", "1 m^^2", "5 %", "max", "free", "日本 🪨", "a\nb", "\x07", "x" * 5000,
    "../../../../etc/passwd", "/dev/zero", "/dev/stdin", ".", "../../escaped", "{0}%s%n$", True, [], [[]], {}, {"a": 1},
    [1], [1, 2, 3], [0, 0, 0], ["free", "free", "free"], [[0, 1], [0, 2]], ["x", 1, True]
]
WORDS = [
    "walls", "periodic", "open", "random", "hcp", "simple-cubic", "file", "uniaxial-strain", "triaxial",
    "velocity-gradient", "platens", "free", "density", "linear", "aligned", "x", "axisymmetric", "plane-strain", "3d",
    "tetrahedron", "triangle", "quasi-newton", "perturbation", "elastic", "explicit-dynamic", "quasi-static", "z=max",
    "y>0", "x=max and y=max"
]


def dumped(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "")
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, list):
        return "[" + ", ".join(map(dumped, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key_text(k)} = {dumped(v)}" for k, v in value.items()) + "}"
    return str(value)


def key_text(key):
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def toml(table, path=()):
    """Tables as headings, so that messages have lines to name."""
    nested = {
        k: v for k, v in table.items()
        if isinstance(v, dict) or (isinstance(v, list) and v and all(isinstance(x, dict) for x in v))
    }
    text = "".join(f"{key_text(k)} = {dumped(v)}\n" for k, v in table.items() if k not in nested)
    for k, v in nested.items():
        name = ".".join([*path, key_text(k)])
        for part in [v] if isinstance(v, dict) else v:
            text += (f"[{name}]\n" if isinstance(v, dict) else f"[[{name}]]\n") + toml(part, (*path, key_text(k)))
    return text


def leaves(node):
    for k, v in list(node.items() if isinstance(node, dict) else enumerate(node)):
        yield node, k, v
        if isinstance(v, (dict, list)):
            yield from leaves(v)


def mutate_tree(draw, text):
    tree = tomllib.loads(text)
    for _ in range(draw.choice([1, 1, 2])):
        places = list(leaves(tree))
        if not places:
            break
        node, k, v = draw.choice(places)
        how = draw.random()
        if how < 0.1 and isinstance(node, dict):
            del node[k]
        elif how < 0.6 and isinstance(v, (int, float)) and not isinstance(v, bool):
            node[k] = v * draw.choice([-1, 0, 0.5, 0.8, 1.2, 2, 3, 0.1, 10, 1e-3, 1e3, 1e-6, 1e6, 1e12])
        elif how < 0.6 and isinstance(v, str) and (m := re.match(r"^([-+0-9.eE]+)( .*)$", v)):
            node[k] = f"{float(m[1]) * draw.choice([0.5, 0.9, 1.1, 2, 1e-9, 1e-3, 0.1, 10, 1e3, 1e9, -1, 0]):g}{m[2]}"
        elif how < 0.68 and isinstance(node, dict):
            node[draw.choice(["bogus", k + "s", "", "a.b", "日本"])] = v
        elif how < 0.74 and isinstance(v, list):
            node[k] = draw.choice([v + v, v[:-1], v[::-1]])
        elif how < 0.84 and isinstance(v, str):
            node[k] = draw.choice(WORDS)
        else:
            node[k] = draw.choice(STRANGE)
    return toml(tree).encode("utf-8", "replace")


def mutate_gently(draw, text):
    """The same file with some of its numbers a little or much larger or smaller."""
    tree = tomllib.loads(text)
    for node, k, v in draw.sample(all_ := list(leaves(tree)), min(4, len(all_))):
        if isinstance(v, (int, float)) and not isinstance(v, bool):
            node[k] = type(v)(v * draw.choice([0.5, 0.8, 1.3, 2, 3]))
        elif isinstance(v, str) and (m := re.match(r"^([-+0-9.eE]+)( .*)$", v)):
            node[k] = f"{float(m[1]) * draw.choice([0.1, 0.5, 0.8, 1.3, 2, 10]):g}{m[2]}"
    return toml(tree).encode()


def mutate_bytes(draw, data):
    data = bytearray(data)
    for _ in range(draw.choice([1, 2, 5])):
        at, how = draw.randrange(len(data) + 1), draw.random()
        if how < 0.3 and data:
            data[min(at, len(data) - 1)] ^= 1 << draw.randrange(8)
        elif how < 0.5:
            del data[at:at + draw.choice([1, 7, 100])]
        elif how < 0.65:
            data[at:at] = bytes(draw.randrange(256) for _ in range(draw.choice([1, 8])))
        elif how < 0.8:
            data = data[:at]
        else:
            data[at:at] = data[max(0, at - 60):at]
    return bytes(data)


def mutate_numbers(draw, data):
    parts = re.split(rb"([-+]?[0-9][-+0-9.eE]*)", data)
    for _ in range(draw.choice([1, 1, 2, 4])):
        k = draw.randrange(1, len(parts), 2) if len(parts) > 2 else 0
        parts[k] = draw.choice(
            [b"0", b"-1", b"999999999", b"99999999999999999999", b"1e308", b"nan", b"x", b"", b"7", b"1e-320", b"2"])
    return b"".join(parts)


def prepared(kind, work):
    """Files of a kind in a folder: what to mutate, and the command."""
    write = lambda name, text: open(os.path.join(work, name), "w").write(text)
    for name, text in bases.RVE.items():
        write(name + ".toml", text)
    for name, text in bases.BVP.items():
        write(name + ".toml", text)
    for name, text in bases.STUDY.items():
        write("study_" + name + ".toml", text)
    write("cell.toml", bases.CELL), write("pack.txt", bases.PACKING), write("mesh.msh", bases.MESH)


KINDS = ["rve"] * 9 + ["packing"] * 2 + ["study"] * 2 + ["checkpoint"] * 3 + ["report"] + (
    ["bvp"] * 5 + ["cell", "mesh", "mesh", "mesh", "checkpoint_bvp"] if fem else [])
whole = {}    # checkpoints of runs that ended well
results_of = {}  # files of such a run


def a_checkpoint(program, scene):
    with tempfile.TemporaryDirectory() as work:
        prepared("", work)
        out = os.path.join(work, "out")
        r = subprocess.run([
            os.path.join(binaries, program), scene, "-o", out, "--quiet", "--threads", "1", "--set",
            "output.checkpoint_interval=\"1e-9 s\""
        ], cwd=work, capture_output=True, text=True)
        assert r.returncode == 0, r.stderr
        for name in ("history.csv", "summary.json", "grading.csv"):
            if os.path.exists(os.path.join(out, name)):
                results_of[name] = open(os.path.join(out, name), "rb").read()
        return open(os.path.join(out, "checkpoint.h5"), "rb").read()


def limits():
    if not sanitized:  # sanitizers map terabytes
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def listing(folder):
    return sorted(
        os.path.relpath(os.path.join(d, f), folder) for d, subs, files in os.walk(folder) for f in subs + files)


def one(number):
    """What is wrong with the ending of case `number`, and how to see it again; None."""
    draw = random.Random(f"{seed}/{number}")
    kind = draw.choice(KINDS)
    outer = tempfile.mkdtemp()
    work = os.path.join(outer, "a", "b")  # room for what would climb out
    os.makedirs(work)
    prepared(kind, work)
    target, program, scene = {
        "rve": lambda: (draw.choice([n + ".toml" for n in bases.RVE]), "grus-rve", None),
        "bvp": lambda: (draw.choice([n + ".toml" for n in bases.BVP]), "grus-bvp", None),
        "cell": lambda: ("cell.toml", "grus-bvp", "block.toml"),
        "study": lambda: (draw.choice(["study_cases.toml", "study_precision.toml", "two.toml"]), "grus-study", None),
        "packing": lambda: ("pack.txt", "grus-rve", "file.toml"),
        "mesh": lambda: ("mesh.msh", "grus-bvp", "plate.toml"),
        "report": lambda: ("run/" + draw.choice(["history.csv", "history.csv", "summary.json", "grading.csv"]),
                           "grus-report", "run"),
        "checkpoint": lambda: ("out/checkpoint.h5", "grus-rve", "walls.toml"),
        "checkpoint_bvp": lambda: ("out/checkpoint.h5", "grus-bvp", "plate.toml")
    }[kind]()
    scene = scene or ("study_cases.toml" if target == "two.toml" and program == "grus-study" else target)
    path = os.path.join(work, target)
    if kind.startswith("checkpoint"):
        os.mkdir(os.path.join(work, "out"))
        new = mutate_bytes(draw, whole[kind]) if draw.random() < 0.9 else draw.choice(
            [b"", b"\x89HDF\r\n\x1a\n", whole[kind][:len(whole[kind]) // 2]])
    elif kind == "report":
        os.mkdir(os.path.join(work, "run"))
        for name, data in results_of.items():
            open(os.path.join(work, "run", name), "wb").write(data)
        data = results_of[os.path.basename(target)]
        new = mutate_numbers(draw, data) if draw.random() < 0.5 else mutate_bytes(draw, data)
    elif kind in ("packing", "mesh"):
        data = open(path, "rb").read()
        new = mutate_numbers(draw, data) if draw.random() < 0.6 else mutate_bytes(draw, data)
    else:
        data = open(path, "rb").read()
        how = draw.random()
        new = mutate_gently(draw, data.decode()) if how < 0.35 else mutate_tree(
            draw, data.decode()) if how < 0.8 else mutate_bytes(draw, data)
    open(path, "wb").write(new)
    command = [os.path.join(binaries, program), scene, "-o", "out"]
    if kind != "report":
        command += ["--check"] if draw.random() < 0.3 and not kind.startswith("checkpoint") else ["--quiet"]
        command += ["--threads", draw.choice(["1", "1", "2"])]
    if kind.startswith("checkpoint"):
        command += ["--resume", "--set", "output.checkpoint_interval=\"1e-9 s\""]
    before, outside = listing(work), listing(outer)
    process = subprocess.Popen(command, cwd=work, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               stdin=subprocess.DEVNULL, preexec_fn=limits, start_new_session=True)
    wrong = []
    try:
        _, errors = process.communicate(timeout=ENOUGH)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
        try:
            _, errors = process.communicate(timeout=END)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)  # an increment of a macro problem is ended first, unless asked twice
        try:
            _, errors = process.communicate(timeout=10)  # other tests have the cores too
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.killpg(process.pid, signal.SIGKILL)
            _, errors = process.communicate()
            wrong.append("does not hear Ctrl-C")
    errors = errors.decode(errors="replace")
    lines = [line for line in errors.splitlines() if line.strip()]
    code = process.returncode
    if kind in ("report", "study") and code == -signal.SIGINT and not errors:
        code = 130  # Ctrl-C reached it before Python had begun
    excused = code == 1 and ("out of memory" in errors or "cannot" in errors or "status" in errors or kind == "study")
    if code not in (0, 2, 3, 130) and not wrong and not excused:
        wrong.append(f"exit {code}")
    if "Traceback" in errors or "Sanitizer" in errors or "runtime error" in errors:
        wrong.append("traceback or sanitizer")
    if code in (1, 2, 3) and len(lines) != 1 and not (kind == "study" and code == 1 and lines):
        wrong.append(f"{len(lines)} lines")
    if code == 2 and listing(work) != before:
        wrong.append(f"left {sorted(set(listing(work)) ^ set(before))[:5]}")
    if [f for f in listing(outer) if f not in outside and not f.startswith("a/b/")]:
        wrong.append("wrote outside")
    if wrong and keep:
        shutil.copytree(outer, os.path.join(keep, f"{seed}_{number}"), dirs_exist_ok=True)
    shutil.rmtree(outer, ignore_errors=True)
    return (f"case {number} ({kind}, {target}): {', '.join(wrong)}: {' '.join(command)}: {errors[:400]!r}"
            if wrong else None), code


begin = time.time()
if fem:
    whole["checkpoint_bvp"] = a_checkpoint("grus-bvp", "plate.toml")
whole["checkpoint"] = a_checkpoint("grus-rve", "walls.toml")
with ThreadPoolExecutor(2 * max(2, len(os.sched_getaffinity(0)))) as pool:  # MPI sleeps more than it works
    results = list(pool.map(one, range(count)))
faults = [fault for fault, _ in results if fault]
for fault in faults:
    print("FAULT", fault)
codes = {c: sum(code == c for _, code in results) for c in sorted({code for _, code in results})}
print(f"fuzz: {count} cases of seed {seed}, exits {codes}, {len(faults)} faults, {time.time() - begin:.0f} s")
# A fuzzer whose cases are all refused, or all fine, tries nothing.
sys.exit(1 if faults or not (0.05 < codes.get(0, 0) / count < 0.8) or codes.get(2, 0) < 0.2 * count else 0)
