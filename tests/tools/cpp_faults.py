# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a fault of C++ can be put behind a choice (mutants.py); python_faults.py is the same of Python."""
import re


def outside_of_brackets(expression):
    """The same with nothing in its brackets."""
    kept, depth = "", 0
    for sign in expression:
        depth -= sign in ")]}"
        kept += sign if depth == 0 else " "
        depth += sign in "([{"
    return kept


def binds_otherwise(old, before, after):
    """True where brackets around an expression would change what is computed: its neighbours bind more strongly."""
    bare, before = outside_of_brackets(old), re.sub(r"//.*", "", before).rstrip()
    if re.search(r"[-+*/|&]=|(?<![=!<>])=(?!=)", bare):
        declared = before[-1:] == "," and re.search(r"[;{}]\s*(const )?[\w:]+(<[^;=]*>)?[&*]? \w+ = [^;]*$", before)
        return bool(declared) or after[:1] not in (";", ",", ")")
    sums = re.search(r"[\w)\]] *[-+] ", bare)
    return bool(sums and (before[-1:] in ("*", "/", "%") or re.search(r"[\w)\]] -$", before) or after[:1] in "*/%"))


def cannot_stand(text, span, old, new):
    """Why a text cannot be put behind a choice; None where it can. The compiler alone is sure, but takes long."""
    before = text[:span[0]].rstrip()
    if "//" in text[:span[0]].rpartition("\n")[2]:
        return "it stands in a comment"
    if any(t.count(a) != t.count(b) for t in (old, new) for a, b in ("()", "[]", "{}")):
        return "brackets do not close"
    if old.startswith(".") or re.search(r"(->|\.|(^|\n)\s*constexpr [^()\n]*)$", before):
        return "it is a member without what holds it, or of a constant, which takes no choice"
    if not old.endswith((";", "}")):
        if re.match(r"(return|throw|if|for|while)\b", old) or old.count(" ? ") != old.count(" : "):
            return "it is no whole statement, or cuts a choice (a ? b : c)"
        if "," in outside_of_brackets(old):
            return "a comma parts arguments: take one of them"
        if binds_otherwise(old, before, text[span[1]:].lstrip()):
            return "it is no whole expression: what stands beside it binds more strongly"
        return "a statement ends with ;" if ";" in old else None
    if not before.endswith((";", "{", "}", ":", ")", "else")) and "//" not in before.rpartition("\n")[2]:
        return "it is no whole statement"
    name = r"(?!(return|throw|delete|else)\b)(const |constexpr |static )*[\w:]+(<[^;=]*>)?[&*]? \w+( = |[({])"
    if re.match(name, old):
        return "it declares a name, which would end with its block"
    return None
