// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The metadata through crops, flips, rotations and borders, which GStreamer 1.28 describes by a matrix. meson.build
// takes GStreamer's header, or video_1_28 where that has no matrix.
#include <gst/video/video.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "meta/meta.h"

// Last, since it defines a macro `fail`.
#include <gst/check/gstcheck.h>

namespace {

using Matrix = std::array<std::array<gfloat, 3>, 3>;

struct Transform {
  std::array<int, 2> in, out;  ///< sizes
  GstVideoRectangle in_rectangle, out_rectangle;
  Matrix matrix;
  std::array<int, 2> in_par = {1, 1}, out_par = {1, 1};
};

struct Point {
  double x, y;
  const char *state;
  double confidence;
};

GstVideoInfo info_of(std::array<int, 2> size, std::array<int, 2> par) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_I420, static_cast<guint>(size[0]), static_cast<guint>(size[1]));
  info.par_n = par[0];
  info.par_d = par[1];
  return info;
}

constexpr std::array tracked_size = {640, 480};

/// The meta of a picture of 640×480 with these points, after the transform; nothing if it is dropped. Checks that
/// everything else is kept.
std::optional<std::vector<Point>> through(const Transform &t, const std::vector<Point> &points, bool cropped = false) {
  std::vector<GstCsdFeature> features;
  for (const Point &p : points)
    features.push_back({static_cast<guint>(features.size()), p.x, p.y, p.state, p.confidence, TRUE});
  GstCsdHeader header{};
  header.source = "a";
  header.algorithm = "csd";
  header.width = header.tracked_width = tracked_size[0];
  header.height = header.tracked_height = tracked_size[1];
  header.n_features = static_cast<guint>(features.size());
  GstBuffer *from = gst_buffer_new(), *to = gst_buffer_new();
  fail_unless(gst_buffer_add_csd_tracks(from, GST_CSD_TRACK_META_NAME, &header, features.data()) != nullptr);
  if (cropped) gst_buffer_add_video_crop_meta(from)->x = 2;

  const GstVideoInfo in = info_of(t.in, t.in_par), out = info_of(t.out, t.out_par);
  GstVideoMetaTransformMatrix data{};
  data.in_info = &in;
  data.out_info = &out;
  data.in_rectangle = t.in_rectangle;
  data.out_rectangle = t.out_rectangle;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) data.matrix[i][j] = t.matrix[i][j];
  GstMeta *meta = GST_META_CAST(gst_buffer_get_custom_meta(from, GST_CSD_TRACK_META_NAME));
  const bool copied = meta->info->transform_func(to, meta, from, gst_video_meta_transform_matrix_get_quark(), &data);
  const GstStructure *s = gst_buffer_get_csd_tracks(to, GST_CSD_TRACK_META_NAME, nullptr);
  fail_unless_equals_int(copied, s != nullptr);
  std::optional<std::vector<Point>> result;
  if (s) {
    fail_unless(gst_csd_structure_get_header(s, &header));
    fail_unless(header.width == t.out[0] && header.height == t.out[1]);
    fail_unless(header.tracked_width == tracked_size[0] && header.tracked_height == tracked_size[1]);
    fail_unless_equals_int(header.n_features, features.size());
    result.emplace();
    for (guint i = 0; i < header.n_features; ++i) {
      GstCsdFeature f;
      fail_unless(gst_csd_structure_get_feature(s, i, &f) && f.id == i);
      result->push_back({f.x, f.y, g_intern_string(f.state), f.confidence});
    }
  }
  gst_buffer_unref(from);
  gst_buffer_unref(to);
  return result;
}

/// `expected` by hand.
void expect(const Transform &t, const std::vector<Point> &points, const std::vector<Point> &expected) {
  const auto got = through(t, points);
  fail_unless(got.has_value(), "the meta is dropped");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Point &g = (*got)[i], &e = expected[i];
    fail_unless(std::abs(g.x - e.x) < 1e-4 && std::abs(g.y - e.y) < 1e-4, "point %d is at %f,%f, not %f,%f",
                static_cast<int>(i), g.x, g.y, e.x, e.y);
    fail_unless(std::string(g.state) == e.state && g.confidence == e.confidence, "point %d is %s (%f), not %s",
                static_cast<int>(i), g.state, g.confidence, e.state);
  }
}

constexpr GstVideoRectangle whole = {0, 0, 640, 480};
constexpr Matrix identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
const Point corner = {0, 0, "tracked", 0.9}, far_corner = {639, 479, "learning", 0.8};

}  // namespace

GST_START_TEST(a_crop_moves_points_and_leaves_out_what_it_cuts_off) {
  // From 100,50 on, 320×240 pixels.
  const Transform crop = {tracked_size, {320, 240}, {100, 50, 320, 240}, {0, 0, 320, 240}, identity};
  expect(crop,
         {{110.25, 60.5, "tracked", 0.9},
          {99, 60, "tracked", 0.9},
          {99.75, 60, "learning", 0.75},  // its centre is within the first column
          {419.25, 289, "tracked", 1},
          {419.75, 289, "occluded", 0.3},
          {200, 290, "tracked", 1},
          {10, 10, "lost", 0},
          {10, 10, "ended", 0},
          {150, 70, "out", 0}},
         {{10.25, 10.5, "tracked", 0.9},
          {-1, 10, "out", 0},
          {-0.25, 10, "learning", 0.75},
          {319.25, 239, "tracked", 1},
          {319.75, 239, "out", 0},
          {100, 240, "out", 0},
          {-90, -40, "lost", 0},
          {-90, -40, "ended", 0},
          {50, 20, "out", 0}});
}
GST_END_TEST

GST_START_TEST(flips_and_quarter_turns_keep_pixels_on_pixels) {
  // The first column becomes the last.
  const Transform flip = {tracked_size, {640, 480}, whole, whole, {{{-1, 0, 640}, {0, 1, 0}, {0, 0, 1}}}};
  expect(flip, {corner, far_corner, {100.5, 20, "tracked", 1}},
         {{639, 0, "tracked", 0.9}, {0, 479, "learning", 0.8}, {538.5, 20, "tracked", 1}});
  // Clockwise: the top left pixel becomes the top right one, x' = 480 − y, y' = x.
  const Transform turn = {tracked_size, {480, 640}, whole, {0, 0, 480, 640}, {{{0, -1, 480}, {1, 0, 0}, {0, 0, 1}}}};
  expect(turn, {corner, far_corner, {100, 20, "tracked", 1}},
         {{479, 0, "tracked", 0.9}, {0, 639, "learning", 0.8}, {459, 100, "tracked", 1}});
  // With a pixel aspect, which the turn turns too: of 4:3 to 3:4.
  Transform wide = turn;
  wide.in_par = {4, 3};
  wide.out_par = {3, 4};
  expect(wide, {{100, 20, "tracked", 1}}, {{459, 100, "tracked", 1}});
  wide.out_par = {4, 3};
  fail_if(through(wide, {corner}).has_value());
}
GST_END_TEST

GST_START_TEST(scaling_keeps_centres_and_borders_are_outside) {
  const Transform half = {tracked_size, {320, 240}, whole, {0, 0, 320, 240}, {{{.5, 0, 0}, {0, .5, 0}, {0, 0, 1}}}};
  expect(half, {{10, 20, "tracked", 1}, corner}, {{4.75, 9.75, "tracked", 1}, {-0.25, -0.25, "tracked", 0.9}});
  // Borders of 80 lines above and below. A point that was predicted above the picture would be on one.
  const Transform boxed = {tracked_size, {640, 640}, whole, {0, 80, 640, 480}, identity};
  expect(boxed, {corner, {10, -5, "occluded", 0.4}, {10, 479.5, "tracked", 1}},
         {{0, 80, "tracked", 0.9}, {10, 75, "out", 0}, {10, 559.5, "out", 0}});
  // A third of a picture enlarged, and written as twice the matrix.
  const Transform zoom = {tracked_size, {640, 480}, {320, 240, 320, 240}, whole, {{{4, 0, 0}, {0, 4, 0}, {0, 0, 2}}}};
  expect(zoom, {{420, 300, "tracked", 1}, {319, 300, "tracked", 1}},
         {{200.5, 120.5, "tracked", 1}, {-1.5, 120.5, "out", 0}});
  // A picture in a picture, a part of which lies outside: x from -40, y from 400.
  const Transform placed = {tracked_size, {800, 600}, whole, {-40, 400, 640, 480}, identity};
  expect(placed, {{39, 10, "tracked", 1}, {40, 10, "tracked", 1}, {40, 200, "tracked", 1}},
         {{-1, 410, "out", 0}, {0, 410, "tracked", 1}, {0, 600, "out", 0}});
  // Half as wide, of pixels that are twice as wide: the same on the display.
  Transform pixels = {tracked_size, {320, 480}, whole, {0, 0, 320, 480}, {{{.5, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  pixels.out_par = {2, 1};
  expect(pixels, {{10, 20, "tracked", 1}}, {{4.75, 20, "tracked", 1}});
  // 426.67 columns are 427: less than a pixel of distortion.
  const Transform rounded = {
      tracked_size, {427, 320}, whole, {0, 0, 427, 320}, {{{427 / 640.f, 0, 0}, {0, 320 / 480.f, 0}, {0, 0, 1}}}};
  expect(rounded, {{319.5, 239.5, "tracked", 1}}, {{213, 159.5, "tracked", 1}});
}
GST_END_TEST

GST_START_TEST(what_would_be_wrong_is_dropped) {
  const Transform same = {tracked_size, {640, 480}, whole, whole, identity};
  fail_unless(through(same, {corner}).has_value());
  for (const Matrix &matrix :
       {Matrix{{{1, 0, 0}, {0, 1, 0}, {.001f, 0, 1}}},                                               // perspective
        Matrix{{{1, 0, 0}, {0, 1, 0}, {0, .001f, 1}}}, Matrix{{{.5f, 0, 0}, {0, 1, 0}, {0, 0, 1}}},  // squeezed
        Matrix{{{1, .1f, 0}, {0, 1, 0}, {0, 0, 1}}},                                                 // sheared
        Matrix{{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}},                                                   // singular
        Matrix{{{0, 0, 0}, {0, 0, 0}, {0, 0, 1}}}, Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}},
        Matrix{{{1, 0, NAN}, {0, 1, 0}, {0, 0, 1}}}, Matrix{{{1, 0, 0}, {0, INFINITY, 0}, {0, 0, 1}}}}) {
    Transform wrong = same;
    wrong.matrix = matrix;
    fail_if(through(wrong, {corner}).has_value());
  }
  // The meta is of another picture, or of a rectangle of it.
  Transform other = same;
  other.in = {320, 240};
  fail_if(through(other, {corner}).has_value());
  fail_if(through(same, {corner}, true).has_value());
}
GST_END_TEST

static Suite *csdtrackmeta_transform_suite() {
  csd::register_track_metas();
  Suite *s = suite_create("csdtrackmeta_transform");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, a_crop_moves_points_and_leaves_out_what_it_cuts_off);
  tcase_add_test(tc, flips_and_quarter_turns_keep_pixels_on_pixels);
  tcase_add_test(tc, scaling_keeps_centres_and_borders_are_outside);
  tcase_add_test(tc, what_would_be_wrong_is_dropped);
  return s;
}

GST_CHECK_MAIN(csdtrackmeta_transform)
