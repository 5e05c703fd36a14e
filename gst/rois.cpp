// SPDX-License-Identifier: LGPL-2.1-or-later
#include "rois.h"

#include <algorithm>
#include <cmath>

#include "image/work_frame.h"

namespace csd {
namespace {

/// Of a feature's patch, in pixels of the picture; the working image has at most WorkFrame::max_lines.
double patch_side(unsigned asked, int height) {
  if (asked > 0) return asked;
  const int lines = std::min(height, WorkFrame::max_lines);
  return std::round(static_cast<double>(default_patch_size(lines)) * height / lines);
}

}  // namespace

void attach_rois(GstBuffer *buffer, const GstVideoInfo &info, const GstVideoCropMeta *crop, const Tracks &tracks,
                 unsigned patch_size) {
  const double left = crop ? crop->x : 0, top = crop ? crop->y : 0;
  const double side = patch_side(patch_size, tracks.height);
  for (const auto &f : tracks.features) {
    if (f.state != FeatureState::learning && f.state != FeatureState::tracked) continue;
    // Pixel i reaches from i - ½ to i + ½; a region that starts at pixel i, w wide, ends with pixel i + w - 1.
    const auto begin = [side](double centre) { return std::max(0., std::round(centre - (side - 1) / 2)); };
    const auto end = [side](double centre, int limit) {
      return std::min<double>(limit, std::round(centre - (side - 1) / 2) + side);
    };
    const double x0 = begin(left + f.x), x1 = end(left + f.x, info.width);
    const double y0 = begin(top + f.y), y1 = end(top + f.y, info.height);
    if (x1 <= x0 || y1 <= y0) continue;
    auto *roi =
        gst_buffer_add_video_region_of_interest_meta(buffer, "csdtrack", static_cast<guint>(x0), static_cast<guint>(y0),
                                                     static_cast<guint>(x1 - x0), static_cast<guint>(y1 - y0));
    roi->id = static_cast<gint>(f.id);
    gst_video_region_of_interest_meta_add_param(
        roi, gst_structure_new("csdtrack", "id", G_TYPE_UINT, f.id, "x", G_TYPE_DOUBLE, f.x, "y", G_TYPE_DOUBLE, f.y,
                               "state", G_TYPE_STRING, state_name(f.state).data(), "confidence", G_TYPE_DOUBLE,
                               f.confidence, nullptr));
  }
}

}  // namespace csd
