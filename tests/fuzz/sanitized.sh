#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-3.0-or-later
# The fuzzer on a build with address and undefined-behaviour sanitizers: sanitized.sh SOURCE COUNT SEED
set -euo pipefail
cd "$1"
cmake --preset sanitized
cmake --build --preset sanitized
exec /usr/bin/python3 tests/fuzz/fuzz.py build-sanitized/bin "$2" "$3" --sanitized
