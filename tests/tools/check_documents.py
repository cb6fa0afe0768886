#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The site of documents builds, holds what it says, and can be searched; the programs have man pages:
check_documents.py BUILD"""
import csv
import glob
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse
from html.parser import HTMLParser

import api_names

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
faults = []


def need(holds, what):
    if not holds:
        faults.append(what)


class Page(HTMLParser):
    """Texts of code blocks, anchors, and what a page asks for: links, and what a browser loads by itself."""

    def __init__(self, text):
        super().__init__()
        self.blocks, self.anchors, self.links, self.loads, self.depth = [], set(), [], [], 0
        self.loads += re.findall(r'"search": "([^"]+\.js)"', text)  # the worker that a search starts
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        a = dict(attributes)
        self.anchors.update(v for k, v in attributes if k in ("id", "name") and v)
        if tag == "pre":
            self.depth = 1
            self.blocks.append("")
        if tag == "a" and a.get("href"):
            self.links.append(a["href"])
        self.loads += [a[k] for k in ("src", "data-src") if a.get(k)]
        if tag == "link" and a.get("rel") in ("stylesheet", "icon", "shortcut icon", "preload",
                                              "modulepreload") and a.get("href"):
            self.loads.append(a["href"])

    def handle_endtag(self, tag):
        if tag == "pre":
            self.depth = 0

    def handle_data(self, data):
        if self.depth:
            self.blocks[-1] += data


def check_pages(sources, site):
    """Each fenced block of a page is a code block with the same text; links, anchors, scripts and pictures are there;
    nothing is loaded from elsewhere."""
    parsed = {}
    for path in glob.glob(os.path.join(site, "**", "*.html"), recursive=True):
        with open(path) as f:
            parsed[os.path.relpath(path, site)] = Page(f.read())
    blocks = 0
    for path in glob.glob(os.path.join(sources, "**", "*.md"), recursive=True):
        name = os.path.relpath(path, sources)
        page = parsed[re.sub("README.md$", "index.md", name)[:-3] + ".html"]
        with open(path) as f:
            text = f.read()
        shown = [b.strip("\n") for b in page.blocks]
        fenced = re.findall(r"^```.*\n([\s\S]*?)^```$", text, re.M)
        fences = len(re.findall(r"^ *(?:```|~~~)", text, re.M))
        need(2 * len(fenced) == fences, f"{name}: a fence that this test does not read")
        for block in fenced:
            blocks += 1
            need(block.strip("\n") in shown, f"{name}: a block is no code block with its text: {block[:60]!r}")
            if block.strip("\n") in shown:
                shown.remove(block.strip("\n"))  # each once
    for path in glob.glob(os.path.join(site, "**", "*.css"), recursive=True):
        with open(path) as f:
            for target in re.findall(r"url\(['\"]?([^)'\"]+)", f.read()):
                if not target.startswith(("data:", "#")):
                    found = os.path.join(os.path.dirname(path), target.partition("?")[0])
                    need("//" not in target and os.path.isfile(found),
                         f"{os.path.relpath(path, site)} asks for {target}")
    need(blocks > 60, f"only {blocks} fenced blocks were looked at")
    for name, page in parsed.items():
        for target in page.loads + page.links:
            if re.match(r"(mailto|javascript|data):", target):
                continue
            if re.match(r"(https?:)?//", target):
                need(target not in page.loads, f"{name} loads {target} from elsewhere")
                continue
            path, _, anchor = target.partition("#")
            path = urllib.parse.unquote(path.partition("?")[0])
            if name == "404.html":  # its links are from the site's root
                path = path.lstrip("/")
            found = os.path.normpath(os.path.join(os.path.dirname(name), path)) if path else name
            if os.path.isdir(os.path.join(site, found)):
                found = os.path.normpath(os.path.join(found, "index.html"))
            need(os.path.isfile(os.path.join(site, found)), f"{name}: {target} is not there")
            if anchor and found in parsed and not anchor.startswith("__"):
                need(urllib.parse.unquote(anchor) in parsed[found].anchors, f"{name}: {target}: no such place")


for program in ("", "-rve", "-bvp", "-report", "-study", "-calibrate"):
    path = os.path.join(build, "man", f"grus{program}.1")
    if shutil.which("help2man") is None:
        break
    page = open(path).read() if os.path.exists(path) else ""
    need(".SH NAME" in page and "--help" in page.replace("\\", "") and len(page) > 500,
         f"no man page of grus{program}")
with tempfile.TemporaryDirectory() as folder:
    if shutil.which("mkdocs") is None or shutil.which("doxygen") is None or "material" not in subprocess.run(
        ["/usr/bin/python3", "-c", "from mkdocs.utils import get_theme_names; print(*get_theme_names())"],
            capture_output=True, text=True).stdout.split():
        print(
            "documents: without mkdocs, its theme material and doxygen, no site (./bootstrap test installs them)")
        sys.exit(1 if faults else 77)
    site = os.path.join(folder, "site")
    r = subprocess.run(
        ["/usr/bin/python3",
         os.path.join(source, "docs", "make_site.py"),
         os.path.join(folder, "pages"), site], capture_output=True, text=True)
    need(r.returncode == 0, f"the site: exit {r.returncode} {r.stdout[-300:]} {r.stderr[-600:]}")
    if r.returncode == 0:
        read = lambda name: open(os.path.join(site, name)).read()
        rows = [line.split(" | ") for line in open(os.path.join(source, "apps", "scene", "keys.txt"))]
        page = read("keys.html")
        lacking = [
            k for k, kind, *_ in rows
            if kind not in ("table", "tables") and f"<code>{k.rpartition('.')[2]}</code>" not in page
        ]
        need(lacking == [] and len(rows) > 300, f"the page of keys lacks {lacking}")
        need("rolling_friction" in page and "Coulomb" in page, "the page of keys has no meanings")
        told = set(re.findall(r"\w+", open(os.path.join(source, "docs", "scenes.md")).read()))
        unsaid = [k for k, *_ in rows if not set(re.findall(r"\w+", k.rpartition(".")[2])) <= told]
        need(unsaid == [], f"docs/scenes.md does not name {unsaid}")
        shown, told = read("gallery.html"), {}
        with open(os.path.join(source, "docs", "gallery.csv"), newline="") as f:
            told = {row["scene"]: row for row in csv.DictReader(f)}
        for path in glob.glob(os.path.join(source, "apps", "scenes", "**", "*.toml"), recursive=True):
            name = os.path.relpath(path, os.path.join(source, "apps", "scenes"))[:-5]
            if name.startswith("new/"):
                continue
            need(f"apps/scenes/{name}.toml" in shown, f"the gallery lacks {name}")
            study = re.search(r"^\[(study|calibrate)\]", open(path).read(), re.M)
            need(study or name in told, f"docs/gallery.csv lacks {name} (cmake --build build --target gallery)")
            picture = told.get(name, {}).get("picture")
            need(not picture or os.path.exists(os.path.join(source, "docs", picture)), f"{name}: no {picture}")
        need(sum(bool(row["picture"]) for row in told.values()) > 20, "scenes without pictures")
        need(
            "advance(std::span" in re.sub(r"<[^>]+>|&lt;", lambda m: "<" if m[0] == "&lt;" else "",
                                          read("api_cpp.html")), "the C++ page has no RveSet")
        faults += api_names.cpp_faults(read("api_cpp.html"), source)
        if os.path.isdir(os.path.join(build, "python", "grus")):
            faults += api_names.python_faults(read("api_python.html"), os.path.join(build, "python"))
        found = {
            d["location"].partition("#")[0]
            for d in json.load(open(os.path.join(site, "search", "search_index.json")))["docs"]
            if "hoek" in (d["text"] + d["title"]).lower()
        }
        need({"keys.html", "tutorial.html"} <= found, f"a search for Hoek-Brown finds {sorted(found)}")
        check_pages(os.path.join(folder, "pages", "docs"), site)
        headings = re.findall(r"<h2[^>]*><code>(.*?)</code>", page)
        need(
            len(headings) == len(set(headings)) > 20,
            f"tables of keys that occur twice: {[h for h in headings if headings.count(h) > 1]}")
        for k in (r[0] for r in rows if r[1] not in ("table", "tables")):
            table, _, key = k.rpartition(".")
            name = html.escape(f"[[{table[:-2]}]]" if table.endswith("[]") else f"[{table}]" if table else "top level")
            part = page.partition(f"<code>{name}</code>")[2].partition("<h2")[0]
            need(
                part.count(f"<td><code>{key}</code></td>") == 1,
                f"the page of keys has {k} {part.count(f'<td><code>{key}</code></td>')} times in its table")
        pages = [f for f in os.listdir(site) if f.endswith(".html")]
        home = read("index.html")
        need(all(p in home for p in pages if p not in ("index.html", "404.html", "search.html")),
             "pages that are not one click from the first")
for fault in faults:
    print("FAULT", fault)
print(f"documents: {len(faults)} faults")
sys.exit(1 if faults else 0)
