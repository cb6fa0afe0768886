# SPDX-License-Identifier: LGPL-3.0-or-later
"""Faults in Python files for mutants.py: each stands behind a choice, as in C++. A place is a whole expression, which
the syntax tree tells for sure, or a statement that fills its lines."""
import ast


def tree(text):
    try:
        return ast.dump(ast.parse(text))
    except SyntaxError:
        return None


def is_expression(text, span):
    a, b = span
    return tree(text) == tree(f"{text[:a]}({text[a:b]}){text[b:]}")


def is_statement(text, span):
    """A simple one, alone in its lines."""
    a, b = span
    try:
        found = ast.parse(text[a:b]).body
    except SyntaxError:
        return False
    alone = not text[:a].rpartition("\n")[2].strip() and not text[b:].partition("\n")[0].strip()
    return alone and len(found) == 1 and not hasattr(found[0], "body")


def cannot_stand(text, span):
    """Why a text cannot be put behind a choice; None where it can."""
    return None if is_expression(text, span) or is_statement(text, span) else "it is no whole expression or statement"


def behind_choice(text, span, faults):
    """What takes the place of a text; `faults`: (number, new text)."""
    old = text[span[0]:span[1]]
    if is_expression(text, span):
        found = f"({old})"
        for number, new in faults:
            found = f"(({new}) if GRUS_MUTANT == {number} else {found})"
        return found
    indent = " " * (span[0] - text.rfind("\n", 0, span[0]) - 1)
    return "".join(f"if GRUS_MUTANT == {number}: {new}\n{indent}el" for number, new in faults) + f"se: {old}"


def with_choice(text):
    """The module learns which fault is chosen, as soon as Python allows."""
    begin = 0
    for node in ast.parse(text).body:
        told = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if not told and not (isinstance(node, ast.ImportFrom) and node.module == "__future__"):
            break
        begin = node.end_lineno
    lines = text.split("\n")
    lines.insert(begin, "GRUS_MUTANT = int(__import__('os').environ.get('GRUS_MUTANT') or 0)")
    return "\n".join(lines)
