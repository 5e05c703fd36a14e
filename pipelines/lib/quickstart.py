# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program behind pipelines/quickstart: quickstart.py VIDEO OUT [PROPERTY=VALUE...], where
VIDEO may be --simulate and three PROPERTY=VALUE of csdsimsrc; or quickstart.py --properties"""

import contextlib
import os
import pathlib
import shutil
import signal
import sys
import tempfile

from pipelines.lib import command, report, tracking
from pipelines.lib.failure import Failure


@contextlib.contextmanager
def unfinished(out):
    """A folder in OUT, hence on its file system, that is gone in the end. If OUT is still empty then, it was not there
    before either."""
    made = [path for path in (out, *out.parents) if not os.path.exists(path)]
    folder = None
    try:
        out.mkdir(parents=True, exist_ok=True)
        folder = pathlib.Path(tempfile.mkdtemp(prefix=".unfinished-", dir=out))
        yield folder
    except OSError as error:
        raise Failure(f"can't write into '{out}' ({error.strerror}): make room or give another OUT"
                      ) from error
    finally:
        if folder:
            shutil.rmtree(folder, ignore_errors=True)
        with contextlib.suppress(OSError):  # not empty
            for path in made:
                path.rmdir()


def interrupted(*_):
    raise KeyboardInterrupt


def main():
    if sys.argv[1:] == ["--properties"]:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # | head is no error
        report.properties(tracking.settable_properties())
        return
    for word in sys.argv[1:]:
        command.check_name(word)
    if sys.argv[1] == "--simulate":
        source, rest = tracking.Simulation(sys.argv[2:5]), sys.argv[5:]
    else:
        source, rest = pathlib.Path(sys.argv[1]), sys.argv[2:]
    out = pathlib.Path(rest[0])
    # until the job runs, which ends in its own way
    for number in command.heard(signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    with unfinished(out) as folder:
        job = tracking.Job(source, out, folder, rest[1:])
        with report.Progress(source.name) as progress:
            job.run(progress)
        report.preview(folder, job.frames)
        report.page(job, folder, out / "page")
        for name in report.results(job):
            if (folder / name).exists():
                os.replace(folder / name, out / name)
            else:  # no preview: that of another run must not seem to belong to this one
                (out / name).unlink(missing_ok=True)
    for text in filter(None, (*job.warnings, job.cut_short)):
        command.told(f"quickstart: {text}", sys.stderr)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    command.told("\n".join(report.table(job, out)), sys.stdout)


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        command.told(f"quickstart: {failure}", sys.stderr)
        sys.exit(failure.code)
    except KeyboardInterrupt:  # before there was anything to end properly
        sys.exit(130)
