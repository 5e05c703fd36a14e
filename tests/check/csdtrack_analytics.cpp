// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack attach-analytics=true: what GstAnalytics' own functions read of it.
#include <gst/analytics/analytics.h>

#include <map>

#include "csdtrack_harness.h"

namespace {

struct Tracked {
  GstClockTime first, last;
  bool lost;
  int detections = 0;
  gint x = 0, y = 0, w = 0, h = 0;
  gfloat confidence = -1;
};

/// What the buffer's relation meta says, by tracking id.
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
    fail_unless(found.emplace(id, t).second, "an id twice");
  }
  return found;
}

}  // namespace

GST_START_TEST(each_feature_is_a_tracking_related_to_its_box) {
  // Corners of squares, which lk can follow; the second's patch reaches beyond the left edge.
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
    gst_buffer_unref(out);
  }
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(what_is_gone_was_last_seen_when_it_was) {
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

GST_START_TEST(what_others_attached_stays) {
  GstHarness *h =
      harness("csdtrack algorithm=lk attach-analytics=true points=\"40,40;80,40;120,40;160,40;200,40;240,40\"");
  GstBuffer *in = picture(320, 240, 0);
  GstAnalyticsODMtd face;
  fail_unless(gst_analytics_relation_meta_add_od_mtd(gst_buffer_add_analytics_relation_meta(in),
                                                     g_quark_from_string("face"), 1, 2, 3, 4, .5f, &face));
  GstBuffer *out = gst_harness_push_and_pull(h, in);
  fail_unless_equals_int(gst_buffer_get_n_meta(out, GST_ANALYTICS_RELATION_META_API_TYPE), 1);
  GstAnalyticsRelationMeta *meta = gst_buffer_get_analytics_relation_meta(out);
  fail_unless_equals_int(gst_analytics_relation_get_length(meta), 13);
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

GST_START_TEST(none_without_the_property_and_none_without_features) {
  for (const char *line : {"csdtrack algorithm=lk points=\"160,120\"", "csdtrack algorithm=lk attach-analytics=true"}) {
    GstHarness *h = harness(line);
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, 0, [](int, int) -> guint8 { return 0; }));
    fail_unless(gst_buffer_get_analytics_relation_meta(out) == nullptr);
    gst_buffer_unref(out);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

static Suite *csdtrack_analytics_suite() {
  Suite *suite = suite_create("csdtrack_analytics");
  TCase *tc = tcase_create("analytics");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, each_feature_is_a_tracking_related_to_its_box);
  tcase_add_test(tc, what_is_gone_was_last_seen_when_it_was);
  tcase_add_test(tc, what_others_attached_stays);
  tcase_add_test(tc, none_without_the_property_and_none_without_features);
  return suite;
}

GST_CHECK_MAIN(csdtrack_analytics)
