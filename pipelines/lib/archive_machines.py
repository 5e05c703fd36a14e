# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where an archive's jobs run: here or over ssh by GNU parallel, or in a cluster as Slurm arrays.

Parallel and Slurm have the same interface:

  start(plan, count)  starts the jobs 0 … count − 1 of a plan
  working()           whether jobs still run
  stop(useless)       is called when signals are ignored already. It returns None if no job runs on
                      after it. Otherwise it returns a message about those jobs, or "".
                      `useless`: no job can do anything more.
  PAUSE               seconds between two calls of working()
  ROUNDS              how often jobs without a result are started
"""

import contextlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence

from pipelines.lib import archive_progress, command

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]  # at the same path on each machine
TIMEOUT = 30  # seconds for a host to answer


def job_command(*arguments: object) -> str:
    """The command of a job, for any shell on any machine."""
    kept = [
        f"{name}={os.environ[name]}" for name in ("GST_PLUGIN_PATH_1_0", "GST_REGISTRY")
        if name in os.environ
    ]
    # The user's own folders, too: gi may be in one.
    folders = [str(REPOSITORY), *filter(None, os.environ.get("PYTHONPATH", "").split(":"))]
    return shlex.join([
        "env", f"PYTHONPATH={':'.join(dict.fromkeys(folders))}", *kept, "/usr/bin/python3", "-B",
        "-P", "-m", "pipelines.lib.archive_job", *map(str, arguments)
    ])


def require(program: str, package: str) -> None:
    if not shutil.which(program):
        raise command.Failure(f"this needs the command {program}: install {package}")


class Parallel:
    """GNU parallel, here or on hosts.

    It retries a job once if the job's process was killed or its host was lost.
    """

    PAUSE = 0.2
    ROUNDS = 1  # it retries by itself

    def __init__(self, jobs: int | None, hosts: Sequence[str], log: pathlib.Path,
                 lock: int) -> None:
        require("parallel", "GNU parallel (Debian: parallel)")
        self._options = ["--will-cite", "--retries", "2", "--jobs", str(jobs or "100%")]
        if hosts:
            self._options += ["--sshlogin", ",".join(hosts)]
        self._log, self._lock = log, lock
        self._process: subprocess.Popen[bytes] | None = None

    def start(self, plan: pathlib.Path, count: int) -> None:
        # Whole commands: parallel interprets arguments in its own way. From a file: it reads them
        # when it needs the next. In a new session: Ctrl-C reaches only this program, which then
        # ends everything in order. parallel inherits the lock and holds it while it runs.
        with tempfile.TemporaryFile() as commands, open(self._log, "ab") as log:
            commands.write(b"".join(
                job_command(plan, number).encode() + b"\0" for number in range(count)))
            commands.seek(0)
            self._process = subprocess.Popen(["parallel", "--null", *self._options],
                                             stdin=commands, stdout=log, stderr=log,
                                             start_new_session=True, pass_fds=[self._lock])

    def working(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def stop(self, _useless: bool) -> str | None:
        process = self._process
        if process is None or process.poll() is not None:
            return None
        for _ in range(2):  # after the second signal it ends its jobs
            process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(1)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
        return None


def usable_hosts(hosts: Sequence[str], out: pathlib.Path, version: str) -> list[str]:
    """The hosts ([N/]HOST, as GNU parallel takes them) that can do the work.

    Prints for each of the others why it can't.
    """
    program = shlex.split(os.environ.get("PARALLEL_SSH", "ssh"))
    require(program[0], "OpenSSH's client (Debian: openssh-client)")
    usable = []
    for host in hosts:
        login = host.rsplit("/", 1)[-1]
        reason = why_unusable(program, login, out, version)
        if reason:
            archive_progress.warn(f"warning: {login} is left out: {reason}")
        else:
            usable.append(host)
    if not usable:
        raise command.Failure("none of the hosts can do it: 'ssh HOST true' must work without "
                              "a question, and the same folders must be there")
    return usable


def why_unusable(program: Sequence[str], login: str, out: pathlib.Path, version: str) -> str:
    """Why this host can't do the work; "" if it can."""
    try:
        done = subprocess.run([
            *program, "-o", "BatchMode=yes", "-o", f"ConnectTimeout={TIMEOUT}", login,
            job_command("--host", out)
        ], capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL,
                              timeout=2 * TIMEOUT)
    except subprocess.TimeoutExpired:
        return f"no answer in {2 * TIMEOUT} s"
    output = done.stdout if done.returncode == 0 else done.stderr
    answer = (output.strip().splitlines() or ["no answer"])[-1]
    if "No module named 'pipelines'" in answer:
        return f"there is no '{REPOSITORY}': the repository must be there, at the same path"
    if done.returncode:
        return answer.removeprefix("archive: ")
    return "" if answer == version else \
        f"csdtrack is {answer} there and {version} here: build the same"


class Slurm:
    """Submits arrays of jobs, each when no task of the last one waits: a cluster bounds their size.

    It keeps their ids in a file. They run on when this program ends, and the next run waits for
    them.
    """

    PAUSE = 2.0
    ROUNDS = 2

    def __init__(self, jobs: int | None, threads: int, folder: pathlib.Path) -> None:
        for program in ("sbatch", "squeue"):
            require(program, "Slurm's commands, or run this where they are (Debian: slurm-client)")
        self._jobs, self._threads = jobs, max(threads, 1)
        self._folder = folder
        self._ids = folder / "slurm-arrays"
        self._rest = range(0)
        self._plan = pathlib.Path()
        config = self._ask("scontrol", "show", "config")
        if config is None:
            raise command.Failure("no Slurm cluster answers here: run this where 'scontrol ping' "
                                  "finds one, or without --slurm")
        found = re.search(r"^MaxArraySize\s*=\s*(\d+)", config, re.M)
        self._max_size = int(found.group(1)) if found else 1001

    def earlier_tasks(self) -> int:
        """How many tasks an earlier run still has in the cluster."""
        with contextlib.suppress(OSError):
            return self._count_tasks(self._ids.read_text().split())
        return 0

    def start(self, plan: pathlib.Path, count: int) -> None:
        self._ids.unlink(missing_ok=True)
        self._plan, self._rest = plan, range(count)
        self._submit()

    def working(self) -> bool:
        ids = self._ids.read_text().split()
        if self._rest and not self._count_tasks(ids[-1:], "PENDING"):
            self._submit()
            return True
        return bool(self._count_tasks(ids))

    def stop(self, useless: bool) -> str | None:
        ids = self._ids.read_text().split() if self._ids.exists() else []
        if not self._count_tasks(ids):
            return None
        if useless:
            self._ask("scancel", *ids)
            return ""
        return ("the cluster goes on: the same command follows it, "
                f"'scancel {' '.join(ids)}' ends it")

    def _submit(self) -> None:
        part, self._rest = self._rest[:self._max_size], self._rest[self._max_size:]
        limit = f"%{self._jobs}" if self._jobs else ""
        # Without srun, as a task is one process. The job's command sets its environment; that of
        # this shell doesn't count.
        done = subprocess.run([
            "sbatch", "--parsable", f"--array=0-{len(part) - 1}{limit}",
            "--job-name=csdtrack-archive", f"--cpus-per-task={self._threads}",
            f"--output={str(self._folder / 'log').replace('%', '%%')}", "--open-mode=append",
            "--wrap", f"exec {job_command(self._plan)} $(({part[0]} + SLURM_ARRAY_TASK_ID))"
        ], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            raise command.Failure(f"Slurm takes no jobs: {' '.join(done.stderr.split())}")
        with open(self._ids, "a", encoding="utf-8") as file:
            file.write(done.stdout.strip().split(";")[0] + "\n")

    def _count_tasks(self, ids: Sequence[str], states: str = "all") -> int:
        """How many tasks of these arrays Slurm has still to finish."""
        if not ids:
            return 0
        wanted = [] if states == "all" else ["--states", states]
        answer = self._ask("squeue", "--noheader", "--array", "--format=%A", "--jobs",
                           ",".join(ids), *wanted)
        return 1 if answer is None else len(answer.split())

    def _ask(self, *words: str) -> str | None:
        """Slurm's answer; "" about jobs that it has forgotten; None if it doesn't answer.

        Without an answer, the jobs may still run.
        """
        done = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            return "" if "Invalid job id" in done.stderr else None
        return done.stdout


Machines = Parallel | Slurm
