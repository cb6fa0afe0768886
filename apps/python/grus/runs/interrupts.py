# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the system asks of a tool: SIGINT, SIGTERM and SIGHUP stop it, SIGUSR1 and SIGUSR2 are handed on to its runs.
Those that it was started with as ignored (nohup) stay ignored."""
import contextlib
import errno
import os
import re
import signal
import sys
import threading
import time

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
WISHES = (signal.SIGUSR1, signal.SIGUSR2)
BEGAN = time.monotonic()
SECONDS = {"": 1, "s": 1, "min": 60, "h": 3600, "ms": 1e-3}


class OutOfTime(KeyboardInterrupt):
    """The time of --max-time is over."""


def hear(signals, handler):
    for number in signals:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, handler)


def end_at_once(program):
    """While a tool loads what takes a second to load: one line and 130 instead of a traceback."""
    def interrupted(*_):
        try:
            os.write(2, f"{program}: interrupted, nothing was written\n".encode())
        finally:
            os._exit(130)  # an exception would end what is being loaded, and be ignored there or told with a traceback
    hear(STOPS, interrupted)
    hear(WISHES, lambda *_: None)


def raise_again():
    hear(STOPS, signal.default_int_handler)


@contextlib.contextmanager
def held():
    """Ctrl-C that comes meanwhile is heard at the end: a program that is just being started is known by then."""
    before = signal.getsignal(signal.SIGINT)
    if not callable(before) or threading.current_thread() is not threading.main_thread():
        yield
        return
    came = []
    signal.signal(signal.SIGINT, lambda *how: came.append(how))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        before(*came[0])


def hand_on(processes):
    """SIGUSR1 and SIGUSR2 reach what runs: a checkpoint is written there. What has just begun may not hear them yet: it
    would die."""
    def to_all(number, _):
        for process in list(processes):
            if time.monotonic() - getattr(process, "begun", float("inf")) > 2:
                process.send_signal(number)
    hear(WISHES, to_all)


def duration(text):
    """Seconds of "2 h", "90 min" or a bare number; for argparse."""
    import argparse  # not while a tool loads: what comes before end_at_once hears no Ctrl-C
    found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([a-z]*)\s*", text)
    try:
        seconds = float(found[1]) * SECONDS[found[2]]
    except (TypeError, ValueError, KeyError):
        seconds = float("nan")
    if not 0 < seconds < float("inf"):
        raise argparse.ArgumentTypeError(f'expected a time above 0 such as "90 min", "2 h" or "3600 s", given {text!r}')
    return seconds


def end_after(seconds):
    """OutOfTime is raised early enough for runs to write their checkpoints; 2 % of the time, a second to a minute."""
    def over(*_):
        raise OutOfTime
    signal.signal(signal.SIGALRM, over)
    reserve = min(max(0.02 * seconds, min(1.0, 0.2 * seconds)), 60)
    signal.setitimer(signal.ITIMER_REAL, max(seconds - reserve - (time.monotonic() - BEGAN), 1e-3))


LINE_OF_LOG = re.compile(rb"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d  ")  # how each begins


class Logged:
    """A stream whose lines also go, with the time, to the end of a file."""

    def __init__(self, stream, file):
        self.stream, self.file, self.line = stream, file, ""

    def write(self, text):
        self.stream.write(text)
        *lines, self.line = (self.line + text).split("\n")
        for line in lines:
            self.file.write(f"{time.strftime('%F %T')}  {line}\n".replace("\r", ""))
        self.file.flush()
        return len(text)

    def __getattr__(self, name):
        return getattr(self.stream, name)


def log_to(path):
    """What is said from now on is written to the end of a file, too: of a log, or of a new one. Raises OSError."""
    if os.path.isfile(path):
        with open(path, "rb") as f:
            begin = f.read(21)
        if begin and not LINE_OF_LOG.fullmatch(begin):
            raise FileExistsError(errno.EEXIST, "is there and is not a log of Grus: name another file")
    file = open(path, "a", encoding="utf-8")
    sys.stdout, sys.stderr = Logged(sys.stdout, file), Logged(sys.stderr, file)


def add_options(parser):
    parser.add_argument("--max-time", metavar="DURATION", type=duration,
                        help='stop after this time, e.g. "2 h": exit status 75; the same command goes on')
    parser.add_argument("--log", metavar="FILE", help="add what is said to the end of FILE, each line with the time")
