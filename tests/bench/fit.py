# SPDX-License-Identifier: LGPL-2.1-or-later
"""Fits the weights of csd's probability that a point is visible (core/csd/tuning.h), and measures
how good they are on tissue that they were not fitted on."""

import argparse
import csv
import pathlib
import re
import sys
import typing
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCE = ROOT / "core" / "csd" / "tuning.h"
TERM = re.compile(r"^  double weigh_(\w+) = (-?[\d.]+);", re.M)
RIDGE = 1.0  # penalty on a weight, in log-odds: a term without evidence stays at 0

Array = NDArray[typing.Any]


class Quality(typing.NamedTuple):
    log_loss: float
    ece: float  # over ten bins
    wrong: float  # share of the claims (p ≥ .5) that are wrong
    missed: float  # share of what is right that is not claimed


def refuse(message: str) -> typing.NoReturn:
    sys.exit(f"fit: {message}")


def read(files: Sequence[str]) -> tuple[list[str], Array, Array, Array]:
    """The names of the terms; for each judgement its tissue, whether the point was right, and the
    values of the terms."""
    names: list[str] | None = None
    tissues, right, values = [], [], []
    for file in files:
        try:
            with open(file, newline="") as lines:
                rows = csv.reader(lines)
                head: list[str] = next(rows, [])
                if head[:2] != ["tissue", "right"] or names not in (None, head[2:]):
                    refuse(f"{file} is no file of csd-accuracy --evidence, "
                           "or one of another csdtrack")
                names = head[2:]
                for row in rows:
                    tissues.append(row[0])
                    right.append(int(row[1]))
                    values.append(np.array(row[2:], np.float32))
        except OSError as error:
            refuse(f"{file}: {error.strerror}")
        except ValueError as error:
            refuse(f"{file} is damaged: {error}")
    if not names or not values:
        refuse("no evidence in the files")
    return names, np.array(tissues), np.array(right, float), np.array(values, float)


def probability(weights: Array, values: Array) -> Array:
    log_odds = np.clip(values @ weights, -30, 30)
    return typing.cast(Array, 1 / (1 + np.exp(-log_odds)))


def fit(values: Array, right: Array) -> Array:
    """Logistic regression by Newton's method."""
    weights = np.zeros(values.shape[1])
    for _ in range(50):
        p = probability(weights, values)
        gradient = values.T @ (right - p) - RIDGE * weights
        hessian = (values * (p * (1 - p))[:, None]).T @ values + RIDGE * np.eye(len(weights))
        step = np.linalg.solve(hessian, gradient)
        weights += step
        if np.abs(step).max() < 1e-6:
            break
    return weights


def quality(weights: Array, values: Array, right: Array) -> Quality:
    p = probability(weights, values)
    loss = -np.mean(np.log(np.where(right > 0, p, 1 - p)))
    bins = np.minimum((p * 10).astype(int), 9)
    ece = sum(abs(p[bins == b].sum() - right[bins == b].sum()) for b in range(10)) / len(p)
    claimed = p >= 0.5
    wrong = 1 - right[claimed].mean() if claimed.any() else 0.0
    missed = (~claimed[right > 0]).mean() if right.any() else 0.0
    return Quality(float(loss), ece, wrong, missed)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="tests/bench/fit", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog="""
FILE comes from csd-accuracy, of a build with -Dbenchmarks=enabled:

    build/tests/bench/csd-accuracy --tissue DIR --seeds 1 --frames 200 --features 80 \\
      --keep /tmp/kept --evidence FILE

Each tissue in turn is left out of the fit, which is then judged by it. The table has the weights in
the source, those fitted to all tissues, and the least and the most of the fits that leave one out.
Below it is the quality of each of them. What is right depends on the tracker, and the tracker on
the weights: put new ones in, measure and fit again, until nothing changes.""")
    parser.add_argument("files", nargs="+", metavar="FILE", help="of csd-accuracy --evidence")
    return parser.parse_args()


def main() -> None:
    names, tissues, right, values = read(parse().files)
    source = {name: float(weight) for name, weight in TERM.findall(SOURCE.read_text())}
    if list(source) != names:
        refuse(f"{SOURCE.relative_to(ROOT)} has other terms: {', '.join(source)}")
    now = np.array(list(source.values()))
    whole = fit(values, right)
    kinds = sorted(set(tissues))
    if len(kinds) < 2:
        refuse("one tissue alone: none can be left out")
    fits, judged = [], []
    for n, tissue in enumerate(kinds, 1):
        print(f"\r{n} of {len(kinds)}: {tissue:30s}", end="", file=sys.stderr, flush=True)
        out = tissues == tissue
        fits.append(fit(values[~out], right[~out]))
        judged.append((quality(fits[-1], values[out], right[out]), tissue))
    print(file=sys.stderr)
    left_out = np.array(fits)
    print(f"{len(right)} judgements on {len(kinds)} tissues, {right.mean():.4f} of them of points "
          "that are visible and within 5 px\n")
    print(f"{'term':14s} {'source':>7s} {'all':>7s} {'least':>7s} {'most':>7s}")
    for i, name in enumerate(names):
        weights = (now[i], whole[i], left_out[:, i].min(), left_out[:, i].max())
        print(f"{name:14s} " + " ".join(f"{weight:7.2f}" for weight in weights))
    print(f"\n{'weights':24s} {'log loss':>8s} {'ECE':>7s} {'wrong':>7s} {'missed':>7s}")
    mean = Quality(*np.mean([q for q, _ in judged], axis=0))
    worst, worst_tissue = max(judged)
    for what, q in (("of the source", quality(now, values, right)),
                    ("fitted to all", quality(whole, values, right)),
                    ("one tissue left out", mean), (f"worst: {worst_tissue}", worst)):
        print(f"{what:24s} {q.log_loss:8.4f} {q.ece:7.4f} {q.wrong:7.4f} {q.missed:7.4f}")


if __name__ == "__main__":
    main()
