// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include "text/read_line.h"

namespace csd {

/// Attaches a numbered line's tracks to a frame of caps `info` as a meta, and scales them to its picture. Returns false
/// and changes nothing if they can't fit it: scale_tracks(). Then `element` posts a WARNING, unless it has `warned`. A
/// line that doesn't say the shape of its pixels has the frame's. The buffer must be writable; its memory is not
/// touched.
bool attach_line(GstElement *element, GstBuffer *buffer, const GstVideoInfo &info, TrackLine &line, bool &warned);

}  // namespace csd
