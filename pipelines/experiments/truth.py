# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the truth itself says of a sequence, and tracks against it feature by feature."""

import json
import math
import random

TAU = 5.0  # pixels, as csd-score has it at this size
CLAIMS = ("tracked", "learning")  # states of a track that has a position
LEAST = 25  # frames that a feature must be visible afterwards, to be counted


def read(path):
    """{id: (x, y, state)} of each frame."""
    with open(path) as file:
        return [{f["id"]: (f["x"], f["y"], f["state"])
                 for f in json.loads(line)["features"]}
                for line in file]


class Truth:
    """Of one video, per frame: how far features are from where they began (rms, pixels), how much farther from each other
    (factor), which share of them is hidden."""

    def __init__(self, frames):
        first = frames[0]
        self.deformation = [
            rms((x - first[i][0], y - first[i][1]) for i, (x, y, _) in f.items()) for f in frames
        ]
        self.scale = [spread(f) / spread(first) if spread(first) else 1 for f in frames]
        self.hidden = [
            sum(state == "occluded" for *_, state in f.values()) / len(f) for f in frames
        ]


def rms(vectors):
    squares = [x * x + y * y for x, y in vectors]
    return math.sqrt(sum(squares) / len(squares))


def spread(frame):
    cx, cy = (sum(p[k] for p in frame.values()) / len(frame) for k in (0, 1))
    return rms((x - cx, y - cy) for x, y, _ in frame.values())


def outcome(truth, track):
    """None where nothing is to be seen, else (found, claimed)."""
    if truth[2] != "tracked":
        return None
    claimed = track is not None and track[2] in CLAIMS
    return claimed and math.dist(truth[:2], track[:2]) <= TAU, claimed


def together(truth, tracks, others):
    """What a second tracker could give the first, as shares of what is visible or claimed: sensitivity and K of the first; its sensitivity
    where it is told each time that the other is right, and what of that it would find where it claims nothing itself; sensitivity and K
    where it is silent whenever the other is. K is None without claims."""
    visible = found = either = again = agreed = claims = agreed_claims = 0
    for frame, first, second in zip(truth, tracks, others):
        for i, at in frame.items():
            claimed, backed = (t is not None and t[2] in CLAIMS
                               for t in (first.get(i), second.get(i)))
            right, other = (o is not None and o[0]
                            for o in (outcome(at, first.get(i)), outcome(at, second.get(i))))
            visible += at[2] == "tracked"
            found += right
            either += right or other
            again += other and not claimed
            agreed += right and backed
            claims += claimed
            agreed_claims += claimed and backed
    k = 1 - found / claims if claims else None
    agreed_k = 1 - agreed / agreed_claims if agreed_claims else None
    return found / visible, k, either / visible, again / visible, agreed / visible, agreed_k


def aftermath(wet, dry, wet_tracks, dry_tracks):
    """Of each feature that something covered in the one video, and not in the same one without it: what changed after it was free
    again, as (sensitivity, share of wrong reports; None without reports), the one less the other, over the same frames."""
    changes = []
    for i in wet[0].keys() & dry[0].keys():
        covered = [
            n for n, (a, b) in enumerate(zip(wet, dry))
            if a[i][2] == "occluded" and b[i][2] != "occluded"
        ]
        if not covered:
            continue
        pairs = [(outcome(wet[n][i], wet_tracks[n].get(i)), outcome(dry[n][i],
                                                                    dry_tracks[n].get(i)))
                 for n in range(covered[-1] + 1, min(len(wet), len(dry)))]
        pairs = [p for p in pairs if None not in p]
        if len(pairs) < LEAST:
            continue
        found, wrong = [], []
        for side in zip(*pairs):
            claims = sum(claimed for _, claimed in side)
            found.append(sum(f for f, _ in side) / len(side))
            wrong.append(1 - sum(f for f, _ in side) / claims if claims else None)
        changes.append((found[0] - found[1], None if None in wrong else wrong[0] - wrong[1]))
    return changes


def fifths(frames):
    """The first and the last fifth of so many frames."""
    return range(round(0.2 * frames)), range(round(0.8 * frames), frames)


def found_in(truth, tracks, feature, frames):
    """Share of the frames with the feature visible in which it is found; None if it never is visible."""
    outcomes = [o for n in frames if (o := outcome(truth[n][feature], tracks[n].get(feature)))]
    return sum(found for found, _ in outcomes) / len(outcomes) if outcomes else None


def change(truth, tracks, before, after):
    """Of each feature that is visible in both ranges of frames: its sensitivity in the later less that in the earlier."""
    pairs = [(found_in(truth, tracks, i, before), found_in(truth, tracks, i, after))
             for i in truth[0]]
    return [b - a for a, b in pairs if None not in (a, b)]


def returns(truth, tracks, within, least):
    """Of the times that a feature was visible, was hidden together with at least this share of all (by the same thing, then), and is
    visible again: whether it was found again in the first `within` frames. Where it is hidden again sooner, unfound, nothing is said."""
    hidden = [
        sum(state == "occluded" for *_, state in frame.values()) / len(frame) for frame in truth
    ]
    back = []
    for i in truth[0]:
        # the last frame with the feature visible; whether most were hidden since then
        last, together = None, False
        for n, frame in enumerate(truth):
            if frame[i][2] != "tracked":
                together = together or (frame[i][2] == "occluded" and hidden[n] >= least)
                continue
            if last is not None and together:
                seen = [
                    outcome(truth[m][i], tracks[m].get(i))
                    for m in range(n, min(n + within, len(truth)))
                ]
                until = seen.index(None) if None in seen else len(seen)
                found = any(o[0] for o in seen[:until])
                if found or until == within:
                    back.append(found)
            last, together = n, False
    return back


def turned(before, after):
    """By how many degrees the view turned between two frames, and by which factor it grew: the similarity that fits best."""
    ids = before.keys() & after.keys()
    a, b = ([complex(*frame[i][:2]) for i in ids] for frame in (before, after))
    a, b = ([z - sum(points) / len(points) for z in points] for points in (a, b))
    factor = sum(q * p.conjugate() for p, q in zip(a, b)) / sum(abs(p) ** 2 for p in a)
    return math.degrees(math.atan2(factor.imag, factor.real)), abs(factor)


def bootstrap(values, draws=2000):
    """Mean and its 95 % interval, over values; the same for the same values. None for fewer than two."""
    if len(values) < 2:
        return None
    chance = random.Random(1)
    means = sorted(sum(chance.choices(values, k=len(values))) / len(values) for _ in range(draws))
    return sum(values) / len(values), means[round(0.025 * (draws - 1))], means[round(0.975 *
                                                                                     (draws - 1))]
