// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstbasetransform.h>
#include <gst/video/video.h>

#include <memory>
#include <mutex>

#include "track/types.h"

namespace csd {

/// overlay=meta: the look of overlay=draw as a GstVideoOverlayComposition. One object belongs to one thread.
class OverlayComposition {
 public:
  OverlayComposition();
  ~OverlayComposition();

  /// Adds the markers of all features but `ended` ones to `buffer`, which must be writable (its memory is not touched).
  /// Positions are those of a picture of `height` lines whose top left is (left, top) of the frame: picture_area(). A
  /// composition that is there already (an earlier element's) is kept, ours lies over it. Nothing to show: no change.
  void attach(GstBuffer *buffer, const Tracks &tracks, int left, int top, int height);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How an in-place GstBaseTransform comes by the right to attach compositions: as GStreamer's text overlay does, by the
/// caps feature meta:GstVideoOverlayComposition *and* by the answer to the allocation query. Where upstream has the
/// feature already, downstream is bound to render compositions and nothing need be asked.
///
/// The element calls, with overlay=meta only set_wanted(true):
///  * in transform_caps: transform_caps(), then intersects with the filter (GST_CAPS_INTERSECT_FIRST);
///  * in fixate_caps, of caps for the source pad: prefer(), then fixates the first;
///  * in set_caps (GstVideoFilter: set_info): set_caps();
///  * in src_event, on GST_EVENT_RECONFIGURE: restart();
///  * in transform_ip, first: settle(); then it attaches if may_attach(), else posts one WARNING if take_refusal();
///  * when `overlay` is set: set_wanted().
/// It must set prefer_passthrough to FALSE (else the base class tries the caps without the feature first).
/// transform_caps(), set_wanted() and restart() may be called in any thread, the others in the streaming thread. What
/// they say of downstream is never of caps that are about to be negotiated anew: the reconfigure flag of the source pad
/// is set under the lock that settle() looks at it with, and the base class clears it before it asks transform_caps().
class OverlayNegotiation {
 public:
  /// If that differs from before, the caps are negotiated anew.
  void set_wanted(GstBaseTransform *element, bool wanted);
  /// What the other pad may have. Downstream of plain caps: with the feature first, then plain; upstream of caps with
  /// the feature: either; the feature is never taken away from caps that have it. Other features, the memory's, stay.
  /// The caller owns the result.
  GstCaps *transform_caps(GstPadDirection direction, GstCaps *caps) const;
  /// `caps` (taken) for downstream with those first that have the feature, if it is wanted. The caller owns the result.
  GstCaps *prefer(GstCaps *caps) const noexcept;
  void set_caps(GstCaps *in, GstCaps *out);
  /// Asks downstream by an allocation query, once after set_caps(): the base class sends none for an in-place element
  /// (seen, 1.22), and the answer needs the caps to have been sent. If downstream took the caps but won't render, they
  /// are negotiated again, and transform_caps() no longer offers the feature; pixels and metas are right meanwhile.
  void settle(GstBaseTransform *element);
  /// Downstream has changed and is asked anew. A refusal that was told is not told again unless it could be attached
  /// meanwhile, or set_wanted() asks anew.
  void restart(GstBaseTransform *element);

  /// Settled or not: whether the caps that are in force let compositions be attached.
  bool may_attach() const { return may_attach_; }
  /// True once after it has turned out that overlays can't be attached.
  bool take_refusal();

 private:
  mutable std::mutex mutex_;  ///< not held while downstream is asked
  // Guarded by mutex_.
  bool wanted_ = false;
  bool refused_ = false;  ///< downstream takes the caps but does not render
  bool told_ = false;
  bool settled_ = false;  ///< downstream has been asked
  // The streaming thread's alone.
  bool may_attach_ = false;
  bool upstream_has_ = false, downstream_has_ = false;  ///< the feature, in the negotiated caps
};

}  // namespace csd
