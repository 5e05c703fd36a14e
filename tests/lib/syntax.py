#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Compiles a build folder's sources without writing code: syntax.py BUILD JOBS [FOLDER...]"""

import concurrent.futures
import json
import pathlib
import shlex
import subprocess
import sys


def check(entry):
    command = shlex.split(entry["command"])
    output = command.index("-o")
    del command[output:output + 2]
    done = subprocess.run(command + ["-fsyntax-only"], cwd=entry["directory"], capture_output=True,
                          text=True)
    return entry["file"], done.returncode, done.stderr


build = pathlib.Path(sys.argv[1])
folders = [pathlib.Path(folder).resolve() for folder in sys.argv[3:]]
entries = [
    entry for entry in json.loads((build / "compile_commands.json").read_text())
    if not folders or any(
        folder in pathlib.Path(entry["directory"], entry["file"]).resolve().parents
        for folder in folders)
]
with concurrent.futures.ThreadPoolExecutor(int(sys.argv[2])) as pool:
    results = list(pool.map(check, entries))
for file, code, errors in results:
    if code:
        print(f"FAILED: {file}\n{errors}")
    print(f"checked {file}")
sys.exit(any(code for _, code, _ in results) or not results)
