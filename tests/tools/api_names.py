# SPDX-License-Identifier: LGPL-3.0-or-later
"""Public names of both interfaces, found in another way than the pages are made, against those pages."""
import glob
import os
import re
import subprocess

# What Python itself says of the package: its names, their public members, and arguments that no docstring names.
LOOK = """
import grus, grus.precice, inspect
for name in [*grus.__all__, "precice.MicroSimulation"]:
    thing = grus.precice.MicroSimulation if "." in name else getattr(grus, name)
    print("name grus." + name)
    calls = [("grus." + name, thing, inspect.getdoc(thing))] if callable(thing) else []
    if inspect.isclass(thing) and not issubclass(thing, Exception):
        for key, value in vars(thing).items():
            if not key.startswith("_") and (callable(value) or isinstance(value, property)):
                print(f"name grus.{name}.{key}")
                calls += [(f"grus.{name}.{key}", value, inspect.getdoc(value))] * callable(value)
    for path, call, doc in calls:
        for argument in inspect.signature(call).parameters if "Args:" in (doc or "") else ():
            if argument != "self":
                print(f"argument {argument} of {path}", f"{argument}:" in doc)
"""


def python_faults(page, package):
    """`page`: HTML; `package`: where the built package is."""
    said = subprocess.run(["/usr/bin/python3", "-c", LOOK], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": package})
    if said.returncode != 0:
        return [f"the package is not read: {said.stderr[-300:]}"]
    lines = said.stdout.splitlines()
    names = [line.split()[1] for line in lines if line.startswith("name ")]
    faults = [f"the Python page has {name} {page.count(chr(34) + name + chr(34) + '>')} times" for name in names
              if page.count(f'id="{name}">') != 1]
    faults += [f"no docstring names the {line.rpartition(' ')[0]}" for line in lines if line.startswith("argument ")
               and line.endswith("False")]
    return faults + ([] if len(names) > 60 and "InputError" in page else [f"only {len(names)} names of Python"])


def declared(text):
    """Names that a header declares in its namespace: types, concepts, aliases, constants, functions."""
    space = re.search(r"^namespace (\S+) {", text, re.M)
    if space is None:
        return []
    text = re.sub(r"//.*", "", text[space.end():])
    depth, outer = 0, []  # what stands in no braces
    for char in text:
        depth -= char == "}"
        outer.append(char if depth == 0 else "")
        depth += char == "{"
    outer = "".join(outer)
    names = re.findall(r"^(?:struct|class|enum class|enum) (\w+)[^;{]*{", outer, re.M)
    names += re.findall(r"^(?:using|concept) (\w+) =|^concept (\w+)", outer, re.M)
    names = [name if isinstance(name, str) else name[0] or name[1] for name in names]
    names += re.findall(r"^(?:inline )?constexpr [\w:<> *]+?(\w+) = ", outer, re.M)
    other = "using|struct|class|enum|namespace|template|static_assert|concept|requires"
    before = rf"^(?:template <[^\n]*>\n|\[\[\w+\]\] )?(?!(?:{other})\b)"
    names += re.findall(before + r"[\w:<>,&* ]+?[&* ](\w+)\(", outer, re.M)
    return [f"{space[1]}::{name}" for name in dict.fromkeys(names)]


def cpp_faults(page, source):
    """Every name of the headers that grus/*.hpp bring, and of the others on the page, once."""
    shown = re.findall(r"<h3[^>]*><code>([\w./]+\.hpp)</code>", page)
    faults = [f"the C++ page has {path} {shown.count(path)} times" for path in set(shown) if shown.count(path) > 1]
    count = 0
    for path in glob.glob(os.path.join(source, "apps", "library", "grus", "*.hpp")):
        with open(path) as f:
            brought = re.findall(r'#include "(.*)"', f.read())
        lacking = {f"grus/{os.path.basename(path)}", *brought} - set(shown)
        faults += [f"the C++ page lacks {lacking}"] * bool(lacking)
    for header in shown:
        if header.startswith("grus/"):
            continue
        with open(os.path.join(source, header)) as f:
            names = declared(f.read())
        count += len(names)
        faults += [f"the C++ page has {name} of {header} {page.count(f'id={chr(34)}{name}{chr(34)}>')} times"
                   for name in names if page.count(f'id="{name}">') != 1]
    return faults + ([] if count > 200 else [f"only {count} names of C++"])
