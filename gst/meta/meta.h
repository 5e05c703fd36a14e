// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <optional>
#include <vector>

#include "base/types.h"
#include "meta/csdtrackmeta.h"

namespace csd {

/// Registers the two metas with GStreamer: "GstCsdTrackMeta" and "GstCsdTruthMeta", with the same structure, see
/// docs/metadata.md. May be called repeatedly and from several threads. Returns false if GStreamer refuses.
///
/// Their tags are `video`, `orientation`, `size`: with these and a transform function they survive converters, scalers
/// and encoders on 1.22. With the tag `colorspace` converters drop them; with only `video` scalers keep them unscaled.
bool register_track_metas();

/// A new structure `name` with `tracks`, for a message. `source` is the element's name, `algorithm` the nick.
/// width,height and tracked-width,tracked-height are those of `tracks`.
GstStructure *new_tracks_structure(const char *name, const Tracks &tracks, const char *source, const char *algorithm);

/// Adds a meta `name` with the same fields to a writable buffer. Existing metas stay. Null if the metas are not
/// registered.
GstCustomMeta *add_tracks(GstBuffer *buffer, const char *name, const Tracks &tracks, const char *source,
                          const char *algorithm);

/// Adds a GstCsdTrackMeta to a writable buffer. Existing metas stay. Null if the metas are not registered.
GstCustomMeta *add_track_meta(GstBuffer *buffer, const Tracks &tracks, const char *source, const char *algorithm);

/// Adds a GstCsdTruthMeta with algorithm "truth". Null if the metas are not registered.
GstCustomMeta *add_truth_meta(GstBuffer *buffer, const Tracks &truth, const char *source);

/// The visible points in the buffer's truth meta, with their ids; nothing without a truth meta for this picture size.
std::optional<std::vector<StartPoint>> visible_truth(GstBuffer *buffer, int width, int height);

/// The shape of a picture's pixels, width to height.
struct PixelAspect {
  int n = 1, d = 1;
};

/// Scales positions and size to a picture of width×height pixels, like the metas' transform. Returns false and changes
/// nothing if the display aspects differ by more than rounding the size of either picture explains: borders and
/// distortion look alike.
bool scale_tracks(Tracks &tracks, const PixelAspect &from, int width, int height, const PixelAspect &to);

}  // namespace csd
