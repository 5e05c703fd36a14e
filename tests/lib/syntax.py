#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lets the compiler of a build folder check every source without producing code.

usage: syntax.py BUILD JOBS [FOLDER...]    FOLDER: only the sources below these
"""

import concurrent.futures
import json
import pathlib
import shlex
import subprocess
import sys


def check(entry: dict[str, str]) -> tuple[str, int, str]:
    """The file of an entry of compile_commands.json, the compiler's exit code and its messages."""
    command = shlex.split(entry["command"])
    output = command.index("-o")
    del command[output:output + 2]
    done = subprocess.run(command + ["-fsyntax-only"], cwd=entry["directory"], capture_output=True,
                          text=True)
    return entry["file"], done.returncode, done.stderr


def main() -> int:
    build, jobs = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    folders = {pathlib.Path(folder).resolve() for folder in sys.argv[3:]}
    entries = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["directory"], entry["file"]).resolve()
        if not folders or folders & set(source.parents):
            entries.append(entry)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(check, entries))
    for file, code, errors in results:
        if code:
            print(f"FAILED: {file}\n{errors}")
        print(f"checked {file}")
    return int(any(code for _, code, _ in results) or not results)


if __name__ == "__main__":
    sys.exit(main())
