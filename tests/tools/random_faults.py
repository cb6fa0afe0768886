#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Faults drawn at random in the Python package, to see how many its tests find: random_faults.py BUILD [--seed N]
[--count N] [--record] [GROUP...]

A fault changes one node of a module's syntax tree: a comparison, an operator, a number, a sign, `not`, or leaves a
statement out. Each is put into a copy of the package and run against the tests of its group, until one fails. What only
looks otherwise (sizes, marks and places of curves) is not drawn from. Nothing is asked of the share that is found: it
is printed, with each fault that no test finds.
"""
import argparse
import ast
import copy
import csv
import functools
import glob
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

KEPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "random_faults.csv")
# Modules, and the tests (by CTest's names) that should find their faults.
GROUPS = {
    "results": (("results.py", "asked.py", "files/*.py"),
                ("results_edges", "tables", "report_numbers", "calibrate_targets")),
    "report": (("report/*.py", "figures.py"),
               ("report_numbers", "report_pages", "report_pictures", "report_frames", "study_pages")),
    "study": (("study/*.py", "study/kinds/*.py", "runs/*.py"),
              ("study_edges", "study_numbers", "study_pages", "study_runs", "study_times")),
    "calibrate": (("calibrate/*.py",), ("calibrate_edges", "calibrate_targets", "calibrate_numbers",
                                        "calibrate_posterior", "calibrate_pounders")),
    "rves": (("rves.py", "samples.py"), ("package_logic",)),
    "bands": (("bands.py",), ("package_bands",)),
}
COMPARISONS = {ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
               ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is}
NEAR = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
             ast.Mod: ast.Add, ast.Pow: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr}
LOOKS = {"ms", "marker", "alpha", "fontsize", "size", "figsize", "dpi", "width", "height", "indent", "loc", "color",
         "bbox_to_anchor", "borderaxespad", "frameon", "lw", "linewidth", "capsize", "help", "metavar", "stacklevel",
         "timeout", "sort_keys", "aspect", "pixels", "xytext", "ha", "va", "textcoords", "shrink",
         "linewidths", "zorder"}


def changes(node):
    """(what, change) of a node: change(node) gives what shall stand there."""
    def other(**fields):
        def made(n):
            new = copy.copy(n)
            for key, value in fields.items():
                setattr(new, key, value)
            return new
        return made
    if isinstance(node, ast.Compare):
        for kinds in (COMPARISONS, NEAR):
            if type(node.ops[0]) in kinds:
                yield other(ops=[kinds[type(node.ops[0])](), *node.ops[1:]])
    elif isinstance(node, (ast.BinOp, ast.AugAssign)) and type(node.op) in OPERATORS:
        yield other(op=OPERATORS[type(node.op)]())
    elif isinstance(node, ast.BoolOp):
        yield other(op=ast.And() if isinstance(node.op, ast.Or) else ast.Or())
        yield other(values=node.values[:-1]) if len(node.values) > 2 else lambda n: n.values[0]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        yield lambda n: n.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield other(value=not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        yield other(value=node.value + 1)
        yield other(value=0.5 * node.value if isinstance(node.value, float) else node.value - 1)
    elif isinstance(node, (ast.Expr, ast.Raise, ast.Continue, ast.AugAssign)) and not told(node):
        yield lambda n: ast.copy_location(ast.Pass(), n)
    elif isinstance(node, ast.Assign) and all(isinstance(t, (ast.Attribute, ast.Subscript)) for t in node.targets):
        yield lambda n: ast.copy_location(ast.Pass(), n)
    elif isinstance(node, ast.IfExp):
        yield lambda n: n.body
        yield lambda n: n.orelse


def told(node):
    return isinstance(node, ast.Expr) and isinstance(node.value, (ast.Constant, ast.Yield, ast.YieldFrom))


def places(tree):
    """(node's place: fields from the root, how many changes). Annotations and looks are left out."""
    def walk(node, way):
        for field, value in ast.iter_fields(node):
            if field in ("annotation", "returns") or (isinstance(node, ast.If) and field == "body" and
                                                      "TYPE_CHECKING" in ast.dump(node.test)):
                continue
            for k, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
                if isinstance(child, ast.keyword) and child.arg in LOOKS or not isinstance(child, ast.AST):
                    continue
                here = [*way, (field, k)]
                for number in range(len(list(changes(child)))):
                    yield here, number
                yield from walk(child, here)
    yield from walk(tree, [])


def with_fault(text, way, number):
    """The module's text with one change, and its line before and after."""
    tree = ast.parse(text)
    holder = tree
    for field, k in way[:-1]:
        holder = getattr(holder, field) if k is None else getattr(holder, field)[k]
    field, k = way[-1]
    node = getattr(holder, field) if k is None else getattr(holder, field)[k]
    new = list(changes(node))[number](node)
    before, line = ast.unparse(node), getattr(node, "lineno", getattr(holder, "lineno", 0))
    if k is None:
        setattr(holder, field, new)
    else:
        getattr(holder, field)[k] = new
    return ast.unparse(ast.fix_missing_locations(tree)), f"{line}: {before}  ->  {ast.unparse(new)}"


def copy_of(build, folder):
    """A build to be changed: its package, its launchers, links to its programs and test programs."""
    shutil.copytree(os.path.join(build, "python"), os.path.join(folder, "python"),
                    ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    for core in glob.glob(os.path.join(build, "python", "grus", "*.so")):
        os.symlink(core, os.path.join(folder, "python", "grus", os.path.basename(core)))
    os.makedirs(os.path.join(folder, "bin"))
    for path in glob.glob(os.path.join(build, "bin", "*")):
        script = os.path.getsize(path) < 10000
        (shutil.copy if script else os.symlink)(path, os.path.join(folder, "bin", os.path.basename(path)))


def tests_of(build, folder, names):
    """(name, command, environment) of tests by CTest, for the copy."""
    told = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True,
                                     text=True, check=True).stdout)
    found = {t["name"]: t for t in told["tests"] if "command" in t}
    for name in names:
        if name not in found:
            print(f"no test {name}")
            continue
        more = next((p["value"] for p in found[name].get("properties", []) if p["name"] == "ENVIRONMENT"), [])
        command = [folder + word[len(build):] if word.startswith(build) else word for word in found[name]["command"]]
        more = dict(v.split("=", 1) for v in more)
        yield name, command, dict(os.environ, PYTHONDONTWRITEBYTECODE="1", GRUS_ABORT="1", **more)


def fails(command, environment, timeout=120):
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:  # a fault may leave runs that still write
        try:
            return subprocess.run(command, cwd=place, env=dict(environment, TMPDIR=place), stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, timeout=timeout).returncode not in (0, 77)
        except subprocess.TimeoutExpired:
            return True


def trial(build, group, draw, count, keep):
    """How many of the faults that are drawn in a group some test finds; keep(drawn, found) after each."""
    patterns, names = GROUPS[group]
    with tempfile.TemporaryDirectory() as folder:
        copy_of(build, folder)
        package = os.path.join(folder, "python", "grus")
        texts = {p: open(p).read() for pattern in patterns for p in sorted(glob.glob(os.path.join(package, pattern)))}
        tests = list(tests_of(build, folder, names))
        for name, command, environment in tests:
            if fails(command, environment):
                sys.exit(f"{name} fails without any fault")
        faults = draw.sample([(p, *place) for p, text in texts.items() for place in places(ast.parse(text))], count)
        lives = 0
        for drawn, (path, way, number) in enumerate(faults, 1):
            changed, about = with_fault(texts[path], way, number)
            with open(path, "w") as f:
                f.write(changed)
            by = next((name for name, *test in tests if fails(*test)), None)
            with open(path, "w") as f:
                f.write(texts[path])
            lives += by is None
            keep(drawn, drawn - lives)
            print(f"{'LIVES' if by is None else 'dead by ' + by}: {os.path.relpath(path, package)}:{about}", flush=True)
        print(f"{group}: {count - lives} of {count} found ({100 * (count - lives) / count:.0f} %)", flush=True)


def keep(group, seed, drawn, found):
    """In random_faults.csv: the last trial of each group, for docs/verification.md."""
    rows = {}
    if os.path.exists(KEPT):
        with open(KEPT, newline="") as f:
            rows = {row["group"]: row for row in csv.DictReader(f)}
    rows[group] = {"group": group, "seed": seed, "drawn": drawn, "found": found}
    with open(KEPT, "w", newline="") as f:
        out = csv.DictWriter(f, ["group", "seed", "drawn", "found"], lineterminator="\n")
        out.writeheader()
        out.writerows(rows[name] for name in [*GROUPS, *sorted(set(rows) - set(GROUPS))] if name in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=os.path.abspath)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--record", action="store_true",
                        help="keep the shares in random_faults.csv, of a trial that is stopped too")
    parser.add_argument("groups", nargs="*", choices=[[], *GROUPS])
    options = parser.parse_intermixed_args()
    for group in options.groups or GROUPS:
        kept = functools.partial(keep, group, options.seed) if options.record else lambda *_: None
        trial(options.build, group, random.Random(f"{group} {options.seed}"), options.count, kept)


if __name__ == "__main__":
    main()
