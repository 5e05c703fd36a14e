// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>
#include <gst/video/video.h>

#include <string>

#include "text/write_line.h"

namespace csd {

/// What GStreamer knows about a frame to be written.
struct FrameRecord {
  const GstStructure *tracks = nullptr;  ///< of a track or truth meta; null: none
  /// A crop added to the frame after tracking; null: none. The output refers to it.
  const GstVideoCropMeta *crop = nullptr;
  const char *role = "track";
  /// Nanoseconds, GST_CLOCK_TIME_NONE where unknown.
  GstClockTime pts = GST_CLOCK_TIME_NONE, duration = GST_CLOCK_TIME_NONE, running_time = GST_CLOCK_TIME_NONE,
               stream_time = GST_CLOCK_TIME_NONE;
  const char *reference_caps = nullptr;  ///< of a GstReferenceTimestampMeta; null: none
  GstClockTime reference_time = GST_CLOCK_TIME_NONE;
  int width = 0, height = 0;                   ///< of the frame if `tracks` is null; 0: unknown
  int pixel_aspect_n = 0, pixel_aspect_d = 0;  ///< from the frame's caps; 0: unknown
};

/// Appends the frame as a JsonLine.
void append_json(std::string &out, const FrameRecord &record);

/// Appends the frame as CsvRows; nothing without features.
void append_csv(std::string &out, const FrameRecord &record);

}  // namespace csd
