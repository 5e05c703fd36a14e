# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prints the latency of a live pipeline with and without csdtrack, by GStreamer's latency tracer: see --help.

    SOURCE ! queue ! csdtrack ! fakesink
    SOURCE ! queue ! fakesink

by turns. The tracer writes, for each frame, how long it took from the source's pad to the sink's.
"""

import argparse
import math
import os
import pathlib
import re
import tempfile

import command
import sources

EPILOG = """
SOURCE is one of those of pipelines/live that are live and send their frames themselves: /dev/videoN, decklink, decklink:N, simulate,
simulate:SCENARIO, test:UYVY, test:v210.

The latency of a frame is what GStreamer's tracer `latency` says: the time from when it leaves the source to when it comes to the sink. The
second row has csdtrack in between, with the preset live-low-latency (docs/elements.md); nothing else differs. The first second of each round,
in which devices settle and features are learnt, is not counted. Numbers hold for this machine, with what else runs on it.

Exit code: 0 if it was measured, 1 if not (one line says why), 2 for wrong use.
"""

SETTLE = 10**9  # ns at the beginning of a round that aren't counted
KINDS = ("without csdtrack", "with csdtrack")


def parse(arguments):
    parser = argparse.ArgumentParser(prog="pipelines/latency", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
                                     description="Prints the latency (p50, p95, p99) of a live pipeline with and without csdtrack.")
    parser.add_argument("source", nargs="?", default="simulate", metavar="SOURCE", help="where the picture comes from (simulate)")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="of each, by turns (3)")
    parser.add_argument("--seconds", type=command.positive, default=10, metavar="N", help="length of a round (10)")
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME", help="of csdtrack (live-low-latency)")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if not re.match(r"/dev/|(decklink|simulate|test)(:|$)", options.source):
        parser.error(f"'{options.source}' is no live source: see --help")
    if not 1 <= options.rounds <= 1000:
        parser.error(f"--rounds: {options.rounds} is not from 1 to 1000")
    if options.seconds <= SETTLE / 1e9:
        parser.error(f"--seconds: {options.seconds:g} leaves nothing to measure after the first second, which isn't counted")
    return options


def latencies(log):
    """{name of the sink: [(time of the record, latency), ...]}, ns, of the tracer's records."""
    found = {}
    for sink, latency, time in re.findall(r" latency, .*sink-element=\(string\)([^,]+),.* time=\(guint64\)(\d+), ts=\(guint64\)(\d+);", log):
        found.setdefault(sink, []).append((int(time), int(latency)))
    return found


def percentile(values, part):
    """The smallest of the values that at least this part of them doesn't exceed."""
    return sorted(values)[math.ceil(part * len(values)) - 1]


def table(measured):
    rows = [f"{'':18}{'p50':>9}{'p95':>9}{'p99':>9}   ms"]
    for kind, values in measured.items():
        rows.append(f"{kind:18}" + "".join(f"{percentile(values, part) / 1e6:9.3f}" for part in (0.5, 0.95, 0.99)) + f"   {len(values)} frames")
    return "\n".join(rows)


def main():
    options = command.options(parse)
    begin = sources.begin(options.source)
    with tempfile.TemporaryDirectory(prefix="csdtrack-") as folder:
        # GStreamer reads these once, when it starts.
        log = pathlib.Path(folder) / "tracer.log"
        os.environ.update(GST_TRACERS="latency(flags=pipeline)", GST_DEBUG="GST_TRACER:7", GST_DEBUG_FILE=str(log), GST_DEBUG_NO_COLOR="1")
        import runner
        for turn in range(options.rounds * 2):
            between = "csdtrack name=csdtrack ! " if turn % 2 else ""
            # Not leaky, and no waiting for the clock: what csdtrack does not keep up with waits in the queue, and is seen as latency.
            run = runner.Run("latency", f"{begin} ! {command.FRAMES} ! {between} "
                                        f"fakesink sync=false name=round{turn}", counted=(f"round{turn}",))
            if between:
                runner.configure(run.element("csdtrack"), options.preset, {}, options.set)
            run.play(options.source, options.seconds)
            if run.told:
                break
        measured = {kind: [] for kind in KINDS}
        for sink, records in latencies(log.read_text()).items():
            measured[KINDS[int(sink.removeprefix("round")) % 2]] += [latency for time, latency in records if time >= records[0][0] + SETTLE]
        if not all(measured.values()):
            raise command.Failure(f"{options.source}: too few frames came: give more --seconds")
        print(table(measured))


command.run("latency", main)
