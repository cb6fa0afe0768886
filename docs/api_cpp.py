# SPDX-License-Identifier: LGPL-3.0-or-later
"""The page of the C++ interface: every public name of the installed headers once, as doxygen reads their comments."""
import os
import re
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree

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
           ]),
           ("Errors, watches, threads, tensors", [
               "dem/base/error.hpp", "dem/base/watch.hpp", "dem/base/parallel.hpp", "dem/base/tensor.hpp"
           ])]

# A comment behind a declaration is of that declaration, but for one behind `struct Model;`, which says where it is.
SETTINGS = """OUTPUT_DIRECTORY = {out}
INPUT = {files}
INPUT_FILTER = "sed -E '/^(struct|class) /!s@([;,] +)// @\\1///< @'"
STRIP_FROM_PATH = {source}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
EXTRACT_ALL = YES
QUIET = YES
WARNINGS = NO
"""


def text_of(node):
    return "".join(node.itertext()) if node is not None else ""


def words_of(node):
    """A comment as Markdown; what stood in backticks does again."""
    if node is None:
        return ""
    out = []
    for part in node.iter():
        code = part.tag == "computeroutput"
        inside = "".join(part.itertext()) if code else part.text or ""
        if not code and part.tag in ("ref", "sp"):
            inside = part.text or " "
        out.append(f"`{inside}`" if code else plain(inside))
        out.append(plain(part.tail or "") if part is not node else "")
    return re.sub(r"\s+", " ", "".join(out)).strip()


def plain(text):
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("|", "&#124;")
    return re.sub(r"([*_\[])", r"\\\1", text)


def told(member):
    return " ".join(filter(None, (words_of(member.find("briefdescription")),
                                  words_of(member.find("detaileddescription")))))


def tidy(code):
    """Doxygen's spaces as clang-format has them."""
    code = re.sub(r"< ", "<", re.sub(r" >", ">", re.sub(r"\s+", " ", code)))
    code = re.sub(r" ([&*]+) ?(?=[\w.),]|$)", r"\1 ", code).replace("& )", "&)").rstrip()
    return re.sub(r"(?<=\w)=(?=[\w\"{-])", " = ", code)


def wrapped(code, width=100):
    """Lines of at most that many characters, broken after commas."""
    lines = [""]
    for part in re.split(r"(?<=,) ", code):
        if lines[-1] and len(lines[-1]) + len(part) + 1 > width:
            lines.append("    " + part)
        else:
            lines[-1] += (" " if lines[-1] else "") + part
    return "\n".join(lines)


def template(node):
    listed = node.find("templateparamlist")
    if listed is None:
        return ""
    return "template <" + ", ".join(tidy(" ".join(filter(None, (text_of(p.find("type")), p.findtext("declname"))))) +
                                    (f" = {text_of(p.find('defval'))}" if p.find("defval") is not None else "")
                                    for p in listed) + ">\n"


def declared(member, owner):
    """A function, an alias, an enumeration or a constant as it is declared."""
    kind, name = member.get("kind"), member.findtext("name")
    if kind == "enum":
        scoped = "enum class" if member.get("strong") == "yes" else "enum"
        return f"{scoped} {name} {{ " + ", ".join(v.findtext("name") for v in member.iter("enumvalue")) + " }"
    head = tidy(member.findtext("definition").replace(owner + "::", "") + (member.findtext("argsstring") or ""))
    start = (member.findtext("initializer") or "").strip()
    return template(member) + wrapped(head.replace("grus::dem::", "").replace("grus::fem::", "") +
                                      (f" {start}" if start and kind == "variable" else ""))


def public(compound, kinds):
    """Members in the order of the source, without what takes away and moves."""
    found = [m for m in compound.iter("memberdef") if m.get("prot") == "public" and m.get("kind") in kinds
             and not re.match("~|operator=$", m.findtext("name"))]
    place = lambda m: m.find("location").attrib
    return sorted(found, key=lambda m: (place(m)["file"], int(place(m)["line"]), int(place(m)["column"])))


def grouped(members, lines):
    """A member without a comment right below another goes with it: the comment is of both."""
    groups, last = [], 0
    for m in members:
        at = int(m.find("location").get("line"))
        if groups and not told(m) and all(line.strip() for line in lines[last - 1:at]):
            groups[-1].append(m)
        else:
            groups.append([m])
        last = at
    return groups


def fields(compound):
    """Table of what a structure holds: those of one line together."""
    rows, lines = [], {}
    for m in public(compound, {"variable"}):
        lines.setdefault(m.find("location").get("line"), []).append(m)
    for held in lines.values():
        starts = [(m.findtext("initializer") or "").strip().lstrip("=").strip() for m in held]
        names = ", ".join(f"`{m.findtext('name')}`" for m in held)
        shown = ", ".join(dict.fromkeys(f"`{s}`" for s in starts if s))
        kind = tidy(text_of(held[0].find("type")))
        rows.append(f"| {names} | `{kind}` | {shown} | {' '.join(filter(None, map(told, held)))} |")
    return ["| holds | kind | default | is |", "|---|---|---|---|", *rows, ""] if rows else []


def structure(compound, lines):
    name = compound.findtext("compoundname")
    short = re.sub(r"^grus::\w+::", "", name)
    head = f"```cpp\n{template(compound)}{compound.get('kind')} {short}\n```"
    out = [f'#### <a id="{name}"></a>`{short}`', "", head, "", told(compound), "", *fields(compound)]
    for group in grouped(public(compound, {"function", "typedef", "enum"}), lines):
        out += ["```cpp", *(declared(m, name) for m in group), "```", "", " ".join(filter(None, map(told, group))), ""]
    return out


def concept(compound):
    name = compound.findtext("compoundname")
    short = re.sub(r"^grus::\w+::", "", name)
    code = re.sub(r"[ \t]+$", "", text_of(compound.find("initializer")).replace(name, short), flags=re.M)
    return [f'#### <a id="{name}"></a>`{short}`', "", f"```cpp\n{code}\n```", "", told(compound), ""]


def by_name(members):
    """Overloads of a function are one entry."""
    groups = {}
    for m in members:
        groups.setdefault(m.findtext("name"), []).append(m)
    return groups.values()


def free(group, space, above):
    """Functions of one name, an alias, a constant or an enumeration of a namespace. `above`: the name right above it,
    whose comment is of both where it has none."""
    name, words = group[0].findtext("name"), " ".join(filter(None, map(told, group)))
    if not words and above:
        words = f"Told with [`{above}`](#{space}::{above})."
    return [f'#### <a id="{space}::{name}"></a>`{name}`', "", "```cpp", *(declared(m, space) for m in group), "```", "",
            words, ""]


def read(source, headers):
    """header -> [(line, Markdown)] of all that it declares."""
    with tempfile.TemporaryDirectory() as out:
        files = " ".join(os.path.join(source, path) for path in headers)
        subprocess.run(["doxygen", "-"], input=SETTINGS.format(out=out, files=files, source=source), text=True,
                       check=True, cwd=source)
        folder, found = os.path.join(out, "xml"), {path: [] for path in headers}
        lines = {path: open(os.path.join(source, path)).read().splitlines() for path in headers}
        for file in sorted(os.listdir(folder)):
            if not file.endswith(".xml") or file in ("index.xml", "Doxyfile.xml"):
                continue
            for compound in ElementTree.parse(os.path.join(folder, file)).iter("compounddef"):
                kind, where = compound.get("kind"), compound.find("location")
                if kind == "namespace":
                    space = compound.findtext("compoundname")
                    above, last, before = "", 0, ""
                    for group in by_name(public(compound, {"function", "typedef", "enum", "variable"})):
                        at = group[0].find("location")
                        file, line = at.get("file"), int(at.get("line"))
                        if any(map(told, group)):
                            above = group[0].findtext("name")
                        elif file != before or not all(text.strip() for text in lines[file][last - 1:line]):
                            above = ""
                        before, last = file, line
                        own = "" if above == group[0].findtext("name") else above
                        found[file].append((line, free(group, space, own)))
                elif kind in ("class", "struct", "concept") and compound.get("prot", "public") == "public":
                    made = concept(compound) if kind == "concept" else structure(compound, lines[where.get("file")])
                    found[where.get("file")].append((int(where.get("line")), made))
    return found


def about(path):
    """What a header says of itself."""
    with open(path) as f:
        lines = f.read().splitlines()[1:]
    end = next(k for k, line in enumerate(lines) if not line.startswith("//"))
    return plain(" ".join(line.lstrip("/ ") for line in lines[:end]))


def page(source):
    out = ["# C++", "", "Every public name of the installed headers, from their own comments; [how to link "
           "them](library.md#c). SI units; stress tension-positive, Voigt order xx yy zz yz xz xy with engineering "
           "shear. Names are in `grus::dem`, `grus::app`, `grus::fem` and `grus::coupling`, by their folder.", ""]
    found = read(source, [path for _, paths in HEADERS for path in paths if not path.startswith("apps/library")])
    for title, paths in HEADERS:
        out += [f"## {title}", ""]
        for path in paths:
            short = path.removeprefix("apps/library/")
            out += [f"### `{short}`", "", about(os.path.join(source, path)), ""]
            if short != path:
                with open(os.path.join(source, path)) as f:
                    out += ["```cpp", *re.findall(r"^#include .*", f.read(), re.M), "```", ""]
            for _, made in sorted(found.get(path, []), key=lambda item: item[0]):
                out += made
    return "\n".join(out)
