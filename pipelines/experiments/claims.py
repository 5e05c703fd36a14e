# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the paper says of the five trackers, each sentence as a test of the numbers that were found here."""

import dataclasses

import figures

BASELINES = ("lk", "ms1", "ms2", "sift")
ALL = ("csd-2012", *BASELINES)


@dataclasses.dataclass(frozen=True)
class Claim:
    where: str  # in the paper
    says: str
    holds: bool | None  # None: nothing happened that could show it
    evidence: str  # in words, with numbers


def known(value, otherwise):
    return otherwise if value is None else value


def of_scores(where, scores):
    """What it says of each of its tables, and of the simulation."""
    s = {t: known(scores.value(t, "sensitivity"), 0) for t in ALL}
    k = {t: known(scores.value(t, "k"), 1) for t in ALL}
    in_words = ", ".join(f"{t} {s[t]:.3f}" for t in ALL), ", ".join(f"{t} {k[t]:.3f}" for t in ALL)
    return [
        Claim(where, "CSD has the highest sensitivity", all(s["csd-2012"] > s[t] for t in BASELINES), in_words[0]),
        Claim(where, "both mean shifts have lower sensitivity than the others",
              max(s["ms1"], s["ms2"]) < min(s["lk"], s["sift"], s["csd-2012"]), in_words[0]),
        Claim(where, "SIFT has the lowest K, CSD the next", sorted(ALL, key=k.get)[:2] == ["sift", "csd-2012"], in_words[1]),
    ]


def of_simulation(plan, found):
    sequence, scores = plan.sequence("simulation"), found.simulation
    first, last = (scores.part(sequence, "lk", "sensitivity_by_frame", *part) for part in ((0, 0.2), (0.8, 1)))
    return [Claim("§3.1", "LK begins well and degrades: its sensitivity in the last fifth is lower by a tenth or more",
                  first - last >= 0.1, f"first fifth {first:.3f}, last {last:.3f}")]


def of_sequences(plan, found):
    occlusion, third = found.tables["table2"], found.tables["table3"]
    smoke, irrigation = plan.sequence("smoke"), plan.sequence("irrigation")
    recovery = {t: occlusion.trackers[t]["recovery"] for t in ALL}
    rate = {t: r["recovered"] / r["returns"] if r["returns"] else 0 for t, r in recovery.items()}
    thick = min(known(v, 1) for _, v in figures.binned(third.by_frame(smoke, "sift", "sensitivity_by_frame")))
    sensitivity = [occlusion.part(irrigation, "csd-2012", "sensitivity_by_frame", *part) for part in ((0, 0.2), (0.8, 1))]
    k = [occlusion.part(irrigation, "csd-2012", "k_by_frame", *part) for part in ((0, 0.2), (0.8, 1))]
    return [
        Claim("§3.2.2", "SIFT and CSD find features again after occlusion more often than LK and mean shift",
              min(rate["sift"], rate["csd-2012"]) > max(rate["lk"], rate["ms1"], rate["ms2"]) if any(rate.values()) else None,
              ", ".join(f"{t} {r['recovered']} of {r['returns']}" for t, r in recovery.items())),
        Claim("§3.2.2", "CSD loses sensitivity, and its K rises, where blood is washed away",
              sensitivity[1] < sensitivity[0] and known(k[1], 0) > known(k[0], 0),
              f"first fifth {sensitivity[0]:.3f} / {known(k[0], 0):.3f}, last {sensitivity[1]:.3f} / {known(k[1], 0):.3f}"),
        Claim("§3.2.4", "SIFT's sensitivity drops to zero in smoke (below .05)", thick < 0.05,
              f"least mean over {figures.BIN} frames {thick:.3f}"),
    ]


def of_cost(found, paper):
    total = {search: sum(row[0] for row in rows) for search, rows in found.cost.items()}
    ratio = total["exhaustive"] / total["ranked"]
    rare = paper["retraining_is_rare_after_frames"]
    first, later = (figures.mean([row[1] for row in rows]) for rows in (found.cost["ranked"][:rare], found.cost["ranked"][rare:]))
    claims = [Claim("§3.3", f"ranked search is about {paper['exhaustive_over_ranked']} times faster (5 to 20 times)", 5 <= ratio <= 20,
                    f"{ratio:.1f} times")]
    if later is not None:
        claims.append(Claim("§3.3", f"after {rare} frames trees are rarely retrained (less than a fifth as often)",
                            later < first / 5, f"leaves a feature and frame: {first:.2f}, then {later:.2f}"))
    return claims


def check(plan, found, paper):
    claims = of_scores("§3.1", found.simulation) + of_simulation(plan, found)
    for name, scores in found.tables.items():
        claims += of_scores(f"Table {name[-1]}", scores)
    return claims + of_sequences(plan, found) + of_cost(found, paper["section3.3"])
