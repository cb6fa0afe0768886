#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""All claims of a study hold: claims.py STUDY.toml BIN"""
import os
import subprocess
import sys
import tempfile

with tempfile.TemporaryDirectory() as folder:
    sys.exit(
        subprocess.run(
            [os.path.join(sys.argv[2], "grus-study"), sys.argv[1], "-o",
             os.path.join(folder, "study"), "--strict"]).returncode)
