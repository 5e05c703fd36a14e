// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <memory>
#include <mutex>

#include "base/types.h"

namespace csd {

/// overlay=meta: the look of overlay=draw as a GstVideoOverlayComposition. One object per thread.
class OverlayComposition {
 public:
  OverlayComposition();
  ~OverlayComposition();

  /// Adds the markers of all features except `ended` ones to `buffer`, which must be writable (its memory isn't
  /// changed). Positions refer to a picture of `height` lines whose top left is at (left, top) in the frame:
  /// picture_area(). An existing composition (from an earlier element) is kept below ours. No change without markers.
  void attach(GstBuffer *buffer, const Tracks &tracks, int left, int top, int height);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How an element that works in place negotiates attaching compositions: like GStreamer's text overlay, by the caps
/// feature meta:GstVideoOverlayComposition *and* the answer to the allocation query. If upstream already has the
/// feature, downstream must render compositions and no query is needed.
///
/// The element calls, only set_wanted(true) with overlay=meta:
///  * for a CAPS query: transform_caps(), then intersects with the filter (GST_CAPS_INTERSECT_FIRST);
///  * when it fixates the source pad's caps: prefer(), then the first;
///  * with the caps of both pads: set_caps();
///  * on GST_EVENT_RECONFIGURE: restart();
///  * first for each frame: settle(); then it attaches if may_attach(), or posts one WARNING if take_refusal();
///  * when `overlay` is set: set_wanted().
/// A GstBaseTransform must set prefer_passthrough to FALSE (or it tries the caps without the feature first).
/// transform_caps(), set_wanted() and restart() are thread-safe; the others belong to the streaming thread. A result
/// never refers to caps that are about to be renegotiated: the reconfigure flag of the source pad is set under the lock
/// that settle() holds when it checks the flag, and the base class (also GstAggregator) clears it before it calls
/// transform_caps().
class OverlayNegotiation {
 public:
  /// `src`: the element's, which outlives this object.
  explicit OverlayNegotiation(GstPad *src) : src_(src) {}

  /// Renegotiates the caps if the value changes.
  void set_wanted(bool wanted);
  /// The caps for the other pad. Downstream of plain caps: with the feature first, then plain; upstream of caps with
  /// the feature: either. Never removes the feature downstream. Other features, such as the memory's, stay. The caller
  /// owns the result.
  GstCaps *transform_caps(GstPadDirection direction, GstCaps *caps) const;
  /// `caps` (taken) for downstream, with the feature first if it is wanted. The caller owns the result.
  GstCaps *prefer(GstCaps *caps) const noexcept;
  void set_caps(GstCaps *in, GstCaps *out);
  /// Sends downstream an allocation query, once after set_caps(): the base class sends none for an in-place element
  /// (seen, 1.22), and the caps must be sent before the query. If downstream took the caps but won't render,
  /// renegotiates without the feature; until then pixels and metas are right.
  void settle();
  /// Downstream has changed and is queried again. A reported refusal is not reported again, unless attaching worked in
  /// between or set_wanted() asks again.
  void restart();

  /// Whether the current caps allow attaching compositions, settled or not.
  bool may_attach() const { return may_attach_; }
  /// Returns true once after attaching turned out to be impossible.
  bool take_refusal();

 private:
  GstPad *const src_;
  mutable std::mutex mutex_;  ///< not held during queries to downstream
  // Guarded by mutex_.
  bool wanted_ = false;
  bool refused_ = false;  ///< downstream accepts the caps but does not render
  bool told_ = false;
  bool settled_ = false;  ///< downstream has been queried
  // Streaming thread only.
  bool may_attach_ = false;
  bool upstream_has_ = false, downstream_has_ = false;  ///< the feature, in the negotiated caps
};

}  // namespace csd
