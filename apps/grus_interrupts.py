# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ctrl-C while a tool loads what takes a second to load: one line and 130 instead of a traceback."""
import signal
import sys


def end_at_once(program):
    def interrupted(*_):
        print(f"{program}: interrupted, nothing was written", file=sys.stderr)
        raise SystemExit(130)
    signal.signal(signal.SIGINT, interrupted)


def raise_again():
    signal.signal(signal.SIGINT, signal.default_int_handler)
