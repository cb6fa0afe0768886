# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a build calls for each source of its own, also where it compiles sources joined (CMAKE_UNITY_BUILD)."""
import json
import os
import re

# Of joined builds only: warnings that joined sources cannot have, and headers compiled once.
JOINED_ONLY = re.compile(r" -Wno-(shadow|subobject-linkage|array-bounds)| -fpch-preprocess| -Winvalid-pch -include \S+")


def compile_calls(build):
    """Entries of compile_commands.json, of one source each."""
    with open(os.path.join(build, "compile_commands.json")) as f:
        entries = json.load(f)
    single = []
    for entry in entries:
        entry["command"] = JOINED_ONLY.sub("", entry["command"])
        if os.path.basename(entry["file"]).startswith("cmake_pch"):
            continue
        if os.path.basename(os.path.dirname(entry["file"])) != "Unity":
            single.append(entry)
            continue
        with open(entry["file"]) as f:
            for source in re.findall(r'#include "([^"]+)"', f.read()):
                command = entry["command"].replace(entry["file"], source)
                single.append({**entry, "file": source, "command": command})
    return single
