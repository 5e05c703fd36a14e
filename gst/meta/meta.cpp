// SPDX-License-Identifier: LGPL-2.1-or-later
#include "meta/meta.h"

#include <gst/video/video.h>

#include <cstring>
#include <memory>
#include <vector>

namespace csd {
namespace {

// The core knows no header of GStreamer's: the words stand there and in the public header.
static_assert(state_name(FeatureState::learning) == GST_CSD_STATE_LEARNING);
static_assert(state_name(FeatureState::tracked) == GST_CSD_STATE_TRACKED);
static_assert(state_name(FeatureState::occluded) == GST_CSD_STATE_OCCLUDED);
static_assert(state_name(FeatureState::lost) == GST_CSD_STATE_LOST);
static_assert(state_name(FeatureState::out) == GST_CSD_STATE_OUT);
static_assert(state_name(FeatureState::ended) == GST_CSD_STATE_ENDED);

/// How a pixel's coordinates scale with the picture: x' = (x + ½)·s − ½, because pixel centres are at integers.
struct Scale {
  double x, y;
  static double apply(double centre, double scale) { return (centre + 0.5) * scale - 0.5; }
};

/// True if the whole input fills the whole output. If the display aspects differ, the scaler has either distorted the
/// picture or added borders, and the transform doesn't say which. A difference of less than a row or a column of the
/// output comes from rounding its size: no border fits in there.
bool fills(const GstVideoInfo &in, const GstVideoInfo &out) {
  int in_n, in_d, n, d;
  if (in.width <= 0 || in.height <= 0 || out.width <= 0 || out.height <= 0) return false;
  if (!gst_util_fraction_multiply(in.width, in.height, in.par_n, in.par_d, &in_n, &in_d) ||
      !gst_util_fraction_multiply(in_n, in_d, out.par_d, out.par_n, &n, &d) || n <= 0 || d <= 0)
    return false;
  const auto height = static_cast<int>(gst_util_uint64_scale_int(out.width, d, n));
  const auto width = static_cast<int>(gst_util_uint64_scale_int(out.height, n, d));
  return height <= out.height ? height == out.height : width == out.width;
}

/// A copy of the feature with its position scaled and all other fields kept.
GstStructure *scaled_feature(const GstStructure *feature, const Scale &scale) {
  double x, y;
  GstStructure *copy = gst_structure_copy(feature);
  if (gst_structure_get_double(copy, "x", &x) && gst_structure_get_double(copy, "y", &y))
    gst_structure_set(copy, "x", G_TYPE_DOUBLE, Scale::apply(x, scale.x), "y", G_TYPE_DOUBLE, Scale::apply(y, scale.y),
                      nullptr);
  return copy;
}

void set_scaled_features(GstStructure *to, const GValue *from, const Scale &scale) {
  GValue array = G_VALUE_INIT;
  const unsigned n = gst_value_array_get_size(from);
  gst_value_array_init(&array, n);
  for (unsigned i = 0; i < n; ++i) {
    const GValue *feature = gst_value_array_get_value(from, i);
    if (!GST_VALUE_HOLDS_STRUCTURE(feature)) continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, GST_TYPE_STRUCTURE);
    g_value_take_boxed(&value, scaled_feature(gst_value_get_structure(feature), scale));
    gst_value_array_append_and_take_value(&array, &value);
  }
  gst_structure_take_value(to, "features", &array);
}

/// Adds a meta with all the fields of `from`, but features only if `features` is set.
GstStructure *add_copy(GstBuffer *buffer, const GstMetaInfo *info, const GstStructure *from, bool features) {
  GstCustomMeta *meta = gst_buffer_add_custom_meta(buffer, g_type_name(info->type));
  if (!meta) return nullptr;
  GstStructure *to = gst_custom_meta_get_structure(meta);
  for (int i = 0; i < gst_structure_n_fields(from); ++i) {
    const char *field = gst_structure_nth_field_name(from, i);
    if (features || std::strcmp(field, "features") != 0)
      gst_structure_set_value(to, field, gst_structure_get_value(from, field));
  }
  return to;
}

gboolean copy_scaled(GstBuffer *to, const GstMetaInfo *info, const GstStructure *from, GstBuffer *buffer,
                     const GstVideoMetaTransform &transform) {
  const GstVideoInfo &in = *transform.in_info, &out = *transform.out_info;
  const GValue *features = gst_structure_get_value(from, "features");
  int width, height;
  if (!features || !GST_VALUE_HOLDS_ARRAY(features) || !gst_structure_get_int(from, "width", &width) ||
      !gst_structure_get_int(from, "height", &height))
    return FALSE;
  // x,y refer to a part that doesn't start where the scaler starts reading.
  const GstVideoCropMeta *crop = gst_buffer_get_video_crop_meta(buffer);
  const bool moved = crop && (crop->x != 0 || crop->y != 0);
  if (moved || width != in.width || height != in.height || !fills(in, out)) return FALSE;

  GstStructure *copy = add_copy(to, info, from, false);
  if (!copy) return FALSE;
  gst_structure_set(copy, "width", G_TYPE_INT, out.width, "height", G_TYPE_INT, out.height, nullptr);
  set_scaled_features(copy, features, {double(out.width) / in.width, double(out.height) / in.height});
  return TRUE;
}

/// Correct or absent: drops the meta unless the coordinates are known to stay right.
gboolean transform_meta(GstBuffer *to, GstCustomMeta *meta, GstBuffer *buffer, GQuark type, gpointer data, gpointer) {
  const GstMetaInfo *info = GST_META_CAST(meta)->info;
  const GstStructure *from = gst_custom_meta_get_structure(meta);
  // Also for a region of the bytes: parsers and encoders cut off headers that way, which doesn't affect coordinates.
  if (GST_META_TRANSFORM_IS_COPY(type)) return add_copy(to, info, from, true) != nullptr;
  if (GST_VIDEO_META_TRANSFORM_IS_SCALE(type))
    return copy_scaled(to, info, from, buffer, *static_cast<const GstVideoMetaTransform *>(data));
  return FALSE;
}

bool register_once(const char *name) {
  if (gst_meta_get_info(name)) return true;  // registered by another copy of this code in the process
  const char *tags[] = {GST_META_TAG_VIDEO_STR, GST_META_TAG_VIDEO_ORIENTATION_STR, GST_META_TAG_VIDEO_SIZE_STR,
                        nullptr};
  return gst_meta_register_custom(name, tags, transform_meta, nullptr, nullptr) != nullptr;
}

}  // namespace

bool register_track_metas() {
  static const bool registered = register_once(GST_CSD_TRACK_META_NAME) && register_once(GST_CSD_TRUTH_META_NAME);
  return registered;
}

namespace {

/// Does everything that may throw, before there is a structure or meta to leak or to leave incomplete.
std::vector<GstCsdFeature> features_of(const Tracks &tracks) {
  std::vector<GstCsdFeature> features;
  features.reserve(tracks.features.size());
  for (const Feature &f : tracks.features)
    features.push_back({f.id, f.x, f.y, state_name(f.state).data(), f.confidence, f.fresh});
  return features;
}

void set(GstStructure *structure, const std::vector<GstCsdFeature> &features, const Tracks &tracks, const char *source,
         const char *algorithm) {
  GstCsdHeader header{};
  // GstStructure refuses invalid UTF-8, and an element's name may be any bytes.
  const std::unique_ptr<char, decltype(&g_free)> name(g_utf8_make_valid(source, -1), g_free);
  header.source = name.get();
  header.algorithm = algorithm;
  header.frame = tracks.frame;
  header.width = header.tracked_width = tracks.width;
  header.height = header.tracked_height = tracks.height;
  header.n_features = static_cast<guint>(features.size());
  gst_csd_structure_set(structure, &header, features.data());
}

}  // namespace

GstStructure *new_tracks_structure(const char *name, const Tracks &tracks, const char *source, const char *algorithm) {
  const auto features = features_of(tracks);
  GstStructure *structure = gst_structure_new_empty(name);
  set(structure, features, tracks, source, algorithm);
  return structure;
}

GstCustomMeta *add_tracks(GstBuffer *buffer, const char *name, const Tracks &tracks, const char *source,
                          const char *algorithm) {
  if (!gst_meta_get_info(name)) return nullptr;
  const auto features = features_of(tracks);
  GstCustomMeta *meta = gst_buffer_add_custom_meta(buffer, name);
  if (meta) set(gst_custom_meta_get_structure(meta), features, tracks, source, algorithm);
  return meta;
}

GstCustomMeta *add_track_meta(GstBuffer *buffer, const Tracks &tracks, const char *source, const char *algorithm) {
  return add_tracks(buffer, GST_CSD_TRACK_META_NAME, tracks, source, algorithm);
}

GstCustomMeta *add_truth_meta(GstBuffer *buffer, const Tracks &truth, const char *source) {
  return add_tracks(buffer, GST_CSD_TRUTH_META_NAME, truth, source, "truth");
}

std::optional<std::vector<StartPoint>> visible_truth(GstBuffer *buffer, int width, int height) {
  const GstStructure *truth = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRUTH_META_NAME, nullptr);
  GstCsdHeader header;
  if (!truth || !gst_csd_structure_get_header(truth, &header) || header.width != width || header.height != height)
    return std::nullopt;
  std::vector<StartPoint> points;
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature f;
    if (gst_csd_structure_get_feature(truth, i, &f) && std::strcmp(f.state, GST_CSD_STATE_TRACKED) == 0)
      points.push_back({f.id, {f.x, f.y}});
  }
  return points;
}

bool scale_tracks(Tracks &tracks, const PixelAspect &from, int width, int height, const PixelAspect &to) {
  const bool same_shape = from.n == to.n && from.d == to.d;
  if (same_shape && tracks.width == width && tracks.height == height) return true;  // exact, without rounding
  GstVideoInfo in, out;
  gst_video_info_init(&in);
  gst_video_info_init(&out);
  in.width = tracks.width;
  in.height = tracks.height;
  in.par_n = from.n;
  in.par_d = from.d;
  out.width = width;
  out.height = height;
  out.par_n = to.n;
  out.par_d = to.d;
  // Either picture may be a copy of the other.
  if (!fills(in, out) && !fills(out, in)) return false;
  const Scale scale{double(width) / tracks.width, double(height) / tracks.height};
  for (Feature &feature : tracks.features) {
    feature.x = Scale::apply(feature.x, scale.x);
    feature.y = Scale::apply(feature.y, scale.y);
  }
  tracks.width = width;
  tracks.height = height;
  return true;
}

}  // namespace csd
