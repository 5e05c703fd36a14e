// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack attach-analytics=true, read back with GstAnalytics' own functions. The element is linked in.
#include "meta/analytics.h"

#include <gst/analytics/analytics.h>
#ifdef CSDTRACK_KEYPOINTS
#include <gst/analytics/gstanalyticskeypointmtd.h>
#endif
#include <malloc.h>

#include <map>
#include <vector>

#include "elements/csdtrack.h"

// After all C++ headers: Check has a macro `fail`.
#include "csdtrack_harness.h"

namespace {

#ifdef CSDTRACK_KEYPOINTS
constexpr int points_each = 1;
#else
constexpr int points_each = 0;
#endif

struct Point {
  gint x = 0, y = 0;
  guint8 visibility = 0;
  gfloat confidence = -1;
};

struct Tracked {
  GstClockTime first, last;
  bool lost;
  int detections = 0;
  gint x = 0, y = 0, w = 0, h = 0;
  gfloat confidence = -1;
  std::vector<Point> points;
};

/// The key points related to the tracking `id`.
std::vector<Point> points_of([[maybe_unused]] GstAnalyticsRelationMeta *meta, [[maybe_unused]] guint id) {
  std::vector<Point> found;
#ifdef CSDTRACK_KEYPOINTS
  gpointer state = nullptr;
  GstAnalyticsMtd point;
  while (gst_analytics_relation_meta_get_direct_related(meta, id, GST_ANALYTICS_REL_TYPE_RELATE_TO,
                                                        gst_analytics_keypoint_mtd_get_mtd_type(), &state, &point)) {
    Point &p = found.emplace_back();
    gint z;
    GstAnalyticsKeypointDimensions dimensions;
    fail_unless(gst_analytics_keypoint_mtd_get_position(&point, &p.x, &p.y, &z, &dimensions));
    fail_unless(dimensions == GST_ANALYTICS_KEYPOINT_DIMENSIONS_2D && z == 0);
    fail_unless(gst_analytics_keypoint_mtd_get_visibility_flags(&point, &p.visibility));
    fail_unless(gst_analytics_keypoint_mtd_get_confidence(&point, &p.confidence));
    fail_unless(gst_analytics_relation_meta_get_relation(meta, point.id, id) == GST_ANALYTICS_REL_TYPE_RELATE_TO);
  }
#endif
  return found;
}

/// The content of the buffer's relation meta, by tracking id.
std::map<guint64, Tracked> read(GstBuffer *buffer) {
  std::map<guint64, Tracked> found;
  GstAnalyticsRelationMeta *meta = gst_buffer_get_analytics_relation_meta(buffer);
  if (!meta) return found;
  gpointer state = nullptr;
  GstAnalyticsMtd tracking;
  while (gst_analytics_relation_meta_iterate(meta, &state, gst_analytics_tracking_mtd_get_mtd_type(), &tracking)) {
    guint64 id;
    gboolean lost;
    Tracked t;
    fail_unless(gst_analytics_tracking_mtd_get_info(&tracking, &id, &t.first, &t.last, &lost));
    t.lost = lost;
    gpointer related = nullptr;
    GstAnalyticsMtd detection;
    while (gst_analytics_relation_meta_get_direct_related(meta, tracking.id, GST_ANALYTICS_REL_TYPE_RELATE_TO,
                                                          gst_analytics_od_mtd_get_mtd_type(), &related, &detection)) {
      ++t.detections;
      fail_unless(gst_analytics_od_mtd_get_obj_type(&detection) == g_quark_from_string("csdtrack"));
      fail_unless(gst_analytics_od_mtd_get_location(&detection, &t.x, &t.y, &t.w, &t.h, &t.confidence));
      fail_unless(gst_analytics_relation_meta_get_relation(meta, detection.id, tracking.id) ==
                  GST_ANALYTICS_REL_TYPE_RELATE_TO);
    }
    t.points = points_of(meta, tracking.id);
    fail_unless(found.emplace(id, t).second, "a duplicate id");
  }
  return found;
}

}  // namespace

GST_START_TEST(each_feature_is_a_tracking_related_to_its_box) {
  // Corners of squares, which lk can follow. The second point's patch reaches beyond the left edge.
  GstHarness *h = harness("csdtrack algorithm=lk attach-analytics=true points=\"160,112;8,96;-9,0\" patch-size=21");
  for (int i = 0; i < 3; ++i) {
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
    const auto found = read(out);
    fail_unless_equals_int(found.size(), 3);
    const Tracked &whole = found.at(0), &clipped = found.at(1), &outside = found.at(2);
    fail_unless_equals_uint64(whole.first, 0);
    fail_unless_equals_uint64(whole.last, i * 40 * GST_MSECOND);
    fail_unless(!whole.lost && whole.detections == 1);
    fail_unless(whole.x == 150 && whole.y == 102 && whole.w == 21 && whole.h == 21);
    fail_unless_equals_float(whole.confidence, 1.f);
    fail_unless(!clipped.lost && clipped.x == 0 && clipped.y == 86 && clipped.w == 19 && clipped.h == 21);
    fail_unless(outside.lost && outside.detections == 0);
    fail_unless_equals_uint64(outside.last, 0);
    fail_unless_equals_int(whole.points.size(), points_each);
    fail_unless_equals_int(clipped.points.size(), points_each);
    fail_unless(outside.points.empty());
    for (const Point &p : whole.points) fail_unless(p.x == 160 && p.y == 112 && p.visibility == 1 && p.confidence == 1);
    gst_buffer_unref(out);
  }
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(a_lost_feature_keeps_the_time_it_was_last_seen) {
  GstHarness *h = harness("csdtrack algorithm=lk attach-analytics=true points=\"160,112;96,96\"");
  GstElement *track = element(h);
  for (int i = 0; i < 4; ++i) {
    if (i == 2) g_signal_emit_by_name(track, "remove-point", 0u);
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
    const auto found = read(out);
    gst_buffer_unref(out);
    fail_unless(!found.at(1).lost);
    fail_unless_equals_uint64(found.at(1).last, i * 40 * GST_MSECOND);
    fail_unless_equals_int(found.count(0), i < 3);
    if (i != 2) continue;
    fail_unless(found.at(0).lost && found.at(0).detections == 0);
    fail_unless_equals_uint64(found.at(0).first, 0);
    fail_unless_equals_uint64(found.at(0).last, 40 * GST_MSECOND);
  }
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(other_elements_metadata_stays) {
  GstHarness *h =
      harness("csdtrack algorithm=lk attach-analytics=true points=\"40,40;80,40;120,40;160,40;200,40;240,40\"");
  GstBuffer *in = picture(320, 240, 0);
  GstAnalyticsODMtd face;
  fail_unless(gst_analytics_relation_meta_add_od_mtd(gst_buffer_add_analytics_relation_meta(in),
                                                     g_quark_from_string("face"), 1, 2, 3, 4, .5f, &face));
  GstBuffer *out = gst_harness_push_and_pull(h, in);
  fail_unless_equals_int(gst_buffer_get_n_meta(out, GST_ANALYTICS_RELATION_META_API_TYPE), 1);
  GstAnalyticsRelationMeta *meta = gst_buffer_get_analytics_relation_meta(out);
  fail_unless_equals_int(gst_analytics_relation_get_length(meta), 1 + 6 * (2 + points_each));
  GstAnalyticsODMtd again;
  fail_unless(gst_analytics_relation_meta_get_od_mtd(meta, face.id, &again));
  fail_unless(gst_analytics_od_mtd_get_obj_type(&again) == g_quark_from_string("face"));
  const auto found = read(out);
  fail_unless_equals_int(found.size(), 6);
  for (const auto &[id, tracked] : found) fail_unless_equals_int(tracked.detections, 1);
  gst_buffer_unref(out);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(nothing_is_attached_without_the_property_or_without_features) {
  for (const char *line : {"csdtrack algorithm=lk points=\"160,120\"", "csdtrack algorithm=lk attach-analytics=true"}) {
    GstHarness *h = harness(line);
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, 0, [](int, int) -> guint8 { return 0; }));
    fail_unless(gst_buffer_get_analytics_relation_meta(out) == nullptr);
    gst_buffer_unref(out);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

/// The relations are a matrix in GStreamer: of 10000 features it would have 400 MB, with key points 900 MB.
GST_START_TEST(memory_does_not_grow_with_the_square_of_the_features) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_GRAY8, 320, 240);
  csd::Tracks tracks;
  for (csd::FeatureId id = 0; id < 10000; ++id)
    tracks.features.push_back({id, id % 320 + 0., id % 240 + 0., csd::FeatureState::tracked, 1, true});
  const auto taken = [] {
    const struct mallinfo2 now = mallinfo2();  // zeros under a sanitizer
    return static_cast<std::ptrdiff_t>(now.uordblks + now.hblkhd);
  };
  csd::Analytics analytics;
  for (const bool others : {false, true}) {
    GstBuffer *buffer = gst_buffer_new();
    const std::ptrdiff_t before = taken();
    if (others) gst_buffer_add_analytics_relation_meta(buffer);  // has room for 5, and grows by 5
    analytics.attach(buffer, csd::PatchBoxes(info, buffer, 240, 21), tracks, 0);
    const std::ptrdiff_t bytes = taken() - before;
    fail_unless(bytes < 32 << 20, "%d MB", int(bytes >> 20));
    const auto found = read(buffer);
    fail_unless_equals_int(found.size(), 1000);
    fail_unless_equals_int(found.rbegin()->first, 999);
    for (const auto &[id, tracked] : found)
      fail_unless(tracked.detections == 1 && tracked.points.size() == points_each);
    gst_buffer_unref(buffer);
  }
}
GST_END_TEST

#ifdef CSDTRACK_KEYPOINTS
GST_START_TEST(a_key_point_is_at_the_features_seen_or_predicted_place) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_GRAY8, 320, 240);
  using enum csd::FeatureState;
  struct Case {
    csd::FeatureState state;
    double x, y;
    std::vector<Point> points;
  };
  constexpr guint8 seen = GST_ANALYTICS_KEYPOINT_VISIBILITY_VISIBLE;
  constexpr guint8 predicted = GST_ANALYTICS_KEYPOINT_VISIBILITY_OCCLUDED | GST_ANALYTICS_KEYPOINT_VISIBILITY_PROJECTED;
  for (const Case &c : {Case{learning, 20.6, 30.4, {{121, 80, seen, .75f}}},
                        {tracked, 20.5, 30.5, {{121, 81, seen, .75f}}},
                        {tracked, 219.4, 189.4, {{319, 239, seen, .75f}}},
                        {occluded, 19.4, -50.4, {{119, 0, predicted, .75f}}},
                        {occluded, -101, 30, {}},
                        {occluded, 219.6, 30, {}},
                        {occluded, 1e300, -1e300, {}},
                        {lost, 20, 30, {}},
                        {out, 20, 30, {}},
                        {ended, 20, 30, {}}}) {
    csd::Tracks tracks;
    csd::Feature &f = tracks.features.emplace_back();
    f.id = 7, f.state = c.state, f.x = c.x, f.y = c.y, f.confidence = .75;
    GstBuffer *buffer = gst_buffer_new();
    GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(buffer);
    crop->x = 100, crop->y = 50, crop->width = 200, crop->height = 150;
    csd::Analytics().attach(buffer, csd::PatchBoxes(info, buffer, 150, 21), tracks, 0);
    const auto found = read(buffer).at(7).points;
    fail_unless_equals_int(found.size(), c.points.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      fail_unless_equals_int(found[i].x, c.points[i].x);
      fail_unless_equals_int(found[i].y, c.points[i].y);
      fail_unless_equals_int(found[i].visibility, c.points[i].visibility);
      fail_unless_equals_float(found[i].confidence, c.points[i].confidence);
    }
    gst_buffer_unref(buffer);
  }
}
GST_END_TEST
#endif

static Suite *csdtrack_analytics_suite() {
  gst_element_register_csdtrack(nullptr);
  Suite *suite = suite_create("csdtrack_analytics");
  TCase *tc = tcase_create("analytics");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, each_feature_is_a_tracking_related_to_its_box);
  tcase_add_test(tc, a_lost_feature_keeps_the_time_it_was_last_seen);
  tcase_add_test(tc, other_elements_metadata_stays);
  tcase_add_test(tc, nothing_is_attached_without_the_property_or_without_features);
  tcase_add_test(tc, memory_does_not_grow_with_the_square_of_the_features);
#ifdef CSDTRACK_KEYPOINTS
  tcase_add_test(tc, a_key_point_is_at_the_features_seen_or_predicted_place);
#endif
  return suite;
}

GST_CHECK_MAIN(csdtrack_analytics)
