# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the experiments run: the sequences of the paper's figures and tables, simulated, and the trackers."""

import dataclasses
import os
import pathlib

import builds

WIDTH, HEIGHT, RATE = 640, 480, 25
FIRST_SEED = 101  # 1 to 20 are for development: constants may have been chosen on them

PAPER = ("csd-2012", "lk", "ms1", "ms2", "sift")  # csdtrack algorithm=..., what the paper compares
PLUGIN = ("csd", "csd-forest", *PAPER)
RIVALS = ("lk-fb", "lk-anchored", "still")  # csd-peers, as many features and frames as the others
# csd-peers, on some features and frames: csrt takes 12 ms for each
SLOW_RIVALS = ("csrt", "kcf", "medianflow")
CLIPS = pathlib.Path(os.environ.get("CSDTRACK_CLIPS", builds.ROOT.parent / "shared" / "clips"))
PICTURES = builds.BUILD / "experiments" / "pictures"  # first frames of clips
TISSUE = pathlib.Path(
    os.environ.get("CSDTRACK_TISSUE", builds.ROOT.parent / "shared" / "tissue" / "textures"))
# As recorders compress. identity: y4menc 1.22 writes the decoder's padding, if it is offered any.
CODEC = ("x264enc pass=qual quantizer=23 ! video/x-h264,profile=high ! h264parse ! avdec_h264 ! "
         "identity drop-allocation=true ! video/x-raw,format=I420")
PAPER_ORDER = ("lk", "ms1", "ms2", "sift", "csd-2012")  # the columns of its tables


@dataclasses.dataclass(frozen=True)
class Sequence:
    """A kind of sequence; with a seed it is one video."""

    name: str
    title: str
    figure: str  # of the paper, with the panels
    table: str  # "table1"…; "": in a figure only
    scenario: str
    effects: str  # over the scenario's
    style: str
    features: int
    frames: int
    seeds: tuple
    rate: int = RATE
    # pictures of real tissue, not in the repository, by seed in turn; None among them: the style
    textures: tuple = ()
    trackers: tuple = ()  # (): all that the plan has for it

    def texture(self, seed):
        """The picture that is this scene's surface, whose video is compressed as recorders do; None: the style is."""
        return self.textures[(seed - FIRST_SEED) % len(self.textures)] if self.textures else None

    def source(self, seed):
        """csdsimsrc and its caps, as gst-launch-1.0 takes them. I420, as decoders give it: every tracker sees the same bytes."""
        effects = f' effects="{self.effects}"' if self.effects else ""
        picture = self.texture(seed)
        texture = f'texture="{picture}"' if picture else f"style={self.style}"
        return (
            f"csdsimsrc scenario={self.scenario}{effects} {texture} seed={seed} features={self.features} "
            f"num-buffers={self.frames} ! video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate={self.rate}/1"
            f"{f' ! {CODEC}' if picture else ''}")


@dataclasses.dataclass(frozen=True)
class Share:
    """Trackers that get a part of each sequence; truth-NAME.jsonl is the truth of just that. 0: all features, all frames."""

    name: str
    trackers: tuple
    features: int = 0
    frames: int = 0
    first_seed: bool = False  # of a sequence's seeds the first only
    cost: float = 1  # of a feature and frame, roughly, beside those of other shares

    def has(self, sequence, seed):
        return not self.first_seed or seed == sequence.seeds[0]

    def of(self, sequence):
        """(features, frames) that it gets."""
        return (min(self.features or sequence.features,
                    sequence.features), min(self.frames or sequence.frames, sequence.frames))


@dataclasses.dataclass(frozen=True)
class Plan:
    """All that is run."""

    sequences: tuple
    shares: tuple
    published: bool
    cost_features: int = 0  # of Fig. 11
    cost_frames: int = 0
    palindrome_frames: int = 0

    def runs(self):
        """(sequence, seed), the longest first, so that no core idles at the end."""
        return sorted(((s, seed) for s in self.sequences for seed in s.seeds),
                      key=lambda run: -self.cost(*run))

    def cost(self, sequence, seed):
        return sum(share.cost * features * frames for share in self.shares_of(sequence, seed)
                   for features, frames in [share.of(sequence)])

    def shares_of(self, sequence, seed):
        """With the trackers that run on this sequence."""
        shares = []
        for share in self.shares:
            trackers = tuple(t for t in share.trackers
                             if t in (sequence.trackers or share.trackers))
            if trackers and share.has(sequence, seed):
                shares.append(
                    dataclasses.replace(share, trackers=trackers,
                                        cost=share.cost * len(trackers) / len(share.trackers)))
        return shares

    def share(self, name):
        return next(share for share in self.shares if share.name == name)

    def sequence(self, name):
        return next(s for s in self.sequences if s.name == name)

    def of_table(self, table):
        return [s for s in self.sequences if s.table == table]

    def of_tables(self):
        """Of the paper's Tables 1 to 3."""
        return [s for s in self.sequences if s.table.startswith("table")]


# name, title, figure, table, scenario, effects, style, textures by seed in turn: of TISSUE, or
# None, the style. The paper's sequences are described in its §3.1 and §3.2. In the simulation's
# light and noise LK drifts, as it does in the paper's: without them it loses nothing in 4000
# frames.
KINDS = (
    ("simulation", "simulation", "7", "", "deformation", "noise=2,light=0.5", "heart",
     ("heart.png", )),
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
    ("rotation", "rotation", "10a–c", "table3", "rotation", "", "peritoneum", (None,
                                                                               "pelvis-a.png")),
    ("smoke", "smoke in two bursts", "10d–f", "table3", "smoke", "", "bowel", (None,
                                                                               "bowel-fat.png")),
    ("zoom", "scale", "10g–i", "table3", "zoom", "", "peritoneum", (None, "uterus.png")),
)
# The simulation again, on the other pictures, for those that don't take a tenth of a second a
# frame.
MORE = ("more", "simulation", "7", "more", "deformation", "noise=2,light=0.5", "heart",
        ("liver.jpg", "gallbladder-a.png"))
PERSISTENT = ("csd-2012", "lk", "csd-forest", "csd")
# The sequence of irrigation, without blood and water: what these change is told from what time
# does.
DRY = ("dry", "tools, no blood, no irrigation", "", "control", "occlusion",
       "tools=0.7,heart-mild=0,liver=0.7", "liver", (None, "gallbladder-a.png"))
# Clips' first frames as texture: name, title, scenario, effects, clip. Run where the clips are.
PICTURE_KINDS = (
    ("picture-light", "strong heartbeat, moving light", "deformation",
     "heart-mild=0,heart-strong=1,light=1", "heart.mkv"),
    ("picture-tools", "tools, highlights, light, sway", "occlusion", "specular=1,light=1,sway=1",
     "abdomen.mkv"),
    ("picture-zoom", "scale, highlights", "zoom", "specular=1", "cutting.mp4"),
    ("picture-rotation", "rotation, smoke", "rotation", "smoke=1", "cholecystectomy.mp4"),
)
SIMULATION_FEATURES, FEATURES = 100, 50  # as in the paper: §3.1, §3.2
REPEATED = (*PAPER, "csd-forest", "csd")  # the paper's five, its future work, and the project's own


def boxes(features, frames):
    """What takes too long for all features."""
    return Share("slow", SLOW_RIVALS, features, frames, cost=10)


def scenes(seeds):
    return tuple(range(FIRST_SEED, FIRST_SEED + seeds))


def pictures_there():
    return all((TISSUE / picture).is_file()
               for *_, pictures in (*KINDS, MORE, DRY)
               for picture in pictures
               if picture)


def repeated(kind, features, frames, seeds, trackers=()):
    """A kind of the paper's; where its pictures of real tissue are not there, all of it is simulated."""
    *kind, pictures = kind
    textures = tuple(picture and str(TISSUE / picture)
                     for picture in pictures) if pictures_there() else ()
    return Sequence(*kind, features, frames, scenes(seeds), textures=textures, trackers=trackers)


def paper_sequences(simulation, more, others):
    """simulation: (features, frames); more: seeds of it; others: (features, frames, seeds)"""
    seeds_after_the_first = scenes(1 + more)[1:]
    return (*(repeated(kind, *((*simulation, 1) if kind[0] == "simulation" else others))
              for kind in KINDS),
            dataclasses.replace(repeated(MORE, *simulation, 1, trackers=PERSISTENT),
                                seeds=seeds_after_the_first),
            repeated(DRY, *others, trackers=("csd-2012", )))


def paper(seeds):
    """The paper's experiments: the simulation's 4000 frames on three pictures, `seeds` scenes of each other sequence."""
    return Plan(paper_sequences((SIMULATION_FEATURES, 4000), 2, (FEATURES, 500, seeds)),
                (Share("tracked", REPEATED), ), True, 10, 100)


def paper_quick(seeds):
    """Shows that everything works, and says little of how well."""
    return Plan(paper_sequences((12, 40), 1, (8, 14, seeds)), (Share("tracked", REPEATED), ), False,
                1, 30)


# What csd is held to: name, title, row of beyond.json (as `table`), scenario, effects, style.
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
    # 0.64: black for 2 s. rotation=1 turns the view by 24° in that time, and black by up to 11° of
    # its own, to either side.
    ("black", "black, the view turns and zooms", "return", "rotation",
     "black=0.64,rotation=3,zoom=0.5", "heart"),
    ("cut", "cut and return", "return", "cut", "", "bowel"),
    ("wipe", "lens wipe", "return", "deformation", "wipe=1", "heart"),
)
CHECKED = ("csd", "lk", "lk-fb", "lk-anchored", "still")
# A tenth of a second a frame and more, or known from the paper's experiments to be far below.
COSTLY = ("csd-2012", "sift", "ms1", "ms2")


def first_frame(clip):
    """Where it is kept."""
    return PICTURES / f"{pathlib.Path(clip).stem}.png"


def beyond_sequences(seeds, features, frames, mixed_frames):
    pictures = [
        Sequence(name, title, "", "pictures", scenario, effects, "", features, frames,
                 scenes(seeds), textures=(str(first_frame(clip)), ))
        for name, title, scenario, effects, clip in PICTURE_KINDS
        if clips_there()
    ]
    return tuple([
        Sequence(name, title, "", row, scenario, effects, style, features,
                 *((mixed_frames, (FIRST_SEED, )) if row == "mixed" else (frames, scenes(seeds))))
        for name, title, row, scenario, effects, style in BEYOND_KINDS
    ] + pictures)


PALINDROMES = ("heart.mkv", "abdomen.mkv", "beads.mkv", "cholecystectomy.mp4", "cutting.mp4",
               "smoke.mp4")


def clips_there():
    """Whether all clips are: what is said of them is written whole or left as it is."""
    return all(
        (CLIPS / clip).is_file() for clip in {*PALINDROMES, *(clip for *_, clip in PICTURE_KINDS)})


def beyond(seeds):
    """csd, and what it is compared with: what costs much on a part of it."""
    return Plan(beyond_sequences(seeds, 100, 500, 4000), (
        Share("tracked", CHECKED), boxes(10, 250), Share("early", COSTLY, 0, 250, True, 5)), True,
        palindrome_frames=250)


def beyond_quick(seeds):
    return Plan(beyond_sequences(seeds, 8, 10, 20), (
        Share("tracked", CHECKED), boxes(2, 6), Share("early", COSTLY, 0, 3, True, 5)), False,
        palindrome_frames=4)


PLANS = {"paper": paper, "paper-quick": paper_quick, "beyond": beyond, "beyond-quick": beyond_quick}
