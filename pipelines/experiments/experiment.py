# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands that write docs/results/ share: options, the runs, and how they end."""

import argparse
import os
import pathlib
import signal
import sys
import typing
from collections.abc import Callable

from pipelines.experiments import builds, page, running, sequences
from pipelines.lib.failure import Failure

# Writes the page of a plan: (plan, folder of the runs, path, command, jobs).
Write = Callable[[sequences.Plan, pathlib.Path, pathlib.Path, str, int], None]


def natural(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return value


def add_runs(parser: argparse.ArgumentParser, name: str) -> None:
    """The options of how to make the runs, which are kept in the folder `name`."""
    parser.add_argument("--jobs", type=natural, metavar="N", default=os.cpu_count(),
                        help="runs at a time (one for each processor)")
    parser.add_argument("--out", type=pathlib.Path, metavar="DIR",
                        help="where the runs are kept "
                        f"(experiments/{name} or experiments/{name}-quick in the build folder)")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")


def arguments(name: str, description: str, epilog: str, seeds: int) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog=f"pipelines/experiments/{name}", epilog=epilog,
                                     description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true",
                        help="a few frames of each; writes nothing into docs/")
    parser.add_argument("--seeds", type=natural, metavar="N",
                        help="scenes of each sequence, from seed "
                        f"{sequences.FIRST_SEED} on ({seeds}; --quick: 1)")
    add_runs(parser, name)
    return parser.parse_args()


def places(name: str, options: argparse.Namespace) -> tuple[str, pathlib.Path, pathlib.Path]:
    """The name of this experiment, the folder of its results, and the page that it writes."""
    mode = f"{name}-quick" if options.quick else name
    out = (options.out or builds.BUILD / "experiments" / mode).resolve()
    return mode, out, (out if options.quick else page.RESULTS) / f"{name}.md"


def exit_code(name: str, out: pathlib.Path, write: Callable[[], pathlib.Path]) -> int:
    """Calls write(), prints the path that it returns or what went wrong, and gives the command's
    exit code. `out` is the folder of the results."""
    try:
        print(write())
    except Failure as failure:
        print(f"{name}: {failure}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{name}: {error.filename or out}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"\n{name}: stopped; the same command goes on from here", file=sys.stderr)
        return 130
    return 0


def run(name: str, options: argparse.Namespace, write: Write, seeds: int) -> int:
    """Makes the runs that are missing, then writes the page. Returns the exit code."""
    mode, out, path = places(name, options)
    seeds = options.seeds or (1 if options.quick else seeds)

    def run_and_write() -> pathlib.Path:
        builds.make(not options.no_install)
        out.mkdir(parents=True, exist_ok=True)
        plan = sequences.PLANS[mode](seeds)
        if plan.of_table("pictures"):
            running.take_pictures()
        missing = sequences.missing_pictures() if plan.of_table("table1") else []
        if missing:
            print(f"{name}: all tissue is simulated, for these pictures of real tissue are missing "
                  f"(CSDTRACK_TISSUE names their folder): {', '.join(map(str, missing))}",
                  file=sys.stderr)
        running.run_all(plan, mode, seeds, out, options.jobs)
        command = [f"pipelines/experiments/{name}"]
        if options.quick:
            command.append("--quick")
        if options.seeds:
            command.append(f"--seeds {options.seeds}")
        write(plan, out, path, " ".join(command), options.jobs)
        return path

    return exit_code(name, out, run_and_write)


def main(name: str, description: str, epilog: str, write: Write,
         seeds: int = 3) -> typing.NoReturn:
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
    sys.exit(run(name, arguments(name, description, epilog, seeds), write, seeds))
