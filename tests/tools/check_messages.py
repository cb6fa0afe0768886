#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Messages that docs/howto/stops.md explains are those of the programs: each stands in the sources."""
import glob
import os
import re
import sys

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = "docs/howto/stops.md"
ROOMS = ("apps", "coupling", "dem", "fem")


def said():
    """Texts of all string literals: neighbours joined as the compiler joins them, escapes undone."""
    texts = []
    for room in ROOMS:
        for path in glob.glob(f"{source}/{room}/**/*.[ch]pp", recursive=True):
            with open(path) as f:
                code = re.sub(r"^\s*//.*$", "", f.read(), flags=re.M)
            literals = r'"(?:[^"\\\n]|\\.)*"'
            for run in re.findall(rf"{literals}(?:\s*{literals})*", code):
                texts.append("".join(t[1:-1] for t in re.findall(literals, run)).replace('\\"', '"'))
    return texts


def messages():
    """Those of the first column of the page's tables."""
    with open(os.path.join(source, PAGE)) as f:
        rows = re.findall(r"^\| (`.*?) \|", f.read(), re.M)
    return [m for row in rows for m in re.findall(r"`([^`]+)`", row)]


def main():
    texts, asked = said(), messages()
    faults = [] if len(asked) > 30 else [f"{PAGE}: only {len(asked)} messages are read"]
    for message in asked:
        parts = [part.strip(" %") for part in message.split("…")]
        told = re.compile(".*".join(re.escape(part) for part in parts if part))
        if not any(told.search(text) for text in texts):
            faults.append(f"{PAGE}: no program says {message!r}")
    for fault in faults:
        print("FAULT", fault)
    print(f"messages: {len(asked)}, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
