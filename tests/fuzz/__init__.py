# SPDX-License-Identifier: LGPL-2.1-or-later
"""The fuzz targets, and the command that runs them."""
