// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>

#include "record/track_queue.h"

namespace csd {

/// The group of a STREAM_START, 0 where it says none.
guint group_of(GstEvent *event);

/// Tells `queue` what an event of the frames, in `segment`, means for it. `offset`: the lines' of their time.
void handle_frame_event(TrackQueue &queue, GstEvent *event, const GstSegment &segment, std::int64_t offset);

}  // namespace csd
