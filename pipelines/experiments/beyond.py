# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd on simulated tissue beside every rival, against goals set before: see --help."""

import sys

from pipelines.experiments import experiment, reach_pages, tissue

EPILOG = """
The scenes are csdsimsrc's, with every difficulty that an operation has, alone and mixed, from seeds
that no tracker was tuned on. The page has what csd reaches beside its goals (beyond.json), and its
δavg, AJ and OA beside those of every rival. Each sequence is rendered once and fed to all trackers.
The full run takes one to two hours on two cores and writes docs/results/beyond.md. --quick takes a
few minutes, shows that everything works, and writes beyond.md into the folder of its runs; its
figures mean nothing.

If all six clips of real tissue are there (heart.mkv, abdomen.mkv, beads.mkv, cholecystectomy.mp4,
cutting.mp4 and smoke.mp4 in $CSDTRACK_CLIPS, else in ../shared/clips), four of them are textures of
more sequences, and all are played forward and backward. That has a page of its own,
beyond-clips.md, which a run without the clips leaves alone.

beyond --tissue DIR takes the pictures and videos of a folder as textures, and writes tissue.md: see
beyond --tissue DIR --help.

After an interruption the same command goes on: finished runs are kept in DIR, unless they are of
another build. To begin anew, delete DIR (about 2 GB in full, and 2 GB more for its raw video while
the mixed scene runs). Installs what is missing first (Debian 12 or 13; apt, as root or with sudo)
and builds csdtrack.

Exit code: 0 if all is written, whether the goals are reached or not, 1 if something failed (it says
what), 2 for wrong use.
"""

if __name__ == "__main__":
    if any(word.startswith("--tissue") for word in sys.argv[1:]):
        sys.exit(tissue.main(sys.argv[1:]))
    experiment.main("beyond", "Runs csd and its rivals on simulated tissue, and says which goals "
                    "csd reaches.", EPILOG, reach_pages.write)
