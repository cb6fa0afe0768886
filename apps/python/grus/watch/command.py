# SPDX-License-Identifier: LGPL-3.0-or-later
"""Follows runs, studies and calibrations while they run: curves, energy, how far they are and how long they will take,
on a page of this machine alone. It asks nothing of the runs, and ends with them."""
import argparse
import os
import sys
import time
import webbrowser

from grus._version import __version__
from grus.files.texts import one_line
from grus.runs import interrupts
from grus.watch.following import Following
from grus.watch.server import Server

EVERY = 1.0  # s, between looks
SHARE = 15  # of the time of a look: runs need the cores more
GRACE = 4.0  # s, for pages to hear of the end


def follow(following, server, stay):
    """Until all that ran has ended, and pages that are open have been told."""
    ended = None
    while True:
        began = time.monotonic()
        following.look()
        server.data = following.told()
        if following.over() and not stay:
            now = time.monotonic()
            ended = ended or now
            if server.told_over or now - max(ended, server.asked) > GRACE:
                time.sleep(0.2)  # the answer is on its way
                return
        time.sleep(max(EVERY, SHARE * (time.monotonic() - began)))


def work(args):
    folders = [os.path.normpath(f) for f in args.folders]
    for folder in folders:
        if os.path.exists(folder) and not os.path.isdir(folder):
            return refused(f"{folder}: is a file; name a results folder")
    following = Following(folders)
    following.look()
    idle = [f for f in folders if os.path.isdir(f) and os.listdir(f) and not following.writers[f]]
    if idle and not args.stay:
        return refused(f"{idle[0]}: nothing runs there: grus report {idle[0]} draws what is there, --stay shows it")
    try:
        server = Server(args.port)
    except OSError as e:
        return refused(f"--port {args.port}: {e.strerror}")
    with server:
        server.data = following.told()
        server.begin()
        for folder in folders:
            if not os.path.isdir(folder):
                print(f"{folder}: waits for a run to begin")
        print(f"{server.address}   (Ctrl-C ends it; runs go on)", flush=True)
        if args.open:
            webbrowser.open(server.address)
        follow(following, server, args.stay)
        server.shutdown()
    print("; ".join(f"{r.name}: {r.state()}" for r in list(following.runs.values())[:10]))
    return 0


def refused(text):
    print(one_line(f"grus watch: {text}"), file=sys.stderr)
    return 2


def port(text):
    number = int(text)
    if not 0 <= number < 65536:
        raise argparse.ArgumentTypeError("expected 0 (any that is free) to 65535")
    return number


def main():
    parser = argparse.ArgumentParser(prog="grus watch", description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="results folders of runs, studies, calibrations")
    parser.add_argument("--port", type=port, default=0, help="of 127.0.0.1 (default: one that is free)")
    parser.add_argument("--stay", action="store_true", help="do not end with the runs; show what has ended, too")
    parser.add_argument("--open", action="store_true", help="open the page in the browser of this machine")
    parser.add_argument("--version", action="version", version=f"grus {__version__}")
    args = parser.parse_args()
    interrupts.raise_again()
    try:
        return work(args)
    except KeyboardInterrupt:
        return 130
