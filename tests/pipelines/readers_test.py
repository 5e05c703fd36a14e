#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""All readers of tracks accept and refuse the same files: readers_test.py REPOSITORY BUILD.

csdtrackdec (from a file, and through its pad `text`), csd-score, csd-motion and csd-report agree on
which lines are valid. Not tested here is what each demands of several lines: that they are sorted
by time, have one picture size, or cover all labelled frames. Nor is a file without any line, as
csdtrackdec waits for its first.
"""

import json
import re
import subprocess
import sys

import harness
import reports

FRAMES, LONGEST = 20, 8 << 20
PROGRAMS = reports.BUILD / "core" / "programs"


def line(at, **changed):
    """A line as csdtrackenc writes it, with fields changed, or left out where they are `...`."""
    ns = at * harness.FRAME
    told = {"schema": 1, "source": "csdtrack0", "role": "track", "algorithm": "csd", "frame": at,
            "pts": ns, "duration": None, "running_time": ns, "stream_time": ns, "reference": None,
            "width": 64, "height": 48, "features": [feature(0, x=20 + at % 3)]} | changed
    return json.dumps({key: value for key, value in told.items() if value is not ...},
                      separators=(",", ":")).encode() + b"\n"


def feature(number, **changed):
    return {"id": number, "x": 20, "y": 20, "state": "tracked", "confidence": 0.9} | changed


def lines(begin, end):
    return b"".join(map(line, range(begin, end)))


def inserted(odd):
    """A file with `odd` as its sixth line."""
    return lines(0, 5) + odd + lines(6, FRAMES)


def instead(old, new):
    """A file whose sixth line has `new` in place of `old`."""
    whole = line(5)
    assert whole.count(old) == 1
    return inserted(whole.replace(old, new))


ALL = lines(0, FRAMES)
TAIL = line(FRAMES)
BOM = b"\xef\xbb\xbf"

TAKEN = {"whole": ALL, "CR LF": ALL.replace(b"\n", b"\r\n"), "byte order mark": BOM + ALL,
         "two files in one": lines(0, 5) + BOM + lines(5, FRAMES),
         "blank first lines": b"\n \r\n\t\n" + ALL,
         "blank lines within": lines(0, 5) + b"\n\n \t \n" + lines(5, FRAMES),
         "zeros for a first line": bytes(4096) + b"\n" + ALL,
         "a line of zeros": lines(0, 5) + bytes(4096) + b"\n" + lines(5, FRAMES),
         "zeros behind each line": ALL.replace(b"\n", b"\0\n"),
         "blanks before a line": lines(0, 5) + b"  " + lines(5, FRAMES),
         "a torn last line": ALL + TAIL[:60],
         "a last line without its newline": ALL + TAIL[:-1],
         "zeros at the end": ALL + bytes(4096),
         "8 MiB of zeros at the end": ALL + bytes(LONGEST),
         "a frame without metadata": ALL + line(FRAMES, frame=None, source=None, algorithm=None,
                                                width=..., height=..., features=[]),
         "an unknown field": instead(
             b'"role"', b'"more":[{"a":[null,true,-1.5e3,"\\u00e9"]}],"role"'),
         "optional fields left out": instead(
             b'"source":"csdtrack0",', b"").replace(b'"duration":null,', b"")}

TOO_LONG, SIZE, NO_JSON = "is longer than 8 MiB", "has no `width` or no `height`", "is no JSON: "
VALUE = NO_JSON + "a value is misspelt or too large"
MANY = [feature(i) for i in range(65537)]
REFUSED = {
    "0×0": (inserted(line(5, width=0, height=0)), 6, SIZE),
    "no width": (inserted(line(5, width=...)), 6, SIZE),
    "0×0 in the first line": (line(0, width=0, height=0) + lines(1, FRAMES), 1, SIZE),
    "behind blank lines": (b"\n\0\n" + inserted(b"[]\n"), 8, "is no JSON object"),
    "zeros before a line": (inserted(bytes(16) + line(5)), 6, VALUE),
    "a zero within a line": (instead(b'"csd"', b'"c\0d"'), 6,
                             NO_JSON + "a control character in a string"),
    "a line without end": (inserted(b"x" * (LONGEST + 100000)), 6, TOO_LONG),
    "a last line without end": (ALL + b'{"schema":1,' + b" " * LONGEST, FRAMES + 1, TOO_LONG),
    "a first line without end": (b"{" * (LONGEST + 1), 1, TOO_LONG),
    "one blank too many": (inserted(b" " * (LONGEST + 1) + b"\n"), 6, TOO_LONG),
    "a line too long by one": (inserted(line(5)[:-1].ljust(LONGEST + 1) + b"\n"), 6, TOO_LONG),
    "too many features": (inserted(line(5, features=MANY)), 6, "has more than 65536 features"),
    "too many brackets": (instead(b'"role"', b'"more":' + b"[" * 200000 + b',"role"'), 6,
                          NO_JSON + "brackets are nested more than 16 deep"),
    "NaN": (instead(b"0.9", b"NaN"), 6, VALUE),
    "a number that is infinite": (instead(b"0.9", b"1e999"), 6, VALUE),
    "too many digits": (instead(b'"frame":5', b'"frame":' + b"5" * 5000), 6,
                        VALUE),
    "Latin-1": (instead(b'"csd"', b'"\xe9"'), 6, NO_JSON + "it is not UTF-8"),
    "a feature twice": (inserted(line(5, features=[feature(0), feature(0)])), 6,
                        "feature 0 after feature 0"),
    "true for an id": (inserted(line(5, features=[feature(True)])), 6,
                       "`id` is no whole number from 0 to 4294967294"),
    "another schema": (inserted(line(5, schema=2)), 6, "schema 2 is not known (1 is)"),
    "no frame": (inserted(line(5, frame=...)), 6, "has features, but no `frame`"),
    "146 years": (ALL + line(FRAMES, stream_time=1 << 62), FRAMES + 1,
                  "`stream_time` is more than 146 years")}


class Readers(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.video = harness.scene_video(cls.tmp / "video.mp4", FRAMES + 1, *harness.H264, width=64,
                                        height=48)
        cls.truth = cls.tmp / "truth.csv"
        cls.truth.write_text(f"frame,id,x,y,visible\n0,0,20,20,1\n{FRAMES - 1},0,20,20,1\n")

    def element(self, source, properties):
        """The line and reason that csdtrackdec refuses, or None if it takes all lines."""
        try:
            harness.play(f"{source} videotestsrc num-buffers={FRAMES + 5} ! "
                         "video/x-raw,format=GRAY8,width=64,height=48,framerate=25/1 ! "
                         f"csdtrackdec name=r {properties} ! fakesink")
        except harness.PipelineError as error:
            number, why = re.match(
                r'Line (\d+) of (?:"[^"]*"|what came to the pad text): (.*)\. '
                r'(?:Set location|Link what)', error.error.message, re.S).groups()
            return int(number), why
        return None

    def program(self, *command):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=harness.TIMEOUT,
                              env=reports.ENVIRONMENT)
        if done.returncode == 0:
            return None
        self.assertEqual(done.returncode, 1, done.stderr)
        last, = done.stderr.splitlines()
        number, why = re.match(
            r"[a-z-]+: .*/odd\.jsonl:(\d+): (.*?)(?:: give what csdtrackenc wrote as \.jsonl)?$",
            last).groups()
        return int(number), why

    def judgements(self, content):
        odd = self.tmp / "odd.jsonl"
        odd.write_bytes(content)
        yield "csdtrackdec location", self.element("", f"location={odd}")
        yield "csdtrackdec.text", self.element(f"filesrc location={odd} ! application/x-ndjson ! "
                                               "r.text", "max-wait=60000000000")
        yield "csd-score", self.program(PROGRAMS / "csd-score", "--resamples", 0, "--by-frame",
                                        self.truth, odd)
        yield "csd-motion", self.program(PROGRAMS / "csd-motion", odd)
        yield "csd-report", self.program(reports.PROGRAM, self.video, odd, self.tmp / "page")

    def test_all_readers_take_these(self):
        for name, content in TAKEN.items():
            with self.subTest(name):
                for reader, judgement in self.judgements(content):
                    self.assertIsNone(judgement, reader)

    def test_all_readers_refuse_these_with_line_and_reason(self):
        for name, (content, number, why) in REFUSED.items():
            with self.subTest(name):
                for reader, judgement in self.judgements(content):
                    self.assertIsNotNone(judgement, reader)
                    self.assertEqual((judgement[0], judgement[1][:len(why)]), (number, why), reader)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
