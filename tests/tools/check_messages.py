#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Messages that docs/howto/stops.md explains are those of the programs: each stands in the sources; and the page has
every message with which a run ends unstable or does not converge, and every note."""
import glob
import os
import re
import sys

source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = "docs/howto/stops.md"
ROOMS = ("apps", "coupling", "dem", "fem")


def joined(code):
    """Texts of string literals: neighbours joined as the compiler joins them, escapes undone."""
    literals = r'"(?:[^"\\\n]|\\.)*"'
    return ["".join(t[1:-1] for t in re.findall(literals, run)).replace('\\"', '"')
            for run in re.findall(rf"{literals}(?:\s*{literals})*", code)]


def said():
    """Texts of all of them."""
    texts = []
    for room in ROOMS:
        for path in glob.glob(f"{source}/{room}/**/*.[ch]pp", recursive=True):
            with open(path) as f:
                texts += joined(re.sub(r"^\s*//.*$", "", f.read(), flags=re.M))
    return texts


def messages():
    """Those of the first column of the page's tables."""
    with open(os.path.join(source, PAGE)) as f:
        rows = re.findall(r"^\| (`.*?) \|", f.read(), re.M)
    return [m for row in rows for m in re.findall(r"`([^`]+)`", row)]


# Where a run is ended, or a note is made. What only goes before another text is none of its own.
ENDS = r"(?:\bUnstable\(|\b(?:notes?|all)\.push_back\(|\b(?:failure|reason) = |\brefuse\()"
BEFORE = {"unit cell: ", "mesh.file: ", ": ", ":…: ",
          "preparation…: ", "boundary[{}]: {}", ": pressure", "cannot read: ",
          "{} by {:.3g} J ({:.2g} of the work) at t = {:.6g} s: lower {}"}


def stops():
    """(file, text) of each."""
    for room in ROOMS:
        for path in sorted(glob.glob(f"{source}/{room}/**/*.[ch]pp", recursive=True)):
            with open(path) as f:
                code = re.sub(r"^\s*//.*$", "", f.read(), flags=re.M)
            for place in re.finditer(ENDS, code):
                held = joined(code[place.start():code.find(";\n", place.start())])
                text = "…".join(held)
                if text and text not in BEFORE:
                    yield os.path.relpath(path, source), text


def pattern(message):
    parts = [part.strip(" %") for part in message.split("…")]
    return re.compile(".*".join(re.escape(part) for part in parts if part))


def main():
    ends, asked = list(stops()), messages()
    texts = said() + [text for _, text in ends]
    faults = [] if len(asked) > 30 else [f"{PAGE}: only {len(asked)} messages are read"]
    patterns = [pattern(message) for message in asked]
    faults += [f"{PAGE}: no program says {message!r}" for message, told in zip(asked, patterns)
               if not any(told.search(text) for text in texts)]
    faults += [f"{PAGE} lacks what {path} says: {text!r}" for path, text in ends
               if not any(told.search(text) for told in patterns)]
    faults += [] if len(ends) > 50 else [f"only {len(ends)} ends are read"]
    for fault in faults:
        print("FAULT", fault)
    print(f"messages: {len(asked)}, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
