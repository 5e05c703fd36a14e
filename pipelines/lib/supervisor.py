# SPDX-License-Identifier: LGPL-2.1-or-later
"""What systemd is told, if it is who started this (sd_notify(3)): that pictures come, and while they do that all is well."""

import contextlib
import os
import socket


def tell(text):
    """Nothing, where nobody asks; a supervisor that is gone matters as little."""
    place = os.environ.get("NOTIFY_SOCKET", "")
    if not place:
        return
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as to:
        to.sendto(text.encode(), socket.MSG_DONTWAIT,
                  f"\0{place[1:]}" if place[0] == "@" else place)


def interval():
    """ms between two signs of life, None if none are wanted."""
    wanted = os.environ.get("WATCHDOG_USEC", "")
    if not wanted.isdecimal() or os.environ.get("WATCHDOG_PID", str(os.getpid())) != str(
            os.getpid()):
        return None
    return max(1, int(wanted) // 3000)
