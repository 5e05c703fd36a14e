// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <atomic>
#include <mutex>

#include "base/types.h"
#include "overlay/overlay_composition.h"
#include "overlay/overlay_painter.h"
#include "support/enums.h"

namespace csd {

/// The property `overlay` of an element that shows tracks: how it handles frames, caps and events. Such an element
/// works in place, and maps for writing only here.
class Overlay {
 public:
  /// The pads of `element`, which outlive this object.
  Overlay(GstElement *element, GstPad *sink, GstPad *src)
      : element_(element), sink_(sink), src_(src), negotiation_(src) {}
  static GParamSpec *param_spec();

  /// Call after setting the property, from any thread. `overlay` is the element's copy of the value, guarded by its
  /// object lock, which must not be held: if two threads set it, both read the last value.
  void see_value(const GstCsdTrackOverlay &overlay);
  /// For transform_caps, from any thread. The caller owns the result; on failure it is `caps`, filtered.
  GstCaps *transform_caps(GstPadDirection direction, GstCaps *caps, GstCaps *filter) const noexcept;
  /// For fixate_caps: takes `other` and returns it in our order of preference, which a peer that puts plain caps first
  /// (glimagesink, gloverlaycompositor) has reversed. The caller owns the result.
  GstCaps *prefer(GstPadDirection direction, GstCaps *other) const noexcept {
    return direction == GST_PAD_SINK ? negotiation_.prefer(other) : other;
  }
  // For an element that isn't a GstBaseTransform, which does this itself. From any thread.

  /// Answers a CAPS or ACCEPT_CAPS query to the video's pad of that direction.
  void answer_caps(GstPadDirection direction, GstQuery *query) const;
  /// The caps to send for those of the video; empty if downstream takes none. The caller owns them.
  GstCaps *choose_caps(GstCaps *in) const;

  /// For upstream events, from any thread.
  void see_event(GstEvent *event);
  /// For set_info, or set_caps.
  void set_caps(GstCaps *in, GstCaps *out);
  /// Whether the overlay works on frames of these caps; if not, it has posted an ERROR. Without this question, show()
  /// throws.
  bool can_show(GstCsdTrackOverlay overlay) const;
  /// Call first for each frame.
  void settle(GstCsdTrackOverlay overlay);
  /// Shows `tracks` on a frame of caps `info`. Only drawing maps for writing, which copies the pixels of a shared
  /// buffer. If a composition isn't possible, or lines could not be drawn into, posts one WARNING. Throws
  /// std::runtime_error if frames of these caps can't be drawn into.
  void show(const GstVideoInfo &info, GstBuffer *buffer, const Tracks &tracks, GstCsdTrackOverlay overlay);

 private:
  GstElement *const element_;
  GstPad *const sink_, *const src_;
  std::mutex values_;               ///< held from reading the value until its negotiation is done
  OverlayNegotiation negotiation_;  ///< thread-safe
  std::atomic<bool> draws_ = false;
  // Streaming thread only.
  bool can_draw_ = true;       ///< into frames of the current caps
  bool told_of_rows_ = false;  ///< that some can't be drawn into
  OverlayPainter painter_;
  OverlayComposition composition_;
};

}  // namespace csd
