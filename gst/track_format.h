// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>
#include <gst/video/video.h>

#include <string>
#include <string_view>

namespace csd {

/// What is written of one frame: docs/metadata.md has the schema.
///
/// Numbers have a dot and JSON's form in every locale. x, y and confidence have 3 decimals.
struct FrameRecord {
  const GstStructure *tracks = nullptr;  ///< of a track or truth meta; null: the frame has none
  /// A rectangle that was laid onto the frame after it was tracked; null: none. What is written refers to it.
  const GstVideoCropMeta *crop = nullptr;
  const char *role = "track";
  /// Nanoseconds, GST_CLOCK_TIME_NONE where unknown.
  GstClockTime pts = GST_CLOCK_TIME_NONE, duration = GST_CLOCK_TIME_NONE, running_time = GST_CLOCK_TIME_NONE,
               stream_time = GST_CLOCK_TIME_NONE;
  const char *reference_caps = nullptr;  ///< of a GstReferenceTimestampMeta; null: none
  GstClockTime reference_time = GST_CLOCK_TIME_NONE;
  int width = 0, height = 0;  ///< of the frame where `tracks` is null; 0: unknown
};

/// The column names of append_csv(), with their newline.
inline constexpr std::string_view csv_header = "frame,pts,stream_time,id,x,y,state,confidence,fresh\n";

/// Appends the frame as one JSON object, without a newline. What is unknown is null.
void append_json(std::string &out, const FrameRecord &record);

/// Appends a row for each feature, each with its newline; nothing where there is none. What is unknown is empty.
void append_csv(std::string &out, const FrameRecord &record);

}  // namespace csd
