#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tree's guard rails: includes and imports only go down, files stay short, public headers read few others."""
import ast
import glob
import os
import re
import sys

root = sys.argv[1]
floor = {
    "dem/base": 0, "dem/kernel": 1, "dem/shape": 1, "dem/state": 2, "dem/contact": 3, "dem/bond": 3, "dem/fracture": 4,
    "dem/motion": 4, "dem/rve": 5, "dem/packing": 6, "dem/io": 6, "dem/rves": 7, "dem/sample": 7, "fem": 10,
    "coupling": 20, "apps/scene": 30, "apps/library/grus": 31, "apps/run": 31, "apps/bvp/scene": 31, "apps/rve": 32,
    "apps/bvp": 32, "apps/python": 33
}
# Rooms of the package grus: its modules and sub-packages, "" its public names.
package = "apps/python/grus"
python_floor = {
    "_core": 0, "_version": 0, "errors": 0, "asked": 1, "curves": 1, "files": 1, "figures": 2, "frames": 2,
    "samples": 2, "bands": 3, "results": 4, "runs": 5, "rves": 5, "calibrate": 6, "report": 6, "study": 6,
    "commands": 6, "": 7, "export": 7, "watch": 7, "precice": 8, "__main__": 8
}
# Headers of the tree that a client reads at most who includes this one, itself among them.
few = {"dem/rves/rve_set.hpp": 5, "apps/library/grus/rves.hpp": 8}
both_catches = {"tests/catch.hpp", "tests/fem/main.cpp", "tests/tools/check_floors.py"}
faults = []


def room(path):
    folder = os.path.dirname(path)
    return folder if folder in floor else None


for top in ("dem", "fem", "coupling", "apps", "tests"):
    for folder, _, names in os.walk(os.path.join(root, top)):
        for name in names:
            path = os.path.relpath(os.path.join(folder, name), root)
            if not name.endswith((".hpp", ".cpp", ".py")) or "__pycache__" in path:
                continue
            text = open(os.path.join(root, path)).read()
            if text.count("\n") > 400:
                faults.append(f"{path}: {text.count(chr(10))} lines; 400 at most")
            if "SPDX-License-Identifier" not in text.split("\n\n")[0][:200]:
                faults.append(f"{path}: no SPDX line at its head")
            if path not in both_catches and re.search("<catch2/|Catch::Matchers::(Contains|StartsWith|EndsWith)", text):
                faults.append(f"{path}: Catch2 of one version alone; take tests/catch.hpp and Catch::Contains")
            mine = room(path)
            for target in re.findall(r'#include "([^"]+)"', text):
                if top == "tests":
                    continue
                theirs = room(f"apps/library/{target}" if target.startswith("grus/") else target)
                if theirs is None:
                    faults.append(f"{path}: includes {target}, which is in no room")
                elif theirs != mine and floor[theirs] > floor[mine]:
                    faults.append(f"{path}: includes {target}, which is above it")
                elif theirs != mine and floor[theirs] == floor[mine]:
                    faults.append(f"{path}: includes {target} of a room beside it")
                elif path.startswith("fem/") and target.startswith("dem/"):
                    faults.append(f"{path}: fem must not know dem")


for kind in ("apps/**/*.in", "apps/**/*.html", "apps/**/*.js", "cmake/*.*", "cmake/debian/p*", "*.toml", "bootstrap"):
    paths = glob.glob(os.path.join(root, kind), recursive=True)
    for path in paths or faults.append(f"no {kind}") or []:
        with open(path) as f:
            if "SPDX-License-Identifier" not in f.read(300):
                faults.append(f"{os.path.relpath(path, root)}: no SPDX line at its head")


def headers_of(path, found):
    """All headers of the tree that come with one."""
    if path not in found:
        found.add(path)
        with open(os.path.join(root, path)) as f:
            for target in re.findall(r'#include "([^"]+)"', f.read()):
                headers_of(f"apps/library/{target}" if target.startswith("grus/") else target, found)
    return found


for path, most in few.items():
    count = len(headers_of(path, set()))
    if count > most:
        faults.append(f"{path}: {count} headers come with it; {most} at most")


def python_file(folder, dotted):
    """The file of the tree that a module's name stands for, seen from a folder; None of what is from elsewhere."""
    for base in (folder, "apps/python"):
        path = os.path.join(base, *dotted.split("."))
        for file in (path + ".py", os.path.join(path, "__init__.py"), path + ".pyi"):
            if os.path.isfile(os.path.join(root, file)):
                return os.path.normpath(file)
    return None


def imported(path):
    """Files of the tree that a Python file imports, wherever in it."""
    folder = os.path.dirname(path)
    with open(os.path.join(root, path)) as f:
        tree = ast.parse(f.read())
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (python_file(folder, name.name) for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                faults.append(f"{path}: a relative import; name the package")
            else:
                for name in node.names:  # a module of a package, or a name in a module
                    yield python_file(folder, f"{node.module}.{name.name}") or python_file(folder, node.module)


def python_room(path):
    """Of a file of the package; None of others."""
    inside = os.path.relpath(path, package)
    return None if inside.startswith("..") else os.path.splitext(inside.split(os.sep)[0])[0].removesuffix("__init__")


def circle_from(path, imports, way, done):
    """A way of imports that comes back to where it was, or None."""
    if path in way:
        return way[way.index(path):] + [path]
    if path in done:
        return None
    done.add(path)
    ways = (circle_from(target, imports, way + [path], done) for target in sorted(imports.get(path, ())))
    return next(filter(None, ways), None)


imports = {}
for top in ("apps", "docs", "tests"):
    for folder, _, names in os.walk(os.path.join(root, top)):
        for path in (os.path.relpath(os.path.join(folder, name), root) for name in names if name.endswith(".py")):
            imports[path] = {target for target in imported(path) if target not in (None, path)}
for path, targets in sorted(imports.items()):
    mine = python_room(path)
    if mine is None:
        continue
    if mine not in python_floor:
        faults.append(f"{path}: in no room of the package")
        continue
    for target in sorted(targets):
        theirs = python_room(target)
        if theirs not in python_floor:
            faults.append(f"{path}: imports {target}, which is in no room of the package")
        elif theirs != mine and python_floor[theirs] > python_floor[mine]:
            faults.append(f"{path}: imports {target}, which is above it")
        elif theirs != mine and python_floor[theirs] == python_floor[mine]:
            faults.append(f"{path}: imports {target} of a room beside it")
done = set()
for path in sorted(imports):
    circle = circle_from(path, imports, [], done)
    if circle:
        faults.append("a circle of imports: " + " -> ".join(circle))
for f in faults:
    print(f)
print(f"floors: {len(faults)} faults")
sys.exit(1 if faults else 0)
