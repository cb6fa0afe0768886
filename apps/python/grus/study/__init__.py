# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-study: cases side by side, and error against run time. Nothing is loaded here: what takes a second must hear
Ctrl-C (see __main__.py)."""
