# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-calibrate: parameters from measured data. Nothing is loaded here: what takes a second must hear Ctrl-C (see
__main__.py)."""
