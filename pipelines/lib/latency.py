# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints the latency of a live pipeline with and without csdtrack: see --help.

    SOURCE ! queue ! csdtrack ! fakesink
    SOURCE ! queue ! fakesink

by turns. Probes note when each frame passes the source's pad and the sink's. GStreamer's tracer `latency` says the same, but that of 1.26.2
(Debian 13) stops every pipeline: a deadlock, mended since.
"""

import argparse
import math
import re
import time

from pipelines.lib import command, sources

EPILOG = """
SOURCE is one of those of pipelines/live that are live and send their frames themselves: /dev/videoN, decklink, decklink:N, simulate,
simulate:SCENARIO, test:UYVY, test:v210.

The latency of a frame is the time from when it leaves the source to when it comes to the sink. The
second row has csdtrack in between, with the preset live-low-latency (docs/pipelines.md); nothing else differs. The first second of each round,
in which devices settle and features are learnt, is not counted. Numbers hold for this machine, with what else runs on it.

Exit code: 0 if it was measured, 1 if not (one line says why), 2 for wrong use.
"""

SETTLE = 10**9  # ns at the beginning of a round that aren't counted
KINDS = ("without csdtrack", "with csdtrack")


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/latency", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG, description=
        "Prints the latency (p50, p95, p99) of a live pipeline with and without csdtrack.")
    parser.add_argument("source", nargs="?", default="simulate", metavar="SOURCE",
                        help="where the picture comes from (simulate)")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="of each, by turns (3)")
    parser.add_argument("--seconds", type=command.positive, default=10, metavar="N",
                        help="length of a round (10)")
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME",
                        help="of csdtrack (live-low-latency)")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if not re.match(r"/dev/|(decklink|simulate|test)(:|$)", options.source):
        parser.error(f"'{options.source}' is no live source: see --help")
    if not 1 <= options.rounds <= 1000:
        parser.error(f"--rounds: {options.rounds} is not from 1 to 1000")
    if options.seconds <= SETTLE / 1e9:
        parser.error(
            f"--seconds: {options.seconds:g} leaves nothing to measure after the first second, which isn't counted"
        )
    return options


class Probes:
    """When the frames of a pipeline left its source, and how long they took to the sink."""

    def __init__(self, pipeline, sink):
        from pipelines.lib.runner import Gst
        self._left = {}     # ns, by PTS
        self.arrivals = []  # (when, latency), ns
        self._go_on = Gst.PadProbeReturn.OK
        found, source = pipeline.iterate_sources().next()
        assert found == Gst.IteratorResult.OK
        source.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, self._leaves)
        sink.get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, self._comes)

    def _leaves(self, _pad, info):
        self._left[info.get_buffer().pts] = time.monotonic_ns()
        return self._go_on

    def _comes(self, _pad, info):
        now = time.monotonic_ns()
        left = self._left.pop(info.get_buffer().pts, None)
        if left is not None:
            self.arrivals.append((now, now - left))
        return self._go_on

    def latencies(self):
        return [latency for now, latency in self.arrivals if now >= self.arrivals[0][0] + SETTLE]


def percentile(values, part):
    """The smallest of the values that at least this part of them doesn't exceed."""
    return sorted(values)[math.ceil(part * len(values)) - 1]


def table(measured):
    rows = [f"{'':18}{'p50':>9}{'p95':>9}{'p99':>9}   ms"]
    for kind, values in measured.items():
        rows.append(f"{kind:18}" + "".join(f"{percentile(values, part) / 1e6:9.3f}"
                                           for part in (0.5, 0.95, 0.99)) +
                    f"   {len(values)} frames")
    return "\n".join(rows)


def main():
    options = command.options(parse)
    begin = sources.begin(options.source)
    from pipelines.lib import runner
    measured = {kind: [] for kind in KINDS}
    for turn in range(options.rounds * 2):
        between = "csdtrack name=csdtrack ! " if turn % 2 else ""
        # Not leaky, and no waiting for the clock: what csdtrack does not keep up with waits in the
        # queue, and is seen as latency.
        run = runner.Run("latency",
                         f"{begin} ! {command.FRAMES} ! {between} fakesink sync=false name=sink",
                         counted=("sink", ))
        if between:
            runner.configure(run.element("csdtrack"), options.preset, {}, options.set)
        probes = Probes(run.pipeline, run.element("sink"))
        run.play(options.source, options.seconds)
        measured[KINDS[turn % 2]] += probes.latencies()
        if run.told:
            break
    if not all(measured.values()):
        raise command.Failure(f"{options.source}: too few frames came: give more --seconds")
    print(table(measured))


if __name__ == "__main__":
    command.run("latency", main)
