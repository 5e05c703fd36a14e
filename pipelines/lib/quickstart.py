#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program behind pipelines/quickstart: quickstart.py VIDEO OUT [PROPERTY=VALUE...]"""

import pathlib
import sys

import report
import tracking


def main():
    video, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    job = tracking.Job(video, out, sys.argv[3:])
    with report.Progress(video.name) as progress:
        job.run(progress)
    report.preview(out / "overlay.mp4", out / "preview.png", job.frames)
    if job.cut_short:
        print(f"quickstart: {job.cut_short}", file=sys.stderr)
    report.table(job, out)


try:
    main()
except tracking.Failure as failure:
    print(f"quickstart: {failure}", file=sys.stderr)
    sys.exit(1)
