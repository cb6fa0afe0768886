#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sentences of README and docs/: of 20 words at most on average, none beyond 45: check_prose.py [--write] [PAGE...]

The mean is of running text and lists; the longest may stand in a table, too. Pages that are not there yet are in
long_sentences.csv with what they had when they were last measured, and none may get worse. --write keeps what has
become better; PAGE shows the longest sentences of a page."""
import csv
import glob
import os
import re
import sys

here = os.path.dirname(os.path.abspath(__file__))
source = os.path.normpath(os.path.join(here, "..", ".."))
KEPT = os.path.join(here, "long_sentences.csv")
MEAN, LONGEST = 20.0, 45
SHORT = r"(?<!\bal)(?<!\beq)(?<!\beqs)(?<!\bfig)(?<!\bcf)(?<!\bvs)(?<!\bSt)(?<!\bNo)"  # a point that ends no sentence
END = re.compile(SHORT + r"(?:[.!?][)\"*]*)\s+(?=[\"*(]*[A-Z0-9`τσΔ])")


def plain(text):
    """Code is a word, a link its text, a picture nothing."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"``?[^`]+``?", "Code", text)


def sentences(text):
    return [s for s in END.split(plain(text)) if words(s)]


def words(sentence):
    return sum(any(c.isalnum() for c in w) for w in sentence.split())


def blocks(page):
    """(text, is a table's cell): paragraphs and list entries, each with its lines joined."""
    page = re.sub(r"^ *```[\s\S]*?^ *```$|<!--[\s\S]*?-->", "\n", page, flags=re.M)
    found, cells = [[]], []
    for line in page.splitlines():
        if line.lstrip().startswith("|"):
            cells += [] if set(line) <= set("|-: ") else re.split(r"(?<!\\)\|", line.strip().strip("|"))
            found.append([])
        elif line.startswith("#") or not line.strip():
            found.append([])
        else:
            found += [[]] if re.match(r"\s*([-*]|\d+\.) ", line) else []
            found[-1].append(re.sub(r"^\s*([-*]|\d+\.) ", "", line).strip())
    return [(" ".join(b), False) for b in found if b] + [(c, True) for c in cells]


def measured(path):
    """Mean of words a sentence, longest sentence (words), all sentences with their lengths."""
    with open(path) as f:
        text = f.read()
    of = [(words(s), s, cell) for block, cell in blocks(text) for s in sentences(block)]
    running = [n for n, _, cell in of if not cell]
    return round(sum(running) / max(1, len(running)), 1), max((n for n, *_ in of), default=0), of


def main(arguments):
    pages = [f"{source}/README.md", *sorted(glob.glob(f"{source}/docs/**/*.md", recursive=True))]
    with open(KEPT, newline="") as f:
        kept = {row["page"]: (float(row["mean"]), int(row["longest"])) for row in csv.DictReader(f)}
    faults, still = [], {}
    for path in pages:
        name = os.path.relpath(path, source)
        mean, longest, of = measured(path)
        if name in arguments:
            for n, sentence, _ in sorted(of, reverse=True)[:12]:
                print(f"{n:4d}  {sentence[:150]}")
            print(f"{name}: mean {mean}, longest {longest}")
        most = kept.get(name, (MEAN, LONGEST))
        if mean > most[0] or longest > most[1]:
            faults.append(f"{name}: {mean} words a sentence, {longest} in the longest; allowed {most[0]}, {most[1]}")
        if mean > MEAN or longest > LONGEST:
            still[name] = (min(mean, max(most[0], MEAN)), min(longest, max(most[1], LONGEST)))
    faults += [f"{name} is good now, or gone: no longer one of {os.path.basename(KEPT)} (--write)"
               for name in kept if name not in still and "--write" not in arguments]
    if "--write" in arguments:
        with open(KEPT, "w", newline="") as f:
            table = csv.writer(f, lineterminator="\n")
            table.writerow(["page", "mean", "longest"])
            table.writerows([name, *figures] for name, figures in still.items())
    for fault in faults:
        print("FAULT", fault)
    print(f"prose: {len(pages) - len(still)} of {len(pages)} pages have short sentences, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
