# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tests of the elements, and what they read in Python."""
