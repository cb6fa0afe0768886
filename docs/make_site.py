#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The documents as a site that can be searched: make_site.py BUILD OUT (cmake --build build --target docs)

README and docs/ as they are, a page of all keys from apps/scene/keys.txt (the table that the reader of scenes holds
itself to), a gallery of the shipped scenes, the interfaces from their own comments. Needs mkdocs, its theme material
and doxygen.
"""
import csv
import glob
import json
import math
import os
import re
import shutil
import subprocess
import sys

import api_cpp
import api_python

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
NAV = [("Start", [("Grus", "index.md"), ("What it does", "features.md"), ("Coming from other programs", "coming.md"),
                  ("Shipped scenes", "shipped.md"), ("Gallery", "gallery.md"), ("Glossary", "glossary.md")]),
       ("Tutorials", [("From a sieve curve to a pile", "tutorial.md"),
                      ("A rock, from cells to strength", "tutorial_rock.md"),
                      ("Grains in a DOLFINx program", "tutorial_dolfinx.md")]),
       ("How to", [("Install", "howto/install.md"), ("It stops with …", "howto/stops.md"),
                   ("Choose parameters", "howto/parameters.md"), ("Test in stages", "stages.md"),
                   ("Walls that move and press", "walls.md"), ("Bond spheres", "bonded_spheres.md"),
                   ("From data to a calibrated scene", "howto/data_to_scene.md"),
                   ("Packings of other programs", "howto/from_other_programs.md"),
                   ("Calibrate", "calibration.md"), ("Run on a cluster", "cluster.md"),
                   ("Use it from Python and C++", "library.md"), ("Extend it", "extending.md"),
                   ("Published problems", [(name.replace("_", " "), f"problems/{name}.md")
                                           for name in ("biaxial_plane_strain", "oedometer_block", "pile_tip",
                                                        "shpb_bars", "strip_footing", "triaxial", "triaxial_block")])]),
       ("Reference", [("The command grus", "commands.md"), ("Scenes", "scenes.md"), ("All keys", "keys.md"),
                     ("Results", "results.md"),
                      ("All columns", "columns.md"), ("All keys of summary.json", "summary_keys.md"),
                      ("C++", "api_cpp.md"), ("Python", "api_python.md")]),
       ("Explanation", [("Physics", "physics.md"), ("Macro problems", "macro.md"), ("Fracture", "physics/fracture.md"),
                        ("Fourteen balls", "physics/fourteen.md"), ("Peridynamics", "physics/peridynamics.md"),
                        ("Grains that attract", "physics/jkr.md"), ("Inertia", "physics/inertia.md"),
                        ("Implicit steps", "physics/implicit.md"),
                        ("Bonded polyhedra", "bonded.md"), ("Cleavage", "cleavage.md"),
                        ("Architecture", "architecture.md"), ("What is deliberate", "deliberate.md")]),
       ("Evidence", [("Verification", "verification.md"), ("Zhang et al. (2015)", "validation/zhang2015.md"),
                     ("Ciantia et al. (2015)", "validation/ciantia2015.md"),
                     ("Galindo-Torres et al. (2012)", "validation/galindo2012.md"),
                     ("Saleme Ruiz (2016)", "validation/saleme2016.md"),
                     ("Zhu & Zhao (2019)", "validation/zhu2019.md"),
                     ("Extreme cases", "stability.md"), ("Error against run time", "studies/README.md"),
                     ("Benchmarks", "benchmarks.md")])]


def with_links(text, page, at):
    """Links of a page that was `page` below the source and is now `at` below the site: to pages as they lie there; to
    what is no page, the text alone."""
    def link(match):
        mark, words, target = match.groups()
        path, hash_sign, part = target.partition("#")
        if re.match(r"\w+:", target) or not path:
            return match.group(0)
        found = os.path.normpath(os.path.join(os.path.dirname(page), path))
        if found == "README.md":
            found = "docs/index.md"
        if not found.startswith("docs/") or not (found == "docs/index.md"
                                                 or os.path.isfile(os.path.join(source, found))) or not found.endswith(
                                                     (".md", ".png")):
            return words if not mark else ""
        return f"{mark}[{words}]({os.path.relpath(found[5:], os.path.dirname(at) or '.')}{hash_sign}{part})"
    return re.sub(r"(!?)\[([^\]\n]*)\]\(([^)\s]+)\)", link, text)


MADE = {"All keys": "keys.md", "All columns": "columns.md", "All keys of summary.json": "summary_keys.md",
        "All names of Python": "api_python.md", "All names of C++": "api_cpp.md"}


def with_made(text, at):
    """Names of pages that are made here, set in italics where the sources cannot link to them, become links."""
    def link(match):
        page = MADE.get(match[1])
        return f"[{match[1]}]({os.path.relpath(page, os.path.dirname(at) or '.')})" if page else match[0]
    return re.sub(r"\*(All [\w. +]+)\*", link, text)


def keys():
    """Tables of keys, one for each table of a scene, each once."""
    text = [
        "# All keys", "",
        "This page is made from the table that the reader of scenes holds every key against which it reads. "
        "`grus-rve --keys [TEXT]` prints the same; `--schema` is for editors. "
        "A number is SI; a text may carry a unit (`\"60 GPa\"`, `\"300 µm\"`, `\"10 ksi\"`).", ""
    ]
    cell = lambda fact: fact.lstrip("~").replace("|", ", ").replace("<", "&lt;")
    with open(os.path.join(source, "apps", "scene", "keys.txt")) as f:
        rows = [line.rstrip("\n").split(" | ") for line in f]
    heads, tables = {}, {}
    for path, kind, unit, limits, fallback, words, example, meaning in rows:
        if kind in ("table", "tables"):
            heads[path.removesuffix("[]")] = meaning
            continue
        table, _, key = path.rpartition(".")
        if unit == "angle":
            limits = re.sub(r"\d[\d.]*", lambda rad: f"{math.degrees(float(rad[0])):.3g}°", limits)
        kind = cell(words) if words else kind + (f" ({unit})" if unit not in ("", "number") else "")
        shown = f"`{example.replace('|', ' ')}`" if example else ""
        tables.setdefault(
            table, []).append(f"| `{key}` | {cell(meaning)} | {kind} | {cell(limits)} | {cell(fallback)} | {shown} |")
    for table in sorted(tables):
        name = f"[[{table[:-2]}]]" if table.endswith("[]") else f"[{table}]" if table else "top level"
        text += ["", f"## `{name}`", "", heads.get(table.removesuffix("[]"), ""), "",
                 "| key | meaning | kind | range | default | example |", "|---|---|---|---|---|---|", *tables[table]]
    return "\n".join(text) + "\n"


def columns():
    """Tables of the columns of history.csv, one for each condition under which they are there."""
    text = ["# Columns of history.csv", "", "By what asks for them; this page is made from the tables that write them. "
            "`--columns` prints those of a scene, in their order. More is told of them with the [results](results.md)."]
    tables = (("grus-rve", "rve/columns.cpp"), ("grus-bvp", "bvp/columns.cpp"),
              ("grus-bvp, after probe_NAME_", "bvp/probe_columns.cpp"))
    for heading, table in tables:
        with open(os.path.join(source, "apps", table)) as f:
            code = f.read()
        told = {name: phrase for phrase, name in re.findall(r"^/// (.*)\.\nbool (\w+)\(", code, re.M)}
        rows = re.findall(r'\{"([^"]+)",\s*"([^"]*)",\s*((?:"[^"]*"\s*)+),\s*(\w+),', code)
        if len(rows) != len(re.findall(r'^    \{"', code, re.M)):
            sys.exit(f"make_site: a row of apps/{table} is not read")
        text += ["", f"## {heading}"]
        for when in dict.fromkeys(row[3] for row in rows):
            text += ["", f"### {told[when]}", "", "| column | unit | is |", "|---|---|---|"]
            for name, unit, doc, _ in (row for row in rows if row[3] == when):
                families = {"{}_N": "wall0_fx_N, wall0_fy_N, …", "{}": "g0_x_m, g0_y_m, …"}
                shown = families.get(name, name.replace("{}", "*"))
                meaning = "".join(re.findall(r'"([^"]*)"', doc))
                text.append(f"| `{shown}` | {unit} | {meaning} |")
    return "\n".join(text) + "\n"


def summary_keys():
    """Tables of the keys of summary.json, by program."""
    text = ["# Keys of summary.json", "", "Those of which there is something to tell are there. This page is made from "
            "the table that the tests hold every run against, and `grus-study --check` every quantity; `*` stands for "
            "all that is below. More is told of them with the [results](results.md)."]
    with open(os.path.join(source, "apps", "python", "grus", "files", "summary_keys.txt")) as f:
        rows = [[part.strip() for part in line.split("|")] for line in f]
    for program, head in (("both", "Of both programs"), ("rve", "grus-rve"), ("bvp", "grus-bvp")):
        text += ["", f"## {head}", "", "| key | unit | is |", "|---|---|---|"]
        text += [f"| `{path}` | {unit} | {meaning} |" for of, path, unit, meaning in rows if of == program]
    return "\n".join(text) + "\n"


def with_titles(text):
    """Fences that name a file, as Python-Markdown takes them."""
    return re.sub(r"^```(\w+) ([\w./-]+)$", r'```\1 title="\2"', text, flags=re.M)


def pages_of(entries):
    """Each page below a list of the navigation."""
    for _, page in entries:
        yield from [page] if isinstance(page, str) else pages_of(page)


def as_nav(entries):
    return [{title: page if isinstance(page, str) else as_nav(page)} for title, page in entries]


def time_told(row):
    """How long a scene takes, as far as gallery.csv knows."""
    if row is None:
        return "Its time is not known."
    if row["cpu_s"]:
        return f"It takes {row['cpu_s']} s of one core (AMD EPYC, in the cloud)."
    if row["ending"].endswith(".md"):
        return f"[Its page]({row['ending']}) tells what it takes and shows."
    if row["ending"] == "not begun":
        return "Its sample takes longer to make than the gallery waits."
    return f"It goes on for longer than the gallery waits: the picture is at {row['ending']}."


def gallery():
    text = ["# Gallery", "", "Each shipped scene: what it is and what to look at, its command, what it takes, and its "
            "picture. `docs/gallery.py` runs them and draws the pictures. Studies are at the end.", ""]
    with open(os.path.join(source, "docs", "gallery.csv"), newline="") as f:
        rows = {row["scene"]: row for row in csv.DictReader(f)}
    studies = []
    for path in sorted(glob.glob(os.path.join(source, "apps", "scenes", "**", "*.toml"), recursive=True)):
        name = os.path.relpath(path, os.path.join(source, "apps", "scenes"))[:-5]
        if name.startswith("new/"):
            continue
        scene = open(path).read()
        title = re.search(r'^title = "(.*)"', scene, re.M)
        title = title[1] if title else name
        tables = set(re.findall(r"^\[(\w+)\]", scene, re.M))
        if tables & {"study", "calibrate"}:
            program = "grus-calibrate" if "calibrate" in tables else "grus-study"
            studies.append(f"| {title} | `{program} apps/scenes/{name}.toml` |")
            continue
        head = " ".join(line.lstrip("# ") for line in scene.split("\n\n")[0].splitlines() if line.startswith("#"))
        program, row = "grus-bvp" if "mesh" in tables else "grus-rve", rows.get(name)
        shown = f"![{title}]({row['picture']})" if row and row["picture"] else "*There is no picture of it.*"
        text += [f"## {title}", "", head, "", f"```sh\n{program} apps/scenes/{name}.toml\n```", "", time_told(row), "",
                 shown, "", f"<details markdown=\"1\"><summary>{name}.toml</summary>\n\n```toml\n{scene}```\n\n"
                 "</details>", ""]
    text += ["## Studies and calibrations", "", "Sets of runs; each draws its own plots and report.", "",
             "| what | command |", "|---|---|", *studies]
    return "\n".join(text) + "\n"


def main(build, out):
    if not (shutil.which("mkdocs") and shutil.which("doxygen")):
        sys.exit("docs: needs mkdocs, its theme material, and doxygen (Debian: mkdocs, mkdocs-material, doxygen)")
    os.makedirs(build, exist_ok=True)
    pages = os.path.join(build, "docs")
    shutil.rmtree(pages, ignore_errors=True)
    left_out = shutil.ignore_patterns("*.py", "gallery.csv", "__pycache__")
    shutil.copytree(os.path.join(source, "docs"), pages, ignore=left_out)
    for path in glob.glob(os.path.join(pages, "**", "*.md"), recursive=True):
        at = os.path.relpath(path, pages)
        text = with_made(with_titles(with_links(open(path).read(), "docs/" + at, at)), at)
        open(path, "w").write(text)
    for name, text in (
            ("index.md", with_links(open(os.path.join(source, "README.md")).read(), "README.md", "index.md")),
            ("keys.md", keys()), ("columns.md", columns()), ("summary_keys.md", summary_keys()),
            ("gallery.md", gallery()),
            ("api_cpp.md", api_cpp.page(source)),
            ("api_python.md", api_python.page(source))):
        open(os.path.join(pages, name), "w").write(text)
    asked = list(pages_of(NAV))
    made = {os.path.relpath(path, pages) for path in glob.glob(os.path.join(pages, "**", "*.md"), recursive=True)}
    if set(asked) != made or len(asked) != len(made):
        sys.exit(f"docs: pages that the navigation has twice or lacks, or that are not there: {set(asked) ^ made}")
    theme = {"name": "material", "font": False, "features": ["navigation.tabs", "navigation.top", "search.highlight"]}
    highlight = {"pymdownx.highlight": {"use_pygments": True, "pygments_lang_class": True}}
    extensions = ["tables", "md_in_html", "toc", highlight, "pymdownx.superfences"]
    config = {
        "site_name": "Grus", "docs_dir": pages, "site_dir": os.path.abspath(out), "theme": theme,
        "use_directory_urls": False, "extra_css": ["site.css"], "plugins": ["search"],
        "markdown_extensions": extensions, "nav": as_nav(NAV)
    }
    path = os.path.join(build, "mkdocs.yml")
    with open(path, "w") as f:
        json.dump(config, f)  # JSON is YAML
    r = subprocess.run(["mkdocs", "build", "--quiet", "--strict", "-f", path])
    if r.returncode == 0:
        print(f"docs: {out}/index.html (search needs a server: python3 -m http.server -d {out})")
    return r.returncode


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1]), sys.argv[2]))
