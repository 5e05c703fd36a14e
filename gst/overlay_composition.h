// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstbasetransform.h>
#include <gst/video/video.h>

#include <atomic>
#include <cstdint>
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
///  * in set_caps (GstVideoFilter: set_info): set_caps();
///  * in src_event, on GST_EVENT_RECONFIGURE: restart();
///  * in transform_ip, first: settle(), and gst_base_transform_reconfigure_src() if it says retry; then it attaches if
///    may_attach(), else posts one WARNING if take_refusal().
/// It must set prefer_passthrough to FALSE (else the base class tries the caps without the feature first).
/// When `overlay` is set: set_wanted(), and if that says so, restart() and gst_base_transform_reconfigure_src().
/// transform_caps(), set_wanted() and restart() may be called in any thread, the others in the streaming thread.
class OverlayNegotiation {
 public:
  enum class Answer { settled, retry };

  /// True if that is another wish than before: then restart() and gst_base_transform_reconfigure_src() are due.
  bool set_wanted(bool wanted);
  /// What the other pad may have. Downstream of plain caps: with the feature first, then plain; upstream of caps with
  /// the feature: either; the feature is never taken away from caps that have it. The caller owns the result.
  GstCaps *transform_caps(GstPadDirection direction, GstCaps *caps) const;
  void set_caps(GstCaps *in, GstCaps *out);
  /// Asks downstream of the pad `src` by an allocation query, once after set_caps(): the base class sends none for an
  /// in-place element (seen, 1.22), and the answer needs the caps to have been sent. retry: downstream took the caps
  /// but won't render; negotiate again, transform_caps() no longer offers the feature. Pixels and metas are right
  /// meanwhile.
  Answer settle(GstPad *src);
  /// Downstream has changed and is asked anew. A refusal that was told is not told again unless it could be attached
  /// meanwhile, or set_wanted() asks anew.
  void restart();

  bool may_attach() const { return may_attach_; }
  /// True once after it has turned out that overlays can't be attached.
  bool take_refusal();

 private:
  std::mutex mutex_;  ///< of settling and restarting; not held while downstream is asked
  std::uint64_t restarts_ = 0;
  std::atomic<bool> wanted_ = false;
  std::atomic<bool> refused_ = false;  ///< downstream takes the caps but does not render
  std::atomic<bool> may_attach_ = false;
  std::atomic<bool> told_ = false;
  std::atomic<bool> settled_ = false;                   ///< downstream has been asked
  bool upstream_has_ = false, downstream_has_ = false;  ///< the feature, in the negotiated caps
};

}  // namespace csd
