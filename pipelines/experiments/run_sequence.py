#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""One run of an experiment, which calls it: run_sequence.py PLAN SEEDS FOLDER SEQUENCE SEED.

Renders the sequence once and feeds it to all trackers. In the folder, which is there only when all of it succeeded: TRACKER.jsonl,
truth-SHARE.jsonl for each share of the plan, and run.json. Says on standard output how far it is: SEQUENCE SEED SHARE.
"""

import itertools
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

import builds
import gi
import sequences

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

# of a run's time: the plugin's trackers, which run while it is rendered; the rest are csd-peers
RENDERED = 0.8
# Frames wait for the slowest tracker, and few of them: a second of raw video each would fill the
# memory.
QUEUE = "queue max-size-buffers=8 max-size-bytes=0 max-size-time=0"


def to_file(path):
    # async: nobody waits for a preroll, for sift answers a frame long after lk.
    return f'filesink sync=false async=false location="{path}"'


def description(sequence, seed, folder, trackers):
    """One source, a tee, a branch for the truth, one for each tracker of the plugin, one for csd-peers."""
    branches = [f"csdtrackenc role=truth ! {to_file(folder / 'truth.jsonl')}",
                f"y4menc ! {to_file(folder / 'video.y4m')}"]
    # content-area=full: all of the simulated picture is tissue. One learner: the other core has
    # another run.
    branches += [
        f"csdtrack name={name} algorithm={name} points=truth learning=sync n-threads=1 content-area=full "
        f"post-messages=none ! csdtrackenc ! {to_file(folder / (name + '.jsonl'))}"
        for name in trackers
    ]
    return f"{sequence.source(seed)} ! tee name=t " + " ".join(f"t. ! {QUEUE} ! {branch}"
                                                               for branch in branches)


def structure_fields(structure):
    return {
        structure.nth_field_name(i): structure.get_value(structure.nth_field_name(i))
        for i in range(structure.n_fields())
    }


def only_first(tracker, frames):
    """Drops the others at its door."""
    coming = itertools.count()
    tracker.get_static_pad("sink").add_probe(
        Gst.PadProbeType.BUFFER, lambda *_: Gst.PadProbeReturn.OK
        if next(coming) < frames else Gst.PadProbeReturn.DROP)


def render(sequence, seed, folder, wanted, progress):
    """Plays the pipeline to its end. wanted: {tracker: frames}. Returns csdtrack's stats by tracker."""
    try:
        pipeline = Gst.parse_launch(description(sequence, seed, folder, wanted))
    except GLib.Error as error:  # such as: no element "x264enc"
        raise builds.Failure(f"{error.message}: is a plugin of GStreamer missing?") from None
    trackers = {name: pipeline.get_by_name(name) for name in wanted}
    for name, frames in wanted.items():
        if frames < sequence.frames:
            only_first(trackers[name], frames)
    bus = pipeline.get_bus()
    pipeline.set_state(Gst.State.PLAYING)
    try:
        while True:
            message = bus.timed_pop_filtered(
                Gst.SECOND, Gst.MessageType.EOS | Gst.MessageType.ERROR | Gst.MessageType.WARNING)
            if message is None:
                progress(
                    min(
                        t.get_property("stats").get_value("frames") / wanted[name]
                        for name, t in trackers.items()))
            elif message.type == Gst.MessageType.EOS:
                return {
                    name: structure_fields(t.get_property("stats")) for name, t in trackers.items()
                }
            else:
                problem, debug = message.parse_error(
                ) if message.type == Gst.MessageType.ERROR else message.parse_warning()
                raise builds.Failure(
                    f"{message.src.get_path_string()}: {problem.message} {debug or ''}")
    finally:
        pipeline.set_state(Gst.State.NULL)


def follow(name, options, folder):
    """A rival on the rendered video. One thread: the other core has another run."""
    command = [
        builds.program("csd-peers"), "-t", name, "-p", folder / "truth.jsonl", "-o",
        folder / f"{name}.jsonl", *options, "-"
    ]
    with open(folder / "video.y4m", "rb") as video:
        done = subprocess.run(list(map(str, command)), stdin=video, capture_output=True, text=True,
                              env={**os.environ, "OPENCV_FOR_THREADS_NUM": "1"})
    if done.returncode:
        raise builds.Failure(f"csd-peers --tracker {name}: {done.stderr.strip()}")


def check(folder, frames):
    """Each file has a line for each frame: a tracker that stopped early must not be scored as if it hadn't. frames: by name."""
    for name, count in frames.items():
        with open(folder / f"{name}.jsonl", "rb") as file:
            lines = sum(1 for _ in file)
        if lines != count:
            raise builds.Failure(f"{name} wrote {lines} lines for {count} frames")


def begun(tracks):
    """The ids that trackers began with: what a tool hides in the first frame is nobody's."""
    with open(tracks) as file:
        return {feature["id"] for feature in json.loads(file.readline())["features"]}


def select_truth(path, selected, ids, frames):
    """The truth of these features in the first frames, for csd-score, which wants tracks of all that it knows.

    Without time stamps, so that frames are matched by number: x264enc adds 1000 hours, which Y4M doesn't carry.
    """
    with open(path) as truth, open(selected, "w") as out:
        for line in itertools.islice(truth, frames):
            line = {**json.loads(line), "pts": None}
            line["features"] = [feature for feature in line["features"] if feature["id"] in ids]
            out.write(json.dumps(line, separators=(",", ":")) + "\n")


def run(plan, sequence, seed, folder):
    def progress(share):
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
    rivals = [(name, share)
              for share in shares
              for name in share.trackers
              if name not in sequences.PLUGIN]
    for i, (name, share) in enumerate(rivals):
        follow(name, [
            *(["--features", share.features] if share.features else []),
            *(["--frames", share.frames] if share.frames else [])
        ], unfinished)
        progress(RENDERED + (1 - RENDERED) * (i + 1) / len(rivals))
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
        "processor_seconds": round(sum(os.times()[:4]), 1),  # its children's too: csd-peers
        "stats": stats
    }
    (unfinished / "run.json").write_text(json.dumps(made, indent=1))
    shutil.rmtree(folder, ignore_errors=True)  # of another build
    unfinished.rename(folder)


def main():
    if len(sys.argv) != 6:
        asked = bool({"-h", "--help"} & set(sys.argv[1:]))
        print(__doc__, file=sys.stdout if asked else sys.stderr)
        return 0 if asked else 2
    name_of_plan, seeds, folder, name, seed = sys.argv[1:]
    plan = sequences.PLANS[name_of_plan](int(seeds))
    sequence, seed = plan.sequence(name), int(seed)
    Gst.init(None)
    try:
        run(plan, sequence, seed, pathlib.Path(folder) / f"{name}-{seed}")
    except (builds.Failure, OSError) as failure:
        print(f"{sequence.name}, seed {seed}: {failure}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
