# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks every video of a list or folder: see --help, and docs/archive.md.

This program compares LIST with what OUT has, hands the rest to jobs (archive_machines.py, archive_job.py) as numbers of a plan, gathers the
results that they leave beside the tracks into the index (archive_index.py), and tells how far it is.
"""

import argparse
import contextlib
import json
import os
import pathlib
import signal
import sys
import time

from pipelines.lib import archive_index, archive_machines, command, lock

VIDEOS = ".3gp .avi .flv .m2ts .m4v .mkv .mov .mp4 .mpeg .mpg .mts .mxf .ogv .ts .vob .webm .wmv".split(
)

EPILOG = f"""
LIST is a folder, of which every video is taken ({' '.join(VIDEOS)}; also in folders within; each file once),
or a text file with the path of a video on each line (relative ones are from its folder; lines that begin with # are left out).

OUT gets for each video VIDEO.jsonl, its tracks, as docs/metadata.md says, and VIDEO.json, what was done and how it went; where the
video is in a folder within LIST, so are they. They are whole or not there. index.sqlite has it all in one table, videos.

Again with the same OUT: what is done and still true is left alone. A video is tracked again if it has changed, if csdtrack has another
version or other settings, if its tracks are gone, or if its job was killed. One that failed is tried again if one of these has changed, or
with --redo failed.

Each machine of --ssh (HOST, or N/HOST for N videos at a time) and each node of the cluster needs the videos, OUT and this repository, built,
at the same paths. Slurm's sbatch reads SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT and the like from the environment.

What csdtrack is told: the preset archive (docs/pipelines.md), and n-threads=1, for videos are tracked side by side.

Exit code: 0 if every video of LIST is done, 1 if not (one line says why; --list has the errors), 2 for wrong use, 130 if told to end.
"""

# how often a job is given out that leaves no result, where GNU parallel doesn't see to it
ROUNDS = 2
MACHINES = ("n-threads",)  # what does not change the tracks
FOUNDED = 30  # seconds of work before it is said how much is left


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/archive", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG, usage=
        "%(prog)s LIST OUT [--ssh HOSTS | --slurm] [--jobs N] [--preset NAME] [--set PROPERTY=VALUE] [--redo WHICH]\n"
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
    parser.add_argument(
        "--jobs", type=int, metavar="N", help=
        "videos at a time, on each machine (one for each core) or in the cluster (what it gives)")
    parser.add_argument("--preset", default="archive", metavar="NAME", help="of csdtrack (archive)")
    parser.add_argument("--redo", choices=("failed", "all"), help="also again what failed, or all")
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


# ---- What there is to do
# -------------------------------------------------------------------------------------------


def walk(base, out):
    """The paths of a folder's videos, each folder and file once. Links come last, for they may lead back, and what is there has its own name."""
    paths, starts, links, seen, again = [], [base], [], {}, []

    def new(path):
        try:
            found = os.stat(path)
        except OSError:
            return True  # that a link leads nowhere is said later
        first = seen.setdefault((found.st_dev, found.st_ino), path)
        if first != path:
            again.append((path, first))
        return first == path

    for start in starts:  # which grows
        for folder, folders, files in os.walk(start):
            if not new(folder):
                folders.clear()
                continue
            folders[:] = sorted(f for f in folders
                                if not f.startswith(".") and os.path.join(folder, f) != out)
            starts += [
                path for path in (os.path.join(folder, f) for f in folders) if os.path.islink(path)
            ]
            for file in sorted(files):
                path = os.path.join(folder, file)
                if file.startswith(".") or os.path.splitext(file)[1].lower() not in VIDEOS:
                    continue
                if os.path.islink(path):
                    links.append(path)
                elif new(path):
                    paths.append(path)
    paths += filter(new, links)
    if again:
        path, first = (archive_index.shown(command.plain(path)) for path in again[0])
        say(f"left out, for it is '{first}' again: '{path}'" +
            (f", and {len(again) - 1} more of the kind" if again[1:] else ""))
    return paths


def find(source, out):
    """{name: path} of the videos. A name is the path below LIST, or the whole one."""
    if source.is_dir():
        base = pathlib.Path(os.path.abspath(source))
        paths = walk(str(base), str(out))
    else:
        try:
            with open(source, encoding="utf-8", errors="surrogateescape") as file:
                text = file.read(100_000)
                # of a long video the beginning is enough
                text += "" if "\0" in text else file.read()
        except OSError as error:
            raise command.Failure(
                f"can't read '{source}' ({error.strerror}): give a folder of videos, or a text file with their paths"
            ) from error
        if "\0" in text:
            raise command.Failure(
                f"'{source}' is no text: give a folder of videos, or a text file with their paths")
        base = pathlib.Path(os.path.abspath(source.parent))
        paths = [
            os.path.abspath(base / line)
            for line in text.split("\n")
            if line.strip() and not line.startswith("#")
        ]
        if paths and not any(map(os.path.exists, paths)):
            raise command.Failure(
                f"'{source}' is no list of videos: nothing is there of what its lines name, such as "
                f"'{archive_index.shown(command.plain(paths[0]))}'")
    if not paths:
        raise command.Failure(f"'{source}' names no video: see --help")
    return {
        os.path.relpath(path, base)
        if pathlib.Path(path).is_relative_to(base) else path.lstrip("/"): path for path in paths
    }


def settings(preset, wished):
    """csdtrack's version, and of its properties what differs from the default: as text for the index, and {name: value} for a job."""
    from pipelines.lib import archive_job  # GStreamer, from here on
    from pipelines.lib import properties, runner
    track = runner.Gst.ElementFactory.make("csdtrack")
    version = archive_job.version()
    runner.configure(track, preset, {"n-threads": "1"}, wished)
    found = {
        name: properties.as_text(track, name)
        for name, spec in sorted(properties.settable(track).items())
        if track.get_property(name) != spec.default_value
    }
    if "attach-meta" in found:
        raise command.Failure("attach-meta=false leaves no tracks to write: leave it out")
    return version, " ".join(f"{name}={value}" for name, value in found.items()
                             if name not in MACHINES), found


def compare(options, index, version, text):
    """Of LIST: the names of all, the jobs to do, and rows that the index lacks."""
    names, jobs, rows = [], [], []
    for name, path in find(options.videos, options.out).items():
        found, plain, path_shown = archive_index.stamp(path), command.plain(name), command.plain(
            path)
        identity = {
            "version": version, "settings": text, "size": found and found[0], "mtime": found and
            found[1]
        }
        names.append(plain)
        known = index.rows.get(plain)
        if known and known["video"] != path_shown and os.path.exists(known["video"]):
            raise command.Failure(
                f"'{options.out}' has tracks of another '{plain}', of '{known['video']}': give another OUT"
            )
        if not archive_index.holds(options.out, known, identity):
            known = archive_index.read_result(options.out, plain)
            if archive_index.holds(options.out, known, identity):
                rows.append(known)
            else:
                known = None
        if known and options.redo not in ("all", known["status"]):
            continue
        why = None
        if path_shown != path:
            why = f"'{path_shown}' is no UTF-8: rename it"
        elif not found:
            why = f"there is no file '{path}': correct the list, or bring it back"
        elif command.is_pipe(path):
            why = f"'{path}' {command.PIPE}"
        elif not found[0]:
            why = f"'{path}' is empty: copy it again, or remove it"
        else:
            jobs.append({"name": name, "video": path, "size": found[0]})
        rows.append(
            dict.fromkeys(archive_index.COLUMNS) | identity | {
                "name": plain, "video": path_shown, "status": "failed" if why else "unfinished",
                "error": why or "not yet tracked"
            })
    return names, jobs, rows


# ---- Being told to end
# ---------------------------------------------------------------------------------------------


def on_end(handler):
    """What a signal to end does."""
    for number in command.heard(signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, handler)


def interrupted(*_):
    # Once: a second signal would leave GNU parallel alone, and it may already be here. Of such a
    # one SIG_IGN would make Python complain.
    on_end(lambda *_: None)
    raise KeyboardInterrupt


def tell(text, end="\n"):
    """Prints it. Where nobody can read it, that is being told to end."""
    if not command.told(text, sys.stdout, end):
        interrupted()


def say(text):
    """Prints it on stderr, to whoever is still there."""
    command.told(f"archive: {text}", sys.stderr)


# ---- How far it is
# -------------------------------------------------------------------------------------------------


class Progress:
    """A line for each video that is through; on a terminal also one that is kept up to date."""

    def __init__(self, jobs, folder):
        self._sizes = [max(job["size"], 1) for job in jobs]
        self._folder = folder
        self._told = {}  # by number: how much of a video is done, 0 … 1, or why its job gave up
        self._begun = None  # in a cluster work may begin hours later
        self._through = 0
        self._bytes = 0
        self._clear = "\r\033[K" if sys.stdout.isatty() else ""

    def row(self, number, row):
        self._through += 1
        self._bytes += self._sizes[number]
        self._told.pop(number, None)
        how = f"{row['frames']} frames, {row['frames'] / max(row['seconds'], 1e-3):.1f} a second" if row["status"] == "done" else \
            f"{row['status']}: {archive_index.shown(row['error'])}"
        tell(f"{self._clear}{self._state()}  {archive_index.shown(row['name'])}: {how}")

    def look(self):
        """Hears what the jobs tell. Returns why some gave up: {number: text}."""
        self._told = {}
        with contextlib.suppress(OSError):
            for name in os.listdir(self._folder):
                with contextlib.suppress(OSError, ValueError):
                    self._told[int(name)] = json.loads((self._folder / name).read_text())
        if self._told and self._begun is None:
            self._begun = time.monotonic()
        return {number: told for number, told in self._told.items() if isinstance(told, str)}

    def show(self):
        if self._clear:
            tell(f"{self._clear}{self._state()}, {len(self._shares())} under way", end="")

    def end(self):
        tell(self._clear, end="")

    def _shares(self):
        return {number: told for number, told in self._told.items() if isinstance(told, float)}

    def _state(self):
        """By the bytes of the videos: how long they are is known when they have been read."""
        sure = self._bytes + sum(share * self._sizes[number]
                                 for number, share in self._shares().items())
        spent = time.monotonic() - self._begun if self._begun else 0
        left = ""
        if spent > FOUNDED and 0 < sure < sum(self._sizes):
            left = f", {archive_index.clock(spent * (sum(self._sizes) / sure - 1))} left"
        return f"{self._through} of {len(self._sizes)}{left}"


class Gatherer:
    """Takes the results that jobs leave into the index."""

    def __init__(self, out, jobs, plan, index, progress):
        self._out, self._jobs, self._plan, self._index, self._progress = out, jobs, plan, index, progress
        self._before = [self._mark(number) for number in range(len(jobs))]
        self.open = set(range(len(jobs)))

    def look(self):
        rows = {}
        for number in sorted(self.open):
            if self._mark(number) == self._before[number]:
                continue
            row = archive_index.read_result(self._out, self._jobs[number]["name"])
            if row and (row["version"], row["settings"]) == (self._plan["version"],
                                                             self._plan["settings"]):
                rows[number] = row
        self._index.put(rows.values())
        self.open -= rows.keys()
        for number, row in rows.items():  # last: there may be nobody to tell it to
            self._progress.row(number, row)

    def _mark(self, number):
        """Differs once the result has been written again."""
        path = archive_index.result_of(self._out, self._jobs[number]["name"])
        try:
            with open(path, "rb") as file:  # opened: over NFS what stat says may be a minute old
                found = os.fstat(file.fileno())
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns


# ---- Doing it
# ------------------------------------------------------------------------------------------------------


def prepare(out, own):
    """Makes OUT's own folder, and returns a lock on it that lasts as long as this program or GNU parallel."""
    try:
        (own / "progress").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise command.Failure(
            f"can't write into '{out}' ({error.strerror}): give another OUT") from error
    return lock.take(own / "lock", out)


def remove(paths):
    """Away with what a run made that couldn't begin, but for folders that have got something else."""
    for path in paths:
        with contextlib.suppress(OSError):
            path.rmdir() if path.is_dir() else path.unlink()


def tidy(out):
    """Away with what killed jobs left. If one of them lives after all, it can't give its tracks their name any more."""
    for folder, _folders, files in os.walk(out):
        for name in files:
            if name.startswith(".") and name.endswith(".unfinished"):
                # a job on another machine may be at it itself
                with contextlib.suppress(FileNotFoundError):
                    os.unlink(os.path.join(folder, name))


def run(options, own, locked, version, text, properties, begun):
    """Returns the rows of all videos of LIST. Calls begun() once it is clear that it can be done."""
    index = archive_index.Index(options.out)
    machines = None
    if options.slurm:
        machines = archive_machines.Slurm(options.jobs, int(properties.get("n-threads", 0)), own)
        if machines.earlier():
            tell("an earlier run's jobs are still in the cluster: waiting for them")
            while machines.earlier():
                time.sleep(machines.PAUSE)
    tidy(options.out)
    for path in (*own.glob("plan-*.json"), *own.glob("progress/*"), own / "log"):
        path.unlink(missing_ok=True)
    names, jobs, rows = compare(options, index, version, text)
    index.put(rows)
    index.forget(options.out, set(names))
    if jobs and not options.slurm:
        hosts = archive_machines.answering(options.hosts, options.out,
                                           version) if options.hosts else []
        machines = archive_machines.Parallel(options.jobs, hosts, own / "log", locked)
    begun()
    if jobs:
        progress = Progress(jobs, own / "progress")
        plan = {
            "out": str(options.out), "version": version, "settings": text, "properties": properties,
            "jobs": jobs
        }
        gatherer = Gatherer(options.out, jobs, plan, index, progress)
        ended = None
        try:
            for _ in range(ROUNDS if options.slurm else 1):
                if gatherer.open:
                    work(machines, gatherer, progress, plan, own / f"plan-{time.time_ns()}.json")
        except (KeyboardInterrupt, command.Full) as error:
            ended = error
        finally:
            on_end(signal.SIG_IGN)  # up to the exit
            why = progress.look()  # before they are told to end
            left = machines.stop(isinstance(ended, command.Full))
            if left is None:
                tidy(options.out)
            # after what must be done: there may be no terminal to print to
            with contextlib.suppress(KeyboardInterrupt):
                progress.end()
            if left:
                say(left)
        with contextlib.suppress(KeyboardInterrupt):
            gatherer.look()
        if not ended:
            why = dict.fromkeys(gatherer.open,
                                f"its job ended without a result: see '{own / 'log'}'") | why
        index.put(index.rows[command.plain(jobs[number]["name"])] | {"error": why[number]}
                  for number in gatherer.open & why.keys())
        if ended and not gatherer.open:
            ended = None  # it came too late: the last line couldn't be read, say
        if ended and not left:
            done = sum(index.rows[name]["status"] == "done" for name in names)
            say(f"ended: {done} of {len(names)} videos are done, the same command does the rest")
        if ended:
            raise ended
    return [index.rows[name] for name in names]


def work(machines, gatherer, progress, plan, path):
    """Hands out all jobs that are open, and gathers until none works any more. Raises command.Full as soon as a job says it."""

    def look():
        gatherer.look()
        full = command.Full(plan["out"])
        if str(full) in progress.look().values():
            raise full

    plan["order"] = sorted(gatherer.open)
    archive_index.whole(path, json.dumps(plan))
    machines.start(path, len(plan["order"]))
    while machines.working():
        begun = time.monotonic()
        look()
        progress.show()
        # many videos take long to look at
        time.sleep(max(machines.PAUSE, 20 * (time.monotonic() - begun)))
    look()
    path.unlink()


def main():
    options = command.options(parse)
    if options.list:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        rows = archive_index.Index(options.list, make=False).rows.values()
        for line in (*archive_index.table(rows), *archive_index.statistics(rows)):
            print(line)
        return
    if not os.path.exists(options.videos):
        raise command.Failure(
            f"there is no '{options.videos}': give a folder of videos, or a text file with their paths"
        )
    options.out = pathlib.Path(os.path.abspath(options.out))
    command.check_name(str(options.out))  # with the folder that it is in
    version, text, properties = settings(options.preset, options.set)
    on_end(interrupted)
    own = options.out / ".archive"
    made = [
        path for path in (options.out / "index.sqlite", own / "lock", own / "progress", own,
                          options.out, *options.out.parents) if not os.path.exists(path)
    ]
    try:
        with contextlib.ExitStack() as undo:
            locked = prepare(options.out, own)
            undo.callback(remove, made)  # not before it is ours: another run may have made it
            rows = run(options, own, locked, version, text, properties, undo.pop_all)
    except OSError as error:
        raise archive_index.failure(error, options.out) from error
    with contextlib.suppress(KeyboardInterrupt):  # what is done is done, whoever reads it
        for line in (*archive_index.troubles(rows), *archive_index.statistics(rows)):
            tell(line)
    not_done = sum(row["status"] != "done" for row in rows)
    if not_done:
        raise command.Failure(
            f"{not_done} of {len(rows)} videos not done: 'pipelines/archive --list {options.out}' says why"
        )


if __name__ == "__main__":
    command.run("archive", main)
