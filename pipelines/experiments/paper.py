# SPDX-License-Identifier: LGPL-2.1-or-later
"""Repeats the experiments of Mountney & Yang (2012), with simulated motion of simulated and real
tissue: see --help."""

from pipelines.experiments import evaluation, experiment

EPILOG = """
Repeats the simulation of the paper's Fig. 7, the classes of its Tables 1 to 3 (Figs 8 to 10) and
the learning times of its Fig. 11, with the paper's five trackers, csd-forest and csd. Each scene is
rendered once and fed to all trackers. The full run writes docs/results/paper.md and the figures.
--quick takes a minute or two, shows that everything works, and writes paper.md into the folder of
its runs; its figures mean nothing.

Every second scene of Tables 1 to 3 and each of Fig. 7 shows real tissue, if the pictures of it are
there (heart.png, liver.jpg and five more in $CSDTRACK_TISSUE, else in ../shared/tissue/textures);
the video of these scenes is compressed by H.264. Without the pictures all tissue is simulated.

After an interruption the same command goes on: finished runs are kept in DIR, unless they are of
another build. To begin anew, delete DIR. Installs what is missing first (Debian 12 or 13; apt, as
root or with sudo) and builds csdtrack.

Exit code: 0 if all is written, 1 if something failed (it says what), 2 for wrong use.
"""

if __name__ == "__main__":
    experiment.main("paper", "Runs the paper's experiments on simulated motion.", EPILOG,
                    evaluation.write, seeds=2)
