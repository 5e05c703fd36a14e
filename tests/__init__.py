# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tests, and the commands that measure csdtrack."""
