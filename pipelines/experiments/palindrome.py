# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs trackers on videos without truth, played forward and then backward: see --help."""

import argparse
import itertools
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator

from pipelines.experiments import builds, sequences
from pipelines.lib.failure import Failure

EPILOG = """
A video that is played forward and then backward shows each image twice and ends where it began. So
it tells how far a tracker can be trusted on your own video, without labels. All trackers start from
the same points, found in the first frame. For each tracker:

  claimed             in which share of the frames a position is claimed
  > 5 px apart        of two claims of a point on the same image, one on the way forward and one on
                      the way back: which share is farther apart, hence at least one of them is
                      false. These two are the honest pair: read them together
  returned            which share of the points is claimed in the last frame, at most 2 px from its
                      start
  falsely returned    which share is claimed there more than 5 px from its start. This pair flatters
                      trackers that compare with the first frame, because the last one is the same
                      image; "still", which never moves, returns with all points

Pixels are those of a picture with up to 576 lines, and grow with more lines. docs/metrics.md
defines all of it; docs/own-video.md says what you can conclude from it, and what not.

TRACKERS are those of csdtrack ({plugin}) and
those of csd-peers ({rivals}, and on {few} of the points, because they are slow, {slow}).

How it is done: all trackers see the same frames, as I420; interlaced frames stay whole. N images
give 2N − 1 frames: the last image is shown once. No decoder runs backward, so the way back is
decoded again in pieces: the last images first, as many as --memory holds, shown in reverse, then
those before them. A seek finds each piece. A checksum of each frame, taken on the way forward,
proves that the frames are identical; where they differ, the video is decoded from the beginning up
to the piece. Only 16 bytes an image and the tracks grow with the video; the tracks are on disk, in
DIR, or in $TMPDIR while it runs.

Installs what is missing first (Debian 12 and 13; apt, as root or with sudo) and builds csdtrack
into build/, once.
Exit code: 0 if all is scored, 1 if something failed (it says what, and scores the other videos),
2 for wrong use.
"""
SLOW_FEATURES = 10
EVERY_TRACKER = (*sequences.PLUGIN, *sequences.RIVALS, *sequences.SLOW_RIVALS)


def number(kind: type[int] | type[float], least: int) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"'{text}' is no number") from None
        if not least <= value < 1e9:
            raise argparse.ArgumentTypeError(f"{text} is not from {least} to 10⁹")
        return value

    return parse


def tracker_list(text: str) -> list[str]:
    names = list(dict.fromkeys(text.split(",")))
    for name in names:
        if name not in EVERY_TRACKER:
            raise argparse.ArgumentTypeError(
                f"there is no tracker '{name}': {', '.join(EVERY_TRACKER)}")
    return names


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/experiments/palindrome",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Tracks points through videos played forward and then backward, and says how "
        "many come back.", epilog=EPILOG.format(plugin=", ".join(sequences.PLUGIN),
                                                rivals=", ".join(sequences.RIVALS),
                                                few=SLOW_FEATURES,
                                                slow=", ".join(sequences.SLOW_RIVALS)))
    parser.add_argument("videos", nargs="+", type=pathlib.Path, metavar="VIDEO",
                        help="any file that GStreamer can decode")
    parser.add_argument("--trackers", type=tracker_list, default=list(EVERY_TRACKER),
                        metavar="A,B,...", help="these only")
    parser.add_argument("--frames", type=number(int, 2), default=250, metavar="N",
                        help="at most N images of each video (250)")
    parser.add_argument("--from", type=number(float, 0), default=0, dest="since", metavar="SECONDS",
                        help="begin there (0); the first image must show tissue")
    parser.add_argument("--features", type=number(int, 1), default=50, metavar="N",
                        help="how many points to look for (50)")
    parser.add_argument("--out", type=pathlib.Path, metavar="DIR",
                        help="keep the tracks, as DIR/NAME-OF-VIDEO/TRACKER.jsonl")
    parser.add_argument("--memory", type=number(int, 1), default=128, metavar="MB",
                        help="how many MB of frames to hold on the way back (128)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print JSON (docs/metrics.md)")
    form.add_argument("--markdown", action="store_true", help="print a Markdown table")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")
    return parser.parse_args()


def check_video(video: pathlib.Path) -> None:
    if not video.exists():
        raise Failure(f"there is no file '{video}': give the path of a video")
    if not video.is_file():
        raise Failure(f"'{video}' is no file: give the path of a video")
    if not os.access(video, os.R_OK):
        raise Failure(
            f"'{video}' can't be read: change its permissions (chmod u+r) or run as its owner")
    if video.stat().st_size == 0:
        raise Failure(f"'{video}' is empty: give the path of a video")


def named(videos: Iterable[pathlib.Path]) -> Iterator[tuple[str, pathlib.Path]]:
    """Each video with a name of its own.

    Videos of the same name are numbered, past names that another video already has.
    """
    videos = list(videos)
    taken = {video.stem for video in videos}
    seen: set[str] = set()
    for video in videos:
        name, count = video.stem, 1
        while name in seen or (count > 1 and name in taken):
            count += 1
            name = f"{video.stem}-{count}"
        seen.add(name)
        yield name, video


def track(video: pathlib.Path, options: argparse.Namespace, folder: pathlib.Path) -> None:
    """Writes the tracks into the folder."""
    # These start GStreamer, which by then must know where the plugin is.
    from pipelines.experiments import follow, mirror
    from pipelines.lib import report

    shown = mirror.Mirror(video, round(options.since * 1e9), options.frames, options.memory << 20)
    frames = iter(shown)
    first = next(frames)  # raises Failure if there is none
    points = follow.detect(shown.picture, first[1], options.features)
    if not points:
        raise Failure(f"'{video}': nothing stands out in the first frame: begin where tissue is "
                      "seen (--from SECONDS)")
    with report.Progress(video.name) as progress:
        follow.follow(itertools.chain([first], frames), shown.picture, points, options.trackers,
                      SLOW_FEATURES, folder,
                      lambda pushed: progress.show(pushed / (2 * shown.images - 1), pushed))
        progress.done(2 * shown.images - 1)
    if shown.cut_short:
        print(f"palindrome: {shown.cut_short}", file=sys.stderr)
    if shown.decoded_anew:
        print(f"palindrome: '{video}': {shown.decoded_anew} of {shown.pieces} pieces were decoded "
              "from the beginning, because seeking gave other frames", file=sys.stderr)


def score(out: pathlib.Path, names: Iterable[str], options: argparse.Namespace) -> None:
    """Prints csd-score's report, which names the files as from `out`."""
    form = [f"--{name}" for name in ("json", "markdown") if getattr(options, name)]
    files = [f"{name}/{tracker}.jsonl" for name in names for tracker in options.trackers]
    done = subprocess.run([builds.program("csd-score"), "--palindrome", *form, "--", *files],
                          cwd=out, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        raise Failure(done.stderr.strip())


def run(options: argparse.Namespace) -> bool:
    """Whether all went well. A video that can't be played is reported, and the others are
    scored."""
    for video in options.videos:
        check_video(video)
    targets = ["plugin", "csd-score"]
    if set(options.trackers) - set(sequences.PLUGIN):
        targets.append("csd-peers")
    builds.make(not options.no_install, targets, "run", ())
    os.environ.update(builds.environment())
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".unfinished-", dir=options.out) as folder:
        made = pathlib.Path(folder)
        names = []
        for name, video in named(options.videos):
            (made / name).mkdir()
            try:
                track(video, options, made / name)
                names.append(name)
            except Failure as failure:
                print(f"palindrome: {failure}", file=sys.stderr)
        if names:
            score(made, names, options)
        if options.out:
            for name in names:
                (options.out / name).mkdir(exist_ok=True)
                for tracks in (made / name).iterdir():
                    os.replace(tracks, options.out / name / tracks.name)
    return len(names) == len(options.videos)


def main() -> int:
    options = arguments()
    try:
        return 0 if run(options) else 1
    except OSError as error:
        print(f"palindrome: {error.filename or options.out}: {error.strerror}", file=sys.stderr)
        return 1
    except Failure as failure:
        print(f"palindrome: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    try:
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
        sys.exit(main())
    except KeyboardInterrupt:
        print("\npalindrome: stopped", file=sys.stderr)
        sys.exit(130)
