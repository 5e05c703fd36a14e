#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
# %% [markdown]
# # How a point on a beating heart moves
#
# Simulated tissue beats and breathes. `csdtrack.Tracker` follows points on it, and the simulator
# knows where they really are. Run it as a program, `beating_heart.py [PICTURE [SECONDS]]`, or cell
# by cell in an editor that knows `# %%`.

# %%
import sys
from collections.abc import Iterator

import gi
import matplotlib
import numpy as np

import csdtrack

gi.require_version("Gst", "1.0")
gi.require_version("GstVideo", "1.0")
from gi.repository import Gst, GstVideo  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

picture = sys.argv[1] if len(sys.argv) > 1 else "beating_heart.png"
seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 12
rate = 25
Gst.init(None)


# %% [markdown]
# ## Frames and truth, as numpy arrays


# %%
def simulated() -> Iterator[tuple[int, np.ndarray, list[tuple[int, float, float]]]]:
    """Yields (pts in ns, H×W×3 RGB, [(id, x, y)] of the visible points) for each frame."""
    pipeline = Gst.parse_launch(
        f"csdsimsrc num-buffers={round(seconds * rate)} style=heart "
        "effects=heart-strong=1,specular=1,noise=1 ! "
        f"video/x-raw,format=RGB,width=480,height=384,framerate={rate}/1 ! "
        "appsink name=sink sync=false")
    pipeline.set_state(Gst.State.PLAYING)
    while sample := pipeline.get_by_name("sink").emit("pull-sample"):
        buffer, info = sample.get_buffer(), GstVideo.VideoInfo.new_from_caps(sample.get_caps())
        frame: np.ndarray = np.ndarray((info.height, info.width, 3), np.uint8,
                                       buffer.extract_dup(0, buffer.get_size()),
                                       strides=(info.stride[0], 3, 1))
        truth = buffer.get_custom_meta("GstCsdTruthMeta").get_structure().get_value("features")
        yield buffer.pts, frame, [(f.get_value("id"), f.get_value("x"), f.get_value("y"))
                                  for f in truth if f.get_value("state") == "tracked"]
    pipeline.set_state(Gst.State.NULL)


# %% [markdown]
# ## Tracks
#
# The tracker starts from the points that are visible in the first frame: its id i is the i-th of
# them.

# %%
tracker = None
samples = []
for pts, frame, visible in simulated():
    if tracker is None:
        first = visible
        tracker = csdtrack.Tracker(points=[(x, y) for _, x, y in first])
    tracks = tracker.process(frame, pts)
    claimed = tracks["confidence"] >= 0.5
    places = {i: (x, y) for i, x, y in visible}
    samples.append(
        (pts * 1e-9, np.where(claimed[:, None], np.stack([tracks["x"], tracks["y"]], 1), np.nan),
         [places.get(i, (np.nan, np.nan)) for i, _, _ in first]))
# times: frames; found and true: frames × points × 2
times, found, true = (np.array(column) for column in zip(*samples))

errors = np.linalg.norm(found - true, axis=2)
print(f"{len(first)} points, {len(times)} frames, median error {np.nanmedian(errors):.2f} px")

# %% [markdown]
# ## Displacement and its rhythms
#
# These are of the point that moves most, among those that were tracked nearly always. Frames in
# which the tracker claims no position are gaps.

# %%
always = np.isfinite(found[..., 0]).mean(axis=0) >= 0.95
moves = np.where(always, np.nanstd(found, axis=0).sum(axis=1), -1)
best = int(np.argmax(moves))
displacement = found[:, best] - found[0, best]
axis = int(np.argmax(np.nanstd(displacement, axis=0)))  # 0: x, 1: y

signal = displacement[:, axis].copy()
known = np.isfinite(signal)
signal = np.interp(times, times[known], signal[known])
window = np.hanning(len(signal))
padded = 8 * len(signal)
amplitude = 2 * np.abs(np.fft.rfft((signal - signal.mean()) * window, padded)) / window.sum()
frequency = np.fft.rfftfreq(padded, 1 / rate)
heart = (frequency > 0.7) & (frequency < 2.5)
beats = 60 * frequency[heart][np.argmax(amplitude[heart])]
print(f"point {best}: {np.ptp(signal):.1f} px in {'xy'[axis]}, heart rate {beats:.0f}/min")

# %%
figure, (above, below) = plt.subplots(2, 1, figsize=(9, 6), constrained_layout=True)
for k, colour in ((0, "tab:blue"), (1, "tab:orange")):
    above.plot(times, true[:, best, k] - true[0, best, k], color=colour, alpha=0.4, linewidth=4,
               label=f"{'xy'[k]}, true")
    above.plot(times, displacement[:, k], color=colour, linewidth=1, label=f"{'xy'[k]}, csdtrack")
above.set(xlabel="time (s)", ylabel="displacement (px)",
          title=f"Point {best} on a simulated beating heart")
above.legend(ncol=4, loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False)
below.plot(frequency, amplitude, color="tab:green")
for rhythm, name in ((0.25, "breath"), (1.25, "heart")):
    below.axvline(rhythm, color="gray", linestyle=":")
    below.annotate(f" {name}, as simulated", (rhythm, 0.92), xycoords=("data", "axes fraction"),
                   color="gray")
below.set(xlim=(0, 5), ylim=(0, None), xlabel="frequency (Hz)",
          ylabel=f"amplitude in {'xy'[axis]} (px)")
figure.savefig(picture, dpi=100)
