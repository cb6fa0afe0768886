# SPDX-License-Identifier: LGPL-3.0-or-later
"""python3 -m grus, as the command grus."""
from grus.runs import interrupts

interrupts.end_at_once("grus")
from grus.commands.command import main  # noqa: E402
from grus.runs.command import end  # noqa: E402

end(main)
