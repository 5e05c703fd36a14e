// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <optional>
#include <vector>

#include "csdtrackmeta.h"
#include "track/types.h"

namespace csd {

/// Makes the two metas known to GStreamer: "GstCsdTrackMeta" and "GstCsdTruthMeta", one structure, docs/metadata.md.
/// May be called again, and by several threads. False if GStreamer refuses.
///
/// Their tags are `video`, `orientation`, `size`: with these and a transform function they survive converters, scalers
/// and encoders on 1.22. With the tag `colorspace` converters drop them; with `video` alone scalers keep them unscaled.
bool register_track_metas();

/// A new structure `name` that holds `tracks`; for a message. `source` is the element's name, `algorithm` the nick.
/// width,height and tracked-width,tracked-height are those of `tracks`.
GstStructure *new_tracks_structure(const char *name, const Tracks &tracks, const char *source, const char *algorithm);

/// Adds a meta `name` with the same fields to a writable buffer. What is there stays. Null if the metas are not
/// registered.
GstCustomMeta *add_tracks(GstBuffer *buffer, const char *name, const Tracks &tracks, const char *source,
                          const char *algorithm);

/// Adds a GstCsdTrackMeta to a writable buffer. What is there stays. Null if the metas are not registered.
GstCustomMeta *add_track_meta(GstBuffer *buffer, const Tracks &tracks, const char *source, const char *algorithm);

/// Adds a GstCsdTruthMeta, whose algorithm is "truth". Null if the metas are not registered.
GstCustomMeta *add_truth_meta(GstBuffer *buffer, const Tracks &truth, const char *source);

/// The points that the buffer's truth calls visible, with their ids; nothing where there is no truth of a picture of
/// this size.
std::optional<std::vector<StartPoint>> visible_truth(GstBuffer *buffer, int width, int height);

/// Scales positions and size to a picture of width×height pixels, as the metas' own transform does. False, and nothing
/// is changed, where the aspects differ: borders can't be told from distortion. Pixels are taken to have one shape.
bool scale_tracks(Tracks &tracks, int width, int height);

}  // namespace csd
