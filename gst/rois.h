// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include "track/types.h"

namespace csd {

/// Attaches a GstVideoRegionOfInterestMeta of type `csdtrack` to `buffer` for each feature that claims a position: the
/// square of its patch, clipped to the frame that `info` describes, in whole pixels of that frame. `patch_size` is the
/// setting, in pixels of the picture; 0: the default for its height. `crop` may be null.
void attach_rois(GstBuffer *buffer, const GstVideoInfo &info, const GstVideoCropMeta *crop, const Tracks &tracks,
                 unsigned patch_size);

}  // namespace csd
