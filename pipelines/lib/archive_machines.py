# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where the jobs of an archive run: here or over ssh by GNU parallel, or in a cluster as Slurm arrays.

A way of running has: start(count), jobs 0 … count − 1 of a plan · working() · stop(useless), called when no signal is heard any more, which
returns None if no job lives after it, else what to say of those, if anything; useless: it makes no sense that they go on · PAUSE, seconds
between two looks at it.
"""

import contextlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

from pipelines.lib import command

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]  # at the same path on each machine
TIMEOUT = 30  # seconds for a host to answer


def worker(*arguments):
    """The command of a job, for any shell on any machine."""
    kept = [
        f"{name}={os.environ[name]}" for name in ("GST_PLUGIN_PATH_1_0", "GST_REGISTRY")
        if name in os.environ
    ]
    return shlex.join(["env", f"PYTHONPATH={REPOSITORY}", *kept, "/usr/bin/python3", "-B", "-P",
                       "-m", "pipelines.lib.archive_job", *map(str, arguments)])


def need(program, package):
    if not shutil.which(program):
        raise command.Failure(f"this needs the command {program}: install {package}")


class Parallel:
    """GNU parallel, here or on hosts. A job whose process was killed, or whose host was lost, is tried a second time by parallel itself."""

    PAUSE = 0.2

    def __init__(self, jobs, hosts, log, lock):
        need("parallel", "GNU parallel (Debian: parallel)")
        self._options = ["--will-cite", "--retries", "2", "--jobs", str(jobs or "100%")]
        if hosts:
            self._options += ["--sshlogin", ",".join(hosts)]
        self._log, self._lock = log, lock
        self._process = None

    def start(self, plan, count):
        # Whole commands, for parallel reads more into one than is meant; from a file, for it reads
        # when it needs the next. A session of its own: ^C reaches this program, which then ends all
        # in good order. The lock stays taken while parallel lives.
        with tempfile.TemporaryFile() as commands, open(self._log, "ab") as log:
            commands.write(b"".join(
                worker(plan, number).encode() + b"\0" for number in range(count)))
            commands.seek(0)
            self._process = subprocess.Popen(["parallel", "--null", *self._options], stdin=commands,
                                             stdout=log, stderr=log, start_new_session=True,
                                             pass_fds=[self._lock])

    def working(self):
        return self._process is not None and self._process.poll() is None

    def stop(self, _useless):
        if not self.working():
            return
        for _ in range(2):  # the second time it ends its jobs
            self._process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(1)
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)


def answering(hosts, out, version):
    """Those of the hosts ([N/]HOST, as GNU parallel names them) where the work can be done. Of each other one a line says why not."""
    program = shlex.split(os.environ.get("PARALLEL_SSH", "ssh"))
    need(program[0], "OpenSSH's client (Debian: openssh-client)")
    good = []
    for host in hosts:
        login = host.rsplit("/", 1)[-1]
        try:
            done = subprocess.run([
                *program, "-o", "BatchMode=yes", "-o", f"ConnectTimeout={TIMEOUT}", login,
                worker("--host", out)
            ], capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL,
                                  timeout=2 * TIMEOUT)
            lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines() or [
                "no answer"
            ]
            why = "" if done.returncode == 0 and lines[-1] == version else \
                f"csdtrack is {lines[-1]} there and {version} here: build the same" if done.returncode == 0 else lines[-1].removeprefix("archive: ")
        except subprocess.TimeoutExpired:
            why = f"no answer in {2 * TIMEOUT} s"
        if why:
            print(f"archive: warning: {login} is left out: {why}", file=sys.stderr, flush=True)
        else:
            good.append(host)
    if not good:
        raise command.Failure(
            "none of the hosts can do it: 'ssh HOST true' must work without a question, and the same folders be there"
        )
    return good


class Slurm:
    """Arrays of jobs, the next of them submitted when no task of the last waits any more: a cluster bounds their size.

    Their ids are kept in a file: they go on when this program is ended, and the next one waits for them.
    """

    PAUSE = 2

    def __init__(self, jobs, threads, folder):
        need("sbatch", "Slurm's commands, or run this where they are (Debian: slurm-client)")
        need("squeue", "Slurm's commands, or run this where they are (Debian: slurm-client)")
        self._jobs, self._threads = jobs, max(threads, 1)
        self._folder = folder
        self._ids = folder / "slurm-arrays"
        self._rest = range(0)
        self._plan = None
        config = self._ask("scontrol", "show", "config")
        if config is None:
            raise command.Failure(
                "no Slurm cluster answers here: run this where 'scontrol ping' finds one, or without --slurm"
            )
        found = re.search(r"^MaxArraySize\s*=\s*(\d+)", config, re.M)
        self._most = int(found.group(1)) if found else 1001

    def earlier(self):
        """Tasks of an earlier run that are still there."""
        with contextlib.suppress(OSError):
            return self._tasks(self._ids.read_text().split())
        return 0

    def start(self, plan, count):
        self._ids.unlink(missing_ok=True)
        self._plan, self._rest = plan, range(count)
        self._submit()

    def working(self):
        ids = self._ids.read_text().split()
        if self._rest and not self._tasks(ids[-1:], "PENDING"):
            self._submit()
            return True
        return bool(self._tasks(ids))

    def stop(self, useless):
        ids = self._ids.read_text().split() if self._ids.exists() else []
        if not self._tasks(ids):
            return None
        if useless:
            self._ask("scancel", *ids)
            return ""
        return f"the cluster goes on: the same command follows it, 'scancel {' '.join(ids)}' ends it"

    def _submit(self):
        part, self._rest = self._rest[:self._most], self._rest[self._most:]
        at_a_time = f"%{self._jobs}" if self._jobs else ""
        # No srun: a task is one process. The environment is what the job's command says, not that
        # of this shell.
        done = subprocess.run([
            "sbatch", "--parsable", f"--array=0-{len(part) - 1}{at_a_time}",
            "--job-name=csdtrack-archive", f"--cpus-per-task={self._threads}",
            f"--output={str(self._folder / 'log').replace('%', '%%')}", "--open-mode=append",
            "--wrap", f"exec {worker(self._plan)} $(({part[0]} + SLURM_ARRAY_TASK_ID))"
        ], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            raise command.Failure(f"Slurm takes no jobs: {' '.join(done.stderr.split())}")
        with open(self._ids, "a", encoding="utf-8") as file:
            file.write(done.stdout.strip().split(";")[0] + "\n")

    def _tasks(self, ids, states="all"):
        """How many tasks of these arrays Slurm still has to do."""
        if not ids:
            return 0
        wanted = [] if states == "all" else ["--states", states]
        answer = self._ask("squeue", "--noheader", "--array", "--format=%A", "--jobs",
                           ",".join(ids), *wanted)
        return 1 if answer is None else len(answer.split())

    def _ask(self, *words):
        """What Slurm says; "" for jobs that it has forgotten; None if it doesn't answer: then they may well go on."""
        done = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if done.returncode:
            return "" if "Invalid job id" in done.stderr else None
        return done.stdout
