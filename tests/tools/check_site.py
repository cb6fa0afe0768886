#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The site as a reader has it, in Chromium: check_site.py [SITE]

Each page: no error in the console, no request that leaves the machine or finds nothing, code blocks with the text of
their sources and a button that copies, links and places that are there, no wider than a phone. Search finds ten words,
an address that is not there shows the page 404. Without SITE it is built first."""
import csv
import functools
import glob
import http.server
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import urllib.parse

import browser

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
faults = []
WORDS = {"sieve": "tutorial.html", "hoek": "keys.html", "oedometer": "problems/oedometer_block.html",
         "checkpoint": "cluster.html", "peridynamics": "physics/peridynamics.html", "preCICE": "library.html",
         "Yade": "coming.html", "Galindo": "validation/galindo2012.html", "unbalanced": "columns.html",
         "footing": "problems/strip_footing.html"}
BUTTONS = """(async () => {  // the theme gives a block its button when it comes into view
  for (const block of document.querySelectorAll('pre')) {
    block.scrollIntoView({block: 'center'});
    const lacks = () => !block.querySelector('button.md-clipboard');
    for (let n = 0; n < 50 && lacks(); ++n) await new Promise(f => setTimeout(f, 20));
  }
  return document.querySelectorAll('pre > button.md-clipboard').length; })()"""
FACTS = """(() => ({
  blocks: [...document.querySelectorAll('pre > code')].map(c => c.textContent),
  links: [...document.querySelectorAll('a[href]')].map(a => a.href),
  places: [...document.querySelectorAll('[id], a[name]')].map(e => e.id || e.name),
  pictures: [...document.images].filter(i => !i.complete || i.naturalWidth == 0).map(i => i.src),
  title: document.title}))()"""
SEARCH = """new Promise(done => {
  const input = document.querySelector('.md-search__input');
  document.querySelector('#__search').checked = true;
  input.focus(); input.value = %s;
  input.dispatchEvent(new Event('input', {bubbles: true})); input.dispatchEvent(new Event('keyup', {bubbles: true}));
  let n = 0;
  const look = () => {
    const links = [...document.querySelectorAll('a.md-search-result__link')].map(a => a.href);
    const hits = links.filter(a => a.includes(%s));
    if (hits.length || ++n > 300) done(links); else setTimeout(look, 50);
  };
  look(); })"""
INDEXED = """new Promise(done => {  // the worker that searches tells that it is ready
  let n = 0;
  document.querySelector('#__search').checked = true;
  const look = () => {
    const said = document.querySelector('.md-search-result__meta').textContent;
    if (/type to start/i.test(said) || ++n > 600) done(said); else setTimeout(look, 50);
  };
  look(); })"""
COPY = """new Promise(done => {
  document.querySelector('pre > button.md-clipboard').click();
  setTimeout(() => navigator.clipboard.readText().then(done, e => done(String(e))), 100); })"""


def need(holds, what):
    if not holds:
        faults.append(what)


class Server(http.server.SimpleHTTPRequestHandler):
    """As a host of pages does it: what is not there is answered with 404.html. The index of words, which every page
    builds anew in a second or so, is empty until a search is tried."""
    words = False

    def do_GET(self):
        if self.path.endswith("/search_index.json") and not Server.words:
            with open(os.path.join(self.directory, "search", "search_index.json")) as f:
                return self.answer(200, "application/json", json.dumps({**json.load(f), "docs": []}).encode())
        super().do_GET()

    def send_error(self, code, message=None, explain=None):
        with open(os.path.join(self.directory, "404.html"), "rb") as f:
            self.answer(code, "text/html", f.read())

    def answer(self, code, kind, body):
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


def fences():
    """Texts of the fenced blocks by page of the site."""
    found = {}
    for path in [f"{source}/README.md", *glob.glob(f"{source}/docs/**/*.md", recursive=True)]:
        name = os.path.relpath(path, f"{source}/docs")
        name = "index.html" if name == "../README.md" else re.sub("README.md$", "index.md", name)[:-3] + ".html"
        with open(path) as f:
            found[name] = [b.strip("\n") for b in re.findall(r"^```.*\n([\s\S]*?)^```$", f.read(), re.M)]
    with open(f"{source}/docs/gallery.csv", newline="") as f:
        scenes = [f"{source}/apps/scenes/{row['scene']}.toml" for row in csv.DictReader(f)]
    found["gallery.html"] = [open(path).read().strip("\n") for path in scenes]
    return found


def quiet(b, base, name):
    """What the page has asked for and said, since this was asked last."""
    for url in b.requests:
        need(url.startswith((base, "data:", "blob:" + base, "about:blank")), f"{name} asks for {url}")
    for url, status in b.statuses.items():
        need(status < 400 or url.endswith("/nowhere/at_all.html"), f"{name}: {url} is answered with {status}")
    for text in b.errors:
        need("nowhere/at_all" in text, f"{name}: console: {text[:200]}")
    b.requests, b.statuses, b.errors = [], {}, []


def look(b, base, site):
    sources, facts = fences(), {}
    for path in sorted(glob.glob(os.path.join(site, "**", "*.html"), recursive=True)):
        name = os.path.relpath(path, site)
        b.width(1200)
        b.open(base + name)
        facts[name] = page = b.ask(FACTS)
        quiet(b, base, name)
        need(page["pictures"] == [], f"{name}: pictures that do not show: {page['pictures']}")
        shown = [block.strip("\n") for block in page["blocks"]]
        for block in sources.get(name, []):
            need(block in shown, f"{name}: no block has the text of its source: {block[:60]!r}")
        b.width(390, phone=True)
        wide = b.ask("document.documentElement.scrollWidth")
        need(wide <= 390, f"{name} is {wide} pixels wide on a phone of 390")
    need(len(facts) > 40 and sum(len(p["blocks"]) for p in facts.values()) > 90, f"only {len(facts)} pages")
    lacking = {n for n, blocks in sources.items() if blocks and n not in facts}
    need(not lacking, f"pages that the site lacks: {lacking}")
    for name, page in facts.items():
        for url in set(page["links"]):
            if not url.startswith(base):
                need(url.startswith(("https://", "mailto:")), f"{name}: a link to {url}")
                continue
            target, _, place = url[len(base):].partition("#")
            target = urllib.parse.unquote(target) or "index.html"
            target = target + "index.html" if target.endswith("/") else target
            need(os.path.isfile(os.path.join(site, target)), f"{name}: {target} is not there")
            place = urllib.parse.unquote(place)
            need(not place or target not in facts or place in facts[target]["places"],
                 f"{name}: {target} has no place {place}")
    return len(facts)


def search(b, base):
    Server.words = True
    b.width(1200)
    b.call("Network.clearBrowserCache")
    b.open(base + "index.html")
    b.ask(INDEXED)
    for word, page in WORDS.items():
        links = b.ask(SEARCH % (repr(word), repr("/" + page)))
        need(any("/" + page in link for link in links), f"a search for {word} does not find {page} but {links[:10]}")
    quiet(b, base, "search")


def run(site):
    handler = functools.partial(Server, directory=site)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    base = f"http://127.0.0.1:{server.server_address[1]}/"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        b = browser.Browser(profile)
        try:
            pages = look(b, base, site)
            search(b, base)
            Server.words = False
            b.open(base + "tutorial.html")
            buttons, blocks = b.ask(BUTTONS), len(fences()["tutorial.html"])
            need(buttons == blocks > 5, f"{buttons} buttons that copy for {blocks} blocks of the tutorial")
            b.call("Browser.grantPermissions", permissions=["clipboardReadWrite", "clipboardSanitizedWrite"])
            b.call("Emulation.setFocusEmulationEnabled", enabled=True)  # of a page in front alone it may be read
            need(b.ask(COPY).strip() == b.ask("document.querySelector('pre > code').textContent").strip(),
                 "the button does not copy its block")
            b.open(base + "nowhere/at_all.html")
            need("404" in b.ask("document.querySelector('h1').textContent")
                 and b.ask("getComputedStyle(document.querySelector('.md-header')).position") == "sticky",
                 "an address that is not there does not show the page 404, with its style")
            quiet(b, base, "404")
        finally:
            b.close()
            server.shutdown()
    return pages


if browser.found() is None:
    print("site: SKIPPED, no Chromium here: nobody has looked at the pages (Debian: apt-get install chromium)")
    sys.exit(77)
if len(sys.argv) < 2 and not (shutil.which("mkdocs") and shutil.which("doxygen")):
    print("site: SKIPPED, no mkdocs or doxygen here (Debian: apt-get install mkdocs mkdocs-material doxygen)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder:
    site = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else os.path.join(folder, "site")
    if len(sys.argv) < 2:
        make = ["/usr/bin/python3", f"{source}/docs/make_site.py", os.path.join(folder, "pages"), site]
        subprocess.run(make, check=True, stdout=subprocess.DEVNULL)
    count = run(site)
for fault in faults:
    print("FAULT", fault)
print(f"site: {count} pages in Chromium, {len(faults)} faults")
sys.exit(1 if faults else 0)
