# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of scenes: programs, cases, what is kept of them."""
