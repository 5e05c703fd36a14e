# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands that write docs/results/ have in common: their options, the runs, what they say when something fails."""

import argparse
import os
import pathlib
import signal
import sys

import builds
import page
import running
import sequences


def natural(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return value


def arguments(name, description, epilog, seeds):
    parser = argparse.ArgumentParser(prog=f"pipelines/experiments/{name}", epilog=epilog,
                                     description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true",
                        help="a few frames of each; writes nothing into docs/")
    parser.add_argument(
        "--seeds", type=natural, metavar="N", help="scenes of each sequence, from seed "
        f"{sequences.FIRST_SEED} on ({seeds}; --quick: 1)")
    parser.add_argument("--jobs", type=natural, metavar="N", default=os.cpu_count(),
                        help="runs at a time (the processors)")
    parser.add_argument("--out", type=pathlib.Path, metavar="DIR", help="where the runs are kept "
                        f"(experiments/{name} or experiments/{name}-quick in the build folder)")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")
    return parser.parse_args()


def places(name, options):
    """What this run is called, the folder of its results, the page that it writes."""
    mode = f"{name}-quick" if options.quick else name
    out = (options.out or builds.BUILD / "experiments" / mode).resolve()
    return mode, out, (out if options.quick else page.RESULTS) / f"{name}.md"


def guarded(name, out, work):
    """The exit code of a command that keeps its results in `out`. Prints the page that work() has written, or what went wrong."""
    try:
        print(work())
    except builds.Failure as failure:
        print(f"{name}: {failure}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{name}: {error.filename or out}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"\n{name}: stopped; the same command goes on from here", file=sys.stderr)
        return 130
    return 0


def run(name, options, write, seeds):
    """The runs, then write(plan, out, path, command, jobs) writes the page."""
    mode, out, path = places(name, options)
    seeds = options.seeds or (1 if options.quick else seeds)

    def work():
        builds.make(not options.no_install)
        out.mkdir(parents=True, exist_ok=True)
        plan = sequences.PLANS[mode](seeds)
        if plan.of_table("pictures"):
            running.take_pictures()
        running.run_all(plan, mode, seeds, out, options.jobs)
        command = " ".join([
            f"pipelines/experiments/{name}",
            *filter(None, ("--quick" if options.quick else "",
                           f"--seeds {options.seeds}" if options.seeds else ""))
        ])
        write(plan, out, path, command, options.jobs)
        return path
    return guarded(name, out, work)


def main(name, description, epilog, write, seeds=3):
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))
    sys.exit(run(name, arguments(name, description, epilog, seeds), write, seeds))
