// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/attach_line.h"

#include <utility>

#include "caps/frame_mapping.h"
#include "meta/meta.h"

namespace csd {

bool attach_line(GstElement *element, GstBuffer *buffer, const GstVideoInfo &info, TrackLine &line, bool &warned) {
  const PictureArea area = picture_area(buffer, info);
  if (area.width < 1 || area.height < 1) return false;
  const int width = line.tracks.width, height = line.tracks.height;
  const PixelAspect video{GST_VIDEO_INFO_PAR_N(&info), GST_VIDEO_INFO_PAR_D(&info)};
  const PixelAspect tracked = line.pixel_aspect_n > 0 ? PixelAspect{line.pixel_aspect_n, line.pixel_aspect_d} : video;
  if (!scale_tracks(line.tracks, tracked, area.width, area.height, video)) {
    if (std::exchange(warned, true)) return false;
    GST_ELEMENT_WARNING(element, STREAM, FORMAT,
                        ("Frames pass without tracks: these are of a picture of %d×%d pixels, and the video, of %d×%d, "
                         "has another aspect. Give csdtrackdec the video that was tracked, or scale it in proportion.",
                         width, height, area.width, area.height),
                        ("borders can't be told from distortion; the pixels' aspects are %d:%d and %d:%d", tracked.n,
                         tracked.d, video.n, video.d));
    return false;
  }
  GstCustomMeta *meta = add_tracks(buffer, line.truth ? GST_CSD_TRUTH_META_NAME : GST_CSD_TRACK_META_NAME, line.tracks,
                                   line.source.c_str(), line.algorithm.c_str());
  if (meta)
    gst_structure_set(gst_custom_meta_get_structure(meta), "tracked-width", G_TYPE_INT, width, "tracked-height",
                      G_TYPE_INT, height, nullptr);
  return true;
}

}  // namespace csd
