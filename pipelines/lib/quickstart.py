#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program behind pipelines/quickstart: quickstart.py VIDEO OUT [PROPERTY=VALUE...]"""

import pathlib
import signal
import sys

import report
import tracking


def main():
    video, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    job = tracking.Job(video, out, sys.argv[3:])
    results = [out / name for name in report.RESULTS]
    for path in results:  # of an earlier run: what can't be made this time must not seem to be there
        path.unlink(missing_ok=True)
    try:
        with report.Progress(video.name) as progress:
            job.run(progress)
    except tracking.Failure:
        if not job.frames:
            for path in results:
                path.unlink(missing_ok=True)
        raise
    report.preview(out, job.frames)
    if job.cut_short:
        print(f"quickstart: {job.cut_short}", file=sys.stderr)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # | head is no error
    report.table(job, out)


try:
    main()
except tracking.Failure as failure:
    print(f"quickstart: {failure}", file=sys.stderr)
    sys.exit(1)
