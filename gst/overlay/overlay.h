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

/// The property `overlay` of a GstVideoFilter that shows tracks: what it does with a frame, with caps and with events.
/// Such an element works in place, and maps for writing here only.
class Overlay {
 public:
  /// For init(): in place, gap aware, every frame wanted, and caps as OverlayNegotiation needs them.
  static void set_up(GstBaseTransform *element);
  static GParamSpec *param_spec();

  /// After the property was set; any thread. `overlay` is where the element keeps the value, guarded by its object
  /// lock, which must not be held: of two threads that set it, each reads what has been set last.
  void see_value(GstBaseTransform *element, const GstCsdTrackOverlay &overlay);
  /// For transform_caps: any thread. The caller owns the result, `caps` by the filter if something fails.
  GstCaps *transform_caps(GstBaseTransform *element, GstPadDirection direction, GstCaps *caps,
                          GstCaps *filter) const noexcept;
  /// For fixate_caps: takes `other`, and gives it back in our order of preference, which a peer that puts plain caps
  /// first (glimagesink, gloverlaycompositor) has turned round. The caller owns the result.
  GstCaps *prefer(GstPadDirection direction, GstCaps *other) const noexcept {
    return direction == GST_PAD_SINK ? negotiation_.prefer(other) : other;
  }
  /// For accept_caps: asks `accept` (the base class's) about caps that say their interlace-mode.
  static gboolean accept_caps(GstBaseTransform *element, GstPadDirection direction, GstCaps *caps,
                              decltype(GstBaseTransformClass::accept_caps) accept);
  /// For src_event: any thread.
  void see_event(GstBaseTransform *element, GstEvent *event);
  /// For set_info, or set_caps.
  void set_caps(GstCaps *in, GstCaps *out);
  /// Whether frames of these caps can be shown so; if not, an ERROR has been posted. Only an element that takes more
  /// than template_caps() need ask.
  bool can_show(GstBaseTransform *element, GstCsdTrackOverlay overlay) const;
  /// For transform_ip, first.
  void settle(GstBaseTransform *element, GstCsdTrackOverlay overlay);
  /// Shows `tracks` on the frame of `element`. Only drawing maps for writing: pixels that somebody else holds too are
  /// copied then, and only then. Where a composition can't be had, one WARNING is posted.
  void show(GstVideoFilter *element, GstBuffer *buffer, const Tracks &tracks, GstCsdTrackOverlay overlay);

 private:
  std::mutex values_;               ///< held from the reading of the value until it is negotiated by
  OverlayNegotiation negotiation_;  ///< guards itself
  std::atomic<bool> draws_ = false;
  // The streaming thread's alone.
  bool can_map_ = true;  ///< frames of the caps in force
  OverlayPainter painter_;
  OverlayComposition composition_;
};

/// For before_transform: controlled properties take the values of the frame's stream time.
void sync_properties(GstBaseTransform *element, GstBuffer *buffer);

}  // namespace csd
