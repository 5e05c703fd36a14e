#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""README's lines of Python, unchanged, on the tracks of a made-up video."""

import io
import json
import pathlib
import re
import subprocess
import sys

from harness import CLAIMS, TIMEOUT, Case, launch, main, scene_video

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"


class Readme(Case):
    def test_pandas_has_a_row_for_each_point_in_each_frame(self):
        import pandas
        lines, = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
        self.assertEqual(len(lines.splitlines()), 3)
        file, = re.findall(r'open\("(.*?)"\)', lines)
        (self.tmp / file).parent.mkdir()
        video = scene_video(self.tmp / "in.mp4", 30)
        launch("filesrc", f"location={video}", "!", "decodebin", "!",
               "csdtrack", "!", "csdtrackenc", "!", "filesink", f"location={file}",
               cwd=self.tmp).check_returncode()
        done = subprocess.run([sys.executable, "-c", lines + "print(tracks.to_csv(index=False))"],
                              cwd=self.tmp, capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        tracks = pandas.read_csv(io.StringIO(done.stdout))
        self.assertEqual(set(tracks.frame), set(range(30)))
        self.assertTrue(((tracks.confidence >= 0.5) == tracks.state.isin(CLAIMS)).all())
        expected = [(frame["frame"], frame["pts"], f["id"], f["x"], f["y"], f["state"])
                    for frame in map(json.loads, (self.tmp / file).read_text().splitlines())
                    for f in frame["features"]]
        self.assertGreater(len(expected), 30)
        rows = tracks[["frame", "pts", "id", "x", "y", "state"]]
        self.assertEqual(list(rows.itertuples(index=False, name=None)), expected)


if __name__ == "__main__":
    main()
