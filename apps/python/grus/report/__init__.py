# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-report: tables, plots and pictures of results. Nothing is loaded here: what takes a second must hear Ctrl-C (see
__main__.py)."""
