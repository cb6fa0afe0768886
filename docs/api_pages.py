# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pages of the C++ and Python interfaces, from the headers' comments and the docstrings."""
import ast
import os
import re

# What other programs include, from the user's side inwards.
HEADERS = [("Cells from scene files",
            ["apps/library/grus/rves.hpp", "apps/scene/open_rves.hpp", "apps/library/grus/scene.hpp",
             "apps/scene/unit_cells.hpp", "apps/scene/prepare_sample.hpp"]),
           ("Cells as a material", [
               "apps/library/grus/rve.hpp", "dem/rves/rve_set.hpp", "dem/rves/driver_options.hpp",
               "dem/rve/response.hpp", "dem/rves/host.hpp", "dem/rve/rve.hpp", "dem/rve/loading.hpp",
               "dem/rve/measure.hpp"
           ]),
           ("Samples of your own", [
               "apps/library/grus/sample.hpp", "dem/sample/recipe.hpp", "dem/sample/make.hpp", "dem/sample/prepare.hpp",
               "dem/sample/programme.hpp", "dem/sample/gauge.hpp", "dem/sample/network.hpp",
               "dem/rve/model.hpp", "dem/rve/state.hpp", "dem/rve/step.hpp", "dem/packing/packing.hpp",
               "dem/contact/laws.hpp", "dem/fracture/fracture_model.hpp", "dem/fracture/criteria.hpp"
           ]),
           ("Finite elements", [
               "fem/material.hpp", "fem/mesh.hpp", "fem/problem.hpp", "fem/statics.hpp", "fem/dynamics.hpp",
               "fem/explicit_statics.hpp"
           ]),
           ("Both together", [
               "coupling/rve_farm.hpp", "coupling/rve_material.hpp", "dem/rves/driver.hpp", "dem/rves/driver_book.hpp",
               "dem/rves/deferral.hpp", "dem/rves/sharing.hpp", "dem/rves/tangents.hpp"
           ])]


def header(text):
    """(what it is for, what it declares): without includes and what is private."""
    lines = text.splitlines()
    about = []
    for line in lines[1:]:
        if not line.startswith("//"):
            break
        about.append(line.lstrip("/ "))
    kept, hidden = [], False
    for line in lines[1 + len(about):]:
        if re.match(r"#(pragma|include|define|undef)|(inline )?namespace |}  // namespace", line):
            continue
        hidden = (hidden or line == "private:") and not line.startswith("}")
        if not hidden:
            kept.append(line)
    return " ".join(about), re.sub(r"\n{3,}", "\n\n", "\n".join(kept)).strip("\n")


def cpp(source):
    text = [
        "# C++", "",
        "Installed headers, from their own comments; [how to link them](library.md). SI units; stress "
        "tension-positive, Voigt order xx yy zz yz xz xy with engineering shear.",
        ""
    ]
    for title, paths in HEADERS:
        text += [f"## {title}", ""]
        for path in paths:
            about, body = header(open(os.path.join(source, path)).read())
            text += [f"### `{path.removeprefix('apps/library/')}`", "", about, ""]
            if body:
                text += ["```cpp", body, "```", ""]
    return "\n".join(text)


def signature(node):
    call = ast.unparse(node.args)
    return f"{node.name}({re.sub('^self(, )?', '', call)})" + (f" -> {ast.unparse(node.returns)}"
                                                               if node.returns else "")


def fields(node):
    """What a data class holds, with defaults, as it stands in the source."""
    return [ast.unparse(f) for f in node.body if isinstance(f, ast.AnnAssign) and not f.target.id.startswith("_")]


def functions(nodes, mark, asked=None):
    """Those with docstrings that are not private; or those with the names that are asked for."""
    text = []
    for node in nodes:
        if not isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            continue
        doc = ast.get_docstring(node)
        if (node.name not in asked) if asked else (doc is None or node.name.startswith("_")):
            continue
        name = signature(node) if isinstance(node, ast.FunctionDef) else node.name
        text += [f"{mark} `{name}`", ""] + (["```text", doc, "```", ""] if doc else [])
        if isinstance(node, ast.ClassDef):
            held = fields(node)
            text += ["```python", *held, "```", ""] if held else []
            text += functions(node.body, mark + "#")
    return text


def python(source):
    """What `import grus` gives, module by module, as its __init__ names them."""
    folder = os.path.join(source, "apps", "python", "grus")

    def parsed(*path):
        with open(os.path.join(folder, *path)) as f:
            return ast.parse(f.read())

    top = parsed("__init__.py")
    text = [
        "# Python", "",
        "From the docstrings; `python3 -m pydoc grus` shows the same. [How to get it](library.md#python).", "",
        "```text",
        ast.get_docstring(top), "```", ""
    ]
    for node in ast.walk(top):
        if isinstance(node, ast.ImportFrom) and re.match(r"grus\.[a-z]", node.module or ""):
            *rooms, module = node.module.split(".")[1:]
            tree = parsed(*rooms, module + ".py")
            names = {alias.name for alias in node.names}
            text += [f"## {node.module}", "", ast.get_docstring(tree) or "", ""] + functions(tree.body, "###", names)
    return "\n".join(text)
