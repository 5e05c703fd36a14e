// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/gstvideofilter.h>

#include <atomic>
#include <mutex>

#include "enums.h"
#include "overlay/overlay_composition.h"
#include "overlay/overlay_painter.h"
#include "track/types.h"

namespace csd {

/// The property `overlay` of a GstVideoFilter that shows tracks: how it handles frames, caps and events. Such an
/// element works in place, and maps for writing only here.
class Overlay {
 public:
  /// For init(): in place, gap-aware, no QoS, and the caps settings that OverlayNegotiation needs.
  static void set_up(GstBaseTransform *element);
  static GParamSpec *param_spec();

  /// Call after setting the property, from any thread. `overlay` is the element's copy of the value, guarded by its
  /// object lock, which must not be held: if two threads set it, both read the last value.
  void see_value(GstBaseTransform *element, const GstCsdTrackOverlay &overlay);
  /// For transform_caps, from any thread. The caller owns the result; on failure it is `caps`, filtered.
  GstCaps *transform_caps(GstBaseTransform *element, GstPadDirection direction, GstCaps *caps,
                          GstCaps *filter) const noexcept;
  /// For fixate_caps: takes `other` and returns it in our order of preference, which a peer that puts plain caps first
  /// (glimagesink, gloverlaycompositor) has reversed. The caller owns the result.
  GstCaps *prefer(GstPadDirection direction, GstCaps *other) const noexcept {
    return direction == GST_PAD_SINK ? negotiation_.prefer(other) : other;
  }
  /// For accept_caps: calls `accept` (the base class's) with caps that include their interlace-mode.
  static gboolean accept_caps(GstBaseTransform *element, GstPadDirection direction, GstCaps *caps,
                              decltype(GstBaseTransformClass::accept_caps) accept);
  /// For src_event, from any thread.
  void see_event(GstBaseTransform *element, GstEvent *event);
  /// For set_info, or set_caps.
  void set_caps(GstCaps *in, GstCaps *out);
  /// Whether the overlay works on frames of these caps; if not, it has posted an ERROR. Only needed by elements that
  /// accept more than template_caps().
  bool can_show(GstBaseTransform *element, GstCsdTrackOverlay overlay) const;
  /// Call first in transform_ip.
  void settle(GstBaseTransform *element, GstCsdTrackOverlay overlay);
  /// Shows `tracks` on a frame of `element`. Only drawing maps for writing, which copies the pixels of a shared buffer.
  /// If a composition isn't possible, posts one WARNING.
  void show(GstVideoFilter *element, GstBuffer *buffer, const Tracks &tracks, GstCsdTrackOverlay overlay);

 private:
  std::mutex values_;               ///< held from reading the value until its negotiation is done
  OverlayNegotiation negotiation_;  ///< thread-safe
  std::atomic<bool> draws_ = false;
  // Streaming thread only.
  bool can_map_ = true;  ///< frames of the current caps
  OverlayPainter painter_;
  OverlayComposition composition_;
};

/// For before_transform: updates controlled properties to the frame's stream time.
void sync_properties(GstBaseTransform *element, GstBuffer *buffer);

}  // namespace csd
