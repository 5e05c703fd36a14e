# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program behind pipelines/quickstart: tracks one file, and leaves the results in a folder.

    python3 -m pipelines.lib.quickstart VIDEO OUT [PROPERTY=VALUE...]
    python3 -m pipelines.lib.quickstart --simulate SETTING SETTING SETTING OUT [PROPERTY=VALUE...]
    python3 -m pipelines.lib.quickstart --properties

A SETTING is PROPERTY=VALUE of csdsimsrc.
"""

import contextlib
import os
import pathlib
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from typing import Any

from pipelines.lib import command, properties, report, tracking
from pipelines.lib.failure import Failure
from pipelines.lib.properties import GObject, Gst


@contextlib.contextmanager
def unfinished_folder(out: pathlib.Path) -> Iterator[pathlib.Path]:
    """A temporary folder in OUT, hence on its file system.

    Afterwards it is removed, and so is OUT if it is empty and wasn't there before.
    """
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


def settable_properties() -> Iterator[tuple[str, str, str, str]]:
    """Name, values, default and description of each property of csdtrack that --set takes."""
    track = Gst.ElementFactory.make("csdtrack")
    for name, spec in properties.settable(track).items():
        if name in tracking.FIXED:
            continue
        default, minimum = spec.default_value, getattr(spec, "minimum", None)
        if spec.value_type.is_a(GObject.TYPE_ENUM):
            values = " | ".join(properties.choices(track, name))
            # PyGObject 3.50 gives the default as a number.
            default = track.get_property(name).value_nick
        elif spec.value_type == GObject.TYPE_BOOLEAN:
            values, default = "true | false", str(default).lower()
        elif minimum is not None:
            values = f"{minimum} to {spec.maximum}"
        else:
            values, default = "text", default or "empty"
        if name in tracking.PRESET:
            default += f"; quickstart: {tracking.PRESET[name]}"
        yield name, values, str(default), spec.blurb


def interrupt(*_: Any) -> None:
    raise KeyboardInterrupt


def main() -> None:
    if sys.argv[1:] == ["--properties"]:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # | head is no error
        report.print_properties(settable_properties())
        return
    for word in sys.argv[1:]:
        command.check_name(word)
    source: pathlib.Path | tracking.Simulation
    if sys.argv[1] == "--simulate":
        source, rest = tracking.Simulation(sys.argv[2:5]), sys.argv[5:]
    else:
        source, rest = pathlib.Path(sys.argv[1]), sys.argv[2:]
    out = pathlib.Path(rest[0])
    # Until the job runs, which ends in its own way.
    for number in command.not_ignored(signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupt)
    with unfinished_folder(out) as folder:
        job = tracking.Job(source, out, folder, rest[1:])
        with report.Progress(source.name) as progress:
            job.run(progress)
        lost = job.differences()
        report.make_preview(folder, job.frames)
        report.make_page(job, folder, out / "page")
        for name in report.results(job):
            if (folder / name).exists():
                os.replace(folder / name, out / name)
            else:
                # Without a preview, an earlier run's must not look like this one's.
                (out / name).unlink(missing_ok=True)
    for text in filter(None, (*job.warnings, job.cut_short)):
        command.print_line(f"quickstart: {text}", sys.stderr)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    command.print_line("\n".join(report.table(job, out)), sys.stdout)
    if lost:
        raise Failure("; ".join(lost))


if __name__ == "__main__":
    command.run("quickstart", main)
