# SPDX-License-Identifier: LGPL-3.0-or-later
"""A history.csv that a run adds to: each look reads what has come since the last."""
import math
import os


class Growing:
    """Columns of a table that grows at its end. A table that another has taken the place of is read anew; a line that
    is half written waits for its other half."""

    def __init__(self, path):
        self.path, self.columns = path, {}
        self.forget()

    def forget(self):
        self.columns, self.names, self.read, self.who = {}, [], 0, None

    def __len__(self):
        return len(next(iter(self.columns.values()), []))

    def look(self):
        """Tells whether anything has changed."""
        try:
            told = os.stat(self.path)
        except OSError:
            changed = bool(self.names)
            self.forget()
            return changed
        who = (told.st_dev, told.st_ino)
        if who != self.who or told.st_size < self.read:
            self.forget()
            self.who = who
        if told.st_size == self.read:
            return False
        with open(self.path, "rb") as f:
            f.seek(self.read)
            text = f.read()
        whole = text[:text.rfind(b"\n") + 1]
        self.read += len(whole)
        self.add(whole.decode("utf-8", "replace").splitlines())
        return bool(whole)

    def add(self, lines):
        if lines and not self.names:
            self.names = lines.pop(0).split(",")
            self.columns = {name: [] for name in self.names}
        for line in lines:
            fields = line.split(",")
            if len(fields) == len(self.names):
                for name, field in zip(self.names, fields):
                    self.columns[name].append(number(field))


def number(text):
    """NaN for what is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
