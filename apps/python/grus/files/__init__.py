# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is read from people and written for them, whatever it is about."""
