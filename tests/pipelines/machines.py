# SPDX-License-Identifier: LGPL-2.1-or-later
"""Stand-ins for other machines, to test pipelines/archive: an SSH server and a Slurm cluster, both
on this machine, in a folder of their own, and run by the user who runs the test."""

import contextlib
import getpass
import os
import pathlib
import re
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

SLOW = 60  # seconds within which a server must answer after its start


def need(*programs):
    """The paths of programs, also of servers, which are outside an ordinary user's PATH."""
    paths = {name: shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin")
             for name in programs}
    missing = [name for name, path in paths.items() if not path]
    if missing:
        raise unittest.SkipTest(f"not installed: {', '.join(missing)} (tests/packages)")
    return paths


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def wait(what, seconds=120):
    """Waits until what() is true, and returns it."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        found = what()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"not true within {seconds} s")


def job_at_work(out, name):
    """Waits for a job of pipelines/archive that has written tracks of a video. Returns its process
    id."""

    def writing():
        for path in out.glob(f".{name}.jsonl.*.unfinished"):
            with contextlib.suppress(OSError):
                if path.stat().st_size:
                    return int(re.search(r"-(\d+)\.unfinished$", path.name).group(1))
        return None

    return wait(writing)


class Servers:
    """Programs that run until stop(). The output of each is in a file of the folder."""

    def __init__(self):
        # A short name: a socket's path has 107 characters at most.
        self._temporary = tempfile.TemporaryDirectory(prefix="csd-")
        self.folder = pathlib.Path(self._temporary.name)
        self.folder.chmod(0o755)  # munge demands that others can enter it
        self._processes = []

    def serve(self, *command, answers, **options):
        """Starts a program and waits until answers() is true."""
        name = pathlib.Path(command[0]).name
        log = self.folder / f"{name}.out"
        with open(log, "wb") as out:
            process = subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL,
                                       stdout=out, stderr=out, **options)
        self._processes.append(process)
        until = time.monotonic() + SLOW
        while not answers():
            if process.poll() is not None or time.monotonic() > until:
                raise AssertionError(f"{name} does not come up:\n"
                                     f"{log.read_text(errors='replace')[-3000:]}")
            time.sleep(0.1)

    def stop(self):
        for process in reversed(self._processes):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._temporary.cleanup()


class Ssh(Servers):
    """sshd on loopback, with keys of its own. `command` is an ssh that knows the hosts `one` and
    `two` (both here) and `gone` (where nobody answers)."""

    def __init__(self):
        paths = need("sshd", "ssh", "ssh-keygen")
        super().__init__()
        try:
            self._start(paths)
        except BaseException:
            self.stop()
            raise

    def _start(self, paths):
        port, closed = free_ports(2)
        for key in ("host", "user"):
            subprocess.run([paths["ssh-keygen"], "-q", "-t", "ed25519", "-N", "", "-f",
                            self.folder / key], check=True)
        if os.getuid() == 0:
            # sshd's folder for unprivileged processes; Debian's service would make it.
            os.makedirs("/run/sshd", exist_ok=True)
        (self.folder / "sshd_config").write_text(
            f"ListenAddress 127.0.0.1\nPort {port}\nHostKey {self.folder}/host\n"
            f"AuthorizedKeysFile {self.folder}/user.pub\nPidFile none\n"
            "StrictModes no\nUsePAM no\nPasswordAuthentication no\n"
            "PermitRootLogin prohibit-password\nMaxStartups 100\nLogLevel VERBOSE\n")
        common = (f"  HostName 127.0.0.1\n  User {getpass.getuser()}\n"
                  f"  IdentityFile {self.folder}/user\n  IdentitiesOnly yes\n"
                  f"  UserKnownHostsFile {self.folder}/known\n  StrictHostKeyChecking accept-new\n"
                  "  LogLevel ERROR\n")
        (self.folder / "ssh_config").write_text(
            f"Host one two\n  Port {port}\n{common}Host gone\n  Port {closed}\n{common}")
        self.command = f"{paths['ssh']} -F {self.folder}/ssh_config"
        login = [*self.command.split(), "-o", "BatchMode=yes", "one", "true"]
        self.serve(paths["sshd"], "-D", "-e", "-f", self.folder / "sshd_config",
                   answers=lambda: subprocess.run(login, capture_output=True).returncode == 0)

    def sessions(self):
        """How many logins there were."""
        return (self.folder / "sshd.out").read_text(errors="replace").count("Accepted publickey")


class Slurm(Servers):
    """A cluster of one node with two processors. Slurm's commands use it with `environment`. Arrays
    have at most `array` tasks."""

    def __init__(self, array):
        paths = need("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "sinfo", "scancel")
        super().__init__()
        self._paths = paths
        try:
            self._start(paths, array)
        except BaseException:
            self.stop()
            raise

    def _start(self, paths, array):
        folder, (control, node) = self.folder, free_ports(2)
        host, user = os.uname().nodename.split(".")[0], getpass.getuser()
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "munge.key").touch(0o600)
        (folder / "munge.key").write_bytes(os.urandom(128))
        (folder / "slurm.conf").write_text(f"""
ClusterName=csdtrack
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=100000
MinJobAge=5
MaxArraySize={array}
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""")
        # No confinement here: else slurmd, from 23.02 on, demands that cgroups are mounted.
        (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        # --force: the folder is below one like /tmp, where others may write.
        self.serve(paths["munged"], "--foreground", "--force", f"--key-file={folder}/munge.key",
                   f"--socket={folder}/munge.socket", f"--pid-file={folder}/munged.pid",
                   f"--log-file={folder}/munged.log", f"--seed-file={folder}/munge.seed",
                   answers=(folder / "munge.socket").exists)
        self.serve(paths["slurmctld"], "-D", "-c", env=self.environment,
                   answers=lambda: self.ask("scontrol", "ping"))
        self.serve(paths["slurmd"], "-D", env=self.environment,
                   answers=lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T"))

    def submitted(self):
        """How many jobs sbatch has submitted."""
        log = (self.folder / "slurmctld.out").read_text(errors="replace")
        return log.count("_slurm_rpc_submit_batch_job: JobId=")

    def ask(self, program, *arguments):
        done = subprocess.run([self._paths[program], *arguments], capture_output=True, text=True,
                              env=self.environment)
        return done.stdout if done.returncode == 0 else ""

    def stop(self):
        if hasattr(self, "environment"):
            self.ask("scancel", "--user", getpass.getuser())
        super().stop()
