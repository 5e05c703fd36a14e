# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures of a sequence's truth, and of tracks against the truth, feature by feature."""

from __future__ import annotations

import json
import math
import pathlib
import random
import statistics
from collections.abc import Iterable, Sequence

TAU = 5.0  # pixels, csd-score's threshold for a picture of this size
CLAIMS = ("tracked", "learning")  # states of a track that has a position
LEAST = 25  # a feature counts if it is visible for so many frames afterwards

Point = tuple[float, float, str]  # x, y, state
Frame = dict[int, Point]  # by the feature's id
Interval = tuple[float, float, float]  # mean, low and high end of its 95 % interval


def read(path: pathlib.Path) -> list[Frame]:
    """The points of each frame in a file of tracks."""
    with open(path) as file:
        return [{
            feature["id"]: (feature["x"], feature["y"], feature["state"])
            for feature in json.loads(line)["features"]
        } for line in file]


class Truth:
    """How much the tissue of one video deforms and hides, frame by frame.

    deformation: distance of the features from their first place (rms, pixels)
    scale: by which factor they are farther from each other than in the first frame
    hidden: which share of them is hidden
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        first = frames[0]
        self.deformation = [
            rms((x - first[i][0], y - first[i][1]) for i, (x, y, _) in frame.items())
            for frame in frames
        ]
        self.scale = [spread(frame) / spread(first) if spread(first) else 1 for frame in frames]
        self.hidden = [share_hidden(frame) for frame in frames]


def rms(vectors: Iterable[tuple[float, float]]) -> float:
    squares = [x * x + y * y for x, y in vectors]
    return math.sqrt(sum(squares) / len(squares))


def spread(frame: Frame) -> float:
    cx = sum(x for x, _, _ in frame.values()) / len(frame)
    cy = sum(y for _, y, _ in frame.values()) / len(frame)
    return rms((x - cx, y - cy) for x, y, _ in frame.values())


def share_hidden(frame: Frame) -> float:
    return sum(state == "occluded" for *_, state in frame.values()) / len(frame)


def claims(track: Point | None) -> bool:
    """Whether the tracker claims to know the feature's position."""
    return track is not None and track[2] in CLAIMS


def outcome(truth: Point, track: Point | None) -> tuple[bool, bool] | None:
    """Whether a visible feature is found within TAU, and whether the tracker claims it; None for a
    feature that is not visible."""
    if truth[2] != "tracked":
        return None
    if track is None or not claims(track):
        return False, False
    return math.dist(truth[:2], track[:2]) <= TAU, True


def found(truth: Point, track: Point | None) -> bool:
    result = outcome(truth, track)
    return result is not None and result[0]


def together(
    truth: Sequence[Frame], tracks: Sequence[Frame], others: Sequence[Frame]
) -> tuple[float, float | None, float, float, float, float | None]:
    """What a second tracker could give the first:

    * sensitivity and K of the first
    * its sensitivity if it were told each time that the other is right
    * which part of that gain it would find where it claims nothing itself
    * sensitivity and K if it were silent whenever the other is

    K is None without claims.
    """
    visible = correct = either = again = agreed = claimed = agreed_claims = 0
    for frame, first, second in zip(truth, tracks, others):
        for i, point in frame.items():
            own_claim, other_claim = claims(first.get(i)), claims(second.get(i))
            own, other = found(point, first.get(i)), found(point, second.get(i))
            visible += point[2] == "tracked"
            correct += own
            either += own or other
            again += other and not own_claim
            agreed += own and other_claim
            claimed += own_claim
            agreed_claims += own_claim and other_claim
    k = 1 - correct / claimed if claimed else None
    agreed_k = 1 - agreed / agreed_claims if agreed_claims else None
    return (correct / visible, k, either / visible, again / visible, agreed / visible, agreed_k)


def aftermath(wet: Sequence[Frame], dry: Sequence[Frame], wet_tracks: Sequence[Frame],
              dry_tracks: Sequence[Frame]) -> list[tuple[float, float | None]]:
    """How tracking changes after blood or water covered a feature.

    For each feature that is covered in the wet video and not in the dry one: the change of its
    sensitivity and of its share of wrong reports (None without reports). Both compare the same
    frames of the two videos, after the feature is free again.
    """
    changes: list[tuple[float, float | None]] = []
    for i in wet[0].keys() & dry[0].keys():
        covered = [
            n for n, (a, b) in enumerate(zip(wet, dry))
            if a[i][2] == "occluded" and b[i][2] != "occluded"
        ]
        if not covered:
            continue
        pairs = []
        for n in range(covered[-1] + 1, min(len(wet), len(dry))):
            after_wet = outcome(wet[n][i], wet_tracks[n].get(i))
            after_dry = outcome(dry[n][i], dry_tracks[n].get(i))
            if after_wet is not None and after_dry is not None:
                pairs.append((after_wet, after_dry))
        if len(pairs) < LEAST:
            continue
        sensitivities, wrong = [], []
        for side in zip(*pairs):
            correct = sum(right for right, _ in side)
            claimed = sum(claim for _, claim in side)
            sensitivities.append(correct / len(side))
            wrong.append(1 - correct / claimed if claimed else None)
        wet_wrong, dry_wrong = wrong
        changes.append((sensitivities[0] - sensitivities[1],
                        None if wet_wrong is None or dry_wrong is None else wet_wrong - dry_wrong))
    return changes


def fifths(frames: int) -> tuple[range, range]:
    """The first and the last fifth of so many frames."""
    return range(round(0.2 * frames)), range(round(0.8 * frames), frames)


def found_in(truth: Sequence[Frame], tracks: Sequence[Frame], feature: int,
             frames: range) -> float | None:
    """In which share of these frames a feature is found while visible; None if it never is
    visible."""
    outcomes = [
        result for n in frames
        if (result := outcome(truth[n][feature], tracks[n].get(feature))) is not None
    ]
    return sum(right for right, _ in outcomes) / len(outcomes) if outcomes else None


def change(truth: Sequence[Frame], tracks: Sequence[Frame], before: range,
           after: range) -> list[float]:
    """The change of sensitivity from one range of frames to a later one, of each feature that is
    visible in both."""
    pairs = [(found_in(truth, tracks, i, before), found_in(truth, tracks, i, after))
             for i in truth[0]]
    return [late - early for early, late in pairs if early is not None and late is not None]


def returns(truth: Sequence[Frame], tracks: Sequence[Frame], within: int,
            least: float) -> list[bool]:
    """Each time a hidden feature is visible again: is it found in the first `within` frames?

    Only where at least the share `least` of all features was hidden with it, hence by the same
    thing. A feature that is hidden again too soon, before it is found, does not count.
    """
    hidden = [share_hidden(frame) for frame in truth]
    back = []
    for i in truth[0]:
        was_visible = False
        hidden_together = False  # since the feature was visible last
        for n, frame in enumerate(truth):
            if frame[i][2] != "tracked":
                hidden_together |= frame[i][2] == "occluded" and hidden[n] >= least
                continue
            if was_visible and hidden_together:
                seen = [
                    outcome(truth[m][i], tracks[m].get(i))
                    for m in range(n, min(n + within, len(truth)))
                ]
                until = seen.index(None) if None in seen else len(seen)
                is_found = any(result[0] for result in seen[:until] if result)
                if is_found or until == within:
                    back.append(is_found)
            was_visible, hidden_together = True, False
    return back


def turned(before: Frame, after: Frame) -> tuple[float, float]:
    """By how many degrees the view turned between two frames, and by which factor it grew.

    Both are of the similarity transform that fits best.
    """
    def centred(frame: Frame) -> list[complex]:
        points = [complex(*frame[i][:2]) for i in sorted(before.keys() & after.keys())]
        middle = sum(points) / len(points)
        return [point - middle for point in points]

    a, b = centred(before), centred(after)
    factor = sum(q * p.conjugate() for p, q in zip(a, b)) / sum(abs(p) ** 2 for p in a)
    return math.degrees(math.atan2(factor.imag, factor.real)), abs(factor)


def bootstrap(values: Sequence[float], draws: int = 2000) -> Interval | None:
    """The mean of the values and its 95 % interval; None for fewer than two.

    Always the same for the same values.
    """
    if len(values) < 2:
        return None
    chance = random.Random(1)
    means = sorted(statistics.fmean(chance.choices(values, k=len(values))) for _ in range(draws))
    return (statistics.fmean(values), means[round(0.025 * (draws - 1))],
            means[round(0.975 * (draws - 1))])
