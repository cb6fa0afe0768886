# SPDX-License-Identifier: LGPL-3.0-or-later
"""report.html and study.txt of a study: what each kind of table adds, in turn, and where its runs lie."""
import html
import os

from grus.figures import page, table as html_table
from grus.files.writing import write_whole
from grus.study.kinds import KINDS


def runs_of(study, done):
    """Of each run: what it is called, its seed, its folder."""
    cases = {c["name"]: c for c in study.cases()}
    rows = [[c["label"], "" if s is None else s, os.path.relpath(done.runner.folder(c, s), done.out)]
            for c in cases.values() for s in c["seeds"] if (c["name"], str(s)) not in done.lost]
    return ("<h2>Runs</h2><p>Each has a folder beside this page, as <code>grus run</code> writes one: its "
            "<code>summary.json</code> has the whole scene, and <code>grus report</code> draws it.</p>"
            f"<details><summary>{len(rows)} runs and their folders</summary>"
            + html_table(["run", "seed", "folder"], rows) + "</details>")


def write(study, done, spent):
    """`spent`: a line on the time. Tells whether all claims hold."""
    shown = [kind.show(study.entries[kind.NAME], done) for kind in KINDS]
    text = f"{study.title}\n{spent}\n" + "".join(s.text for s in shown)
    write_whole(os.path.join(done.out, "study.txt"), text)
    body = f"<p>{html.escape(spent)}</p>" + "".join(s.body for s in shown) + runs_of(study, done)
    write_whole(os.path.join(done.out, "report.html"), page(study.title, body))
    print(text)
    return all(s.passed for s in shown)
