# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks one video of an archive, on any machine: python3 -m pipelines.lib.archive_job PLAN NUMBER

    filesrc ! decodebin ! videoconvert ! csdtrack ! csdtrackenc ! filesink

The tracks get their name when they are complete, and then the result is written beside them
(archive_index.py). A result says that the video is done, or that it can't be done. Other failures,
such as a full disk or another version of csdtrack here, leave no result. They end with exit code 1
and a message, on stderr and in OUT/.archive/progress/NUMBER, which otherwise holds the progress.

`--host FOLDER` prints the version of csdtrack here. It fails if the folder isn't here.
"""

import contextlib
import datetime
import json
import os
import pathlib
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

from pipelines.lib import archive_index, command, runner, video_errors
from pipelines.lib.frame_times import FrameTimes
from pipelines.lib.runner import GLib, Gst

STALL = 600  # seconds without a new frame, after which the job gives up
PROGRESS_INTERVAL = 2  # seconds


def version() -> str:
    plugin = Gst.Registry.get().find_plugin("csdtrack")
    if not plugin:
        raise command.Failure(f"no csdtrack on {os.uname().nodename}: the repository must be "
                              "built there, at the same path")
    return plugin.get_version()


class Job(runner.Run):
    """A run over a file, which knows whether an error is the video's fault."""

    NO_FRAME = "check that it plays, or convert it to H.264"

    def __init__(self, video: pathlib.Path, out: pathlib.Path,
                 properties: Mapping[str, str]) -> None:
        # videoconvert passes on formats that csdtrack takes.
        super().__init__(
            "archive", "filesrc name=video ! decodebin ! videoconvert ! "
            "identity name=times ! csdtrack name=csdtrack ! csdtrackenc ! application/x-ndjson ! "
            "filesink name=tracks")
        self.video, self._out = video, out
        self.times = FrameTimes(Gst, self.element("times").get_static_pad("src"), "archive",
                                str(video), rising=False)
        self.element("video").set_property("location", str(video))
        runner.configure(self.element("csdtrack"), None, properties, [])
        self.is_videos_fault = True
        self.begin: int | None = None  # ns in the file, of the first frame
        self.position = 0  # ns in the file, end of the newest frame
        self.length = 0    # ns, as the file says; 0 if it doesn't
        self.stated = video_errors.StatedLength(self.pipeline)
        self._missing: list[str] = []
        self._stalled = (0, time.monotonic())

    def run(self, tracks: pathlib.Path, report: Callable[[float], None]) -> None:
        """Tracks the video. `report` is called with the share that is done."""
        self.element("tracks").set_property("location", str(tracks))
        self.element("csdtrack").get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER,
                                                                 self._on_frame)
        GLib.timeout_add_seconds(PROGRESS_INTERVAL, self._tick, report)
        self.play("")

    def _query_length(self) -> None:
        known, length = self.pipeline.query_duration(Gst.Format.TIME)
        if known and length > 0:
            self.length = length

    def end(self) -> Any:
        """A signal to end fails the job: tracks of half a video are no result."""
        self.is_videos_fault = False
        self.fail("ended before the video did")
        return GLib.SOURCE_REMOVE

    def _on_frame(self, pad: Gst.Pad, info: Gst.PadProbeInfo) -> Any:
        buffer = info.get_buffer()
        segment = pad.get_sticky_event(Gst.EventType.SEGMENT, 0).parse_segment()
        at = segment.to_stream_time(Gst.Format.TIME, buffer.pts)
        if at != Gst.CLOCK_TIME_NONE:
            length = buffer.duration if buffer.duration != Gst.CLOCK_TIME_NONE else 0
            self.begin = at if self.begin is None else min(self.begin, at)
            self.position = max(self.position, at + length)
        return Gst.PadProbeReturn.OK

    def _tick(self, report: Callable[[float], None]) -> Any:
        now = time.monotonic()
        if self.frames != self._stalled[0]:
            self._stalled = (self.frames, now)
        elif self.frames and now - self._stalled[1] > STALL:
            self.fail(f"'{self.video}' gave no frame after frame {self.frames} "
                      f"for {STALL // 60} minutes: check that it plays")
        self._query_length()
        if self.length:
            report(min(self.position / self.length, 1))
        return GLib.SOURCE_CONTINUE

    def _handle(self, message: Gst.Message) -> None:
        if message.type == Gst.MessageType.ELEMENT and message.has_name("missing-plugin"):
            self._missing.append(message.get_structure().get_string("name"))
        if message.type == Gst.MessageType.EOS:
            self._query_length()
        super()._handle(message)

    def _on_error(self, element: Gst.Element, error: Any, debug: str | None) -> None:
        factory = runner.factory_name(element)
        if factory == "filesink":
            self.is_videos_fault = False
            # Verbatim: the program that started the job recognises a full disk by this text.
            self.fail(str(command.of_filesink(self._out, error, debug)))
            return
        text = video_errors.explain(self.video, self._out, "csdtrack", factory, error, debug or "",
                                    self._missing)
        if self.frames and factory not in ("csdtrack", "csdtrackenc"):
            reason = error.message.rstrip(".")
            text = (f"'{self.video}' is damaged from frame {self.frames} on ({reason}): "
                    "repair or convert it")
        self.fail(runner.one_line(text))


def count(tracks: pathlib.Path) -> dict[str, int]:
    """The index's figures about complete tracks."""
    features: set[int] = set()
    claimed, frames, size = 0, 0, (0, 0)
    with open(tracks, encoding="utf-8") as file:
        for text in file:
            line = json.loads(text)
            claims = [f["id"] for f in line["features"] if f["state"] in ("learning", "tracked")]
            features.update(claims)
            claimed += bool(claims)
            frames += 1
            size = (line["width"], line["height"])
    return {
        "frames": frames, "features": len(features), "claimed": claimed, "width": size[0],
        "height": size[1]
    }


def progress_path(out: pathlib.Path, number: int) -> pathlib.Path:
    return out / ".archive" / "progress" / str(number)


def track(plan: Mapping[str, Any], number: int) -> None:
    """Does the plan's job of this number."""
    entry, out = plan["jobs"][number], pathlib.Path(plan["out"])
    name, video = entry["name"], pathlib.Path(entry["video"])
    host, installed = os.uname().nodename, version()
    if installed != plan["version"]:
        raise command.Failure(f"csdtrack is {installed} on {host} and {plan['version']} "
                              "where the run began: build the same on both")
    found = archive_index.size_and_mtime(video)
    if not found:
        raise command.Failure(f"'{video}' isn't there on {host}: its folder must have the same "
                              "path on each machine")
    result: archive_index.Row = dict.fromkeys(archive_index.COLUMNS)
    result.update(
        name=name, video=str(video), version=installed, settings=plan["settings"], size=found[0],
        mtime=found[1], host=host,
        started=datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"))
    tracks = archive_index.tracks_path(out, name)
    tracks.parent.mkdir(parents=True, exist_ok=True)
    progress = progress_path(out, number)
    started = time.monotonic()
    job = Job(video, out, plan["properties"])
    with archive_index.open_unfinished(tracks) as file:
        unfinished = pathlib.Path(file.name)

    def report(share: float) -> None:
        with contextlib.suppress(OSError):
            progress.write_text(f"{share:.4f}")

    report(0)
    try:
        if video_errors.lacks_index(video):
            raise command.Failure(video_errors.no_index(video))
        job.run(unfinished, report)
        counted = count(unfinished)
        if counted["frames"] != job.times.frames:
            job.is_videos_fault = False
            raise command.Failure(f"{job.times.frames} frames came, and the tracks hold "
                                  f"{counted['frames']} lines: check the disk of '{out}'")
        result.update(counted, status="done",
                      duration=(job.position - (job.begin or 0)) / Gst.SECOND,
                      note=job.stated.known and video_errors.breaks_off(
                          video, job.position, job.length) or None)
        with open(unfinished, "rb") as written:
            os.fsync(written.fileno())
        os.replace(unfinished, tracks)
        size, mtime = archive_index.stamp(tracks.stat())
        result.update(tracks_size=size, tracks_mtime=mtime)
    except command.Failure as failure:
        if not job.is_videos_fault:
            raise
        # Tracks of an earlier run must not look like those of this one.
        tracks.unlink(missing_ok=True)
        result.update(status="failed", error=str(failure))
    finally:
        for path in (unfinished, progress):
            path.unlink(missing_ok=True)
    result["seconds"] = round(time.monotonic() - started, 3)
    archive_index.write_atomically(archive_index.result_path(out, name),
                                   json.dumps(result, indent=1, ensure_ascii=False) + "\n")


def main() -> None:
    if sys.argv[1] == "--host":
        if not os.path.isdir(sys.argv[2]):
            raise command.Failure(
                f"there is no folder '{sys.argv[2]}': it must have the same path on each machine")
        print(version())
        return
    with open(sys.argv[1], encoding="utf-8") as file:
        plan = json.load(file)
    number = plan["order"][int(sys.argv[2])]
    try:
        try:
            track(plan, number)
        except OSError as error:
            raise archive_index.failure(error, plan["out"]) from error
    except command.Failure as failure:
        with contextlib.suppress(OSError):
            progress_path(pathlib.Path(plan["out"]), number).write_text(json.dumps(str(failure)))
        raise


if __name__ == "__main__":
    command.run("archive", main)
