# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks one video of an archive, wherever a job of it runs: archive_job.py PLAN NUMBER

    filesrc ! decodebin ! videoconvert ! csdtrack ! csdtrackenc ! filesink

The tracks get their name when they are whole, and then the result beside them (archive_index.py). A result says that the video is done, or
that it can't be. What isn't the video's fault (a full disk, another version here) leaves no result, a line on stderr and in the file that else
says how far the job is (OUT/.archive/progress/NUMBER), and exit code 1.

archive_job.py --host FOLDER: prints the version of csdtrack here; an error if the folder isn't here.
"""

import contextlib
import datetime
import json
import os
import pathlib
import sys
import time

from pipelines.lib import archive_index, command, runner, tracking

Gst, GLib = runner.Gst, runner.GLib

STALL = 600  # seconds without a new frame, after which none is waited for
TELL = 2     # seconds between two words on how far it is


def version():
    plugin = Gst.Registry.get().find_plugin("csdtrack")
    if not plugin:
        raise command.Failure(
            f"no csdtrack on {os.uname().nodename}: the repository must be built there, at the same path"
        )
    return plugin.get_version()


class Job(runner.Run):
    """A pipeline that is for files: an error is put down to the video if it is the video's."""

    SILENCE = 60
    NO_PICTURE = "check that it plays, or convert it to H.264"

    def __init__(self, video, out, settings):
        # videoconvert passes on what csdtrack takes as it is.
        super().__init__(
            "archive", "filesrc name=video ! decodebin ! videoconvert ! "
            "csdtrack name=csdtrack ! csdtrackenc ! application/x-ndjson ! filesink name=tracks")
        self.video, self._out = video, out
        self.element("video").set_property("location", str(video))
        runner.configure(self.element("csdtrack"), None, settings, [])
        self.videos_fault = True
        self.begin = None  # ns in the file, of the first frame
        self.position = 0  # ns in the file, end of the newest frame
        self.length = 0    # ns, as the file says itself; 0 if it doesn't
        self._missing = []
        self._stalled = (0, time.monotonic())

    def run(self, tracks, tell):
        self.element("tracks").set_property("location", str(tracks))
        self.element("csdtrack").get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER,
                                                                 self._passed)
        GLib.timeout_add_seconds(TELL, self._tick, tell)
        self.play("")

    def _ask_length(self):
        known, length = self.pipeline.query_duration(Gst.Format.TIME)
        if known and length > 0:
            self.length = length

    def end(self):
        """Told to end: half of the tracks are none."""
        self.videos_fault = False
        self.fail("ended before the video did")
        return GLib.SOURCE_REMOVE

    def _passed(self, pad, info):
        buffer = info.get_buffer()
        segment = pad.get_sticky_event(Gst.EventType.SEGMENT, 0).parse_segment()
        at = segment.to_stream_time(Gst.Format.TIME, buffer.pts)
        if at != Gst.CLOCK_TIME_NONE:
            length = buffer.duration if buffer.duration != Gst.CLOCK_TIME_NONE else 0
            self.begin = at if self.begin is None else min(self.begin, at)
            self.position = max(self.position, at + length)
        return Gst.PadProbeReturn.OK

    def _tick(self, tell):
        now = time.monotonic()
        if self.frames != self._stalled[0]:
            self._stalled = (self.frames, now)
        elif self.frames and now - self._stalled[1] > STALL:
            self.fail(
                f"'{self.video}' gave no frame after frame {self.frames} for {STALL // 60} minutes: check that it plays"
            )
        self._ask_length()
        if self.length:
            tell(min(self.position / self.length, 1))
        return GLib.SOURCE_CONTINUE

    def _handle(self, message):
        if message.type == Gst.MessageType.ELEMENT and message.has_name("missing-plugin"):
            self._missing.append(message.get_structure().get_string("name"))
        if message.type == Gst.MessageType.EOS:
            self._ask_length()
        if message.type != Gst.MessageType.ERROR:
            super()._handle(message)
            return
        error, debug = message.parse_error()
        factory = message.src.get_factory() if isinstance(message.src, Gst.Element) else None
        name = factory.get_name() if factory else ""
        if name == "filesink":
            self.videos_fault = False
            # to the letter: it is told from others by its text
            self.fail(str(command.of_filesink(self._out, error, debug)))
            return
        text = tracking.explain(self.video, self._out, "csdtrack", name, error, debug or "",
                                self._missing)
        if self.frames and name not in ("csdtrack", "csdtrackenc"):
            text = f"'{self.video}' is damaged from frame {self.frames} on ({error.message.rstrip('.')}): repair or convert it"
        self.fail(runner.one_line(text))


def count(tracks):
    """Of whole tracks, what the index tells about them."""
    features, claimed, frames, size = set(), 0, 0, (0, 0)
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


def told_of(out, number):
    return out / ".archive" / "progress" / str(number)


def track(plan, number):
    """The job `number` of all in the plan."""
    entry, out = plan["jobs"][number], pathlib.Path(plan["out"])
    name, video = entry["name"], pathlib.Path(entry["video"])
    here = version()
    if here != plan["version"]:
        raise command.Failure(
            f"csdtrack is {here} on {os.uname().nodename} and {plan['version']} where the run began: build the same on both"
        )
    found = archive_index.stamp(video)
    if not found:
        raise command.Failure(
            f"'{video}' isn't there on {os.uname().nodename}: its folder must have the same path on each machine"
        )
    result = dict.fromkeys(archive_index.COLUMNS)
    result.update(
        name=name, video=str(video), version=here, settings=plan["settings"], size=found[0],
        mtime=found[1], host=os.uname().nodename,
        started=datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"))
    tracks = archive_index.tracks_of(out, name)
    tracks.parent.mkdir(parents=True, exist_ok=True)
    told = told_of(out, number)
    begun = time.monotonic()
    job = Job(video, out, plan["properties"])
    with archive_index.unfinished(tracks) as file:
        unfinished = pathlib.Path(file.name)

    def tell(share):
        with contextlib.suppress(OSError):
            told.write_text(f"{share:.4f}")

    tell(0)
    try:
        if tracking.lacks_index(video):
            raise command.Failure(tracking.no_index(video))
        job.run(unfinished, tell)
        result.update(count(unfinished), status="done",
                      duration=(job.position - (job.begin or 0)) / Gst.SECOND,
                      note=tracking.breaks_off(video, job.position, job.length) or None)
        with open(unfinished, "rb") as file:
            os.fsync(file.fileno())
        os.replace(unfinished, tracks)
        result["tracks_size"], result["tracks_mtime"] = archive_index.stamp(tracks)
    except command.Failure as failure:
        if not job.videos_fault:
            raise
        # What older settings made of it must not seem to be of these.
        tracks.unlink(missing_ok=True)
        result.update(status="failed", error=str(failure))
    finally:
        for path in (unfinished, told):
            path.unlink(missing_ok=True)
    result["seconds"] = round(time.monotonic() - begun, 3)
    archive_index.whole(archive_index.result_of(out, name),
                        json.dumps(result, indent=1, ensure_ascii=False) + "\n")


def main():
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
            told_of(pathlib.Path(plan["out"]), number).write_text(json.dumps(str(failure)))
        raise


if __name__ == "__main__":
    command.run("archive", main)
