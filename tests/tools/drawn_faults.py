#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""C++ faults drawn at random: drawn_faults.py [--seed N] [--count N] [--spare N] FILE... > table

Prints a table for `mutants.py --table`. Each fault changes one sign of an expression that stands whole (what is
returned, assigned or asked): a comparison the other way, `and` for `or`, plus for minus, times for over, least for
largest, a number, a sign, a part of a vector, a root; or it leaves a statement out. Files are drawn first, evenly, so
that long ones do not rule. `--spare`: more of them, for those that do not compile. What bounds a comparison, < for <=,
is not drawn from: of numbers that are no integers it changes nothing.
"""
import argparse
import json
import os
import random
import re
import sys

import mutants

SWAPS = {" < ": " >= ", " > ": " <= ", " <= ": " > ", " >= ": " < ", " == ": " != ", " != ": " == ", " && ": " || ",
         " || ": " && ", " + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", "std::max": "std::min",
         "std::min": "std::max", "sin(": "cos(", "cos(": "sin(", "std::sqrt(": "(", "std::abs(": "(",
         "std::floor(": "std::ceil(", "std::ceil(": "std::floor(", "true": "false", "false": "true",
         ".transpose()": "", ".norm()": ".squaredNorm()", ".squaredNorm()": ".norm()", ".x()": ".y()",
         ".y()": ".z()", ".z()": ".x()", ".front()": ".back()", ".back()": ".front()", "begin()": "end()",
         "plus": "minus", ".a]": ".b]", ".b]": ".a]", "first": "second", "low": "high", "INFINITY": "-INFINITY"}
TOKEN = re.compile("|".join([*(re.escape(t) if not t[0].isalpha() else rf"\b{re.escape(t)}" +
                               (r"\b" if t[-1].isalnum() else "") for t in SWAPS),
                             r"(?<![\w.\])])(?:\d+\.?\d*(?:e-?\d+)?)\b", r"(?<=[(,=?:] )-(?=[\w(])",
                             r"(?<=\()-(?=[\w(])", r"^-(?=[\w(])", r"!(?=[\w(])"]))


def masked(text):
    """The same length, without what comments and words in quotes say."""
    def blank(found):
        return re.sub(r"[^\n]", " ", found.group())
    text = re.sub(r"//[^\n]*", blank, text)
    return re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\])\'', lambda f: '"' + "_" * (len(f.group()) - 2) + '"', text)


def closing(text, at):
    """Where the bracket that opens at `at` closes."""
    depth = 0
    for k in range(at, len(text)):
        depth += (text[k] in "([{") - (text[k] in ")]}")
        if depth == 0:
            return k
    return -1


def end_of(text, at):
    """Where an expression that begins at `at` ends: at a sign that is in none of its brackets."""
    depth = 0
    for k in range(at, len(text)):
        if depth == 0 and text[k] in ";,)]}":
            return k
        depth += (text[k] in "([{") - (text[k] in ")]}")
    return -1


def expressions(text):
    """(begin, end, what) of whole expressions and of statements that may be left out."""
    for found in re.finditer(r"\b(if|while) \(", text):
        begin, end = found.end(), closing(text, found.end() - 1)
        inside = text[begin:end]
        begin += inside.rfind(";") + 1
        if not re.match(r"\s*(const )?[\w:]+[&*]? \w+ = ", text[begin:end]):
            yield begin, end, "asked"
    for found in re.finditer(r"\bfor \(([^;{]*);([^;]*);", text):
        yield found.start(2), found.end(2), "asked"
    for found in re.finditer(r"\breturn (?=[\w(!*-])", text):
        yield found.end(), end_of(text, found.end()), "returned"
    for found in re.finditer(r"[\w)\]>] ([-+*/]?=) (?=[\w(!-])", text):
        line = text[text.rfind("\n", 0, found.start()) + 1:found.start() + 1]
        if not re.search(r"\b(constexpr|using|template|static|auto&|for)\b|&\s+\w+$|&&? \w+$", line):
            yield found.end(), end_of(text, found.end()), "assigned"
    for found in re.finditer(r"(?<=[;{}]\n)( +)(?!return|throw|const |using |static |break|continue|if|for|while|case|"
                             r"else|struct|namespace|auto |double |int |bool |void )([a-z_][^;{}]*;)", text):
        if re.match(r"[\w.>:\[\]()*-]+( [-+*/]?= |\(|\.|->)", found.group(2)):
            yield found.start(2), found.end(2), "left out"


def changed_number(word, draw):
    if "." in word or "e" in word:
        return f"{float(word) * draw.choice((0.5, 2.0)):g}" if float(word) else "1.0"
    return str(int(word) + 1) if int(word) < 2 else draw.choice((str(int(word) + 1), str(int(word) - 1)))


def drawn_from(path, draw):
    """A place of a file and what shall stand there; None: none was found."""
    text = open(os.path.join(mutants.root, path)).read()
    bare = masked(text)
    inside = bare.find("namespace")  # what is above it declares
    found = [(a, b, what) for a, b, what in expressions(bare) if inside < a < b and '"' not in bare[a:b]]
    draw.shuffle(found)
    for begin, end, what in found:
        old = text[begin:end].strip()
        begin += len(text[begin:end]) - len(text[begin:end].lstrip())
        span = (begin, begin + len(old))
        place = {"file": path, "old": old}
        if what == "left out":
            place["new"] = ";"
        else:
            tokens = [t for t in TOKEN.finditer(old) if t.group() not in ("true", "false") or what != "asked"]
            if not tokens or "[&" in old or "{" in old:
                continue
            token = draw.choice(tokens)
            word = token.group()
            new = SWAPS.get(word, changed_number(word, draw) if word[0].isdigit() else "")
            place["new"] = old[:token.start()] + new + old[token.end():]
            if what != "asked":
                place["type"] = "grus_mutants::plain"
        stands = mutants.places_of(text, old)
        if span not in stands or mutants.cannot_stand(text, span, place):
            continue
        if len(stands) > 1:
            place["nth"] = stands.index(span) + 1
        return place, text.count("\n", 0, begin) + 1
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--spare", type=int, default=0)
    parser.add_argument("files", nargs="+")
    options = parser.parse_args()
    draw = random.Random(f"drawn {options.seed}")
    files, taken, made = sorted(options.files), [], 0
    for _ in range(100 * options.count):
        if made == options.count + options.spare:
            break
        path = draw.choice(files)
        one = drawn_from(path, draw)
        if one is None:
            continue
        place, line = one
        lines = range(line, line + place["old"].count("\n") + 1)
        if any(path == p and set(lines) & set(other) for p, other in taken):
            continue
        taken.append((path, lines))
        made += 1
        print("[[mutant]]\nname = " + json.dumps(f"{options.seed}.{made} {path}:{line}"))
        print("\n".join(f"{key} = {json.dumps(value)}" for key, value in place.items()) + "\n")
    sys.exit(0 if made == options.count + options.spare else "drawn_faults: not as many places are there")


if __name__ == "__main__":
    main()
