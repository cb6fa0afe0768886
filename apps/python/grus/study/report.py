# SPDX-License-Identifier: LGPL-3.0-or-later
"""report.html and study.txt of a study: what each kind of table adds, in turn."""
import os

from grus.figures import page
from grus.files.writing import write_whole
from grus.study.kinds import KINDS


def write(study, done, spent):
    """`spent`: a line on the time. Tells whether all claims hold."""
    shown = [kind.show(study.entries[kind.NAME], done) for kind in KINDS]
    text = f"{study.title}\n{spent}\n" + "".join(s.text for s in shown)
    write_whole(os.path.join(done.out, "study.txt"), text)
    write_whole(os.path.join(done.out, "report.html"), page(study.title, "".join(s.body for s in shown)))
    print(text)
    return all(s.passed for s in shown)
