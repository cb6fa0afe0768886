# SPDX-License-Identifier: LGPL-3.0-or-later
"""The two errors of Grus, each of one line; the compiled core raises the same classes."""


class InputError(ValueError):
    """What was given cannot be used; the text says what to change."""


class Unstable(RuntimeError):
    """What went wrong while grains moved, and where; what raised it can be used afterwards."""
