# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs csd-motion: puts its rhythms into the index, and its displacements into chunks."""

import array
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from report import script
from report.messages import Progress, ReportError, memory_file

CHUNK_BYTES = 1 << 19  # of displacements before base64: each chunk but the last has at least these
UNKNOWN = -32768
REMEDY = "give what csdtrackenc wrote as .jsonl"


def program() -> str:
    """csd-motion beside csd-report, whose script sets CSD_MOTION, or in PATH."""
    found = os.environ.get("CSD_MOTION") or shutil.which("csd-motion")
    if not found:
        raise ReportError("there is no csd-motion beside this program or in PATH: "
                          "install it, or build it (-Dprograms=enabled)")
    return found


def quantised(values: Sequence[float | None]) -> tuple[float, str]:
    """Step and base64: 16 bits a value, in steps of a power of two of at least 1/64 px."""
    known = [v for v in values if v is not None]
    most = max(max(known), -min(known)) if known else 0
    step = max(2.0**-6, 2.0**math.ceil(math.log2(most / 32000)) if most else 0)
    return step, script.packed(
        array.array("h", [UNKNOWN if v is None else round(v / step) for v in values]))


def displacement(path: Mapping[str, Any]) -> dict[str, Any]:
    """A member of a chunk, from csd-motion's path of a feature or of the scene."""
    dx_step, dx = quantised(path["dx"])
    dy_step, dy = quantised(path["dy"])
    return {
        "id": path.get("id"), "first": path.get("first", 0), "dx": dx, "dx_step": dx_step, "dy": dy,
        "dy_step": dy_step
    }


class Motion:
    """A run of csd-motion.

    `head`: its JSON without `series`; `chunk_of`: the number of the chunk with a feature's
    displacement.
    Use it in a `with` statement. When that is entered, csd-motion starts. judge() waits for its
    judgement of the file, which is that of csd-score and csdtrackdec, too.
    """

    def __init__(self, tracks_path: pathlib.Path, folder: pathlib.Path, wanted: bool) -> None:
        """`folder`: of the chunks; `wanted`: show progress."""
        self.head: dict[str, Any] = {}
        self.chunk_of: dict[int, int] = {}
        self._tracks, self._wanted, self._folder = tracks_path, wanted, folder
        self._members: list[dict[str, Any]] = []
        self._bytes, self._count = 0, 0
        self._first_line = ""  # of `series`

    def __enter__(self) -> "Motion":
        """Raises ReportError if there is no csd-motion."""
        self._stderr = memory_file()
        self._run = subprocess.Popen(
            [program(), "--json", "--series", str(self._tracks)], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=self._stderr, text=True)
        assert self._run.stdout
        self._stdout = self._run.stdout
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        if kind:
            self._run.kill()
        self._stdout.close()
        self._run.wait()
        self._stderr.close()

    def judge(self) -> None:
        """Waits until csd-motion has read the file and found its rhythms.

        Raises ReportError if it refuses the file.
        """
        with Progress("looking for rhythms (csd-motion)", self._wanted) as progress:
            progress.show(0)
            head = self._read_head()
        if head is None:
            self._check_exit()
            raise ReportError("csd-motion gives no result")
        self.head = head

    def _check_exit(self) -> None:
        if self._run.wait() == 0:
            return
        self._stderr.seek(0)
        why = (self._stderr.read().splitlines() or ["csd-motion failed"])[-1]
        why = why.removeprefix("csd-motion: ")
        names_line = re.match(r":\d+: ", why.removeprefix(str(self._tracks)))
        raise ReportError(f"{why}: {REMEDY}" if names_line else why)

    def write_series(self, page_times: Callable[[list[int]], Iterable[float]],
                     progress: Callable[[int], None]) -> None:
        """Writes the displacements. Raises ReportError.

        `page_times`: the times on the page (s) of frames by their numbers, or NaN. `progress`: is
        called with the number of features that are done.
        """
        self._write_scene(page_times)
        done = 0
        # Each line is one feature, and only one line at a time is in memory.
        for line in self._stdout:
            if not line.startswith("{"):  # the end of the JSON
                continue
            line = line.rstrip().rstrip(",")
            feature = line.removesuffix("]}") if line.endswith("]}]}") else line
            self._add(displacement(json.loads(feature)))
            done += 1
            progress(done)
        self._flush()
        self._check_exit()

    def _read_head(self) -> dict[str, Any] | None:
        """Reads up to `series`, the last member. Its first line, the scene's, is read with it."""
        head: list[str] = []
        for line in self._stdout:
            before, found, after = line.partition('"series": ')
            if found:
                self._first_line = after
                return json.loads("".join(head).rstrip().rstrip(",") + "}")
            head.append(before)
        return None

    def _write_scene(self, page_times: Callable[[list[int]], Iterable[float]]) -> None:
        scene = json.loads(self._first_line.rstrip() + "]}")
        self._first_line = ""
        script.write(self._folder / "scene.js", "scene", {
            "times": script.packed(array.array("d", page_times(scene["frames"]))),
            **displacement(scene["scene"])
        })

    def _add(self, member: dict[str, Any]) -> None:
        self.chunk_of[member["id"]] = self._count
        self._members.append(member)
        self._bytes += len(member["dx"]) + len(member["dy"])
        if self._bytes >= CHUNK_BYTES:
            self._flush()

    def _flush(self) -> None:
        if self._members:
            script.write(self._folder / f"motion-{self._count:05}.js", "motion", self._count,
                         self._members)
            self._count, self._members, self._bytes = self._count + 1, [], 0
