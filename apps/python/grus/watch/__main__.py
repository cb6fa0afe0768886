# SPDX-License-Identifier: LGPL-3.0-or-later
"""python3 -m grus.watch, as grus watch."""
from grus.runs import interrupts

interrupts.end_at_once("grus watch")
from grus.runs.command import end  # noqa: E402
from grus.watch.command import main  # noqa: E402

end(main)
