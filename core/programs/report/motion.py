# SPDX-License-Identifier: LGPL-2.1-or-later
"""What csd-motion says of the tracks: rhythms for the index, displacements as chunks. Nothing is computed here."""

import array
import json
import math
import os
import pathlib
import re
import shutil
import subprocess

import failure
import script
from failure import Failure, Progress

BYTES = 1 << 19  # a chunk of displacements at least, before base64, unless it is the last
UNKNOWN = -32768
REMEDY = "give what csdtrackenc wrote as .jsonl"


def program():
    """csd-motion beside this program, else in PATH."""
    import __main__
    beside = pathlib.Path(__main__.__file__).resolve().parent / "csd-motion"
    found = str(beside) if os.access(beside, os.X_OK) else shutil.which("csd-motion")
    if not found:
        raise Failure(
            "there is no csd-motion beside this program or in PATH: install it, or build it (-Dprograms=enabled)"
        )
    return found


def quantised(values):
    """16 bits each, in steps of a power of two from 1/64 px on: (step, base64)."""
    most = max((abs(v) for v in values if v is not None), default=0)
    step = max(2.0 ** -6, 2.0 ** math.ceil(math.log2(most / 32000)) if most else 0)
    return step, script.packed(
        array.array("h", (UNKNOWN if v is None else round(v / step) for v in values)))


def displacement(path):
    """The member of a chunk for what csd-motion says of a feature or of the scene."""
    dx_step, dx = quantised(path["dx"])
    dy_step, dy = quantised(path["dy"])
    return {
        "id": path.get("id"), "first": path.get("first", 0), "dx": dx, "dx_step": dx_step, "dy": dy,
        "dy_step": dy_step
    }


class Motion:
    """head: csd-motion's JSON without `series`; chunk_of: feature: number of the chunk with its displacement.

    To be entered: then the file has been read and found good. It is csd-motion that judges it, as it does for csd-score and csdtrackdec.
    """

    def __init__(self, tracks_path, folder, wanted):
        """`wanted`: tell progress."""
        self.chunk_of = {}
        self._tracks, self._wanted = tracks_path, wanted
        self._folder, self._members, self._bytes, self._count = folder, [], 0, 0

    def __enter__(self):
        """Raises Failure."""
        self._log = failure.log()
        self._run = subprocess.Popen(
            [program(), "--json", "--series", str(self._tracks)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=self._log, text=True)
        try:
            with Progress("looking for rhythms (csd-motion)", self._wanted) as progress:
                progress.show(0)
                self.head = self._head(self._run.stdout)
            if self.head is None:
                self._ended()
                raise Failure("csd-motion says nothing")
        except BaseException:
            self.__exit__(BaseException)
            raise
        return self

    def __exit__(self, kind, *_):
        if kind:
            self._run.kill()
        self._run.stdout.close()
        self._run.wait()
        self._log.close()

    def _ended(self):
        if self._run.wait() == 0:
            return
        self._log.seek(0)
        said = (self._log.read().splitlines() or
                ["csd-motion failed"])[-1].removeprefix("csd-motion: ")
        raise Failure(f"{said}: {REMEDY}" if re.match(r":\d+: ", said.removeprefix(str(self._tracks)
                                                                                   )) else said)

    def series(self, page_time, progress):
        """Leaves the displacements. page_time(s of csd-motion) → s on the page, or None. progress(features done). Raises Failure."""
        self._series(self._run.stdout, page_time, progress)
        self._ended()

    def _head(self, lines):
        """Up to `series`, which is the last member; its first line, the scene's, is left for _series."""
        head = []
        for line in lines:
            before, found, after = line.partition('"series": ')
            if found:
                self._first = after
                text = "".join(head).rstrip().rstrip(",")
                return json.loads(text + "}")
            head.append(before)
        return None

    def _series(self, lines, page_time, progress):
        """A line for the scene, then one for each feature: each is whole in memory, and never two."""
        scene = json.loads(self._first.rstrip() + "]}")
        self._first = ""
        times = array.array("d", (page_time(t) for t in scene["times"]))
        script.write(self._folder / "scene.js", "scene",
                     {"times": script.packed(times), **displacement(scene["scene"])})
        del scene
        done = 0
        for line in lines:
            if not line.startswith("{"):  # the end of the whole
                continue
            line = line.rstrip().rstrip(",")
            self._add(
                displacement(
                    json.loads(line.removesuffix("]}") if line.endswith("]}]}") else line)))
            done += 1
            progress(done)
        self._flush()

    def _add(self, member):
        self.chunk_of[member["id"]] = self._count
        self._members.append(member)
        self._bytes += len(member["dx"]) + len(member["dy"])
        if self._bytes >= BYTES:
            self._flush()

    def _flush(self):
        if self._members:
            script.write(self._folder / f"motion-{self._count:05}.js", "motion", self._count,
                         self._members)
            self._count, self._members, self._bytes = self._count + 1, [], 0
