# SPDX-License-Identifier: LGPL-2.1-or-later
"""Notifies systemd, if it started this process: frames arrive, and keep arriving (sd_notify(3))."""

import contextlib
import os
import socket
import threading


def notify(text: str) -> None:
    """Sends a message. Does nothing without a supervisor, or if the supervisor is gone."""
    place = os.environ.get("NOTIFY_SOCKET", "")
    if not place:
        return
    address = f"\0{place[1:]}" if place[0] == "@" else place
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(text.encode(), socket.MSG_DONTWAIT, address)


def interval() -> int | None:
    """Milliseconds between two watchdog messages, or None if the supervisor wants none."""
    wanted = os.environ.get("WATCHDOG_USEC", "")
    own = str(os.getpid())
    if not wanted.isdecimal() or os.environ.get("WATCHDOG_PID", own) != own:
        return None
    return max(1, int(wanted) // 3000)


def wait_for(thread: threading.Thread) -> None:
    """Waits for a thread that ends by itself. The supervisor takes that for work meanwhile."""
    pause = (interval() or 1000) / 1000
    while thread.is_alive():
        notify("WATCHDOG=1")
        thread.join(pause)
