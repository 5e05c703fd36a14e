#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/quickstart, on videos made up by ffmpeg: quickstart_test.py REPOSITORY BUILD. Speaks TAP."""

import csv
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import traceback

import numpy as np

REPOSITORY, BUILD = map(pathlib.Path, sys.argv[1:3])


def ffmpeg(*arguments):
    subprocess.run(["ffmpeg", "-v", "error", "-y", *map(str, arguments)], check=True, stdin=subprocess.DEVNULL)


def probe(path, *arguments):
    out = subprocess.run(["ffprobe", "-v", "error", "-of", "json", *arguments, str(path)], check=True,
                         capture_output=True, text=True).stdout
    return json.loads(out)


def picture(size="320x240", seconds=2, source="testsrc2"):
    return ["-f", "lavfi", "-i", f"{source}=size={size}:rate=25:duration={seconds}"]


def sound(seconds=2):
    return ["-f", "lavfi", "-i", f"sine=duration={seconds}"]


def command(*arguments):
    return [REPOSITORY / "pipelines" / "quickstart", "--no-install", *map(str, arguments)]


ENVIRONMENT = dict(os.environ, CSDTRACK_BUILD=str(BUILD))


def quickstart(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, env=ENVIRONMENT,
                          stdin=subprocess.DEVNULL, timeout=300)


def first_frame(path, width, height):
    """As players show it: ffmpeg turns it as the file asks."""
    grey = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "gray", "-"],
                          check=True, capture_output=True, stdin=subprocess.DEVNULL).stdout
    return np.frombuffer(grey, np.uint8).reshape(height, width).astype(float)


def packets(path):
    """The bytes of each sound packet, as hashes: what must not change when sound is copied."""
    return [p["data_hash"] for p in probe(path, "-select_streams", "a:0", "-show_packets", "-show_data_hash",
                                          "md5")["packets"]]


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def tracked(video, out, frames, *options):
    """Runs quickstart and checks what every run must leave. Returns what it printed."""
    done = quickstart(*options, video, out)
    assert done.returncode == 0, done.stderr
    lines = (out / "tracks.jsonl").read_text().splitlines()
    assert len(lines) == frames, f"{len(lines)} lines for {frames} frames"
    assert [json.loads(line)["frame"] for line in lines] == list(range(frames))
    with open(out / "tracks.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    of_json = [(f["id"], f["state"]) for line in lines for f in json.loads(line)["features"]]
    assert [(int(r["id"]), r["state"]) for r in rows] == of_json
    streams = probe(out / "overlay.mp4", "-show_streams")["streams"]
    videos = [s for s in streams if s["codec_type"] == "video"]
    assert [s["codec_name"] for s in videos] == ["h264"] and int(videos[0]["nb_frames"]) == frames, videos
    assert sorted(p.name for p in out.iterdir()) == ["overlay.mp4", "preview.png", "tracks.csv", "tracks.jsonl"]
    assert (out / "preview.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    for word in ("frames", "features", "p50", "p95", "overlay.mp4", "tracks.jsonl", "tracks.csv", "preview.png"):
        assert word in done.stdout, f"{word} is not in: {done.stdout}"
    return done


def refused(tmp, video, *words, out=None):
    done = quickstart(video, out or tmp / "out")
    assert done.returncode == 1, f"exit code {done.returncode}: {done.stdout}"
    lines = done.stderr.strip().splitlines()
    errors = [line for line in lines if line.startswith("quickstart: ")]
    assert len(errors) == 1, done.stderr
    for word in words:
        assert word in errors[0], errors[0]
    assert "Traceback" not in done.stderr
    assert "CRITICAL" not in done.stderr


def test_copies_aac(tmp):
    ffmpeg(*picture(), *sound(), "-c:v", "libx264", "-pix_fmt", "yuv420p", "-c:a", "aac", tmp / "a.mp4")
    tracked(tmp / "a.mp4", tmp / "out", 50)
    before, after = packets(tmp / "a.mp4"), packets(tmp / "out" / "overlay.mp4")
    # A demuxer may leave out what comes before the edit list's start, and the encoder's padding at the end.
    assert len(after) >= len(before) - 3
    start = before.index(after[0])
    assert start <= 2 and before[start:start + len(after)] == after


def test_encodes_what_mp4_cannot_hold(tmp):
    ffmpeg(*picture(), *sound(), "-c:v", "mjpeg", "-c:a", "pcm_s16le", tmp / "pcm.avi")
    tracked(tmp / "pcm.avi", tmp / "out", 50)
    streams = probe(tmp / "out" / "overlay.mp4", "-show_streams")["streams"]
    assert [s["codec_name"] for s in streams if s["codec_type"] == "audio"] == ["aac"]


def test_odd_size_ten_bit(tmp):
    ffmpeg(*picture("321x241", source="testsrc"), "-c:v", "ffv1", "-pix_fmt", "yuv444p10le", tmp / "odd.mkv")
    tracked(tmp / "odd.mkv", tmp / "out", 50)
    first = json.loads((tmp / "out" / "tracks.jsonl").read_text().splitlines()[0])
    assert (first["width"], first["height"]) == (321, 241)
    stream = probe(tmp / "out" / "overlay.mp4", "-show_streams")["streams"][0]
    assert (stream["width"], stream["height"]) == (320, 240)


def test_cut_off_matroska(tmp):
    ffmpeg(*picture(seconds=4), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "whole.mkv")
    whole = (tmp / "whole.mkv").read_bytes()
    (tmp / "cut.mkv").write_bytes(whole[:len(whole) // 2])
    decoded = int(probe(tmp / "cut.mkv", "-count_frames", "-show_streams")["streams"][0]["nb_read_frames"])
    assert 0 < decoded < 70
    done = tracked(tmp / "cut.mkv", tmp / "out", decoded)
    told = re.search(r"up to (\S+) s only, and says that it lasts 4\.0 s", done.stderr)
    # The last frames need others to be decoded that were cut off: they are missing before the end.
    assert told and 0 <= float(told[1]) - decoded / 25 < 0.3, done.stderr


def test_cut_off_in_the_header(tmp):
    ffmpeg(*picture(), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "whole.mkv")
    whole = (tmp / "whole.mkv").read_bytes()
    (tmp / "cut.mkv").write_bytes(whole[:whole.index(b"\x1f\x43\xb6\x75")])  # to the first cluster
    refused(tmp, tmp / "cut.mkv", "complete")


def test_plays_upright(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "a.mp4")
    for degrees, width, height in ((90, 240, 320), (180, 320, 240), (270, 240, 320)):
        ffmpeg("-i", tmp / "a.mp4", "-c", "copy", "-metadata:s:v:0", f"rotate={degrees}", tmp / f"{degrees}.mp4")
        out = tmp / f"out{degrees}"
        done = tracked(tmp / f"{degrees}.mp4", out, 25, "--algorithm", "lk", "--points", "100,50")
        assert "turned" in done.stdout, done.stdout
        before, after = (first_frame(p, width, height) for p in (tmp / f"{degrees}.mp4", out / "overlay.mp4"))
        assert np.abs(before - after).mean() < 5, "shown as the input is"
        assert np.abs(before - after[::-1, ::-1]).mean() > 20, "and this would show if it were not"
        assert png_size(out / "preview.png") == (2 * width + 4, 3 * height + 8), "six of them, 4 pixels apart"
        line = json.loads((out / "tracks.jsonl").read_text().splitlines()[0])
        # Positions are of the picture as it is stored.
        assert (line["width"], line["height"]) == (320, 240)
        assert [(f["x"], f["y"]) for f in line["features"]] == [(100, 50)]
        # The marker, with its id, is at (100, 50) turned, which is anticlockwise.
        x, y = {90: (50, 319 - 100), 180: (319 - 100, 239 - 50), 270: (239 - 50, 100)}[degrees]
        differs = np.abs(before - after) > 60
        assert differs[y - 20:y + 21, x - 20:x + 21].sum() == differs.sum() > 30, differs.sum()
    assert "turned" not in quickstart("--algorithm", "lk", tmp / "a.mp4", tmp / "out").stdout


def test_interrupted(tmp):
    ffmpeg(*picture(seconds=60), "-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p", tmp / "long.mkv")
    with subprocess.Popen(command(tmp / "long.mkv", tmp / "out"), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, env=ENVIRONMENT) as run:
        for line in run.stderr:
            if "25 %" in line:
                run.send_signal(signal.SIGINT)
                break
        out, err = run.communicate(timeout=300)
    assert run.returncode == 0 and "ended early" in err, err
    lines = (tmp / "out" / "tracks.jsonl").read_text().splitlines()
    assert 0 < len(lines) < 1500 and f"frames      {len(lines)} " in out, out
    video = probe(tmp / "out" / "overlay.mp4", "-count_frames", "-show_streams")["streams"][0]
    assert int(video["nb_read_frames"]) == len(lines)


def test_given_points(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "ffv1", tmp / "a.mkv")
    tracked(tmp / "a.mkv", tmp / "out", 25, "--points", "100,100;200.5,120", "--algorithm", "lk")
    for line in (tmp / "out" / "tracks.jsonl").read_text().splitlines():
        assert [f["id"] for f in json.loads(line)["features"]] == [0, 1]


def test_one_frame(tmp):
    ffmpeg(*picture(seconds=0.04), "-frames:v", 1, tmp / "one.png")
    tracked(tmp / "one.png", tmp / "out", 1)
    assert png_size(tmp / "out" / "preview.png") == (320, 240), "one frame, one tile"


def test_nothing_to_see(tmp):
    ffmpeg(*picture(seconds=1, source="color"), "-c:v", "ffv1", tmp / "black.mkv")
    assert "features    none" in tracked(tmp / "black.mkv", tmp / "out", 25).stdout


def test_mp4_without_index(tmp):
    ffmpeg(*picture(), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "a.mp4")
    whole = (tmp / "a.mp4").read_bytes()
    (tmp / "cut.mp4").write_bytes(whole[:whole.index(b"moov") - 4])
    refused(tmp, tmp / "cut.mp4", "index")


def test_not_a_video(tmp):
    (tmp / "text.mp4").write_text("no video, only words\n" * 100)
    (tmp / "out").mkdir()
    (tmp / "out" / "preview.png").write_bytes(b"of an earlier run")
    refused(tmp, tmp / "text.mp4", "video")
    assert not list((tmp / "out").iterdir()), "nothing is left that looks like a result"


def test_sound_only(tmp):
    ffmpeg(*sound(), "-c:a", "aac", tmp / "a.mp4")
    refused(tmp, tmp / "a.mp4", "no video stream")


def test_odd_names(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "ffv1", tmp / "a.mkv")
    video = (tmp / "a.mkv").rename(tmp / "it's 100 %d: a \"video\" ! é.mkv")
    tracked(video, tmp / "50 %d: it's ! é", 25, "--algorithm", "lk")


def test_missing_empty_folder(tmp):
    refused(tmp, tmp / "none.mp4", "there is no file")
    (tmp / "empty.mp4").touch()
    refused(tmp, tmp / "empty.mp4", "empty")
    refused(tmp, tmp, "folder")
    os.mkfifo(tmp / "fifo.mp4")
    refused(tmp, tmp / "fifo.mp4", "pipe")
    refused(tmp, "/dev/null", "device")


def test_out_cannot_be_written(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    (tmp / "file").touch()
    refused(tmp, tmp / "a.mkv", "OUT", out=tmp / "file")
    refused(tmp, tmp / "a.mkv", "OUT", out=pathlib.Path("/proc/out"))


def test_wrong_property(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    for option, word in (("max-features=many", "max-features"), ("no-such=1", "no-such"), ("algorithm=magic", "lk")):
        done = quickstart("--set", option, tmp / "a.mkv", tmp / "out")
        assert done.returncode == 1 and word in done.stderr, done.stderr


def test_help_and_wrong_use(tmp):
    assert quickstart("--help").returncode == 0 and "usage:" in quickstart("--help").stdout
    assert quickstart().returncode == 2
    assert quickstart("--no-such-option", tmp).returncode == 2


def main():
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
    print(f"1..{len(tests)}")
    failures = 0
    for number, (name, test) in enumerate(tests, 1):
        with tempfile.TemporaryDirectory(prefix="csdtrack-") as folder:
            try:
                test(pathlib.Path(folder))
                print(f"ok {number} - {name}", flush=True)
            except Exception:
                failures += 1
                print("".join("# " + line + "\n" for line in traceback.format_exc().splitlines()), end="")
                print(f"not ok {number} - {name}", flush=True)
    return failures > 0


sys.exit(main())
