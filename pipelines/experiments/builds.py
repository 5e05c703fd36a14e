# SPDX-License-Identifier: LGPL-2.1-or-later
"""The build that the experiments run: where it is, its programs, what made it."""

import functools
import hashlib
import os
import pathlib
import platform
import re
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("CSDTRACK_BUILD", ROOT / "build")).resolve()
TARGETS = {"csd-score": "core/programs/csd-score", "csd-peers": "core/programs/peers/csd-peers",
           "learning-cost": "tests/bench/learning-cost", "csd-accuracy": "tests/bench/csd-accuracy",
           "bench-clips": "tests/bench/bench-clips", "plugin": "gst/libgstcsdtrack.so"}


class Failure(Exception):
    """Says what went wrong, for the user."""


def program(name):
    return BUILD / TARGETS[name]


def make(install, targets=("csd-score", "csd-peers", "learning-cost", "plugin"),
         packages="run test", commands=("parallel", "gnuplot")):
    """Installs what is missing, unless told not to, and builds. Raises Failure."""
    script = '. "$root/pipelines/lib/setup.sh"\n'
    if install:
        script += f"ensure_packages {packages} >&2 || exit 1\n"
    script += f'make_in "$1" {" ".join(TARGETS[t] for t in targets)} 2>&1'
    done = subprocess.run(["bash", "-c", script, "builds", BUILD],
                          env={**os.environ, "root": str(ROOT)}, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise Failure("the programs could not be built:\n" +
                      "\n".join(done.stdout.splitlines()[-12:]))
    for command in commands:
        if not shutil.which(command):
            raise Failure(
                f"there is no {command}: install Debian's package {'gnuplot-nox' if command == 'gnuplot' else command}"
            )


def environment():
    """Where GStreamer finds this build's plugin."""
    plugins = os.pathsep.join(
        filter(None, (str(BUILD / "gst"), os.environ.get("GST_PLUGIN_PATH_1_0"))))
    return {
        **os.environ, "GST_PLUGIN_PATH_1_0": plugins,
        "GST_REGISTRY": str(BUILD / "gst-registry.bin")
    }


@functools.cache
def fingerprint(name):
    return checksum(program(name))


def checksum(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def identity(sequence, seed, plan):
    """What a run depends on. A run of another identity is another run."""
    picture = sequence.texture(seed)
    texture = {"texture": checksum(pathlib.Path(picture))} if picture else {}
    parts = {f"{share.name}_{what}": of for share in plan.shares_of(sequence, seed)
             for what, of in (("features", share.features), ("frames", share.frames)) if of}
    return {
        "source": sequence.source(seed), **texture, **parts, "plugin": fingerprint("plugin"),
        "csd-peers": fingerprint("csd-peers")
    }


def output(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True,
                              cwd=ROOT).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor():
    found = re.search(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M)
    return f"{found[1] if found else platform.machine()}, {os.cpu_count()} threads"


def release():
    """What the sources call themselves, where they are no repository."""
    return re.search(r"^project\(.*?\bversion: '([^']+)'", (ROOT / "meson.build").read_text(),
                     re.M | re.S)[1]


def versions():
    """{what: which} of the repository and the system as they are now."""
    found = [
        ("csdtrack", output("git", "describe", "--always", "--dirty", "--abbrev=10") or release()),
        ("GStreamer", output("pkg-config", "--modversion", "gstreamer-1.0")),
        ("OpenCV", output("pkg-config", "--modversion", "opencv4")),
        ("compiler", output("g++", "--version").splitlines()[0] if shutil.which("g++") else ""),
        ("system", platform.freedesktop_os_release().get("PRETTY_NAME", "")),
        ("processor", processor())
    ]
    return {what: which for what, which in found if which}
