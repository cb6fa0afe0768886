# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands that run cases have in common: how they end, and what they say of it."""
import os
import signal
import sys

from grus.errors import InputError
from grus.files.folders import InUse
from grus.files.texts import one_line
from grus.runs import interrupts


class Lacking(Exception):
    """Something that is asked for and that no run has."""


def duration_text(s):
    return f"{s:.0f} s" if s < 120 else f"{s / 60:.0f} min" if s < 7200 else f"{s / 3600:.1f} h"


def status_of(program, args, work, interrupted):
    """Exit status of a command; what went wrong is told in one line, the whole story to who asks."""
    try:
        interrupts.raise_again()
        if args.log:
            try:
                interrupts.log_to(args.log)
            except FileExistsError as e:
                raise InputError(f"--log: {args.log}: {e.strerror}") from None
            except OSError as e:
                raise InputError(f"--log: {args.log}: cannot write: {e.strerror}") from None
        if args.max_time:
            interrupts.end_after(args.max_time)
        return work(args)
    except (InputError, InUse) as e:
        print(one_line(f"{program}: {e}"), file=sys.stderr)
        return 2
    except Lacking as e:
        print(one_line(f"{program}: {args.scene}: {e}"), file=sys.stderr)
        return 1
    except interrupts.OutOfTime:
        print(f"{program}: out of time: finished runs are kept; the same command goes on", file=sys.stderr)
        return 75
    except KeyboardInterrupt:
        print(f"{program}: {interrupted}", file=sys.stderr)
        return 130
    except Exception as e:
        if os.environ.get("GRUS_DEBUG"):
            raise
        print(one_line(f"{program}: {args.scene}: {type(e).__name__}: {e} (GRUS_DEBUG=1 shows where)"), file=sys.stderr)
        return 1


def end(main):
    """Runs a tool and ends with its status."""
    try:
        status = main()
    except SystemExit as e:
        status = e.code
    signal.setitimer(signal.ITIMER_REAL, 0)
    interrupts.hear(interrupts.STOPS, signal.SIG_IGN)  # nothing is left to interrupt; Python's own end would die of it
    sys.exit(status)
