# SPDX-License-Identifier: LGPL-2.1-or-later
"""Commands that measure what csdtrack costs and what each of its parts contributes."""
