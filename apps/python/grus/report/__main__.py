# SPDX-License-Identifier: LGPL-3.0-or-later
"""python3 -m grus.report, as grus-report. Loading takes a second: Ctrl-C is heard before it."""
import sys

from grus.runs import interrupts

interrupts.end_at_once("grus-report")
from grus.runs.command import end  # noqa: E402

try:
    from grus.report.command import main
except ImportError as e:
    if e.name != "matplotlib":
        raise
    sys.exit("grus-report: needs matplotlib (Debian: python3-matplotlib)")

end(main)
