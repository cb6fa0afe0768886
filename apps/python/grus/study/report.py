# SPDX-License-Identifier: LGPL-3.0-or-later
"""report.html and study.txt of a study: what each kind of table adds, in turn."""
import html
import os

from grus.figures import STYLE
from grus.files.writing import write_whole
from grus.study.kinds import KINDS


def write(study, done, spent):
    """`spent`: a line on the time. Tells whether all claims hold."""
    shown = [kind.show(study.entries[kind.NAME], done) for kind in KINDS]
    text = f"{study.title}\n{spent}\n" + "".join(s.text for s in shown)
    write_whole(os.path.join(done.out, "study.txt"), text)
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8">
<title>{html.escape(study.title)}</title>
<style>{STYLE}img{{max-width:100%;margin:.3em}}</style>
<h1>{html.escape(study.title)}</h1>{"".join(s.body for s in shown)}</html>"""
    write_whole(os.path.join(done.out, "report.html"), page)
    print(text)
    return all(s.passed for s in shown)
