# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes what README and pages of docs/ repeat of docs/results/."""

import argparse
import sys

from pipelines.experiments import summaries
from pipelines.lib.failure import Failure


def main() -> None:
    argparse.ArgumentParser(
        prog="pipelines/experiments/summary", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter, epilog="""
Everything between the marks in these pages, and their plots, comes from the tables of
docs/results/. Run it after any command that writes there. Needs gnuplot.
Exit code: 0 if all is written, 1 if a page lacks something (it says what), 2 for wrong use.
""").parse_args()
    try:
        for path in summaries.write():
            print(path)
    except Failure as failure:
        sys.exit(f"summary: {failure}")
    except OSError as error:
        sys.exit(f"summary: {error.filename}: {error.strerror}")


if __name__ == "__main__":
    main()
