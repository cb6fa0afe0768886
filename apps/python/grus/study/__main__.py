# SPDX-License-Identifier: LGPL-3.0-or-later
"""python3 -m grus.study, as grus-study. Loading takes a second: Ctrl-C is heard before it."""
from grus.runs import interrupts

interrupts.end_at_once("grus-study")
from grus.runs.command import end  # noqa: E402
from grus.study.command import main  # noqa: E402

end(main)
