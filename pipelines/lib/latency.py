# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints the latency of a live pipeline with and without csdtrack: see --help.

    SOURCE ! queue ! csdtrack ! fakesink
    SOURCE ! queue ! fakesink

take turns. Probes note when each frame passes the source's pad and the sink's. GStreamer's tracer
`latency` measures the same, but that of 1.26.2 (Debian 13) deadlocks every pipeline; later versions
don't.
"""

import argparse
import math
import re
import time
from collections.abc import Mapping, Sequence
from typing import Any

from pipelines.lib import command, sources

EPILOG = """
SOURCE is one of those of pipelines/live that are live and send their frames themselves:
/dev/videoN, decklink, decklink:N, simulate, simulate:SCENARIO, test:UYVY, test:v210.

The latency of a frame is the time from when it leaves the source to when it reaches the sink. The
second row has csdtrack in between, with the preset live-low-latency (docs/pipelines.md); nothing
else differs. The first second of each round, in which devices settle and features are learnt, is
not counted. The numbers hold for this machine, with what else runs on it.

Exit code: 0 if it was measured, 1 if not (one line says why), 2 for wrong use.
"""

SETTLE = 10**9  # ns at the beginning of a round that aren't counted
KINDS = ("without csdtrack", "with csdtrack")


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/latency", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Prints the latency (p50, p95, p99) of a live pipeline with and without "
        "csdtrack.")
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
        parser.error(f"--seconds: {options.seconds:g} leaves nothing to measure "
                     "after the first second, which isn't counted")
    return options


class Probes:
    """Measures how long each frame takes from a pipeline's source to its sink."""

    def __init__(self, pipeline: Any, sink: Any) -> None:
        from pipelines.lib.runner import Gst
        self._left: dict[int, int] = {}  # when a frame left the source, ns, by PTS
        self.arrivals: list[tuple[int, int]] = []  # (time, latency), ns
        self._ok = Gst.PadProbeReturn.OK
        found, source = pipeline.iterate_sources().next()
        assert found == Gst.IteratorResult.OK
        source.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, self._on_departure)
        sink.get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, self._on_arrival)

    def _on_departure(self, _pad: Any, info: Any) -> Any:
        self._left[info.get_buffer().pts] = time.monotonic_ns()
        return self._ok

    def _on_arrival(self, _pad: Any, info: Any) -> Any:
        now = time.monotonic_ns()
        left = self._left.pop(info.get_buffer().pts, None)
        if left is not None:
            self.arrivals.append((now, now - left))
        return self._ok

    def latencies(self) -> list[int]:
        return [latency for now, latency in self.arrivals if now >= self.arrivals[0][0] + SETTLE]


def percentile(values: Sequence[int], part: float) -> int:
    """The smallest of the values that at least this part of them doesn't exceed."""
    return sorted(values)[math.ceil(part * len(values)) - 1]


def table(measured: Mapping[str, Sequence[int]]) -> str:
    rows = [f"{'':18}{'p50':>9}{'p95':>9}{'p99':>9}   ms"]
    for kind, values in measured.items():
        parts = [f"{percentile(values, part) / 1e6:9.3f}" for part in (0.5, 0.95, 0.99)]
        rows.append(f"{kind:18}{''.join(parts)}   {len(values)} frames")
    return "\n".join(rows)


def main() -> None:
    options = command.parse_options(parse)
    source = sources.launch(options.source)
    from pipelines.lib import runner
    measured: dict[str, list[int]] = {kind: [] for kind in KINDS}
    for turn in range(options.rounds * 2):
        between = "csdtrack name=csdtrack ! " if turn % 2 else ""
        # The queue isn't leaky and the sink doesn't wait for the clock. Frames for which csdtrack
        # is too slow wait in the queue, and show as latency.
        run = runner.Run(
            "latency",
            f"{source} ! {command.FRAME_QUEUE} ! {between} fakesink sync=false name=sink",
            counted=("sink",))
        if between:
            runner.configure(run.element("csdtrack"), options.preset, {}, options.set)
        probes = Probes(run.pipeline, run.element("sink"))
        run.play(options.source, options.seconds)
        measured[KINDS[turn % 2]] += probes.latencies()
        if run.stopped:
            break
    if not all(measured.values()):
        raise command.Failure(f"{options.source}: too few frames came: give more --seconds")
    print(table(measured))


if __name__ == "__main__":
    command.run("latency", main)
