# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus export: results as other programs read them."""
