#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/csdtrack-record.service: pipelines/record under a supervisor that acts like systemd.

service_test.py REPOSITORY BUILD"""

import configparser
import contextlib
import os
import pathlib
import shlex
import shutil
import signal
import socket
import subprocess
import sys

import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
UNIT = SOURCE / "docs" / "csdtrack-record.service"


class Supervisor:
    """Receives the notifications of a service, as systemd would. `watchdog` is in µs."""

    def __init__(self, test, watchdog):
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        test.addCleanup(self._socket.close)
        self._socket.bind(str(test.tmp / f"{test.id()}.socket"))
        self.environment = {**os.environ, "CSDTRACK_BUILD": str(BUILD),
                            "NOTIFY_SOCKET": self._socket.getsockname(),
                            "WATCHDOG_USEC": str(watchdog)}

    def notification(self, seconds=harness.TIMEOUT):
        """The next notification, or None after so many seconds without one."""
        self._socket.settimeout(seconds)
        with contextlib.suppress(TimeoutError):
            return self._socket.recv(1000).decode()


class Service(harness.Case):
    def unit(self):
        unit = configparser.ConfigParser()
        unit.optionxform = str
        unit.read(UNIT)
        return unit["Service"]

    def test_systemd_accepts_the_unit(self):
        if not shutil.which("systemd-analyze"):
            self.skipTest("no systemd-analyze here")
        copy = self.tmp / UNIT.name
        program = shlex.split(self.unit()["ExecStart"])[0]
        copy.write_text(UNIT.read_text().replace(program, str(SOURCE / "pipelines" / "record")))
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", copy], capture_output=True,
                              text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_restarts_lose_no_recording(self):
        unit, out = self.unit(), self.tmp / "recordings"
        program, *options, source, folder = shlex.split(unit["ExecStart"])
        self.assertEqual((pathlib.Path(program).name, source[:5], folder[:1]),
                         ("record", "/dev/", "/"))
        supervisor = Supervisor(self, 300_000)
        before = {}
        # The second run is killed; its files must stay too.
        for life, end in enumerate((getattr(signal, unit["KillSignal"]), signal.SIGKILL,
                                    getattr(signal, unit["WatchdogSignal"]))):
            process = subprocess.Popen([SOURCE / "pipelines" / "record", *options, "simulate", out],
                                       env=supervisor.environment, stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, text=True)
            self.addCleanup(process.stdout.close)
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
            for sign in ["READY=1"] + ["WATCHDOG=1"] * 11:
                self.assertEqual(supervisor.notification(), sign)
            process.send_signal(end)
            said = process.stdout.read()
            self.assertEqual(process.wait(60), -end if end == signal.SIGKILL else 0, said)
            while supervisor.notification(0.01):
                pass  # sent while it ended
            after = {path.name: path.read_bytes() for path in out.iterdir()
                     if not path.name.startswith(".")}
            self.assertEqual({name: after.get(name) for name in before}, before,
                             "earlier files have changed")
            self.assertEqual(sorted(after.keys() - before.keys()),
                             [f"{life:05}.jsonl", f"{life:05}.mkv"])
            before = after
            lines = harness.read_lines(out / f"{life:05}.jsonl", torn=end == signal.SIGKILL)
            harness.check_tracks(self, lines)
            frames = harness.decoded_frames(out / f"{life:05}.mkv") if end != signal.SIGKILL else 0
            if frames:
                self.assertRegex(said, rf"^{len(lines)}( of {frames})? frames")
                self.assertGreaterEqual(frames, len(lines))
            self.assertTrue(lines)

    def test_the_watchdog_is_not_fed_without_frames(self):
        supervisor = Supervisor(self, 300_000)
        program = """
import signal
from pipelines.lib import runner
run = runner.Run("test", "videotestsrc is-live=true ! video/x-raw,width=160,height=120 ! "
                 "valve name=valve drop-mode=forward-sticky-events ! "
                 "csdtrack name=csdtrack ! fakesink")

def set_drop(drop):
    run.element("valve").set_property("drop", drop)
    return True

for number, drop in (signal.SIGUSR1, True), (signal.SIGUSR2, False):
    runner.GLib.unix_signal_add(runner.GLib.PRIORITY_HIGH, number, set_drop, drop)
run.play("test")
"""
        process = subprocess.Popen([sys.executable, "-c", program], cwd=SOURCE,
                                   env=supervisor.environment)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertEqual([supervisor.notification() for _ in range(3)],
                         ["READY=1", "WATCHDOG=1", "WATCHDOG=1"])
        process.send_signal(signal.SIGUSR1)
        for _ in range(20):  # some may be on their way
            if not supervisor.notification(1):
                break
        else:
            self.fail("it feeds the watchdog while no frame comes")
        process.send_signal(signal.SIGUSR2)
        self.assertEqual(supervisor.notification(), "WATCHDOG=1")

    def test_the_watchdog_is_fed_while_the_last_file_is_read_back(self):
        """And a second signal ends that."""
        supervisor, out = Supervisor(self, 300_000), self.tmp / "standing"
        program = """
import os
from pipelines.lib import command, record, recorded
end = recorded.Recorded.end_file

def stand_still(self, name):
    os.unlink(name)
    os.mkfifo(name)  # its reader waits for a writer
    end(self, name)

recorded.Recorded.end_file = stand_still
command.run("record", record.main)
"""
        process = subprocess.Popen([sys.executable, "-c", program, "--preset", "", "simulate", out],
                                   cwd=SOURCE, env=supervisor.environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.assertEqual(supervisor.notification(), "READY=1")
        process.terminate()
        video = out / "00000.mkv"
        while process.poll() is None and not video.is_fifo():
            supervisor.notification(0.01)
        for _ in range(5):  # the first may have been sent before
            self.assertEqual(supervisor.notification(5), "WATCHDOG=1")
        process.terminate()
        _, said = process.communicate(timeout=60)
        self.assertEqual((process.returncode, said),
                         (1, f"record: '{video}' could not be read back: it was interrupted\n"))


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
