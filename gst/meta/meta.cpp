// SPDX-License-Identifier: LGPL-2.1-or-later
#include "meta/meta.h"

#include <gst/video/video.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>
#include <optional>
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

/// Where a pixel of the input is in the output. The matrix is for points whose 0,0 is the picture's corner, as
/// GStreamer's are; ours is half a pixel further in, because pixel centres are at integers: x' = (x + ½)·s − ½.
struct Map {
  double xx = 1, xy = 0, x0 = 0;
  double yx = 0, yy = 1, y0 = 0;

  static Map scale(double x, double y) { return {.xx = x, .yy = y}; }
  void apply(double &x, double &y) const {
    const double u = x + 0.5, v = y + 0.5;
    x = xx * u + xy * v + x0 - 0.5;
    y = yx * u + yy * v + y0 - 0.5;
  }
};

/// A rectangle between corners.
struct Area {
  double left, top, right, bottom;
  bool contains(double x, double y) const {
    return x + 0.5 >= left && x + 0.5 < right && y + 0.5 >= top && y + 0.5 < bottom;
  }
};

/// True if the whole input fills the whole output. If the display aspects differ, the scaler has either distorted the
/// picture or added borders, and the transform doesn't say which. A difference of less than a row or a column of the
/// output comes from rounding its size: no border fits in there.
bool fills(const GstVideoInfo &in, const GstVideoInfo &out) {
  int in_n, in_d, n, d;
  for (const GstVideoInfo *info : {&in, &out})
    if (info->width <= 0 || info->height <= 0 || info->par_n <= 0 || info->par_d <= 0) return false;
  if (!gst_util_fraction_multiply(in.width, in.height, in.par_n, in.par_d, &in_n, &in_d) ||
      !gst_util_fraction_multiply(in_n, in_d, out.par_d, out.par_n, &n, &d) || n <= 0 || d <= 0)
    return false;
  const auto height = static_cast<int>(gst_util_uint64_scale_int(out.width, d, n));
  const auto width = static_cast<int>(gst_util_uint64_scale_int(out.height, n, d));
  return height <= out.height ? height == out.height : width == out.width;
}

/// What can't be seen in the output isn't claimed there. Truths say `out`, too. Ended and lost features stay as they
/// are.
void leave(GstStructure *feature) {
  const char *state = gst_structure_get_string(feature, "state");
  if (!state || std::strcmp(state, GST_CSD_STATE_ENDED) == 0 || std::strcmp(state, GST_CSD_STATE_LOST) == 0) return;
  GValue out = G_VALUE_INIT;
  g_value_init(&out, G_TYPE_STRING);
  g_value_set_interned_string(&out, g_intern_static_string(GST_CSD_STATE_OUT));
  gst_structure_take_value(feature, "state", &out);
  gst_structure_set(feature, "confidence", G_TYPE_DOUBLE, 0., nullptr);
}

/// A copy of the feature with its position mapped and all other fields kept, unless it leaves `visible`.
GstStructure *mapped_feature(const GstStructure *feature, const Map &map, const Area *visible) {
  double x, y;
  GstStructure *copy = gst_structure_copy(feature);
  if (gst_structure_get_double(copy, "x", &x) && gst_structure_get_double(copy, "y", &y)) {
    map.apply(x, y);
    gst_structure_set(copy, "x", G_TYPE_DOUBLE, x, "y", G_TYPE_DOUBLE, y, nullptr);
    if (visible && !visible->contains(x, y)) leave(copy);
  }
  return copy;
}

void set_mapped_features(GstStructure *to, const GValue *from, const Map &map, const Area *visible) {
  GValue array = G_VALUE_INIT;
  const unsigned n = gst_value_array_get_size(from);
  gst_value_array_init(&array, n);
  for (unsigned i = 0; i < n; ++i) {
    const GValue *item = gst_value_array_get_value(from, i);
    const GstStructure *feature = GST_VALUE_HOLDS_STRUCTURE(item) ? gst_value_get_structure(item) : nullptr;
    if (!feature) continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, GST_TYPE_STRUCTURE);
    g_value_take_boxed(&value, mapped_feature(feature, map, visible));
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

/// The features, if their positions refer to the whole of an input picture; else null.
const GValue *features_in(const GstStructure *from, GstBuffer *buffer, const GstVideoInfo &in) {
  const GValue *features = gst_structure_get_value(from, "features");
  int width, height;
  if (!features || !GST_VALUE_HOLDS_ARRAY(features) || !gst_structure_get_int(from, "width", &width) ||
      !gst_structure_get_int(from, "height", &height))
    return nullptr;
  // x,y refer to a part that doesn't start where the scaler starts reading.
  const GstVideoCropMeta *crop = gst_buffer_get_video_crop_meta(buffer);
  const bool moved = crop && (crop->x != 0 || crop->y != 0);
  return moved || width != in.width || height != in.height ? nullptr : features;
}

/// `visible`: null if the whole of the input is in the output.
gboolean copy_mapped(GstBuffer *to, const GstMetaInfo *info, const GstStructure *from, const GValue *features,
                     const GstVideoInfo &out, const Map &map, const Area *visible) {
  GstStructure *copy = add_copy(to, info, from, false);
  if (!copy) return FALSE;
  gst_structure_set(copy, "width", G_TYPE_INT, out.width, "height", G_TYPE_INT, out.height, nullptr);
  set_mapped_features(copy, features, map, visible);
  return TRUE;
}

gboolean copy_scaled(GstBuffer *to, const GstMetaInfo *info, const GstStructure *from, GstBuffer *buffer,
                     const GstVideoMetaTransform &transform) {
  const GstVideoInfo &in = *transform.in_info, &out = *transform.out_info;
  const GValue *features = features_in(from, buffer, in);
  if (!features || !fills(in, out)) return FALSE;
  const Map map = Map::scale(double(out.width) / in.width, double(out.height) / in.height);
  return copy_mapped(to, info, from, features, out, map, nullptr);
}

#ifdef CSDTRACK_MATRIX
/// The matrix maps within two rectangles; this maps the whole picture. Nothing for a perspective, whose scale differs
/// from place to place.
std::optional<Map> map_of(const GstVideoMetaTransformMatrix &transform) {
  const auto &m = transform.matrix;
  const GstVideoRectangle &from = transform.in_rectangle, &to = transform.out_rectangle;
  const double w = m[2][2];
  if (m[2][0] != 0 || m[2][1] != 0 || w == 0) return std::nullopt;
  Map map{
      .xx = m[0][0] / w, .xy = m[0][1] / w, .x0 = m[0][2] / w, .yx = m[1][0] / w, .yy = m[1][1] / w, .y0 = m[1][2] / w};
  map.x0 += to.x - map.xx * from.x - map.xy * from.y;
  map.y0 += to.y - map.yx * from.x - map.yy * from.y;
  const double all[] = {map.xx, map.xy, map.x0, map.yx, map.yy, map.y0};
  return std::all_of(std::begin(all), std::end(all), [](double d) { return std::isfinite(d); }) ? std::optional(map)
                                                                                                : std::nullopt;
}

/// Whether circles stay circles on the display: `part` of the input is moved, scaled, turned or flipped, but not
/// distorted. Less than a pixel in all comes from rounding its size.
bool keeps_shapes(const Map &map, const GstVideoInfo &in, const GstVideoRectangle &part, const GstVideoInfo &out) {
  if (in.par_n <= 0 || in.par_d <= 0 || out.par_n <= 0 || out.par_d <= 0) return false;
  const double wide = double(in.par_n) / in.par_d, wide_out = double(out.par_n) / out.par_d;
  // Where a step of one line's height goes to, along x and along y.
  const double xx = wide_out * map.xx / wide, yx = map.yx / wide, xy = wide_out * map.xy, yy = map.yy;
  const double x = std::hypot(xx, yx), y = std::hypot(xy, yy);
  const double distortion = std::max(std::abs(x - y), std::abs(xx * xy + yx * yy) / std::max(x, y));
  return x > 0 && y > 0 && distortion * std::max(part.w * wide, double(part.h)) < 1;
}

gboolean copy_by_matrix(GstBuffer *to, const GstMetaInfo *info, const GstStructure *from, GstBuffer *buffer,
                        const GstVideoMetaTransformMatrix &transform) {
  const GstVideoInfo &in = *transform.in_info, &out = *transform.out_info;
  const GValue *features = features_in(from, buffer, in);
  const auto map = map_of(transform);
  if (!features || !map || !keeps_shapes(*map, in, transform.in_rectangle, out)) return FALSE;
  const GstVideoRectangle &r = transform.out_rectangle;
  // Beside the rectangle is a border, or another picture.
  const Area visible{std::max(0., double(r.x)), std::max(0., double(r.y)),
                     std::min(double(out.width), double(r.x) + r.w), std::min(double(out.height), double(r.y) + r.h)};
  return copy_mapped(to, info, from, features, out, *map, &visible);
}
#endif

/// Correct or absent: drops the meta unless the coordinates are known to stay right.
gboolean transform_meta(GstBuffer *to, GstCustomMeta *meta, GstBuffer *buffer, GQuark type, gpointer data, gpointer) {
  const GstMetaInfo *info = GST_META_CAST(meta)->info;
  const GstStructure *from = gst_custom_meta_get_structure(meta);
  // Also for a region of the bytes: parsers and encoders cut off headers that way, which doesn't affect coordinates.
  if (GST_META_TRANSFORM_IS_COPY(type)) return add_copy(to, info, from, true) != nullptr;
  if (GST_VIDEO_META_TRANSFORM_IS_SCALE(type))
    return copy_scaled(to, info, from, buffer, *static_cast<const GstVideoMetaTransform *>(data));
#ifdef CSDTRACK_MATRIX
  if (GST_VIDEO_META_TRANSFORM_IS_MATRIX(type))
    return copy_by_matrix(to, info, from, buffer, *static_cast<const GstVideoMetaTransformMatrix *>(data));
#endif
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
  const Map map = Map::scale(double(width) / tracks.width, double(height) / tracks.height);
  for (Feature &feature : tracks.features) map.apply(feature.x, feature.y);
  tracks.width = width;
  tracks.height = height;
  return true;
}

}  // namespace csd
