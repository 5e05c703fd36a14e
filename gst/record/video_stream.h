// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include "caps/frame_time.h"

namespace csd {

/// csdtrackdec's video, from READY to READY. Only the element's own thread uses it, or nothing flows.
struct VideoStream {
  GstVideoInfo info;
  GstCaps *caps = nullptr;  ///< null until they come
  bool negotiated = false;
  FrameMoments head;  ///< of the frame at the head of the queue
  FramePace pace;
  bool warned_aspect = false;

  VideoStream() { gst_video_info_init(&info); }
  void begin(GstCaps *its) {
    gst_caps_replace(&caps, its);
    negotiated = false;
    pace = {};
  }
};

}  // namespace csd
