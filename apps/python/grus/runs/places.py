# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a file of a command names what it should not, and what may have been meant."""
import difflib
import re

from grus.files.texts import text_of


def place_of(path, name):
    """"FILE:LINE: TABLE.KEY" of the first text that is `name`; the file where none is."""
    table = key = ""
    for number, line in enumerate(text_of(path).splitlines(), 1):
        if head := re.match(r"\s*\[\[?\s*([\w.-]+)\s*\]", line):
            table, key = head[1], ""
        for word in re.finditer(r"""([\w.-]+)\s*=|"([^"]*)"|'([^']*)'""", line.split("#")[0]):
            if word[1]:
                key = word[1]
            elif name in word.groups()[1:]:
                return f"{path}:{number}: {'.'.join(filter(None, (table, key)))}"
    return path


def hint(name, known):
    """" (did you mean '...'?)" of what is near; nothing where nothing is."""
    near = difflib.get_close_matches(name, known, 1, 0.6)
    return f" (did you mean '{near[0]}'?)" if near else ""
