# SPDX-License-Identifier: LGPL-2.1-or-later
"""The plans of the experiments: which simulated sequences are rendered, and who tracks them."""

from __future__ import annotations

import dataclasses
import os
import pathlib
from collections.abc import Callable

from pipelines.experiments import builds

WIDTH, HEIGHT, RATE = 640, 480, 25
FIRST_SEED = 101  # 1 to 20 are for development: constants may have been chosen on them

# The trackers. csdtrack has those of PLUGIN as values of its property algorithm, csd-peers the
# others.
PAPER = ("csd-2012", "lk", "ms1", "ms2", "sift")  # those that the paper compares
PLUGIN = ("csd", "csd-forest", *PAPER)
RIVALS = ("lk-fb", "lk-anchored", "still")
# These run on a part of the features and frames: csrt takes 12 ms for each feature in a frame.
SLOW_RIVALS = ("csrt", "kcf", "medianflow")
REPEATED = (*PAPER, "csd-forest", "csd")  # the paper's five, its future work, and the project's own
PAPER_ORDER = ("lk", "ms1", "ms2", "sift", "csd-2012")  # the columns of the paper's tables

CLIPS = pathlib.Path(os.environ.get("CSDTRACK_CLIPS", builds.ROOT.parent / "shared" / "clips"))
PICTURES = builds.BUILD / "experiments" / "pictures"  # first frames of clips
TISSUE = pathlib.Path(
    os.environ.get("CSDTRACK_TISSUE", builds.ROOT.parent / "shared" / "tissue" / "textures"))
# Compression as in recorders. identity keeps the decoder's padding away from y4menc, whose
# version 1.22 writes the padding into the file.
CODEC = ("x264enc pass=qual quantizer=23 ! video/x-h264,profile=high ! h264parse ! avdec_h264 ! "
         "identity drop-allocation=true ! video/x-raw,format=I420")


@dataclasses.dataclass(frozen=True)
class Sequence:
    """A kind of simulated sequence. With a seed it is one video."""

    name: str
    title: str
    figure: str  # the paper's figure, with its panels
    table: str  # "table1" to "table3", or another group; "": in a figure only
    scenario: str
    effects: str  # change the scenario's
    style: str
    features: int
    frames: int
    seeds: tuple[int, ...]
    rate: int = RATE
    # Pictures of real tissue, which are not in the repository. Seeds take them in turn; None among
    # them stands for the style.
    textures: tuple[str | None, ...] = ()
    trackers: tuple[str, ...] = ()  # (): all that the plan has for it

    def texture(self, seed: int) -> str | None:
        """The picture of real tissue on this scene's surface; None: its style is drawn instead.

        A video of real tissue is compressed as recorders do.
        """
        return self.textures[(seed - FIRST_SEED) % len(self.textures)] if self.textures else None

    def source(self, seed: int) -> str:
        """csdsimsrc and its caps, as gst-launch-1.0 takes them.

        I420, as decoders give it: every tracker sees the same bytes.
        """
        effects = f' effects="{self.effects}"' if self.effects else ""
        picture = self.texture(seed)
        texture = f'texture="{picture}"' if picture else f"style={self.style}"
        return (f"csdsimsrc scenario={self.scenario}{effects} {texture} seed={seed} "
                f"features={self.features} num-buffers={self.frames} ! "
                f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate={self.rate}/1"
                f"{f' ! {CODEC}' if picture else ''}")


@dataclasses.dataclass(frozen=True)
class Share:
    """A group of trackers that runs on a part of each sequence.

    truth-NAME.jsonl is the truth of that part. 0 stands for all features and all frames.
    """

    name: str
    trackers: tuple[str, ...]
    features: int = 0
    frames: int = 0
    first_seed: bool = False  # only the first seed of each sequence
    cost: float = 1  # of a feature in a frame, roughly, relative to the other shares

    def has(self, sequence: Sequence, seed: int) -> bool:
        return not self.first_seed or seed == sequence.seeds[0]

    def of(self, sequence: Sequence) -> tuple[int, int]:
        """How many features and frames of the sequence it runs on."""
        return (min(self.features or sequence.features, sequence.features),
                min(self.frames or sequence.frames, sequence.frames))


@dataclasses.dataclass(frozen=True)
class Plan:
    """Everything that an experiment runs."""

    sequences: tuple[Sequence, ...]
    shares: tuple[Share, ...]
    published: bool
    cost_features: int = 0  # in the measurement of the paper's Fig. 11
    cost_frames: int = 0
    palindrome_frames: int = 0

    def runs(self) -> list[tuple[Sequence, int]]:
        """Each sequence with each seed, the longest first, so that no core idles at the end."""
        return sorted(((sequence, seed) for sequence in self.sequences for seed in sequence.seeds),
                      key=lambda run: -self.cost(*run))

    def cost(self, sequence: Sequence, seed: int) -> float:
        return sum(share.cost * features * frames for share in self.shares_of(sequence, seed)
                   for features, frames in [share.of(sequence)])

    def shares_of(self, sequence: Sequence, seed: int) -> list[Share]:
        """The shares of a run, each with the trackers that run on this sequence."""
        shares = []
        for share in self.shares:
            trackers = tuple(tracker for tracker in share.trackers
                             if tracker in (sequence.trackers or share.trackers))
            if trackers and share.has(sequence, seed):
                cost = share.cost * len(trackers) / len(share.trackers)
                shares.append(dataclasses.replace(share, trackers=trackers, cost=cost))
        return shares

    def share(self, name: str) -> Share:
        return next(share for share in self.shares if share.name == name)

    def sequence(self, name: str) -> Sequence:
        return next(sequence for sequence in self.sequences if sequence.name == name)

    def of_table(self, table: str) -> list[Sequence]:
        return [sequence for sequence in self.sequences if sequence.table == table]

    def of_tables(self) -> list[Sequence]:
        """The sequences of the paper's Tables 1 to 3."""
        return [sequence for sequence in self.sequences if sequence.table.startswith("table")]


# name, title, figure, table, scenario, effects, style; then the textures by seed in turn: a picture
# in TISSUE, or None for the style.
Kind = tuple[str, str, str, str, str, str, str, tuple[str | None, ...]]
# The paper describes its sequences in §3.1 and §3.2. The light and noise of the simulation make LK
# drift, as it does in the paper's: without them LK loses nothing in 4000 frames.
KINDS: tuple[Kind, ...] = (
    ("simulation", "simulation", "7", "", "deformation", "noise=2,light=0.5", "heart",
     ("heart.png",)),
    ("strong-heart", "strongly beating heart", "8a–c", "table1", "deformation",
     "heart-mild=0,heart-strong=1,specular=0.5,light=0.5", "heart", (None, "heart.png")),
    ("mild-heart", "mildly beating heart", "8d–f", "table1", "deformation",
     "specular=0.5,light=0.5", "heart", (None, "heart.png")),
    ("liver", "liver, breathing to and from the lamp", "8g–i", "table1", "deformation",
     "heart-mild=0,liver=1,falloff=1,specular=0.3", "liver", (None, "liver.jpg")),
    ("few-occluded", "tools over the abdominal wall, few features occluded", "9a–c", "table2",
     "occlusion", "tools=0.8,heart-mild=0,liver=0.7", "peritoneum", (None, "fascia.png")),
    ("more-occluded", "tools over the liver, more features occluded", "9d–f", "table2", "occlusion",
     "tools=2,heart-mild=0,liver=1", "liver", (None, "liver.jpg")),
    ("irrigation", "tools, blood and irrigation", "9g–i", "table2", "occlusion",
     "tools=0.7,heart-mild=0,liver=0.7,blood=1,irrigation=1", "liver", (None, "gallbladder-a.png")),
    ("rotation", "rotation", "10a–c", "table3", "rotation", "", "peritoneum",
     (None, "pelvis-a.png")),
    ("smoke", "smoke in two bursts", "10d–f", "table3", "smoke", "", "bowel",
     (None, "bowel-fat.png")),
    ("zoom", "scale", "10g–i", "table3", "zoom", "", "peritoneum", (None, "uterus.png")),
)
# The simulation again on the other pictures, for the trackers that take less than a tenth of a
# second a frame.
MORE: Kind = ("more", "simulation", "7", "more", "deformation", "noise=2,light=0.5", "heart",
              ("liver.jpg", "gallbladder-a.png"))
PERSISTENT = ("csd-2012", "lk", "csd-forest", "csd")
# The sequence of irrigation without blood and water: it tells their effect from that of time.
DRY: Kind = ("dry", "tools, no blood, no irrigation", "", "control", "occlusion",
             "tools=0.7,heart-mild=0,liver=0.7", "liver", (None, "gallbladder-a.png"))
# First frames of clips as textures: name, title, scenario, effects, clip. Skipped without the
# clips.
PICTURE_KINDS = (
    ("picture-light", "strong heartbeat, moving light", "deformation",
     "heart-mild=0,heart-strong=1,light=1", "heart.mkv"),
    ("picture-tools", "tools, highlights, light, sway", "occlusion", "specular=1,light=1,sway=1",
     "abdomen.mkv"),
    ("picture-zoom", "scale, highlights", "zoom", "specular=1", "cutting.mp4"),
    ("picture-rotation", "rotation, smoke", "rotation", "smoke=1", "cholecystectomy.mp4"),
)
SIMULATION_FEATURES, FEATURES = 100, 50  # as in the paper: §3.1, §3.2


def slow_share(features: int, frames: int) -> Share:
    return Share("slow", SLOW_RIVALS, features, frames, cost=10)


def scenes(seeds: int) -> tuple[int, ...]:
    return tuple(range(FIRST_SEED, FIRST_SEED + seeds))


def missing_pictures() -> list[pathlib.Path]:
    """The pictures of real tissue that the paper's sequences would show, and that are not there."""
    wanted = dict.fromkeys(TISSUE / picture for *_, pictures in (*KINDS, MORE, DRY)
                           for picture in pictures if picture)
    return [picture for picture in wanted if not picture.is_file()]


def repeated(kind: Kind, features: int, frames: int, seeds: int,
             trackers: tuple[str, ...] = ()) -> Sequence:
    """One of the paper's sequences; drawn by the simulator alone if its pictures are missing."""
    name, title, figure, table, scenario, effects, style, pictures = kind
    textures = tuple(picture and str(TISSUE / picture) for picture in pictures)
    return Sequence(name, title, figure, table, scenario, effects, style, features, frames,
                    scenes(seeds), textures=() if missing_pictures() else textures,
                    trackers=trackers)


def paper_sequences(simulation: tuple[int, int], more: int,
                    others: tuple[int, int, int]) -> tuple[Sequence, ...]:
    """All sequences of the paper's experiments.

    simulation: its features and frames; more: the number of its further seeds;
    others: features, frames and number of seeds of all other sequences.
    """
    seeds_after_the_first = scenes(1 + more)[1:]
    return (*(repeated(kind, *((*simulation, 1) if kind[0] == "simulation" else others))
              for kind in KINDS),
            dataclasses.replace(repeated(MORE, *simulation, 1, trackers=PERSISTENT),
                                seeds=seeds_after_the_first),
            repeated(DRY, *others, trackers=("csd-2012",)))


def paper(seeds: int) -> Plan:
    """The paper's experiments: 4000 frames of the simulation on three pictures, and `seeds` scenes
    of each other sequence."""
    return Plan(paper_sequences((SIMULATION_FEATURES, 4000), 2, (FEATURES, 500, seeds)),
                (Share("tracked", REPEATED),), True, 10, 100)


def paper_quick(seeds: int) -> Plan:
    """Shows that everything works; too short to say how well."""
    return Plan(paper_sequences((12, 40), 1, (8, 14, seeds)), (Share("tracked", REPEATED),), False,
                1, 30)


# The sequences behind csd's goals: name, title, row of beyond.json (as `table`), scenario, effects,
# style.
BEYOND_KINDS = (
    ("textured", "textured", "deformation", "deformation", "", "heart"),
    ("smooth", "smooth", "deformation", "deformation", "", "liver"),
    ("faint", "low texture", "deformation", "low-texture", "", "liver"),
    ("tools-liver", "tools over the liver", "occlusion", "occlusion", "", "liver"),
    ("tools-heart", "tools over the heart", "occlusion", "occlusion", "", "heart"),
    ("irrigation", "tools, blood and irrigation", "occlusion", "occlusion",
     "tools=0.7,heart-mild=0,liver=0.7,blood=1,irrigation=1", "liver"),
    ("zoom-heart", "heart", "zoom", "zoom", "", "heart"),
    ("zoom-peritoneum", "peritoneum", "zoom", "zoom", "", "peritoneum"),
    ("rotation", "peritoneum", "rotation", "rotation", "", "peritoneum"),
    ("smoke", "bowel", "smoke", "smoke", "", "bowel"),
    ("specular-fat", "fat", "light", "specular", "", "fat"),
    ("specular-heart", "heart", "light", "specular", "", "heart"),
    ("mixed", "everything mixed", "mixed", "mixed", "", "heart"),
    # black=0.64: black for 2 s. In that time rotation=1 turns the view by 24°, and black itself
    # turns it by up to 11° to either side.
    ("black", "black, the view turns and zooms", "return", "rotation",
     "black=0.64,rotation=3,zoom=0.5", "heart"),
    ("cut", "cut and return", "return", "cut", "", "bowel"),
    ("wipe", "lens wipe", "return", "deformation", "wipe=1", "heart"),
)
CHECKED = ("csd", "lk", "lk-fb", "lk-anchored", "still")
# These take a tenth of a second a frame and more, or are far below by the paper's experiments.
COSTLY = ("csd-2012", "sift", "ms1", "ms2")


def first_frame(clip: str) -> pathlib.Path:
    """Where the picture of the clip's first frame is kept."""
    return PICTURES / f"{pathlib.Path(clip).stem}.png"


def beyond_sequences(seeds: int, features: int, frames: int,
                     mixed_frames: int) -> tuple[Sequence, ...]:
    pictures = [
        Sequence(name, title, "", "pictures", scenario, effects, "", features, frames,
                 scenes(seeds), textures=(str(first_frame(clip)),))
        for name, title, scenario, effects, clip in PICTURE_KINDS
        if clips_there()
    ]
    simulated = [
        Sequence(name, title, "", row, scenario, effects, style, features,
                 *((mixed_frames, (FIRST_SEED,)) if row == "mixed" else (frames, scenes(seeds))))
        for name, title, row, scenario, effects, style in BEYOND_KINDS
    ]
    return tuple(simulated + pictures)


PALINDROMES = ("heart.mkv", "abdomen.mkv", "beads.mkv", "cholecystectomy.mp4", "cutting.mp4",
               "smoke.mp4")


def clips_there() -> bool:
    """Whether all clips are there: the page about them is written whole or left as it is."""
    return all((CLIPS / clip).is_file()
               for clip in {*PALINDROMES, *(clip for *_, clip in PICTURE_KINDS)})


def beyond(seeds: int) -> Plan:
    """csd beside its rivals; costly rivals run on a part of the features, frames or seeds."""
    return Plan(beyond_sequences(seeds, 100, 500, 4000),
                (Share("tracked", CHECKED), slow_share(10, 250),
                 Share("early", COSTLY, 0, 250, True, 5)), True, palindrome_frames=250)


def beyond_quick(seeds: int) -> Plan:
    return Plan(beyond_sequences(seeds, 8, 10, 20),
                (Share("tracked", CHECKED), slow_share(2, 6),
                 Share("early", COSTLY, 0, 3, True, 5)), False, palindrome_frames=4)


PLANS: dict[str, Callable[[int], Plan]] = {
    "paper": paper, "paper-quick": paper_quick, "beyond": beyond, "beyond-quick": beyond_quick,
}
