#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Every real clip gives a line for each frame that can be decoded, and each line fits the schema.

learning=sync is needed: a clip is read faster than features are learnt, so without it only LK would
be tested.
"""

import csv

import harness


class Clips(harness.Case):
    def test_a_valid_line_for_each_decoded_frame(self):
        for clip in harness.clips():
            with self.subTest(clip=clip.name):
                stem = self.tmp / clip.stem
                run = harness.Run("filesrc name=file ! decodebin ! csdtrack algorithm=csd-2012 "
                                  "learning=sync max-features=10 ! tee name=t t. ! queue ! "
                                  f"csdtrackenc ! filesink location={stem}.jsonl "
                                  "buffer-mode=unbuffered t. ! queue ! csdtrackenc ! text/csv ! "
                                  f"filesink location={stem}.csv")
                run.element("file").set_property("location", str(clip))
                run.to_end()
                lines = harness.read_lines(f"{stem}.jsonl")
                harness.check_tracks(self, lines, harness.decoded_frames(clip), most=10)
                states = {f["state"] for line in lines for f in line["features"]}
                self.assertLessEqual({"learning", "tracked"}, states,
                                     "features are found, and descriptors take over from LK")
                self.assertGreaterEqual(run.messages[0].get_value("frame"), 0)
                self.assertEqual(run.warnings, [])
                with open(f"{stem}.csv", newline="") as file:
                    rows = [(int(r["frame"]), int(r["id"]), float(r["x"]), float(r["y"]),
                             r["state"]) for r in csv.DictReader(file)]
                self.assertEqual(rows, [(line["frame"], f["id"], f["x"], f["y"], f["state"])
                                        for line in lines for f in line["features"]])


if __name__ == "__main__":
    harness.main()
