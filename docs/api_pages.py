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


def functions(nodes, mark):
    text = []
    for node in nodes:
        doc = ast.get_docstring(node) if isinstance(node, (ast.FunctionDef, ast.ClassDef)) else None
        if doc is None or node.name.startswith("_"):
            continue
        name = signature(node) if isinstance(node, ast.FunctionDef) else node.name
        text += [f"{mark} `{name}`", "", "```text", doc, "```", ""]
        if isinstance(node, ast.ClassDef):
            text += functions(node.body, mark + "#")
    return text


def python(source):
    folder = os.path.join(source, "apps", "python", "grus")
    text = [
        "# Python", "",
        "From the docstrings; `python3 -m pydoc grus` shows the same. [How to get it](library.md#python).", "",
        "```text",
        ast.get_docstring(ast.parse(open(os.path.join(folder, "__init__.py")).read())), "```", ""
    ]
    for name in ("rves", "results", "runs/run"):
        tree = ast.parse(open(os.path.join(folder, name + ".py")).read())
        text += [f"## grus.{name.replace('/', '.')}", "",
                 ast.get_docstring(tree) or "", ""] + functions(tree.body, "###")
    return "\n".join(text)
