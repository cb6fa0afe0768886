# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus: one command for all programs, and what shells need to complete it."""
