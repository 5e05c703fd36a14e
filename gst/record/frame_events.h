// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>

#include "record/track_queue.h"

namespace csd {

/// The group-id of a STREAM_START; 0 without one.
guint group_of(GstEvent *event);

/// Applies an event of the frames, in `segment`, to `queue`. `offset`: the lines' time relative to the frames'.
void handle_frame_event(TrackQueue &queue, GstEvent *event, const GstSegment &segment, std::int64_t offset);

}  // namespace csd
