# SPDX-License-Identifier: LGPL-3.0-or-later
"""Who writes into a results folder: by the lock of its marker, which is looked at and never taken."""
import os
from typing import NamedTuple

from grus.files.folders import MARKER


class Process(NamedTuple):
    """`since`: seconds that it runs; `folder`: where it was started."""
    number: int
    words: list
    folder: str
    since: float


def locked_by(path, locks="/proc/locks"):
    """The process that holds a lock of flock on a file; None: nobody, as far as can be seen."""
    try:
        file = os.stat(path)
        with open(locks) as f:
            lines = [line.split() for line in f]
    except OSError:
        return None
    for words in lines:
        if len(words) < 8 or words[1] != "FLOCK":  # "->" in its place waits for one
            continue
        major, minor, inode = words[5].split(":")
        if int(inode) != file.st_ino:
            continue
        device = os.makedev(int(major, 16), int(minor, 16))
        if device == file.st_dev or holds(int(words[4]), file):
            return int(words[4])
    return None


def holds(process, file):
    """Whether it has the file open: folders laid over others tell another device in /proc/locks."""
    try:
        for name in os.listdir(f"/proc/{process}/fd"):
            told = os.stat(f"/proc/{process}/fd/{name}")
            if (told.st_dev, told.st_ino) == (file.st_dev, file.st_ino):
                return True
    except OSError:
        pass
    return False


def writer(folder):
    """The process that writes into a results folder, or None."""
    number = locked_by(os.path.join(folder, MARKER))
    return None if number is None else about(number)


def about(number):
    words, folder, since = [], "", 0.0
    try:
        with open(f"/proc/{number}/cmdline") as f:
            words = f.read().split("\0")[:-1]
        folder = os.readlink(f"/proc/{number}/cwd")
        with open(f"/proc/{number}/stat") as f:
            began = int(f.read().rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
        with open("/proc/uptime") as f:
            since = float(f.read().split()[0]) - began
    except (OSError, ValueError, IndexError):  # of somebody else, or gone
        pass
    return Process(number, words, folder, since)
