# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus watch: a page on this machine that follows runs while they run."""
