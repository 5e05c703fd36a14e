#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks over the network: tcpserversink sends them, and a plain socket reads them while the
pipeline runs."""

import csv
import socket
import threading

import numpy as np

import harness
from harness import Gst

FEATURES = 5


class Served:
    """A pipeline that sends its first frame once a client is connected, and that client's lines."""

    def __init__(self, test, forms, pictures):
        self.arrived = threading.Event()
        self.run = harness.Run(
            f"appsrc name=in ! csdtrack learning=sync max-features={FEATURES} ! csdtrackenc ! "
            f"{forms} tcpserversink name=server host=127.0.0.1 port=0",  # 0: any free port
            self._when_arrived(harness.buffers(pictures)), harness.rgb_caps())
        test.addCleanup(self.run.pipeline.set_state, Gst.State.NULL)
        server = self.run.element("server")
        server.connect("client-added", lambda *_: self.arrived.set())
        # Without a frame this stops in PAUSED. The server listens from READY on.
        self.run.pipeline.set_state(Gst.State.PLAYING)
        client = socket.create_connection(("127.0.0.1", server.get_property("current-port")),
                                          harness.TIMEOUT)
        test.addCleanup(client.close)
        self._text = client.makefile(encoding="utf-8", newline="")
        test.addCleanup(self._text.close)

    def _when_arrived(self, buffers):
        assert self.arrived.wait(harness.TIMEOUT), "the server saw no client"
        yield from buffers

    def lines(self, count):
        """The first `count` lines. Each must be complete."""
        for _ in range(count):
            line = self._text.readline()
            assert line.endswith("\n"), f"torn: {line!r}"
            yield line

    def rest(self):
        """What comes after them, until the pipeline has ended and the server has closed."""
        self.run.until(Gst.MessageType.EOS)
        self.run.pipeline.set_state(Gst.State.NULL)
        return self._text.read()


def scene(frames, black=0):
    """So many frames. The first `black` ones are black, so nothing is detected there."""
    made = harness.Scene()
    for t in range(frames):
        yield made.picture(t) if t >= black else np.zeros((made.height, made.width, 3), np.uint8)


class Network(harness.Case):
    def test_json_lines_come_one_by_one(self):
        served = Served(self, "", scene(30, black=5))
        lines = [harness.parse_line(line) for line in served.lines(30)]
        self.assertEqual(served.rest(), "")
        harness.check_tracks(self, lines, frames=30, most=FEATURES)
        self.assertEqual([len(line["features"]) for line in lines], [0] * 5 + [FEATURES] * 25)

    def test_csv_with_frames_without_features(self):
        # tcpserversink 1.22 would abort on an empty buffer.
        served = Served(self, "text/csv !", scene(30, black=5))
        rows = list(csv.DictReader(served.lines(1 + 25 * FEATURES)))
        self.assertEqual(served.rest(), "")
        self.assertEqual([int(row["frame"]) for row in rows],
                         [t for t in range(5, 30) for _ in range(FEATURES)])
        self.assertEqual([int(row["id"]) for row in rows], list(range(FEATURES)) * 25)
        self.assertEqual([int(row["pts"]) for row in rows],
                         [int(row["frame"]) * harness.FRAME for row in rows])


if __name__ == "__main__":
    harness.main()
