# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands in pipelines/ run: a module for each, and what they share."""
