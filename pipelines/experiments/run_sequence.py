# SPDX-License-Identifier: LGPL-2.1-or-later
"""One run of an experiment.

usage: python3 -m pipelines.experiments.run_sequence PLAN SEEDS FOLDER SEQUENCE SEED

Renders the sequence once and feeds it to all trackers. FOLDER then has a folder SEQUENCE-SEED, if
everything succeeded, with TRACKER.jsonl, truth-SHARE.jsonl for each share of the plan, and
run.json. Standard output says how far it is: SEQUENCE SEED SHARE.
"""

import itertools
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time
import typing
from collections.abc import Callable, Mapping, Sequence as Rows

import gi

from pipelines.experiments import builds, sequences
from pipelines.experiments.sequences import Plan, Sequence
from pipelines.lib.failure import Failure

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

# The share of a run's time that passes while the sequence is rendered and the plugin's trackers
# run. The rest is csd-peers'.
RENDERED = 0.8
# Frames wait for the slowest tracker. Only a few of them: queues of a second of raw video each
# would fill the memory.
QUEUE = "queue max-size-buffers=8 max-size-bytes=0 max-size-time=0"


def to_file(path: pathlib.Path) -> str:
    # async=false: no sink waits for a preroll, because sift answers a frame long after lk.
    return f'filesink sync=false async=false location="{path}"'


def description(sequence: Sequence, seed: int, folder: pathlib.Path,
                trackers: Mapping[str, int]) -> str:
    """The pipeline: one source and a tee with a branch for the truth, one for each tracker of the
    plugin, and one for csd-peers."""
    branches = [
        f"csdtrackenc role=truth ! {to_file(folder / 'truth.jsonl')}",
        f"y4menc ! {to_file(folder / 'video.y4m')}",
    ]
    # All of the simulated picture is tissue: content-area=full. Each run has one core, so
    # n-threads=1.
    branches += [
        f"csdtrack name={name} algorithm={name} points=truth learning=sync n-threads=1 "
        "content-area=full post-messages=none ! "
        f"csdtrackenc ! {to_file(folder / f'{name}.jsonl')}" for name in trackers
    ]
    return f"{sequence.source(seed)} ! tee name=t " + " ".join(f"t. ! {QUEUE} ! {branch}"
                                                               for branch in branches)


def structure_fields(structure: Gst.Structure) -> dict[str, typing.Any]:
    names = map(structure.nth_field_name, range(structure.n_fields()))
    return {name: structure.get_value(name) for name in names}


def only_first(tracker: Gst.Element, frames: int) -> None:
    """Lets only the first frames into the tracker."""
    coming = itertools.count()

    def pass_or_drop(*_: object) -> Gst.PadProbeReturn:
        return Gst.PadProbeReturn.OK if next(coming) < frames else Gst.PadProbeReturn.DROP

    tracker.get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, pass_or_drop)


def render(sequence: Sequence, seed: int, folder: pathlib.Path, wanted: Mapping[str, int],
           progress: Callable[[float], None]) -> dict[str, typing.Any]:
    """Plays the pipeline to its end. wanted: frames by tracker. Returns csdtrack's stats by
    tracker."""
    try:
        pipeline = Gst.parse_launch(description(sequence, seed, folder, wanted))
    except GLib.Error as error:  # such as: no element "x264enc"
        raise Failure(f"{error.message}: is a plugin of GStreamer missing?") from None
    trackers = {name: pipeline.get_by_name(name) for name in wanted}
    for name, frames in wanted.items():
        if frames < sequence.frames:
            only_first(trackers[name], frames)
    bus = pipeline.get_bus()
    pipeline.set_state(Gst.State.PLAYING)
    kinds = Gst.MessageType.EOS | Gst.MessageType.ERROR | Gst.MessageType.WARNING
    try:
        while True:
            message = bus.timed_pop_filtered(Gst.SECOND, kinds)
            stats = {name: tracker.get_property("stats") for name, tracker in trackers.items()}
            if message is None:
                progress(min(stats[name].get_value("frames") / wanted[name] for name in stats))
            elif message.type == Gst.MessageType.EOS:
                return {name: structure_fields(structure) for name, structure in stats.items()}
            else:
                is_error = message.type == Gst.MessageType.ERROR
                problem, debug = message.parse_error() if is_error else message.parse_warning()
                raise Failure(f"{message.src.get_path_string()}: {problem.message} {debug or ''}")
    finally:
        pipeline.set_state(Gst.State.NULL)


def follow(name: str, options: Rows[str], folder: pathlib.Path) -> None:
    """Runs a rival on the rendered video. In one thread: the other core has another run."""
    command = [
        builds.program("csd-peers"), "-t", name, "-p", folder / "truth.jsonl", "-o",
        folder / f"{name}.jsonl", *options, "-"
    ]
    with open(folder / "video.y4m", "rb") as video:
        done = subprocess.run(list(map(str, command)), stdin=video, capture_output=True, text=True,
                              env={**os.environ, "OPENCV_FOR_THREADS_NUM": "1"})
    if done.returncode:
        raise Failure(f"csd-peers --tracker {name}: {done.stderr.strip()}")


def check(folder: pathlib.Path, frames: Mapping[str, int]) -> None:
    """Raises Failure unless each file has a line for each of its frames.

    A tracker that stopped early must not be scored as if it hadn't. frames: by name of the file.
    """
    for name, count in frames.items():
        with open(folder / f"{name}.jsonl", "rb") as file:
            lines = sum(1 for _ in file)
        if lines != count:
            raise Failure(f"{name} wrote {lines} lines for {count} frames")


def begun(tracks: pathlib.Path) -> set[int]:
    """The ids that trackers began with. Features that a tool hides in the first frame have none."""
    with open(tracks) as file:
        return {feature["id"] for feature in json.loads(file.readline())["features"]}


def select_truth(path: pathlib.Path, selected: pathlib.Path, ids: set[int], frames: int) -> None:
    """Writes the truth of these features in the first frames for csd-score, which expects tracks
    of all features that the truth has.

    Without time stamps, so that frames are matched by number: x264enc adds 1000 hours, which Y4M
    doesn't carry.
    """
    with open(path) as truth, open(selected, "w") as out:
        for text in itertools.islice(truth, frames):
            line: dict[str, typing.Any] = {**json.loads(text), "pts": None}
            line["features"] = [feature for feature in line["features"] if feature["id"] in ids]
            out.write(json.dumps(line, separators=(",", ":")) + "\n")


def run(plan: Plan, sequence: Sequence, seed: int, folder: pathlib.Path) -> None:
    def progress(share: float) -> None:
        print(sequence.name, seed, f"{share:.4f}", flush=True)

    unfinished = folder.with_name(f".unfinished-{folder.name}")
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    began = time.monotonic()
    shares = plan.shares_of(sequence, seed)
    frames = {name: share.of(sequence)[1] for share in shares for name in share.trackers}
    stats = render(sequence, seed, unfinished,
                   {name: n for name, n in frames.items() if name in sequences.PLUGIN},
                   lambda share: progress(RENDERED * share))
    rivals = [(name, share) for share in shares for name in share.trackers
              if name not in sequences.PLUGIN]
    for i, (name, share) in enumerate(rivals, 1):
        options: list[str] = []
        if share.features:
            options += ["--features", str(share.features)]
        if share.frames:
            options += ["--frames", str(share.frames)]
        follow(name, options, unfinished)
        progress(RENDERED + (1 - RENDERED) * i / (len(rivals) + 1))
    (unfinished / "video.y4m").unlink()
    check(unfinished, {"truth": sequence.frames, **frames})
    for share in shares:
        select_truth(unfinished / "truth.jsonl", unfinished / f"truth-{share.name}.jsonl",
                     begun(unfinished / f"{share.trackers[0]}.jsonl"), share.of(sequence)[1])
    (unfinished / "truth.jsonl").unlink()
    made = {
        "identity": builds.identity(sequence, seed, plan),
        "versions": builds.versions(),
        "seconds": round(time.monotonic() - began, 1),
        "processor_seconds": round(sum(os.times()[:4]), 1),  # also of its children, csd-peers
        "stats": stats,
    }
    (unfinished / "run.json").write_text(json.dumps(made, indent=1))
    shutil.rmtree(folder, ignore_errors=True)  # of another build
    unfinished.rename(folder)
    progress(1)


def main() -> int:
    if len(sys.argv) != 6:
        asked = bool({"-h", "--help"} & set(sys.argv[1:]))
        print(__doc__, file=sys.stdout if asked else sys.stderr)
        return 0 if asked else 2
    name_of_plan, seeds, folder, name, seed = sys.argv[1:]
    plan = sequences.PLANS[name_of_plan](int(seeds))
    sequence = plan.sequence(name)
    Gst.init(None)
    try:
        run(plan, sequence, int(seed), pathlib.Path(folder) / f"{name}-{seed}")
    except (Failure, OSError) as failure:
        print(f"{name}, seed {seed}: {failure}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
