#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The site of documents builds, holds what it says, and can be searched; the programs have man pages: check_documents.py BUILD"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
faults = []


def need(holds, what):
    if not holds:
        faults.append(what)


for program in ("rve", "bvp", "report", "study", "calibrate"):
    path = os.path.join(build, "man", f"grus-{program}.1")
    if shutil.which("help2man") is None:
        break
    page = open(path).read() if os.path.exists(path) else ""
    need(".SH NAME" in page and "--help" in page.replace("\\", "") and len(page) > 500, f"no man page of grus-{program}")
with tempfile.TemporaryDirectory() as folder:
    if shutil.which("mkdocs") is None:
        print("documents: without mkdocs, the site was not built")
        sys.exit(1 if faults else 77)
    site = os.path.join(folder, "site")
    r = subprocess.run(["/usr/bin/python3", os.path.join(source, "docs", "make_site.py"), os.path.join(folder, "pages"), site], capture_output=True, text=True)
    need(r.returncode == 0, f"the site: exit {r.returncode} {r.stdout[-300:]} {r.stderr[-600:]}")
    if r.returncode == 0:
        read = lambda name: open(os.path.join(site, name)).read()
        rows = [line.split(" | ") for line in open(os.path.join(source, "apps", "scene", "keys.txt"))]
        page = read("keys.html")
        lacking = [k for k, kind, *_ in rows if kind not in ("table", "tables") and f"<code>{k.rpartition('.')[2]}</code>" not in page]
        need(lacking == [] and len(rows) > 300, f"the page of keys lacks {lacking}")
        need("rolling_friction" in page and "Coulomb" in page, "the page of keys has no meanings")
        need(all(name in read("gallery.html") for name in ("biaxial_plane_strain.toml", "sand_box.toml", "pile_tip.toml")), "scenes that the gallery lacks")
        need("advance(std::span" in re.sub(r"<[^>]+>|&lt;", lambda m: "<" if m[0] == "&lt;" else "", read("api_cpp.html")), "the C++ page has no RveSet")
        need("RveSet" in read("api_python.html") and "Raises InputError" in read("api_python.html"), "the Python page has no RveSet")
        found = {d["location"].partition("#")[0] for d in json.load(open(os.path.join(site, "search", "search_index.json")))["docs"] if "hoek" in (d["text"] + d["title"]).lower()}
        need({"keys.html", "tutorial.html"} <= found, f"a search for Hoek-Brown finds {sorted(found)}")
        pages = [f for f in os.listdir(site) if f.endswith(".html")]
        home = read("index.html")
        need(all(p in home for p in pages if p not in ("index.html", "404.html", "search.html")), "pages that are not one click from the first")
for fault in faults:
    print("FAULT", fault)
print(f"documents: {len(faults)} faults")
sys.exit(1 if faults else 0)
