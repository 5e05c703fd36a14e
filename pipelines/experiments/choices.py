# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures each choice that the paper leaves open, in csd-2012: see --help."""

import argparse
import json
import pathlib
import re
import sys
import threading
import typing
from collections.abc import Iterable, Mapping, Sequence

from pipelines.experiments import builds, figures, page, truth
from pipelines.experiments.experiment import add_runs, exit_code, natural, places
from pipelines.experiments.tissue import accuracy, check, measure_all
from pipelines.lib.failure import Failure

PLAN = json.loads(pathlib.Path(__file__).with_name("choices.json").read_text())
CHOICES = builds.ROOT / "core" / "csd2012" / "choices.h"
FIRST_SEED, FRAMES, FEATURES = 101, 200, 25
QUICK_FRAMES, QUICK_FEATURES = 22, 4  # the descriptors take over after 13 frames
# The classes of the paper's Tables 1 to 3, as scenes of csd-accuracy: those of simulated tissue,
# and those that are combined with pictures of real tissue.
CLASSES = {
    "deformation": (("deformation-heart", "deformation-liver"), ("beat",)),
    "occlusion": (("tools-heart", "tools-liver"), ("tools",)),
    "zoom, rotation, smoke": (("zoom-heart", "rotation", "smoke"), ("zoom", "turn")),
}
SCENE = re.compile(r"^(\S+) +\d+ +\S+ +(\S+) +(\S+)", re.M)  # name, sensitivity, K
DRAWS = 10000

Row = Mapping[str, typing.Any]  # of choices.json
Scene = tuple[str, int]  # with its seed
Found = dict[Scene, tuple[float, float]]  # sensitivity, K
Classes = dict[str, tuple[list[str], list[str]]]  # simulated and real scenes by class

EPILOG = f"""
The table has a row for each reading of the paper and for each choice alone (choices.json). It has
sensitivity and K on simulated tissue, and on pictures of real tissue as textures, compressed by
H.264, {FRAMES} frames and {FEATURES} features each; and how much better or worse than the reading
it is, scene by scene, with a 95 % interval. Writes docs/results/choices.md.

With four pictures each row takes two minutes a seed on two cores. After an interruption the same
command goes on: results and rendered scenes (half a megabyte a frame) are kept in DIR, unless they
are of another build.
"""


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/experiments/choices", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs csd-2012 with each choice that the paper leaves open.", epilog=EPILOG)
    parser.add_argument("--tissue", type=pathlib.Path, metavar="DIR", required=True,
                        help="a folder of pictures of real tissue")
    parser.add_argument("--pictures", type=natural, default=4, metavar="N",
                        help="how many of them to take, evenly spread over their names (4)")
    parser.add_argument("--seeds", type=natural, default=2, metavar="N",
                        help=f"scenes of each kind, from seed {FIRST_SEED} on (2; --quick: 1)")
    parser.add_argument("--quick", action="store_true",
                        help=f"{QUICK_FRAMES} frames and {QUICK_FEATURES} features of one picture "
                        "in three scenes, no simulated tissue; writes nothing into docs/")
    add_runs(parser, "choices")
    return parser.parse_args()


def check_plan() -> None:
    """Raises Failure unless each name in choices.json is a choice's."""
    known = set(re.findall(r"^  double (\w+) =", CHOICES.read_text(), re.M))
    for numbers in (*PLAN["readings"].values(), *(row.get("set", {}) for row in PLAN["rows"])):
        for name in numbers:
            if name not in known:
                raise Failure(
                    f"choices.json: {CHOICES.relative_to(builds.ROOT)} has no number {name}")


def scenes(options: argparse.Namespace) -> tuple[list[str], Classes]:
    """The names of the pictures, and the scenes of each class."""
    on_pictures = accuracy("--tissue", options.tissue, "--list").split()
    names = sorted({scene.split("/")[1] for scene in on_pictures})
    wanted = 1 if options.quick else min(options.pictures, len(names))
    names = [names[i * len(names) // wanted] for i in range(wanted)]
    classes = {}
    for title, (simulated, kinds) in CLASSES.items():
        if options.quick:
            simulated, kinds = (), kinds[:1]
        classes[title] = (list(simulated), [f"{kind}/{name}" for kind in kinds for name in names])
    return names, classes


def size(options: argparse.Namespace) -> tuple[int, int]:
    """Frames and features of each scene."""
    return (QUICK_FRAMES, QUICK_FEATURES) if options.quick else (FRAMES, FEATURES)


def arguments(row: Row) -> list[str]:
    """csd-accuracy's options for a row."""
    numbers = {**PLAN["readings"].get(row.get("of"), {}), **row.get("set", {})}
    settings = [word for name, value in numbers.items() for word in ("--set", f"{name}={value:g}")]
    return ["--algorithm", row.get("algorithm", "csd-2012"), *settings]


def measure(options: argparse.Namespace, out: pathlib.Path, scenes_of: Classes) -> list[Found]:
    """Sensitivity and K of each row in each scene; those that this very program measured before are
    kept."""
    scores = out / "results.json"
    known = json.loads(scores.read_text()) if scores.exists() else {}
    program = builds.fingerprint("csd-accuracy")
    frames, features = size(options)
    checksums = {
        file.stem: builds.checksum(file) for file in options.tissue.iterdir() if file.is_file()
    }
    seeds = range(FIRST_SEED, FIRST_SEED + (1 if options.quick else options.seeds))
    wanted = [(scene, seed) for both in scenes_of.values() for some in both for scene in some
              for seed in seeds]
    # The first run of a scene renders it into a file, for all others.
    rendering = {scene: threading.Lock() for scene in wanted}

    def measure_scene(work: tuple[Row, Scene]) -> tuple[Scene, tuple[float, float]]:
        row, (scene, seed) = work
        texture = checksums[scene.split("/")[1]] if "/" in scene else ""
        key = " ".join([
            program, texture, f"seed {seed} frames {frames} features {features}", scene,
            *arguments(row)
        ])
        if key not in known:
            folder = ["--tissue", options.tissue] if "/" in scene else []
            with rendering[scene, seed]:
                text = accuracy(*arguments(row), *folder, "--clips", "", "--seeds", seed,
                                "--frames", frames, "--features", features, "--keep", out, scene)
            known[key] = next((float(found[2]), float(found[3]))
                              for found in SCENE.finditer(text) if found[1] == scene)
        return (scene, seed), known[key]

    work = [(row, scene) for row in PLAN["rows"] for scene in wanted]

    def say(done: int, found: tuple[Scene, tuple[float, float]]) -> None:
        (scene, seed), (sensitivity, k) = found
        print(f"{done} of {len(work)}: {work[done - 1][0]['title']}, {scene}, seed {seed}: "
              f"{sensitivity:.3f} / {k:.3f}", file=sys.stderr)

    found = measure_all(work, measure_scene, known, scores, options.jobs, say)
    return [dict(found[i:i + len(wanted)]) for i in range(0, len(found), len(wanted))]


def difference(found: Found, base: Found) -> str:
    """Of sensitivity − K, scene by scene, with its interval."""
    changes = [(found[scene][0] - found[scene][1]) - (base[scene][0] - base[scene][1])
               for scene in base]
    interval = truth.bootstrap(changes, DRAWS)
    assert interval, "there are two scenes and more"
    middle, low, high = interval
    return page.minus(f"{middle:+.3f} [{low:+.3f}, {high:+.3f}]")


def base_of(row: Row, rows: Sequence[Row], results: Sequence[Found]) -> Found:
    """The results that a row is compared with: for a row that changes numbers, those of its reading
    or algorithm unchanged; for the others, those of the first row."""
    def family(of_row: Row) -> tuple[str | None, str | None]:
        return of_row.get("of"), of_row.get("algorithm")

    for other, found in zip(rows, results):
        if "set" in row and "set" not in other and family(other) == family(row):
            return found
    return results[0]


def seeds_in_words(found: Iterable[Scene]) -> str:
    seeds = sorted({seed for _, seed in found})
    return f"seed{'s' if len(seeds) > 1 else ''} {', '.join(map(str, seeds))}"


def table(scenes_of: Classes, results: Sequence[Found]) -> str:
    rows = []
    for row, found in zip(PLAN["rows"], results):
        cells = [row["title"]]
        for both in scenes_of.values():
            for some in filter(None, both):
                of_class = [value for (scene, _), value in found.items() if scene in some]
                cells.append(" / ".join(f"{figures.mean(values):.3f}" for values in zip(*of_class)))
        is_first = found is results[0]
        cells.append("" if is_first else difference(found, base_of(row, PLAN["rows"], results)))
        rows.append(cells)
    header = [
        f"{title}, {tissue}" for title, both in scenes_of.items()
        for tissue, some in zip(("simulated", "real"), both) if some
    ]
    return page.table(["", *header, "against"], rows)


def about(names: Sequence[str], results: Sequence[Found], frames: int, features: int) -> str:
    return f"""The first row is the literal reading of the paper, which takes each sentence exactly
as it stands. Then come each choice of [choices.h](../core/csd2012/choices.h) alone; `csd-2012`,
which is the best combination, with some of its choices reversed; `csd-forest`, the paper's future
work; and two others to compare with. Sensitivity / K at 5 px, {frames} frames, {features} features,
{seeds_in_words(results[0])}. The last column compares sensitivity − K, scene by scene, with the
reading that the row changes (a row without a change: with the first row), with a 95 % interval over
the scenes. *Real*: pictures of real tissue as textures, compressed as recorders do:
{", ".join(names)}. The folder holds pictures of operations, which are not part of this repository.
The choices were made on seed 1 with other pictures (heart, colon-a, peritoneum). The intervals take
scenes as independent, though several share a picture."""


def main() -> int:
    options = parse()
    _, out, path = places("choices", options)

    def write() -> pathlib.Path:
        check_plan()
        check([options.tissue])
        builds.make(not options.no_install, ("csd-accuracy",), commands=("ffmpeg",))
        out.mkdir(parents=True, exist_ok=True)
        names, scenes_of = scenes(options)
        results = measure(options, out, scenes_of)
        length = "--quick" if options.quick else f"--seeds {options.seeds}"
        command = (f"pipelines/experiments/choices --tissue {options.tissue.name} {length} "
                   f"--pictures {len(names)}")
        page.write(path, "What the paper leaves open", about(names, results, *size(options)),
                   command, builds.versions(), table(scenes_of, results))
        return path

    return exit_code("choices", out, write)


if __name__ == "__main__":
    sys.exit(main())
