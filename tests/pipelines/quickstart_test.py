#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/quickstart on videos made by ffmpeg. Prints TAP: quickstart_test.py REPOSITORY BUILD"""

import contextlib
import csv
import itertools
import json
import math
import os
import pathlib
import re
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import traceback

import harness
import numpy as np

REPOSITORY, BUILD = map(pathlib.Path, sys.argv[1:3])


def ffmpeg(*arguments):
    subprocess.run(["ffmpeg", "-v", "error", "-y", *map(str, arguments)], check=True,
                   stdin=subprocess.DEVNULL)


def probe(path, *arguments):
    out = subprocess.run(["ffprobe", "-v", "error", "-of", "json", *arguments, str(path)],
                         check=True, capture_output=True, text=True).stdout
    return json.loads(out)


def picture(size="320x240", seconds=2, source="testsrc2"):
    return ["-f", "lavfi", "-i", f"{source}=size={size}:rate=25:duration={seconds}"]


def sound(seconds=2):
    return ["-f", "lavfi", "-i", f"sine=duration={seconds}"]


def command(*arguments):
    return [REPOSITORY / "pipelines" / "quickstart", "--no-install", *map(str, arguments)]


RESULTS = ["overlay.mp4", "page", "preview.png", "tracks.csv", "tracks.jsonl"]
SIMULATED = [*RESULTS, "truth.jsonl"]
ENVIRONMENT = dict(os.environ, CSDTRACK_BUILD=str(BUILD))


def start(*arguments):
    return subprocess.Popen(command(*arguments), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)


def quickstart(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, env=ENVIRONMENT,
                          stdin=subprocess.DEVNULL, timeout=300)


def long_video(tmp):
    ffmpeg(*picture(seconds=60), "-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p",
           tmp / "long.mkv")
    return tmp / "long.mkv"


def first_frame(path, width, height):
    """The first frame as players show it: ffmpeg rotates it as the file demands."""
    grey = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-frames:v", "1", "-f", "rawvideo",
                           "-pix_fmt", "gray", "-"],
                          check=True, capture_output=True, stdin=subprocess.DEVNULL).stdout
    return np.frombuffer(grey, np.uint8).reshape(height, width).astype(float)


def packets(path):
    """Hashes of the bytes of each sound packet. They must not change when sound is copied."""
    return [p["data_hash"] for p in probe(path, "-select_streams", "a:0", "-show_packets",
                                          "-show_data_hash", "md5")["packets"]]


def png_size(path):
    return struct.unpack(">II", path.read_bytes()[16:24])


def tracked(video, out, frames, *options, without=()):
    """Runs quickstart and checks its results, but those in `without`. Returns the finished
    process."""
    done = quickstart(*options, video, out)
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[0] == f"tracking {video.name}", done.stderr
    check_results(out, frames, done, [name for name in RESULTS if name not in without])
    return done


def check_results(out, frames, done, results):
    lines = (out / "tracks.jsonl").read_text().splitlines()
    assert len(lines) == frames, f"{len(lines)} lines for {frames} frames"
    assert [json.loads(line)["frame"] for line in lines] == list(range(frames))
    with open(out / "tracks.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    of_json = [(f["id"], f["state"]) for line in lines for f in json.loads(line)["features"]]
    assert [(int(r["id"]), r["state"]) for r in rows] == of_json
    streams = probe(out / "overlay.mp4", "-show_streams")["streams"]
    videos = [s for s in streams if s["codec_type"] == "video"]
    assert [s["codec_name"] for s in videos] == ["h264"], videos
    assert int(videos[0]["nb_frames"]) == frames, videos
    assert sorted(contents(out)) == results
    assert (out / "preview.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    if "page" in results:
        index = (out / "page" / "data" / "index.js").read_text()
        assert f'"frames":{frames},' in index, index
        assert (out / "page" / "index.html").stat().st_size, index
    for word in ("frames", "features", "p50", "p95", *results):
        assert word in done.stdout, f"{word} is not in: {done.stdout}"


def simulated(out, frames, *options, without=()):
    """Runs quickstart without a video and checks its results, but those in `without`. Returns what
    it printed, tracks and truth."""
    done = quickstart("--frames", frames, "--simulate", *options, out)
    assert done.returncode == 0, done.stderr
    check_results(out, frames, done, [name for name in SIMULATED if name not in without])
    tracks, truth = ([json.loads(line) for line in (out / name).read_text().splitlines()]
                     for name in ("tracks.jsonl", "truth.jsonl"))
    assert {line["role"] for line in tracks} == {"track"}
    assert {line["role"] for line in truth} == {"truth"}
    assert [(t["frame"], t["pts"], t["width"], t["height"]) for t in tracks] == [
        (i, i * 40_000_000, 640, 480) for i in range(frames)]
    assert [(t["frame"], t["pts"]) for t in truth] == [(t["frame"], t["pts"]) for t in tracks]
    return done.stdout, tracks, truth


def score(tracks, truth, most):
    """Sensitivity and 1−precision, in per cent and as means over the frames, and the median error:
    as in docs/metrics.md."""
    sensitivity, false, errors = [], [], []
    for claims, truths in zip(tracks, truth):
        claimed = {f["id"]: (f["x"], f["y"]) for f in claims["features"]
                   if f["state"] in ("learning", "tracked")}
        seen = {f["id"]: (f["x"], f["y"]) for f in truths["features"] if f["state"] == "tracked"}
        off = [math.dist(claimed[i], seen[i]) for i in claimed.keys() & seen.keys()]
        right = sum(distance <= most for distance in off)
        errors += off
        if seen:
            sensitivity.append(100 * right / len(seen))
        if claimed:
            false.append(100 * (len(claimed) - right) / len(claimed))
    return statistics.mean(sensitivity), statistics.mean(false), statistics.median(errors)


def contents(out):
    """{name: content} of a folder; None if it is not there."""
    return {p.name: contents(p) if p.is_dir() else p.read_bytes()
            for p in out.iterdir()} if out.is_dir() else None


def check_refused(tmp, video, *words, out=None, options=()):
    out = out or tmp / "out"
    before = contents(out)
    done = quickstart(*options, video, out)
    assert contents(out) == before, "a run that fails must leave OUT as it was"
    assert done.returncode == (2 if options else 1), f"exit code {done.returncode}: {done.stdout}"
    lines = done.stderr.strip().splitlines()
    errors = [line for line in lines if line.startswith("quickstart: ")]
    assert len(errors) == 1, done.stderr
    for word in words:
        assert word in errors[0], errors[0]
    assert "Traceback" not in done.stderr
    assert "CRITICAL" not in done.stderr


def test_copies_aac(tmp):
    ffmpeg(*picture(), *sound(), "-c:v", "libx264", "-pix_fmt", "yuv420p", "-c:a", "aac",
           tmp / "a.mp4")
    tracked(tmp / "a.mp4", tmp / "out", 50)
    before, after = packets(tmp / "a.mp4"), packets(tmp / "out" / "overlay.mp4")
    # A demuxer may leave out packets before the edit list's start, and the encoder's padding at the
    # end.
    assert len(after) >= len(before) - 3
    start = before.index(after[0])
    assert start <= 2 and before[start:start + len(after)] == after


def test_encodes_what_mp4_cannot_hold(tmp):
    ffmpeg(*picture(), *sound(), "-c:v", "mjpeg", "-c:a", "pcm_s16le", tmp / "pcm.avi")
    tracked(tmp / "pcm.avi", tmp / "out", 50)
    streams = probe(tmp / "out" / "overlay.mp4", "-show_streams")["streams"]
    assert [s["codec_name"] for s in streams if s["codec_type"] == "audio"] == ["aac"]


def test_odd_size_ten_bit(tmp):
    ffmpeg(*picture("321x241", source="testsrc"), "-c:v", "ffv1", "-pix_fmt", "yuv444p10le",
           tmp / "odd.mkv")
    tracked(tmp / "odd.mkv", tmp / "out", 50)
    first = json.loads((tmp / "out" / "tracks.jsonl").read_text().splitlines()[0])
    assert (first["width"], first["height"]) == (321, 241)
    stream = probe(tmp / "out" / "overlay.mp4", "-show_streams")["streams"][0]
    assert (stream["width"], stream["height"]) == (320, 240)


def test_truncated_matroska(tmp):
    ffmpeg(*picture(seconds=4), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "whole.mkv")
    whole = (tmp / "whole.mkv").read_bytes()
    (tmp / "cut.mkv").write_bytes(whole[:len(whole) // 2])
    decoded = int(probe(tmp / "cut.mkv", "-count_frames",
                        "-show_streams")["streams"][0]["nb_read_frames"])
    assert 0 < decoded < 70
    done = tracked(tmp / "cut.mkv", tmp / "out", decoded)
    told = re.search(r"up to (\S+) s only, and says that it lasts 4\.0 s", done.stderr)
    # The last frames can't be decoded, as they need others that were cut off.
    assert told and 0 <= float(told[1]) - decoded / 25 < 0.3, done.stderr


def test_truncated_in_the_header(tmp):
    ffmpeg(*picture(), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "whole.mkv")
    whole = (tmp / "whole.mkv").read_bytes()
    (tmp / "cut.mkv").write_bytes(whole[:whole.index(b"\x1f\x43\xb6\x75")])  # to the first cluster
    check_refused(tmp, tmp / "cut.mkv", "complete")


def turn(source, target, degrees):
    """Writes a copy that players rotate. ffmpeg 5 and 7 have no common option for that."""
    mp4 = bytearray(source.read_bytes())
    a, b, c, d = {90: (0, -1, 1, 0), 180: (-1, 0, 0, -1), 270: (0, 1, -1, 0)}[degrees]
    # The track header's matrix has numbers of 16.16 bits, in its last column of 2.30.
    struct.pack_into(">9i", mp4, mp4.index(b"tkhd") + 44,
                     a << 16, b << 16, 0, c << 16, d << 16, 0, 0, 0, 1 << 30)
    target.write_bytes(mp4)


def test_rotated_videos_play_upright(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "a.mp4")
    for degrees, width, height in ((90, 240, 320), (180, 320, 240), (270, 240, 320)):
        turn(tmp / "a.mp4", tmp / f"{degrees}.mp4", degrees)
        out = tmp / f"out{degrees}"
        done = tracked(tmp / f"{degrees}.mp4", out, 25, "--algorithm", "lk", "--points", "100,50")
        assert "turned" in done.stdout, done.stdout
        before, after = (first_frame(p, width, height)
                         for p in (tmp / f"{degrees}.mp4", out / "overlay.mp4"))
        assert np.abs(before - after).mean() < 5, "not shown as the input is"
        assert np.abs(before - after[::-1, ::-1]).mean() > 20, "180° would not be seen"
        assert png_size(out / "preview.png") == (2 * width + 4, 3 * height + 8), (
            "not six pictures, 4 pixels apart")
        line = json.loads((out / "tracks.jsonl").read_text().splitlines()[0])
        # Positions are those in the picture as it is stored.
        assert (line["width"], line["height"]) == (320, 240)
        assert [(f["x"], f["y"]) for f in line["features"]] == [(100, 50)]
        # The marker, with its id, is at (100, 50) turned anticlockwise.
        x, y = {90: (50, 319 - 100), 180: (319 - 100, 239 - 50), 270: (239 - 50, 100)}[degrees]
        differs = np.abs(before - after) > 60
        assert differs[y - 20:y + 21, x - 20:x + 21].sum() == differs.sum() > 30, differs.sum()
    assert "turned" not in quickstart("--algorithm", "lk", tmp / "a.mp4", tmp / "out").stdout


def shown(path):
    """How many frames a player shows: it obeys the edit list."""
    stream = probe(path, "-select_streams", "v", "-count_frames", "-show_streams")["streams"][0]
    return int(stream["nb_read_frames"])


def test_frames_without_times(tmp):
    ffmpeg(*picture(), "-c:v", "mjpeg", "-f", "mjpeg", tmp / "raw.mjpeg")
    done = tracked(tmp / "raw.mjpeg", tmp / "out", 50)
    assert "25 a second are taken" in done.stderr, done.stderr
    assert shown(tmp / "out" / "overlay.mp4") == 50


def test_frames_of_the_same_time(tmp):
    ffmpeg(*picture(), "-c:v", "mpeg4", "-bf", "1", "-g", "12", tmp / "xvid.avi")
    done = quickstart(tmp / "xvid.avi", tmp / "out")
    assert done.returncode == 0, done.stderr
    assert shown(tmp / "out" / "overlay.mp4") == 50


def test_uneven_times_are_shown_to_the_end(tmp):
    """A capture of a screen, on which little moves."""
    ffmpeg(*picture(), "-vf", "settb=1/1000,setpts='N*500+floor(N/5)*4000+floor(N/19)*9000'",
           "-frames:v", "41", "-fps_mode", "passthrough", "-enc_time_base", "1/1000", "-c:v",
           "libx264", "-bf", "0", tmp / "screen.mp4")
    done = quickstart(tmp / "screen.mp4", tmp / "out")
    assert done.returncode == 0, done.stderr
    assert shown(tmp / "out" / "overlay.mp4") == 41


def test_a_picture_whose_aspect_changes_stays_right(tmp):
    """From 4:3 to 16:9: the second part gets borders above and below."""
    for name, aspect in ("1", "16/15"), ("2", "64/45"):
        ffmpeg("-f", "lavfi", "-i", "color=white:size=720x576:rate=25:duration=1", "-vf",
               f"setsar={aspect}", "-c:v", "mpeg2video", tmp / f"{name}.m2v")
    (tmp / "x.m2v").write_bytes((tmp / "1.m2v").read_bytes() + (tmp / "2.m2v").read_bytes())
    ffmpeg("-r", "25", "-i", tmp / "x.m2v", "-c", "copy", "-f", "vob", tmp / "x.vob")
    done = quickstart(tmp / "x.vob", tmp / "out")
    assert done.returncode == 0, done.stderr
    decoded = subprocess.run(["ffmpeg", "-v", "error", "-i", tmp / "out" / "overlay.mp4", "-vsync",
                              "0", "-f", "rawvideo", "-pix_fmt", "gray", "-"],
                             check=True, capture_output=True).stdout
    frames = np.frombuffer(decoded, np.uint8).reshape(-1, 576, 720)
    assert len(frames) == len((tmp / "out" / "tracks.jsonl").read_text().splitlines()), len(frames)
    assert frames[5, [10, 565], 360].min() > 200
    assert frames[40, [10, 565], 360].max() < 50
    assert frames[40, [100, 475], 360].min() > 200


def test_of_several_pictures_the_largest_is_tracked(tmp):
    ffmpeg("-f", "lavfi", "-i", "testsrc=size=160x120:rate=5:duration=2", *picture(), "-map", "0",
           "-map", "1", "-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p",
           tmp / "two.mkv")
    done = quickstart(tmp / "two.mkv", tmp / "out")
    assert done.returncode == 0, done.stderr
    assert "has 2 pictures: the largest is tracked" in done.stderr, done.stderr
    assert "50 of 320×240" in done.stdout, done.stdout


def test_a_format_that_videocrop_refuses(tmp):
    ffmpeg(*picture(), "-c:v", "r210", tmp / "r210.mov")
    done = quickstart(tmp / "r210.mov", tmp / "out")
    assert done.returncode == 0 and "50 of 320×240 r210" in done.stdout, done.stderr


def test_what_is_lost_is_counted(tmp):
    """A muxer that drops a packet, and a disk that swallows a line, say nothing themselves."""
    ffmpeg(*picture(), *"-c:v libx264 -preset ultrafast -pix_fmt yuv420p".split(), tmp / "x.mkv")
    plant = """
from pipelines.lib import command, quickstart, tracking
build, Gst, count = tracking.Job._build, tracking.Gst, 0

def plant(job, properties):
    build(job, properties)
    [element] = [one for one in job._made if one.get_factory().get_name() == "%s"][%d:][:1]
    def drop(*_):
        global count
        count += 1
        return Gst.PadProbeReturn.DROP if count == 7 else Gst.PadProbeReturn.OK
    pad = element.sinkpads[0] if element.sinkpads else element.get_static_pad("sink")
    pad.add_probe(Gst.PadProbeType.BUFFER, drop)

tracking.Job._build = plant
command.run("quickstart", quickstart.main)
"""
    for place, words in ((("mp4mux", 0), "overlay.mp4 holds 49 of 50 frames"),
                         (("filesink", 1), "tracks.jsonl' holds 49 lines of 50 frames")):
        out = tmp / place[0]
        environment = {**ENVIRONMENT, "PYTHONPATH": str(REPOSITORY),
                       "GST_PLUGIN_PATH_1_0": str(BUILD / "gst"),
                       "GST_REGISTRY": str(tmp / "registry.bin"),
                       "CSD_REPORT": str(REPOSITORY / "core" / "programs" / "csd-report"),
                       "PATH": f"{BUILD / 'core' / 'programs'}:{os.environ['PATH']}"}
        done = subprocess.run([sys.executable, "-c", plant % place, tmp / "x.mkv", out],
                              capture_output=True, text=True, env=environment, timeout=300)
        assert done.returncode == 1 and words in done.stderr, done.stderr
        assert (out / "overlay.mp4").exists() and (out / "tracks.jsonl").exists()


def test_interrupted(tmp):
    with start(long_video(tmp), tmp / "out") as run:
        for line in run.stderr:
            if re.match(r" *\d+ % ", line):
                run.send_signal(signal.SIGINT)
                break
        out, err = run.communicate(timeout=300)
    assert run.returncode == 0 and "ended early" in err and "100 %" not in err, err
    assert sorted(contents(tmp / "out")) == RESULTS
    lines = (tmp / "out" / "tracks.jsonl").read_text().splitlines()
    assert 0 < len(lines) < 1500 and f"frames      {len(lines)} " in out, out
    video = probe(tmp / "out" / "overlay.mp4", "-count_frames", "-show_streams")["streams"][0]
    assert int(video["nb_read_frames"]) == len(lines)


def test_simulation(tmp):
    # Tools soon hide some points, and Lucas–Kanade still claims some of these.
    out, tracks, truth = simulated(tmp / "out", 60, "mixed", "--algorithm", "lk")
    at_first = [(f["id"], f["x"], f["y"], f["state"]) for f in truth[0]["features"]]
    assert len(at_first) == 50 and {state for *_, state in at_first} == {"tracked"}
    assert [(f["id"], f["x"], f["y"], f["state"]) for f in tracks[0]["features"]] == at_first
    told = re.search(r"^sensitivity +([\d.]+)% .* 5 px\n1−precision +([\d.]+)% .*\nerror +([\d.]+) "
                     r"px ", out, re.M)
    assert told, out
    expected = score(tracks, truth, 5)
    assert 0 < expected[0] < 100 and 0 < expected[1] < 100 and expected[2] > 0.005, expected
    for number, value, digits in zip(map(float, told.groups()), expected, (1, 1, 2)):
        assert abs(number - value) <= 0.51 * 10**-digits + 0.001, (told.groups(), expected)


def test_simulation_by_seed_and_scenario(tmp):
    ways = [("zoom",), ("zoom",), ("zoom", "--seed", "2"), ("deformation",)]
    outs = [tmp / str(i) for i in range(len(ways))]
    for out, way in zip(outs, ways):
        simulated(out, 3, *way, "--max-features", "5")
    for name in ("tracks.csv", "truth.jsonl", "overlay.mp4"):
        once, again, seed, scenario = ((out / name).read_bytes() for out in outs)
        if name != "overlay.mp4":  # has a date in it
            assert once == again, name
        assert len({once, seed, scenario}) == 3, name


def test_simulation_of_given_points(tmp):
    out, tracks, truth = simulated(tmp / "out", 3, "deformation", "--points",
                                   "320,240;200.5,120.25", "--algorithm", "lk")
    for line in (tracks[0], truth[0]):
        places = [(f["id"], f["x"], f["y"]) for f in line["features"]]
        assert places == [(0, 320, 240), (1, 200.5, 120.25)], line
    assert re.search(r"^sensitivity +100\.0%", out, re.M), out
    assert re.search(r"^1−precision +0\.0%", out, re.M), out


def test_simulation_without_points(tmp):
    out, *_ = simulated(tmp / "out", 2, "deformation", "--max-features", "0", without=("page",))
    assert "max-features is 0" in out and re.search(r"^score +none: \S", out, re.M), out


def test_simulation_without_arguments(tmp):
    done = subprocess.run(command("--frames", "2", "--max-features", "3"), capture_output=True,
                          text=True, env=ENVIRONMENT, stdin=subprocess.DEVNULL, timeout=300,
                          cwd=tmp)
    assert done.returncode == 0 and "scenario=mixed, seed=1" in done.stderr, done.stderr
    check_results(tmp / "csdtrack-simulated", 2, done, SIMULATED)


def test_simulation_interrupted(tmp):
    with start("--simulate", "mixed", "--frames", "2000", "--algorithm", "lk",
               tmp / "out") as run:
        while not any(path.stat().st_size for path in tmp.glob("out/.unfinished-*/truth.jsonl")):
            assert run.poll() is None, run.stderr.read()
            time.sleep(0.05)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=300)
    assert run.returncode == 0 and "ended early" in err and "100 %" not in err, err
    assert sorted(contents(tmp / "out")) == SIMULATED
    tracks, truth = ((tmp / "out" / name).read_text().splitlines()
                     for name in ("tracks.jsonl", "truth.jsonl"))
    assert 0 < len(tracks) == len(truth) < 2000 and re.search(r"^sensitivity +\d", out, re.M), out


def test_closing_the_terminal_leaves_whole_results(tmp):
    with contextlib.ExitStack() as stack:
        stack.addCleanup = stack.callback
        terminal = harness.Terminal(stack, command("--simulate", "mixed", "--frames", "2000",
                                                   "--algorithm", "lk", tmp / "out"), ENVIRONMENT)
        while not any(path.stat().st_size for path in tmp.glob("out/.unfinished-*/truth.jsonl")):
            assert terminal.process.poll() is None, terminal.read()
            time.sleep(0.05)
        assert terminal.close() == 0
    assert sorted(contents(tmp / "out")) == SIMULATED
    tracks, truth = ((tmp / "out" / name).read_text().splitlines()
                     for name in ("tracks.jsonl", "truth.jsonl"))
    assert 0 < len(tracks) == len(truth) < 2000


def test_interrupted_before_the_first_frame(tmp):
    """When the folder is there, but no pipeline runs yet."""
    program = """
import os, signal, sys
from pipelines.lib import tracking

def never(*_):
    os.kill(os.getpid(), int(number))

number = sys.argv.pop(1)
tracking.Job = never
from pipelines.lib import command, quickstart
command.run("quickstart", quickstart.main)
"""

    def reset_signals():  # the tests themselves may run with these ignored
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.signal(signal.SIGHUP, signal.SIG_DFL)

    for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
        done = harness.run_python(program, int(number), REPOSITORY / "README.md", tmp / "out",
                                  env=ENVIRONMENT, preexec_fn=reset_signals)
        assert done.returncode == 130 and not (tmp / "out").exists(), (number, done)


def test_simulation_refused(tmp):
    for options, code, word in (
            (("--frames", "0"), 2, "--frames"), (("--frames", "x"), 2, "--frames"),
            (("--seed", "x"), 2, "'x'"), (("--seed", "-1", tmp / "out"), 2, "'-1'"),
            (("--seed", "1", tmp / "out"), 2, "out' stands for VIDEO"),
            (("--simulate", "magic"), 2, "mixed"), (("--points", "1;2"), 2, "points"),
            (("--simulate",), 2, "--simulate"),
            (("--simulate", "zoom", tmp / "a.mkv", tmp / "out"), 2, "OUT")):
        done = subprocess.run(command(*options), capture_output=True, text=True, env=ENVIRONMENT,
                              stdin=subprocess.DEVNULL, timeout=300, cwd=tmp)
        assert done.returncode == code and word in done.stderr and "Traceback" not in done.stderr, (
            options, done.stderr)
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    for option in ("--frames", "--seed"):
        done = quickstart(option, "3", tmp / "a.mkv", tmp / "out")
        assert done.returncode == 2 and option in done.stderr, done.stderr
    assert sorted(contents(tmp)) == ["a.mkv"]


def test_a_video_leaves_a_users_truth_alone(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    (tmp / "out").mkdir()
    (tmp / "out" / "truth.jsonl").write_text("of the user")
    assert quickstart("--algorithm", "lk", tmp / "a.mkv", tmp / "out").returncode == 0
    assert (tmp / "out" / "truth.jsonl").read_text() == "of the user"


def test_given_points(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "ffv1", tmp / "a.mkv")
    tracked(tmp / "a.mkv", tmp / "out", 25, "--points", "100,100;200.5,120", "--algorithm", "lk")
    for line in (tmp / "out" / "tracks.jsonl").read_text().splitlines():
        assert [f["id"] for f in json.loads(line)["features"]] == [0, 1]


def test_page_of_a_simulation(tmp):
    simulated(tmp / "out", 10, "zoom", "--algorithm", "lk")
    clean = probe(tmp / "out" / "page" / "video.mp4", "-count_frames",
                  "-show_streams")["streams"][0]
    assert int(clean["nb_read_frames"]) == 10, clean
    marked, shown = (first_frame(p, 640, 480)
                     for p in (tmp / "out" / "overlay.mp4", tmp / "out" / "page" / "video.mp4"))
    # Fifty markers, of some hundred pixels each, are in the one only.
    assert 3000 < (np.abs(marked - shown) > 40).sum() < 60000, (np.abs(marked - shown) > 40).sum()


def test_a_folder_page_of_the_user_is_left_alone(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    (tmp / "out" / "page").mkdir(parents=True)
    (tmp / "out" / "page" / "notes.txt").write_text("of the user")
    done = quickstart("--algorithm", "lk", tmp / "a.mkv", tmp / "out")
    assert done.returncode == 0 and "no page: " in done.stderr, done.stderr
    assert contents(tmp / "out" / "page") == {"notes.txt": b"of the user"}


def test_one_frame(tmp):
    ffmpeg(*picture(seconds=0.04), "-frames:v", 1, tmp / "one.png")
    tracked(tmp / "one.png", tmp / "out", 1)
    assert png_size(tmp / "out" / "preview.png") == (320, 240), "not one tile"


def test_a_black_video_has_no_features(tmp):
    ffmpeg(*picture(seconds=1, source="color"), "-c:v", "ffv1", tmp / "black.mkv")
    done = tracked(tmp / "black.mkv", tmp / "out", 25, without=["page"])
    assert ("features    none: nothing in the picture" in done.stdout and
            "no page: " in done.stderr), done


def test_no_features_with_max_features_0(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    done = tracked(tmp / "a.mkv", tmp / "out", 5, "--max-features", "0", without=["page"])
    assert "max-features is 0" in done.stdout and "stands out" not in done.stdout, done.stdout


def test_points_outside_the_picture_are_named(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    done = tracked(tmp / "a.mkv", tmp / "out", 5, "--points",
                   "9999,9999;0,0;100,100;319,239;-7.5,3")
    assert ("2 of 5 points lie outside the picture of 320×240: 9999,9999; "
            "-7.5,3\n" in done.stdout), done.stdout
    assert "outside" not in tracked(tmp / "a.mkv", tmp / "out", 5, "--points", "0,0").stdout


def test_a_tiny_picture_is_refused(tmp):
    ffmpeg(*picture("10x10", 0.2), "-c:v", "ffv1", tmp / "tiny.mkv")
    check_refused(tmp, tmp / "tiny.mkv", "10×10")


def test_mp4_without_index(tmp):
    ffmpeg(*picture(), "-c:v", "libx264", "-pix_fmt", "yuv420p", tmp / "a.mp4")
    whole = (tmp / "a.mp4").read_bytes()
    (tmp / "cut.mp4").write_bytes(whole[:whole.index(b"moov") - 4])
    check_refused(tmp, tmp / "cut.mp4", "index")


def test_not_a_video(tmp):
    (tmp / "text.mp4").write_text("no video, only words\n" * 100)
    check_refused(tmp, tmp / "text.mp4", "video")
    check_refused(tmp, tmp / "text.mp4", "video", out=tmp / "one" / "two")
    assert not (tmp / "one").exists()


def test_sound_only(tmp):
    ffmpeg(*sound(), "-c:a", "aac", tmp / "a.mp4")
    check_refused(tmp, tmp / "a.mp4", "no video stream")


def test_failing_keeps_earlier_results(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "ffv1", tmp / "a.mkv")
    ffmpeg(*sound(), tmp / "a.wav")
    (tmp / "text.md").write_text("no video, only words\n" * 100)
    tracked(tmp / "a.mkv", tmp / "out", 25, "--points", "100,100", "--algorithm", "lk")
    (tmp / "out" / "notes.txt").write_text("not of quickstart")
    for video, word, options in (("text.md", "video", ()), ("a.wav", "no video stream", ()),
                                 ("a.mkv", "points", ("--points", "1;2")),
                                 ("a.mkv", "lk", ("--algorithm", "magic"))):
        check_refused(tmp, tmp / video, word, options=options)
    before = contents(tmp / "out")
    assert quickstart("--points", "50,50", "--algorithm", "lk", tmp / "a.mkv",
                      tmp / "out").returncode == 0
    after = contents(tmp / "out")
    assert before.keys() == after.keys() and after["notes.txt"] == before["notes.txt"]
    assert all(before[name] != after[name] for name in RESULTS), "some are not of the new run"


def test_a_full_disk_keeps_earlier_results(tmp):
    if subprocess.run(["unshare", "-rm", "mount", "-t", "tmpfs", "none", tmp],
                      capture_output=True).returncode:
        return "SKIP no small file system can be mounted here"
    ffmpeg(*picture("640x480", 4), "-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p",
           tmp / "a.mkv")
    (tmp / "disk").mkdir()
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=300k none "$1" && echo old '
         '>"$1/tracks.csv" && shift && "$@"; code=$?; ls -A "$0"; cat "$0/tracks.csv"; exit $code',
         tmp / "disk", tmp / "disk", *command("--algorithm", "lk", tmp / "a.mkv", tmp / "disk")],
        capture_output=True, text=True, env=ENVIRONMENT, stdin=subprocess.DEVNULL, timeout=300)
    assert done.returncode == 1 and "the disk is full" in done.stderr, done.stderr
    assert "100 %" not in done.stderr, done.stderr
    assert done.stdout.split() == ["tracks.csv", "old"], done.stdout


def test_a_killed_run_leaves_its_lines(tmp):
    with start(long_video(tmp), tmp / "out") as run:
        found = (re.search(r"\((\d+) frames", line) for line in run.stderr)
        frames = next(int(told[1]) for told in found if told)
        run.kill()
    [folder] = (tmp / "out").iterdir()
    assert folder.name.startswith(".unfinished-")
    *lines, _torn = (folder / "tracks.jsonl").read_text().split("\n")
    assert [json.loads(line)["frame"] for line in lines] == list(range(len(lines)))
    assert len(lines) > frames - 20, "more than a few lines are missing"


def test_progress(tmp):
    # Its timestamps don't start at 0.
    ffmpeg(*picture(seconds=60), *sound(60), "-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt",
           "yuv420p", "-output_ts_offset", "100", tmp / "long.ts")
    run = command("--algorithm", "lk", tmp / "long.ts", tmp / "out")
    lines = quickstart(*run[2:]).stderr.splitlines()[1:]
    told = [re.fullmatch(r" *(\d+) % \((\d+) frames, \d+ fps(?:, (?:\d+:\d\d left|took "
                         r"\d+:\d\d))?\)", line) for line in lines]
    assert len(told) >= 2 and all(told), lines
    told = [(int(match[1]), int(match[2])) for match in told]
    assert told[-1] == (100, 1500) and all(percent < 100 for percent, _ in told[:-1]), lines
    for percent, frames in told:
        assert abs(percent - 100 * frames / 1500) < 3, lines

    terminal, its_end = os.openpty()
    with subprocess.Popen(run, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=its_end,
                          env=ENVIRONMENT) as process:
        os.close(its_end)
        shown = b""
        try:
            while part := os.read(terminal, 4096):
                shown += part
        except OSError:  # the other end is closed
            pass
    os.close(terminal)
    assert process.returncode == 0, shown
    bars = [bar.strip() for bar in shown.decode().replace("\x1b[K", "").split("\r") if bar.strip()]
    # At first the length of the video may be unknown.
    bars = list(itertools.dropwhile(re.compile(r"\[\?{30}\] +0 frames").match, bars))
    told = [re.match(r"\[([#.]{30})\] +(\d+) %  (\d+) frames", bar) for bar in bars]
    assert len(told) >= 2 and all(told), bars
    for match in told:
        assert abs(int(match[2]) - 100 * int(match[3]) / 1500) < 3, bars
        assert abs(match[1].count("#") - 30 * int(match[2]) / 100) <= 1, bars
    assert told[-1][2] == "100" and told[-1][3] == "1500", bars


def test_odd_names(tmp):
    ffmpeg(*picture(seconds=1), "-c:v", "ffv1", tmp / "a.mkv")
    video = (tmp / "a.mkv").rename(tmp / "it's 100 %d: a \"video\" ! é.mkv")
    tracked(video, tmp / "50 %d: it's ! é", 25, "--algorithm", "lk")
    bad = video.rename(tmp / os.fsdecode(b"b\xe9d.mkv"))
    check_refused(tmp, bad, "b\\xe9d.mkv' is no UTF-8", options=("--algorithm", "lk"))


def test_missing_empty_and_special_files_are_refused(tmp):
    check_refused(tmp, tmp / "none.mp4", "there is no file")
    (tmp / "empty.mp4").touch()
    check_refused(tmp, tmp / "empty.mp4", "empty")
    check_refused(tmp, tmp, "folder")
    os.mkfifo(tmp / "fifo.mp4")
    check_refused(tmp, tmp / "fifo.mp4", "pipe")
    check_refused(tmp, "/dev/null", "device")


def test_out_cannot_be_written(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    (tmp / "file").touch()
    check_refused(tmp, tmp / "a.mkv", "OUT", out=tmp / "file")
    check_refused(tmp, tmp / "a.mkv", "OUT", out=pathlib.Path("/proc/out"))


def test_wrong_property(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    for option, word in (("max-features=many", "max-features"), ("no-such=1", "no-such"),
                         ("algorithm=magic", "lk")):
        done = quickstart("--set", option, tmp / "a.mkv", tmp / "out")
        assert done.returncode == 2 and word in done.stderr, done.stderr


def test_properties_that_quickstart_sets_are_refused(tmp):
    ffmpeg(*picture(seconds=0.2), "-c:v", "ffv1", tmp / "a.mkv")
    for option in ("attach-meta=false", "name=x", "overlay=none"):
        check_refused(tmp, tmp / "a.mkv", option.split("=")[0], options=("--set", option))


def test_properties(_tmp):
    done = quickstart("--properties")
    assert done.returncode == 0 and not done.stderr, done.stderr
    heads = {line.split()[0]: line for line in done.stdout.splitlines() if not line.startswith(" ")}
    for name, values, default in (("algorithm",
                                   "csd | csd-2012 | lk | ms1 | ms2 | sift | csd-forest", "csd"),
                                  ("max-features", "0 to 10000", "50"), ("points", "text", "empty"),
                                  ("attach-roi", "true | false", "false"),
                                  ("learning", "async | sync", "async; quickstart: sync")):
        assert heads[name].split(None, 1)[1] == f"{values}  (default: {default})", heads[name]
    assert "Detected features to maintain" in done.stdout
    for word in ("Factory", "Pad Templates", "video/x-raw", "attach-meta", "overlay"):
        assert word not in done.stdout, word
    assert "stats" not in heads and "name" not in heads


def test_help_and_wrong_use(tmp):
    assert quickstart("--help").returncode == 0 and "usage:" in quickstart("--help").stdout
    assert quickstart("--no-such-option", tmp).returncode == 2


def main():
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
    print(f"1..{len(tests)}")
    failures = 0
    for number, (name, test) in enumerate(tests, 1):
        with tempfile.TemporaryDirectory(prefix="csdtrack-") as folder:
            try:
                skipped = test(pathlib.Path(folder))
                print(f"ok {number} - {name}" + (f" # {skipped}" if skipped else ""), flush=True)
            except Exception:
                failures += 1
                print("".join("# " + line + "\n" for line in traceback.format_exc().splitlines()),
                      end="")
                print(f"not ok {number} - {name}", flush=True)
    return failures > 0


sys.exit(main())
