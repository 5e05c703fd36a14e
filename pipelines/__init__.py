# SPDX-License-Identifier: LGPL-2.1-or-later
"""The commands for users, and the Python behind them."""
