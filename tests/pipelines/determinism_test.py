#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""With learning=sync and the same seed csdtrack gives the same bytes on every run, with any
n-threads, alone or beside others."""

import re

import harness

SYNC = "algorithm=csd-2012 learning=sync max-features=8 training-time=200000000 seed=7"


class Determinism(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        video = harness.scene_video(cls.tmp / "in.mkv", 40)
        cls.source = f"filesrc location={video} ! decodebin"

    def tracks(self, properties, name="csdtrack0"):
        path = self.tmp / "tracks.jsonl"
        run = harness.Run(f"{self.source} ! csdtrack name={name} {properties} ! csdtrackenc ! "
                          f"filesink location={path}")
        track = run.element(name)
        run.to_end()
        lines = harness.read_lines(path)
        harness.check_tracks(self, lines, 40)
        self.stats = track.get_property("stats")
        return path.read_bytes()

    def test_any_number_of_threads_gives_the_same_bytes(self):
        first = self.tracks(SYNC + " n-threads=1")
        self.assertGreater(self.stats.get_value("learned"), 0,
                           "no descriptor was learned: this test shows nothing")
        self.assertGreater(self.stats.get_value("retrainings"), 0)
        for threads in (1, 2, 4):
            with self.subTest(threads=threads):
                self.assertEqual(self.tracks(f"{SYNC} n-threads={threads}"), first)

    def test_the_other_algorithms_give_the_same_bytes(self):
        results = []
        for algorithm in ("csd", "lk", "ms1", "ms2", "sift"):
            with self.subTest(algorithm):
                first = self.tracks(f"algorithm={algorithm} max-features=20")
                self.assertEqual(self.tracks(f"algorithm={algorithm} max-features=20"), first)
                lines = harness.read_lines(self.tmp / "tracks.jsonl")
                self.assertEqual({line["algorithm"] for line in lines}, {algorithm})
                results.append([line["features"] for line in lines])
        for i, features in enumerate(results):
            self.assertNotIn(features, results[:i], "two algorithms give the same tracks")

    def test_another_process_gives_the_same_bytes(self):
        path = self.tmp / "other.jsonl"
        done = harness.launch("-q", self.source, "! csdtrack", SYNC, "! csdtrackenc ! filesink",
                              f"location={path}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(path.read_bytes(), self.tracks(SYNC))

    def test_eight_in_one_pipeline_do_not_affect_each_other(self):
        alone = self.tracks(SYNC)
        lk = self.tracks("algorithm=lk")
        branches = []
        for i in range(4):
            # Two in a row: each adds its own meta, and csdtrackenc's `source` chooses one.
            branches.append(f"t. ! queue ! csdtrack name=a{i} {SYNC} n-threads={1 + i} ! csdtrack "
                            f"name=b{i} algorithm=lk ! tee name=s{i} s{i}. ! queue ! csdtrackenc "
                            f"source=a{i} ! filesink location={self.tmp}/a{i}.jsonl s{i}. ! queue "
                            f"! csdtrackenc source=b{i} ! filesink location={self.tmp}/b{i}.jsonl")
        harness.play(f"{self.source} ! tee name=t {' '.join(branches)}")
        for i in range(4):
            for name, expected in ((f"a{i}", alone), (f"b{i}", lk)):
                with self.subTest(name):
                    text = (self.tmp / f"{name}.jsonl").read_bytes()
                    self.assertEqual(re.sub(rb'"source":"[ab]\d"', b'"source":"csdtrack0"', text),
                                     expected)

    def test_a_clip_gives_the_same_bytes_with_any_number_of_threads(self):
        clip = min(harness.clips(), key=lambda p: p.stat().st_size)
        results = []
        for threads in (1, 2, 4):
            path = self.tmp / f"{threads}.jsonl"
            run = harness.Run("filesrc name=file ! decodebin ! csdtrack name=csdtrack0 "
                              "algorithm=csd-2012 learning=sync max-features=10 "
                              f"n-threads={threads} ! csdtrackenc ! filesink location={path}")
            run.element("file").set_property("location", str(clip))
            run.to_end()
            results.append(path.read_bytes())
        self.assertEqual(results[0], results[1])
        self.assertEqual(results[0], results[2])


if __name__ == "__main__":
    harness.main()
