// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/formats.h"

#include <algorithm>
#include <string>

namespace csd {

namespace {

#define CSD_VIDEO_FIELDS ", interlace-mode = (string) { progressive, interleaved, mixed }"

/// Those of a list of names that the running GStreamer knows.
std::vector<GstVideoFormat> known(const char *names) {
  std::vector<GstVideoFormat> out;
  gchar **list = g_strsplit(names, ", ", -1);
  for (gchar **name = list; *name; ++name)
    if (const auto format = gst_video_format_from_string(*name); format != GST_VIDEO_FORMAT_UNKNOWN)
      out.push_back(format);
  g_strfreev(list);
  return out;
}

const std::vector<GstVideoFormat> &usual_formats() {
  static const std::vector<GstVideoFormat> formats = known(CSD_USUAL_FORMATS);
  return formats;
}

const std::vector<GstVideoFormat> &native_formats() {
  static const std::vector<GstVideoFormat> formats =
      known(CSD_USUAL_FORMATS ", " CSD_OTHER_FORMATS ", " CSD_NEWER_FORMATS);
  return formats;
}

bool contains(const std::vector<GstVideoFormat> &formats, GstVideoFormat format) {
  return std::find(formats.begin(), formats.end(), format) != formats.end();
}

}  // namespace

bool is_native(GstVideoFormat format) {
  return contains(native_formats(), format);
}

std::vector<GstVideoFormat> pixel_formats() {
  std::vector<GstVideoFormat> out = native_formats();
  guint count = 0;
  const GstVideoFormat *all = gst_video_formats_raw(&count);
  for (guint i = 0; i < count; ++i) {
    const GstVideoFormatInfo *info = gst_video_format_get_info(all[i]);
    // DMA_DRM and ENCODED are no pixels. A format of several lines at once does not exist (1.28).
    if (!is_native(all[i]) && info->unpack_func && info->n_planes > 0 && info->pack_lines == 1) out.push_back(all[i]);
  }
  return out;
}

GstCaps *caps_of(const std::vector<GstVideoFormat> &formats) {
  static constexpr char rest[] = ", width = " GST_VIDEO_SIZE_RANGE ", height = " GST_VIDEO_SIZE_RANGE
                                 ", framerate = " GST_VIDEO_FPS_RANGE CSD_VIDEO_FIELDS;
  static constexpr char composition[] = "(" GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION ")";
  // Features with and without SystemMemory don't intersect, and elements use both spellings.
  static constexpr char system_composition[] =
      "(" GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY ", " GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION ")";
  std::string names[2];
  for (const GstVideoFormat format : formats) {
    std::string &list = names[contains(usual_formats(), format) ? 0 : 1];
    list += (list.empty() ? "" : ", ") + std::string(gst_video_format_to_string(format));
  }
  GstCaps *caps = gst_caps_new_empty();
  for (const char *features : {"", composition, system_composition})
    for (const std::string &list : names) {
      if (list.empty()) continue;
      const std::string text = std::string("video/x-raw") + features + ", format = (string) { " + list + " }" + rest;
      gst_caps_append(caps, gst_caps_from_string(text.c_str()));
    }
  return caps;
}

GstCaps *template_caps() {
  // Each frame's caps are compared with these, and they are not allowed to fail then.
  static GstCaps *const caps = [] {
    GstCaps *all = caps_of(pixel_formats());
    GST_MINI_OBJECT_FLAG_SET(all, GST_MINI_OBJECT_FLAG_MAY_BE_LEAKED);
    return all;
  }();
  return gst_caps_ref(caps);
}

GstCaps *any_memory_caps() {
  // The common formats first: a source that supports all would pick one that nothing else accepts.
  GstCaps *caps = gst_caps_make_writable(template_caps());
  gst_caps_append(caps, gst_caps_from_string("video/x-raw(ANY)" CSD_VIDEO_FIELDS));
  return caps;
}

bool can_map(GstCaps *caps) {
  GstCaps *mappable = template_caps();
  const bool can = gst_caps_can_intersect(caps, mappable);
  gst_caps_unref(mappable);
  return can;
}

bool read_caps(GstCaps *caps, GstVideoInfo &info) {
  if (can_map(caps)) return gst_video_info_from_caps(&info, caps);
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  int width = 0, height = 0;
  if (!gst_structure_get_int(structure, "width", &width) || !gst_structure_get_int(structure, "height", &height) ||
      width < 1 || height < 1)
    return false;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_ENCODED, static_cast<guint>(width), static_cast<guint>(height));
  gst_structure_get_fraction(structure, "framerate", &info.fps_n, &info.fps_d);
  gst_structure_get_fraction(structure, "pixel-aspect-ratio", &info.par_n, &info.par_d);
  return true;
}

GstCaps *complete_caps(GstCaps *caps) {
  GstCaps *complete = gst_caps_copy(caps);
  for (guint i = 0; i < gst_caps_get_size(complete); ++i) {
    GstStructure *structure = gst_caps_get_structure(complete, i);
    if (!gst_structure_has_field(structure, "interlace-mode"))
      gst_structure_set(structure, "interlace-mode", G_TYPE_STRING, "progressive", nullptr);
  }
  return complete;
}

}  // namespace csd
