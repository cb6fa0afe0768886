#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small faults put into formulas, to see whether a test notices: mutants.py [--places] [--named] [--work DIR]
[--jobs N] [--table FILE] [--report FILE [--go-on]] [NAME...]

The table beside this file says where: a place in a file, what stands there, what shall stand there instead. All faults
are built in at once, behind a variable of the environment (GRUS_MUTANT) that chooses one; 0 or nothing is the program
as it is. Each fault is run against the tests it names, then against all other test programs, the shortest first, until
one fails: then it is dead; those of Python files against the tests that they name alone. Cases that do not come past a
fault's place are not run for it. Tests of whole programs (scenes_values) are named by CTest's names. The report is
written after each fault: --go-on takes what it holds as run. Exit 0 if all that are not marked equivalent are dead but
for one in twenty, and all that are marked `from = "review"` are dead.
"""
import argparse
import concurrent.futures
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import tomllib

import cpp_faults
import python_faults

here = os.path.dirname(os.path.abspath(__file__))
root = os.path.normpath(os.path.join(here, "..", ".."))
HEADER = """#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <cstdlib>
#include <type_traits>
namespace grus_mutants {
inline const int chosen = std::getenv("GRUS_MUTANT") ? std::atoi(std::getenv("GRUS_MUTANT")) : 0;

/// A byte a fault, of a file if one is named: 1 where a program has come past it.
inline volatile char* places() {
  static char none[1 << 16];
  const char* name = std::getenv("GRUS_MUTANT_REACHED");
  const int file = name ? ::open(name, O_RDWR) : -1;
  void* all = file < 0 ? MAP_FAILED : ::mmap(nullptr, 1 << 16, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return all == MAP_FAILED ? none : static_cast<char*>(all);
}
inline volatile char* const reached = places();

/// What an expression is worth: its two forms may differ in type.
template <class T>
auto plain(T&& value) {
  if constexpr (requires { value.eval(); }) {
    return value.eval();
  } else {
    return std::decay_t<T>(static_cast<T&&>(value));
  }
}
}
#define GRUS_MUTANT_IS(k) (grus_mutants::reached[k] = 1, __builtin_expect(grus_mutants::chosen == (k), 0))
""" + "".join(f'#pragma GCC diagnostic ignored "-W{w}"\n' for w in (
    "conversion", "sign-conversion", "float-conversion", "sign-compare", "shadow", "parentheses", "unused-variable",
    "unused-parameter", "unused-but-set-variable", "unused-value", "dangling-else", "unused-function",
    "unused-local-typedefs"))
# Compiles as ever, so that ccache knows what holds no fault; what warns again, with warnings that are no errors.
LENIENT = """#!/bin/sh
{ccache} "$@" 2>/dev/null || exec {ccache} "$@" -Wno-error
"""


def refuse(message):
    sys.exit(f"mutants: {message}")


def read_table(path):
    with open(path, "rb") as f:
        table = tomllib.load(f)["mutant"]
    names = [m["name"] for m in table]
    if len(set(names)) != len(names):
        refuse(f"{path}: a name is given twice: {sorted(n for n in names if names.count(n) > 1)[0]}")
    for m in table:
        m["places"] = m.get("places") or [{k: m[k] for k in ("file", "old", "new", "type", "nth") if k in m}]
        if of_python(m) and not m.get("tests"):
            refuse(f"{path}: {m['name']}: names no test")
    return table


def of_python(m):
    return m["places"][0]["file"].endswith(".py")


def places_of(text, old):
    """Where a text stands, however its lines are broken."""
    words = r"\s+".join(r"\s*".join(re.escape(part) for part in re.findall(r"\w+|\W", word)) for word in old.split())
    return [found.span() for found in re.finditer(words, text)]


def cannot_stand(text, span, place):
    """Why a text cannot be put behind a choice; None where it can."""
    if place["file"].endswith(".py"):
        return python_faults.cannot_stand(text, span)
    return cpp_faults.cannot_stand(text, span, place["old"].strip(), place["new"].strip())


def with_faults(table, only=None):
    """Texts of the files that hold faults, of all or of `only` these numbers. Places in a file are replaced from the
    back; those of the same text share a place."""
    spans, changed = {}, {}
    for number, m in enumerate(table, 1):
        if only and number not in only:
            continue
        for place in m["places"]:
            path = place["file"]
            text = open(os.path.join(root, path)).read()
            found, nth = places_of(text, place["old"]), place.get("nth", 0)
            if nth == 0 and len(found) != 1:
                refuse(f"{m['name']}: {path} holds {len(found)} times {place['old']!r}")
            if nth > len(found):
                refuse(f"{m['name']}: {path} does not hold {place['old']!r} {nth} times")
            if why := cannot_stand(text, found[max(nth, 1) - 1], place):
                refuse(f"{m['name']}: {place['old']!r}: {why}")
            spans.setdefault(path, {}).setdefault(found[max(nth, 1) - 1], []).append((number, place))
    for path, places in spans.items():
        text = open(os.path.join(root, path)).read()
        ordered = sorted(places, reverse=True)
        for a, b in zip(ordered[1:], ordered):
            if a[1] > b[0]:
                refuse(f"{path}: {text[a[0]:a[1]]!r} and {text[b[0]:b[1]]!r} overlap")
        for span in ordered:
            old = text[span[0]:span[1]]
            if path.endswith(".py"):
                faults = [(number, place["new"]) for number, place in places[span]]
                text = text[:span[0]] + python_faults.behind_choice(text, span, faults) + text[span[1]:]
                continue
            statement = old.rstrip().endswith((";", "}"))
            new = f"{{ {old} }}" if statement else f"({old})"
            for number, place in places[span]:
                kind = place.get("type")
                if statement:
                    new = f"if (GRUS_MUTANT_IS({number})) {{ {place['new']} }} else {new}"
                elif kind:
                    new = f"(GRUS_MUTANT_IS({number}) ? {kind}({place['new']}) : {kind}({new}))"
                else:
                    new = f"(GRUS_MUTANT_IS({number}) ? ({place['new']}) : {new})"
            text = text[:span[0]] + new + text[span[1]:]
        if path.endswith(".py"):
            text = python_faults.with_choice(text)
            if python_faults.tree(text) is None:
                refuse(f"{path}: is no Python with its faults")
        changed[path] = text
    return changed


def renew(path, data):
    """Writes a file only if it is another one: what is the same is not built again."""
    if not os.path.exists(path) or open(path, "rb").read() != data:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        open(path, "wb").write(data)


def prepare(table, work, python_alone, tests, only):
    """Builds in all faults, or `only` these; for faults of Python alone those, and programs without tests. `tests`: of
    what is built the programs, and these; None: all."""
    source = os.path.join(work, "source")
    build = os.path.join(source, "build")
    files = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True,
                           check=True).stdout.split("\n")
    changed = {name: text for name, text in with_faults(table, only).items()
               if name.endswith(".py") or not python_alone}
    for name in filter(None, files):
        renew(os.path.join(source, name),
              with_header(name, changed[name]) if name in changed else open(os.path.join(root, name), "rb").read())
    renew(os.path.join(source, "mutant.hpp"), HEADER.encode())
    lenient = os.path.join(work, "lenient")
    renew(lenient, LENIENT.format(ccache=shutil.which("ccache") or "").encode())
    os.chmod(lenient, 0o755)
    subprocess.run([
        "cmake", f"-DCCACHE={lenient}", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_UNITY_BUILD=ON"
    ], check=True, stdout=subprocess.DEVNULL)
    if subprocess.run(["cmake", "--build", build, *targets(build, python_alone, tests), "--", "-k", "0"]).returncode:
        refuse("the faults do not compile")
    return build


def with_header(name, text):
    """C++ learns which fault is chosen in its first line; what holds no fault is compiled as it always is."""
    return (text if name.endswith(".py") else f'#include "mutant.hpp"\n{text}').encode()


def targets(build, python_alone, tests):
    if not python_alone and tests is None:
        return []
    there = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"], capture_output=True, text=True).stdout
    programs = {t for t in tests or () if re.search(rf"^test_{re.escape(t)}: phony", there, re.M)}
    return ["--target", "programs", *sorted(f"test_{t}" for t in programs)]


def cases_of(build, test):
    """The cases of a test program, one by one; of a whole program's test a single one, which has no name."""
    program = os.path.join(build, "tests", "test_" + test)
    if not os.path.exists(program):
        return [None]
    listed = lambda *names: subprocess.run([program, *names, "--list-test-names-only"], env=environment_of(0),
                                           capture_output=True, text=True).stdout.splitlines()
    cases = listed()
    with file_of(cases) as names:
        if not cases or listed("-f", names.name) != cases:
            refuse(f"{test} does not know its cases by their names")
    return cases


def file_of(cases):
    """A file that names cases, as test programs read it."""
    names = tempfile.NamedTemporaryFile("w")
    names.write("".join('"' + re.sub(r'([\\",\[])', r"\\\1", case) + '"\n' for case in cases if case))
    names.flush()
    return names


def way_of(build, test, case):
    """The faults whose places a case comes past, and how long it takes (s). It has to pass, at a second try where the
    machine was busy; None where it does not: it judges no fault."""
    with tempfile.NamedTemporaryFile() as places:
        places.truncate(1 << 16)
        for patience in (600, 1200):
            begin = time.time()
            if run(build, test, [case], 0, patience, places.name):
                return {k for k, seen in enumerate(places.read()) if seen}, time.time() - begin
            print(f"{test}: {case}: fails without any fault", flush=True)
        return None, 0


def environment_of(number, reached=""):
    return dict(os.environ, GRUS_MUTANT=str(number), GRUS_MUTANT_REACHED=reached, OMPI_ALLOW_RUN_AS_ROOT="1",
                OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_btl="^tcp,uct,openib,ofi", OMP_NUM_THREADS="1",
                OPENBLAS_NUM_THREADS="1", OMPI_MCA_hwloc_base_binding_policy="none", GRUS_ABORT="1")


def run(build, test, cases, number, timeout, reached=""):
    """True where these cases of a test pass. A fault that makes a test hang is found by its time, and by thrice it."""
    with tempfile.TemporaryDirectory() as folder, file_of(cases) as names:
        command = [os.path.join(build, "tests", "test_" + test), "--abort", "-f", names.name]
        if cases == [None]:  # a whole program's test, by its name
            command = ["ctest", "--test-dir", build, "-R", f"^{test}$", "--no-tests=error"]
        for limit in (timeout, 3 * timeout):
            try:
                return subprocess.run(command, cwd=folder, env=dict(environment_of(number, reached), TMPDIR=folder),
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                      timeout=limit).returncode == 0
            except subprocess.TimeoutExpired:
                continue
        return False


class Ways:
    """What the cases of a test come past, and how long they take, once it is asked for."""

    def __init__(self, build):
        self.build, self.known, self.lock, self.broken = build, {}, threading.Lock(), set()

    def of(self, test):
        with self.lock:
            if test not in self.known:
                self.known[test] = [(case, *way_of(self.build, test, case)) for case in cases_of(self.build, test)]
                self.broken |= {test for _, reached, _ in self.known[test] if reached is None}
            return self.known[test]

    def past(self, test, number, everywhere):
        """The cases that come past a fault, and how long they take together (s); `everywhere`: all of them do."""
        some = [(case, s) for case, reached, s in self.of(test) if reached is not None and
                (everywhere or number in reached)]
        return [case for case, _ in some], sum(s for _, s in some)


def written(path, faults, found):
    """A table of the faults that have been run, as a whole or not at all."""
    with open(path + ".new", "w") as f:
        f.write("| room | fault | found by |\n|---|---|---|\n")
        for m in faults:
            if m["name"] in found:
                lives = "equivalent: " + m["equivalent"] if "equivalent" in m else "**lives**"
                f.write(f"| {m['places'][0]['file']} | {m['name']} | {found[m['name']] or lives} |\n")
    os.replace(path + ".new", path)


def read_report(path):
    """Who found each fault, None: nobody; by name, as numbers change with the table."""
    if not os.path.exists(path):
        return {}
    with open(path) as f:
        cells = [[c.strip() for c in line.strip().strip("|").split("|")] for line in f.read().splitlines()[2:]]
    return {c[1]: None if c[-1] == "**lives**" or c[-1].startswith("equivalent") else c[-1] for c in cells}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work",
                        help="folder to build in; kept, so that a second run builds less (default: a scratch folder)")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--table", default=os.path.join(here, "mutants.toml"), help="another table of faults")
    parser.add_argument("--report", help="file for a table of the faults that were run, written after each")
    parser.add_argument("--go-on", action="store_true", help="the faults that the report holds are not run again")
    parser.add_argument("--places", action="store_true", help="only see that every place is found")
    parser.add_argument("--named", action="store_true",
                        help="only against the tests that they name; no other faults and tests are built")
    parser.add_argument("names", nargs="*", help="only these faults")
    options = parser.parse_args()
    table = read_table(options.table)
    unknown = set(options.names) - {m["name"] for m in table}
    if unknown:
        refuse(f"no such fault: {sorted(unknown)[0]}")
    if options.places:
        print(f"mutants: the places of {len(table)} faults stand in {len(with_faults(table))} files")
        return
    chosen = sorted(((k, m) for k, m in enumerate(table, 1) if not options.names or m["name"] in options.names),
                    key=lambda of: "equivalent" in of[1])  # those are run against all tests, which takes long
    python_alone = all(of_python(m) for _, m in chosen)
    scratch = None if options.work else tempfile.TemporaryDirectory()
    asked = {t for _, m in chosen for t in m.get("tests", "").split()}
    build = prepare(table, os.path.abspath(options.work or scratch.name), python_alone,
                    *((asked, {k for k, _ in chosen}) if options.named else (None, None)))
    tests = [] if python_alone or options.named else sorted(
        os.path.basename(p)[5:] for p in glob.glob(os.path.join(build, "tests", "test_*"))
        if os.access(p, os.X_OK) and os.path.isfile(p))
    ways = Ways(build)
    found = read_report(options.report) if options.go_on else {}
    found = {m["name"]: found[m["name"]] for _, m in chosen if m["name"] in found}
    print(f"{len(table)} faults, {len(tests)} tests; {len(found)} of {len(chosen)} were run before", flush=True)

    def judge(number, m):
        def finds(test):
            cases, usual = ways.past(test, number, of_python(m))
            return cases and not run(build, test, cases, number, 10 + 4 * usual * options.jobs)
        named = m.get("tests", "").split()
        if killer := next(filter(finds, named), None):
            return killer
        others = [] if of_python(m) else [t for t in tests if t not in named]
        return next(filter(finds, sorted(others, key=lambda t: ways.past(t, number, False)[1])), None)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        waiting = {pool.submit(judge, k, m): m for k, m in chosen if m["name"] not in found}
        for done in concurrent.futures.as_completed(waiting):
            m = waiting[done]
            found[m["name"]] = killer = done.result()
            if options.report:
                written(options.report, [m for _, m in chosen], found)
            lives = "LIVES" + (f", equivalent: {m['equivalent']}" if "equivalent" in m else "")
            print(f"[{len(found)}/{len(chosen)}] {m['name']}: {'dead by ' + killer if killer else lives}", flush=True)
    real = [m for _, m in chosen if "equivalent" not in m]
    alive = [m for m in real if found[m["name"]] is None]
    for m in (m for _, m in chosen if "equivalent" in m and found[m["name"]]):
        print(f"marked equivalent, but dead: {m['name']} by {found[m['name']]}")
    print(f"{len(real) - len(alive)} of {len(real)} dead ({100 * (1 - len(alive) / max(1, len(real))):.1f} %)" +
          ("; alive: " + ", ".join(m["name"] for m in alive) if alive else ""))
    if ways.broken:
        print("failed without any fault: " + ", ".join(sorted(ways.broken)))
    sys.exit(1 if ways.broken or any(m.get("from") == "review" for m in alive) or len(alive) > 0.05 * len(real) else 0)


if __name__ == "__main__":
    main()
