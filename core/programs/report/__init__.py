# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program csd-report, which makes a page from a video and its tracks."""
