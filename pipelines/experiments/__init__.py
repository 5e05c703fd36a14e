# SPDX-License-Identifier: LGPL-2.1-or-later
"""The experiments behind docs/results/, each a command of this folder."""
