# SPDX-License-Identifier: LGPL-2.1-or-later
"""The build that the experiments run: its folder, its programs, and the versions behind it."""

from __future__ import annotations

import functools
import hashlib
import os
import pathlib
import platform
import re
import shutil
import subprocess
import typing
from collections.abc import Iterable

from pipelines.lib.failure import Failure

if typing.TYPE_CHECKING:
    from pipelines.experiments.sequences import Plan, Sequence

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("CSDTRACK_BUILD", ROOT / "build")).resolve()
TARGETS = {
    "csd-score": "core/programs/csd-score",
    "csd-peers": "core/programs/peers/csd-peers",
    "learning-cost": "tests/bench/learning-cost",
    "csd-accuracy": "tests/bench/csd-accuracy",
    "bench-clips": "tests/bench/bench-clips",
    "plugin": "gst/libgstcsdtrack.so",
}
DEBIAN_PACKAGES = {"gnuplot": "gnuplot-nox"}  # of commands whose package has another name


def program(name: str) -> pathlib.Path:
    return BUILD / TARGETS[name]


def make(install: bool,
         targets: Iterable[str] = ("csd-score", "csd-peers", "learning-cost", "plugin"),
         packages: str = "run test", commands: Iterable[str] = ("parallel", "gnuplot")) -> None:
    """Builds the targets, after installing missing packages if `install` is set.

    Raises Failure if the build fails or one of `commands` is missing.
    """
    script = '. "$root/pipelines/lib/setup.sh"\n'
    if install:
        script += f"ensure_packages {packages} >&2 || exit 1\n"
    script += f'make_in "$1" {" ".join(TARGETS[target] for target in targets)} 2>&1'
    done = subprocess.run(["bash", "-c", script, "builds", BUILD],
                          env={**os.environ, "root": str(ROOT)}, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, text=True)
    if done.returncode:
        end = "\n".join(done.stdout.splitlines()[-12:])
        raise Failure(f"the programs could not be built:\n{end}")
    for command in commands:
        if not shutil.which(command):
            package = DEBIAN_PACKAGES.get(command, command)
            raise Failure(f"there is no {command}: install Debian's package {package}")


def environment() -> dict[str, str]:
    """The environment in which GStreamer finds this build's plugin."""
    plugins = (str(BUILD / "gst"), os.environ.get("GST_PLUGIN_PATH_1_0"))
    return {
        **os.environ,
        "GST_PLUGIN_PATH_1_0": os.pathsep.join(filter(None, plugins)),
        "GST_REGISTRY": str(BUILD / "gst-registry.bin"),
    }


@functools.cache
def fingerprint(name: str) -> str:
    return checksum(program(name))


def checksum(path: pathlib.Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def identity(sequence: Sequence, seed: int, plan: Plan) -> dict[str, typing.Any]:
    """Everything that a run's result depends on. A kept run with another identity runs again."""
    picture = sequence.texture(seed)
    texture = {"texture": checksum(pathlib.Path(picture))} if picture else {}
    parts = {
        f"{share.name}_{limit}": count
        for share in plan.shares_of(sequence, seed)
        for limit, count in (("features", share.features), ("frames", share.frames)) if count
    }
    return {
        "source": sequence.source(seed),
        **texture,
        **parts,
        "plugin": fingerprint("plugin"),
        "csd-peers": fingerprint("csd-peers"),
    }


def output(*command: str) -> str:
    """What a command prints; "" if it fails or isn't there."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True,
                              cwd=ROOT).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor() -> str:
    found = re.search(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M)
    return f"{found[1] if found else platform.machine()}, {os.cpu_count()} threads"


def release() -> str:
    """The version in meson.build, for sources that are no git repository."""
    found = re.search(r"^project\(.*?\bversion: '([^']+)'", (ROOT / "meson.build").read_text(),
                      re.M | re.S)
    assert found
    return found[1]


def versions() -> dict[str, str]:
    """The versions of the repository, its libraries and the system, by name."""
    commit = output("git", "describe", "--always", "--dirty", "--abbrev=10")
    found = {
        "csdtrack": commit or release(),
        "GStreamer": output("pkg-config", "--modversion", "gstreamer-1.0"),
        "OpenCV": output("pkg-config", "--modversion", "opencv4"),
        "compiler": output("g++", "--version").splitlines()[0] if shutil.which("g++") else "",
        "system": platform.freedesktop_os_release().get("PRETTY_NAME", ""),
        "processor": processor(),
    }
    return {name: version for name, version in found.items() if version}
