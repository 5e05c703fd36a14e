# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks every video of a list or folder: see --help, and docs/archive.md.

This program compares LIST with the results in OUT (archive_videos.py), and writes a plan. Jobs
(archive_machines.py, archive_job.py) get numbers of the plan, and leave results beside the tracks.
The program gathers those into the index (archive_index.py), and prints its progress
(archive_progress.py).
"""

import argparse
import contextlib
import json
import os
import pathlib
import signal
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pipelines.lib import (archive_index, archive_machines, archive_progress, archive_videos,
                           command, lock)

EPILOG = f"""
LIST is a folder or a text file. Of a folder every video is taken, also of folders within, and each
file once ({' '.join(archive_videos.VIDEOS)}).
A text file has the path of a video on each line. Relative paths begin at its own folder. Lines that
begin with # are left out.

OUT gets for each video VIDEO.jsonl, its tracks (docs/metadata.md), and VIDEO.json, what was done
and how it went. Where the video is in a folder within LIST, so are they. They are complete or not
there. index.sqlite has it all in one table, videos.

The same command again leaves alone what is done and still valid. A video is tracked again if it has
changed, if csdtrack has another version or other settings, if its tracks are gone, or if its job
was killed. One that failed is tried again if one of these has changed, or with --redo failed.

Each machine of --ssh (HOST, or N/HOST for N videos at a time) and each node of the cluster needs
the videos, OUT and this repository, built, at the same paths. Slurm's sbatch reads
SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT and the like from the environment.

csdtrack runs with the preset archive (docs/pipelines.md), and with n-threads=1, as videos are
tracked side by side.

Exit code: 0 if every video of LIST is done, 1 if not (one line says why; --list has the errors),
2 for wrong use, 130 if it was ended by a signal.
"""

MACHINE_SETTINGS = ("n-threads",)  # properties that don't change the tracks


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/archive", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        usage="%(prog)s LIST OUT [--ssh HOSTS | --slurm] [--jobs N] [--preset NAME] "
        "[--set PROPERTY=VALUE] [--redo WHICH]\n"
        "       %(prog)s --list OUT",
        description="Tracks points on the tissue in every video of a list or folder.")
    parser.add_argument("videos", type=pathlib.Path, nargs="?", metavar="LIST",
                        help="a folder of videos, or a text file with their paths")
    parser.add_argument("out", type=pathlib.Path, nargs="?", metavar="OUT",
                        help="the folder of the tracks and the index")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--ssh", metavar="HOSTS",
                       help="on these machines, HOST,HOST,… (on this one)")
    where.add_argument("--slurm", action="store_true", help="in a cluster, as Slurm arrays")
    where.add_argument("--list", type=pathlib.Path, metavar="OUT",
                       help="print the index of an earlier run, and do nothing")
    parser.add_argument("--jobs", type=int, metavar="N",
                        help="videos at a time, on each machine (one for each core) "
                        "or in the cluster (what it gives)")
    parser.add_argument("--preset", default="archive", metavar="NAME", help="of csdtrack (archive)")
    parser.add_argument("--redo", choices=("failed", "all"),
                        help="track again those that failed, or all")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if options.list and options.videos:
        parser.error("--list OUT stands alone")
    if not options.list and not options.out:
        parser.error("give LIST and OUT")
    if options.out and os.path.exists(options.out):
        if not os.path.isdir(options.out):
            parser.error(f"'{options.out}' is a file: give a folder as OUT")
        if os.path.exists(options.videos) and os.path.samefile(options.videos, options.out):
            parser.error(f"'{options.out}' can't be LIST and OUT at once: give another OUT")
    if options.jobs is not None and options.jobs < 1:
        parser.error(f"--jobs: {options.jobs} is not at least 1")
    options.hosts = [host.strip() for host in (options.ssh or "").split(",") if host.strip()]
    if options.ssh is not None and (not options.hosts or any(
            host.startswith("-") or any(c.isspace() for c in host) for host in options.hosts)):
        parser.error(f"--ssh: '{options.ssh}' is no list of hosts: HOST,HOST,…")
    return options


def read_settings(preset: str, settings: Iterable[tuple[str, str]]) -> tuple[str, str,
                                                                             dict[str, str]]:
    """csdtrack's version, and its properties that are not the default.

    The properties are given as text for the index, and by name for a job.
    """
    from pipelines.lib import archive_job, properties, runner  # from here on GStreamer is needed
    track = runner.Gst.ElementFactory.make("csdtrack")
    version = archive_job.version()
    runner.configure(track, preset, {"n-threads": "1"}, settings)
    changed = {
        name: properties.as_text(track, name)
        for name, spec in sorted(properties.settable(track).items())
        if track.get_property(name) != spec.default_value
    }
    if "attach-meta" in changed:
        raise command.Failure("attach-meta=false leaves no tracks to write: leave it out")
    text = " ".join(f"{name}={value}" for name, value in changed.items()
                    if name not in MACHINE_SETTINGS)
    return version, text, changed


def prepare(out: pathlib.Path, own: pathlib.Path) -> int:
    """Makes the program's own folder in OUT, and locks it.

    The lock lasts as long as this program or GNU parallel.
    """
    try:
        (own / "progress").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise command.Failure(
            f"can't write into '{out}' ({error.strerror}): give another OUT") from error
    return lock.take(own / "lock", out)


def remove(paths: Iterable[pathlib.Path]) -> None:
    """Removes what a run made that couldn't start, except folders that hold something else."""
    for path in paths:
        with contextlib.suppress(OSError):
            if path.is_dir():
                path.rmdir()
            else:
                path.unlink()


def remove_unfinished(out: pathlib.Path) -> None:
    """Removes the files of killed jobs. A job that still runs can't rename its tracks any more."""
    for folder, _folders, files in os.walk(out):
        for name in files:
            if name.startswith(".") and name.endswith(".unfinished"):
                # A job on another machine may have removed it.
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(os.path.join(folder, name))


def run(options: argparse.Namespace, own: pathlib.Path, lock_file: int, version: str,
        settings: str, properties: Mapping[str, str],
        on_start: Callable[[], Any]) -> list[archive_index.Row]:
    """Returns the rows of all videos of LIST. Calls on_start() before the first job starts."""
    index = archive_index.Index(options.out)
    machines: archive_machines.Machines | None = None
    if options.slurm:
        slurm = archive_machines.Slurm(options.jobs, int(properties.get("n-threads", 0)), own)
        machines = slurm
        if slurm.earlier_tasks():
            archive_progress.print_or_interrupt(
                "an earlier run's jobs are still in the cluster: waiting for them")
            while slurm.earlier_tasks():
                time.sleep(slurm.PAUSE)
    remove_unfinished(options.out)
    for path in (*own.glob("plan-*.json"), *own.glob("progress/*"), own / "log"):
        path.unlink(missing_ok=True)
    names, jobs, rows = archive_videos.compare(options, index, version, settings)
    index.put(rows)
    index.forget(options.out, set(names))
    if jobs and machines is None:
        hosts = archive_machines.usable_hosts(options.hosts, options.out,
                                              version) if options.hosts else []
        machines = archive_machines.Parallel(options.jobs, hosts, own / "log", lock_file)
    on_start()
    if jobs and machines:
        plan = {
            "out": str(options.out), "version": version, "settings": settings,
            "properties": properties, "jobs": jobs
        }
        run_jobs(machines, plan, index, own, names)
    return [index.rows[name] for name in names]


def run_jobs(machines: archive_machines.Machines, plan: dict[str, Any],
             index: archive_index.Index, own: pathlib.Path, names: list[str]) -> None:
    """Runs the plan's jobs to their end, or until a signal or a full disk ends them."""
    out = pathlib.Path(plan["out"])
    progress = archive_progress.Progress(plan["jobs"], own / "progress")
    gatherer = archive_progress.Gatherer(plan, index, progress)
    ended: BaseException | None = None
    try:
        for _ in range(machines.ROUNDS):
            if gatherer.open:
                run_round(machines, gatherer, progress, plan, own / f"plan-{time.time_ns()}.json")
    except (KeyboardInterrupt, command.Full) as error:
        ended = error
    finally:
        archive_progress.set_signal_handler(signal.SIG_IGN)  # up to the exit
        why = progress.read()  # before stop() ends the jobs
        left = machines.stop(isinstance(ended, command.Full))
        if left is None:
            remove_unfinished(out)
        # After the rest, as the terminal may be gone.
        with contextlib.suppress(KeyboardInterrupt):
            progress.end()
        if left:
            archive_progress.warn(left)
    with contextlib.suppress(KeyboardInterrupt):
        gatherer.gather()
    if not ended:
        no_result = f"its job ended without a result: see '{own / 'log'}'"
        why = dict.fromkeys(gatherer.open, no_result) | why
    index.put(index.rows[command.escaped(plan["jobs"][number]["name"])] | {"error": why[number]}
              for number in gatherer.open & why.keys())
    if not ended or not gatherer.open:  # a signal may also come after the last job
        return
    if not left:
        done = sum(index.rows[name]["status"] == "done" for name in names)
        archive_progress.warn(
            f"ended: {done} of {len(names)} videos are done, the same command does the rest")
    raise ended


def run_round(machines: archive_machines.Machines,
              gatherer: archive_progress.Gatherer, progress: archive_progress.Progress,
              plan: dict[str, Any], path: pathlib.Path) -> None:
    """Starts all jobs without a result, and gathers until none runs any more.

    Raises command.Full as soon as a job reports a full disk.
    """

    def gather() -> None:
        gatherer.gather()
        full = command.Full(plan["out"])
        if str(full) in progress.read().values():
            raise full

    plan["order"] = sorted(gatherer.open)
    archive_index.write_atomically(path, json.dumps(plan))
    machines.start(path, len(plan["order"]))
    while machines.working():
        started = time.monotonic()
        gather()
        progress.show()
        # At most a twentieth of the time is spent on gathering, which takes long for many videos.
        time.sleep(max(machines.PAUSE, 20 * (time.monotonic() - started)))
    gather()
    path.unlink()


def print_index(out: pathlib.Path) -> None:
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    rows = archive_index.Index(out, make=False).rows.values()
    for line in (*archive_index.table(rows), *archive_index.statistics(rows)):
        print(line)


def main() -> None:
    options = command.parse_options(parse)
    if options.list:
        print_index(options.list)
        return
    if not os.path.exists(options.videos):
        raise command.Failure(f"there is no '{options.videos}': give a folder of videos, "
                              "or a text file with their paths")
    options.out = pathlib.Path(os.path.abspath(options.out))
    command.check_name(str(options.out))  # the folders above it, too
    version, settings, properties = read_settings(options.preset, options.set)
    archive_progress.set_signal_handler(archive_progress.interrupt)
    own = options.out / ".archive"
    made = [
        path for path in (options.out / "index.sqlite", own / "lock", own / "progress", own,
                          options.out, *options.out.parents) if not os.path.exists(path)
    ]
    try:
        with contextlib.ExitStack() as undo:
            lock_file = prepare(options.out, own)
            # Only now, with the lock: another run may have made them.
            undo.callback(remove, made)
            rows = run(options, own, lock_file, version, settings, properties, undo.pop_all)
    except OSError as error:
        raise archive_index.failure(error, options.out) from error
    # The results stand, whether or not anybody reads this.
    with contextlib.suppress(KeyboardInterrupt):
        for line in (*archive_index.troubles(rows), *archive_index.statistics(rows)):
            archive_progress.print_or_interrupt(line)
    not_done = sum(row["status"] != "done" for row in rows)
    if not_done:
        raise command.Failure(f"{not_done} of {len(rows)} videos not done: "
                              f"'pipelines/archive --list {options.out}' says why")


if __name__ == "__main__":
    command.run("archive", main)
