// SPDX-License-Identifier: LGPL-2.1-or-later
#include "meta/rois.h"

#include <algorithm>
#include <cmath>

#include "image/work_frame.h"

namespace csd {
namespace {

/// Side of a feature's patch in pixels of the picture. The working image has at most WorkFrame::max_lines.
double patch_side(unsigned asked, int height) {
  if (asked > 0) return asked;
  const int lines = std::min(height, WorkFrame::max_lines);
  return std::round(static_cast<double>(default_patch_size(lines)) * height / lines);
}

}  // namespace

PatchBoxes::PatchBoxes(const GstVideoInfo &info, GstBuffer *buffer, int lines, unsigned patch_size)
    : width_(info.width), height_(info.height), left_(0), top_(0), side_(patch_side(patch_size, lines)) {
  const GstVideoCropMeta *crop = gst_buffer_get_video_crop_meta(buffer);
  if (!crop) return;
  left_ = crop->x;
  top_ = crop->y;
  const GstVideoMeta *meta = gst_buffer_get_video_meta(buffer);
  if (!meta) return;
  width_ = static_cast<int>(meta->width);
  height_ = static_cast<int>(meta->height);
}

std::optional<Box> PatchBoxes::around(double x, double y) const {
  // Pixel i covers i - ½ to i + ½; a box of width w that starts at pixel i ends with pixel i + w - 1.
  const auto begin = [this](double centre) { return std::max(0., std::round(centre - (side_ - 1) / 2)); };
  const auto end = [this](double centre, int limit) {
    return std::min<double>(limit, std::round(centre - (side_ - 1) / 2) + side_);
  };
  const double x0 = begin(left_ + x), x1 = end(left_ + x, width_);
  const double y0 = begin(top_ + y), y1 = end(top_ + y, height_);
  if (x1 <= x0 || y1 <= y0) return std::nullopt;
  return Box{static_cast<int>(x0), static_cast<int>(y0), static_cast<int>(x1 - x0), static_cast<int>(y1 - y0)};
}

std::optional<cv::Point> PatchBoxes::pixel(double x, double y) const {
  const double column = std::round(left_ + x), row = std::round(top_ + y);
  if (column < 0 || column >= width_ || row < 0 || row >= height_) return std::nullopt;
  return cv::Point(static_cast<int>(column), static_cast<int>(row));
}

void attach_rois(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks) {
  for (const auto &f : tracks.features) {
    if (!claims_position(f.state)) continue;
    const auto box = boxes.around(f.x, f.y);
    if (!box) continue;
    auto *roi = gst_buffer_add_video_region_of_interest_meta(buffer, "csdtrack", static_cast<guint>(box->x),
                                                             static_cast<guint>(box->y), static_cast<guint>(box->width),
                                                             static_cast<guint>(box->height));
    roi->id = static_cast<gint>(f.id);
    gst_video_region_of_interest_meta_add_param(
        roi, gst_structure_new("csdtrack", "id", G_TYPE_UINT, f.id, "x", G_TYPE_DOUBLE, f.x, "y", G_TYPE_DOUBLE, f.y,
                               "state", G_TYPE_STRING, state_name(f.state).data(), "confidence", G_TYPE_DOUBLE,
                               f.confidence, nullptr));
  }
}

}  // namespace csd
