// SPDX-License-Identifier: LGPL-2.1-or-later
// States, points, and what makes csdtrack forget. csdtrack_properties.cpp tests properties, csdtrack_output.cpp output.
#include "bus.h"
#include "csdtrack_harness.h"

using csd_check::said;

namespace {

using States = std::map<guint, std::string>;

}  // namespace

GST_START_TEST(states_go_up_and_down) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  for (int i = 0; i < 3; ++i)
    for (const GstState state :
         {GST_STATE_READY, GST_STATE_PAUSED, GST_STATE_PLAYING, GST_STATE_PAUSED, GST_STATE_READY, GST_STATE_NULL})
      fail_unless_equals_int(gst_element_set_state(track, state), GST_STATE_CHANGE_SUCCESS);
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(given_points_have_ids_in_order_and_one_outside_is_out) {
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120;96.5,64;-5,10;1e6,1e6\"");
  const auto first = push(h, picture(320, 240, 0));
  fail_unless(first == (States{{0, "learning"}, {1, "learning"}, {2, "out"}, {3, "out"}}) ||
              first == (States{{0, "tracked"}, {1, "tracked"}, {2, "out"}, {3, "out"}}));
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(flush_size_and_stream_reset_tracks_but_framerate_does_not) {
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120\"");
  fail_unless(push(h, picture(320, 240, 0)).count(0) == 1);
  // Another framerate is the same stream.
  gst_harness_set_src_caps_str(h, "video/x-raw,format=GRAY8,width=320,height=240,framerate=30/1");
  const auto same = push(h, picture(320, 240, 1));
  fail_unless(same.size() == 1 && same.count(0) == 1 && same.at(0) != "ended");
  // After a flush the old feature ends. The same pixels begin again with the next id.
  gst_harness_push_event(h, gst_event_new_flush_start());
  gst_harness_push_event(h, gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h, gst_event_new_segment(&segment));
  auto next = push(h, picture(320, 240, 2));
  fail_unless(next.size() == 2 && next.at(0) == "ended" && next.count(1) == 1);
  // Another size.
  gst_harness_set_src_caps_str(h, "video/x-raw,format=GRAY8,width=336,height=240,framerate=30/1");
  next = push(h, picture(336, 240, 3));
  fail_unless(next.size() == 2 && next.at(1) == "ended" && next.count(2) == 1);
  // Another stream; the harness started one of its own.
  gst_harness_push_event(h, gst_event_new_stream_start("another"));
  gst_harness_set_src_caps_str(h, "video/x-raw,format=GRAY8,width=336,height=240,framerate=30/1");
  gst_harness_push_event(h, gst_event_new_segment(&segment));
  next = push(h, picture(336, 240, 4));
  fail_unless(next.size() == 2 && next.at(2) == "ended" && next.count(3) == 1);
  // The signal reset.
  GstElement *track = element(h);
  g_signal_emit_by_name(track, "reset");
  GstBuffer *out = gst_harness_push_and_pull(h, picture(336, 240, 5));
  next = states(out);
  fail_unless(next.size() == 2 && next.at(3) == "ended" && next.count(4) == 1);
  fail_unless_equals_uint64(frame_number(out), 5);
  gst_buffer_unref(out);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(points_are_added_and_removed_during_playback) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  guint id = 7;
  g_signal_emit_by_name(track, "add-point", 10., 10., &id);  // in NULL
  fail_unless_equals_int(id, G_MAXUINT);
  gst_element_set_state(track, GST_STATE_READY);
  g_signal_emit_by_name(track, "add-point", 10., 10., &id);
  fail_unless_equals_int(id, G_MAXUINT);
  g_object_set(track, "max-features", 0, "algorithm", 2, nullptr);
  GstHarness *h = gst_harness_new_with_element(track, "sink", "src");
  gst_harness_play(h);
  gst_harness_set_src_caps_str(h, gray_320);
  fail_unless(push(h, picture(320, 240, 0)).empty());
  g_signal_emit_by_name(track, "add-point", 160., 120., &id);
  fail_unless_equals_int(id, 0);
  guint bad = 0;
  g_signal_emit_by_name(track, "add-point", static_cast<double>(NAN), 120., &bad);
  fail_unless_equals_int(bad, G_MAXUINT);
  fail_unless(push(h, picture(320, 240, 1)).count(0) == 1);
  g_signal_emit_by_name(track, "remove-point", 0u);
  g_signal_emit_by_name(track, "remove-point", 99u);
  fail_unless(push(h, picture(320, 240, 2)) == (States{{0, "ended"}}));
  fail_unless(push(h, picture(320, 240, 3)).empty());
  gst_harness_teardown(h);
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(clicks_add_and_remove_points_if_enabled) {
  GstHarness *h = harness("csdtrack max-features=0 algorithm=lk name=t");
  GstElement *track = element(h);
  int index = 0;
  const auto next = [&] { return push(h, picture(320, 240, index++)); };
  const auto click = [h](int button, double x, double y) {
    GstEvent *event = gst_navigation_event_new_mouse_button_press(button, x, y, GST_NAVIGATION_MODIFIER_NONE);
    gst_harness_push_upstream_event(h, event);
  };
  next();
  click(1, 100, 120);
  fail_unless(next().empty());  // navigation=false
  g_object_set(track, "navigation", TRUE, nullptr);
  click(1, 100, 120);
  click(1, 200, 60);
  click(2, 50, 50);
  const auto two = next();
  fail_unless_equals_int(two.size(), 2);
  click(3, 190, 90);
  const auto one = next();
  fail_if(one.at(0) == "ended");
  fail_unless_equals_string(one.at(1).c_str(), "ended");
  gst_harness_push_upstream_event(h, gst_navigation_event_new_key_press("x", GST_NAVIGATION_MODIFIER_NONE));
  fail_unless_equals_int(next().size(), 1);
  gst_harness_push_upstream_event(h, gst_navigation_event_new_key_press("r", GST_NAVIGATION_MODIFIER_NONE));
  const auto reset = next();
  fail_unless_equals_string(reset.at(0).c_str(), "ended");
  click(3, 190, 90);  // there is no point
  fail_unless(next().empty());
  click(1, NAN, 60);
  fail_unless(next().empty());
  // Elements upstream get the events, too.
  int heard = 0;
  while (GstEvent *event = gst_harness_try_pull_upstream_event(h)) {
    heard += GST_EVENT_TYPE(event) == GST_EVENT_NAVIGATION;
    gst_event_unref(event);
  }
  fail_unless_equals_int(heard, 9);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(a_finger_adds_a_point_where_it_comes_down) {
  GstHarness *h = harness("csdtrack algorithm=lk max-features=0 navigation=true");
  int index = 0;
  const auto next = [&] { return push(h, picture(320, 240, index++)).size(); };
  const auto send = [h](GstEvent *event) { gst_harness_push_upstream_event(h, event); };
  constexpr auto none = GST_NAVIGATION_MODIFIER_NONE;
  next();
  // A finger is moved, which is no second click. Some sinks know the pressure.
  send(gst_navigation_event_new_touch_down(7, 100, 120, NAN, none));
  send(gst_navigation_event_new_touch_frame(none));
  send(gst_navigation_event_new_touch_motion(7, 180, 120, 0.5, none));
  send(gst_navigation_event_new_touch_up(7, 180, 120, none));
  fail_unless_equals_int(next(), 1);
  // GTK says the same twice.
  send(gst_navigation_event_new_touch_down(8, 200, 60, 0.5, none));
  send(gst_navigation_event_new_mouse_button_press(1, 200, 60, none));
  fail_unless_equals_int(next(), 2);
  send(gst_navigation_event_new_mouse_button_release(1, 200, 60, none));
  send(gst_navigation_event_new_touch_up(8, 200, 60, none));
  // Two fingers, and a click elsewhere.
  send(gst_navigation_event_new_touch_down(1, 40, 60, 0.5, none));
  send(gst_navigation_event_new_touch_down(2, 40, 160, 0.5, none));
  send(gst_navigation_event_new_touch_cancel(none));
  fail_unless_equals_int(next(), 4);
  send(gst_navigation_event_new_mouse_button_press(1, 280, 200, none));
  fail_unless_equals_int(next(), 5);
  // Only the first press at a finger's place is the finger's. The third button removes there.
  send(gst_navigation_event_new_mouse_button_press(3, 40, 160, none));
  next();
  fail_unless_equals_int(next(), 4);
  send(gst_navigation_event_new_mouse_button_press(1, 40, 160, none));
  fail_unless_equals_int(next(), 4);
  send(gst_navigation_event_new_mouse_button_press(1, 40, 160, none));
  fail_unless_equals_int(next(), 5);
  send(gst_navigation_event_new_touch_down(3, NAN, 60, 0.5, none));
  fail_unless_equals_int(next(), 5);
  GstElement *track = element(h);
  g_object_set(track, "navigation", FALSE, nullptr);
  gst_object_unref(track);
  send(gst_navigation_event_new_touch_down(4, 140, 160, 0.5, none));
  fail_unless_equals_int(next(), 5);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(no_frame_is_dropped_for_being_late) {
  GstHarness *h = harness("csdtrack algorithm=lk");
  gst_harness_push_upstream_event(h, gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 2., GST_SECOND, GST_SECOND));
  for (int i = 0; i < 10; ++i) push(h, picture(320, 240, i));  // all are earlier than QoS asks for
  GstElement *track = element(h);
  GstStructure *stats = nullptr;
  g_object_get(track, "stats", &stats, nullptr);
  guint64 frames = 0, p50 = 0, p95 = 0, max = 0;
  fail_unless(gst_structure_get(stats, "frames", G_TYPE_UINT64, &frames, "time-p50", G_TYPE_UINT64, &p50, "time-p95",
                                G_TYPE_UINT64, &p95, "time-max", G_TYPE_UINT64, &max, nullptr));
  fail_unless_equals_uint64(frames, 10);
  fail_unless(p50 > 0 && p50 <= p95 && p95 <= max);
  fail_unless(gst_structure_get_string(stats, "simd") != nullptr);
  gst_structure_free(stats);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(features_wait_past_the_budget_and_are_marked) {
  GstHarness *h = harness("csdtrack algorithm=csd frame-budget=1 points=\"80,80;160,120;240,160\"");
  guint waited = 0;
  for (int i = 0; i < 4; ++i) {
    GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
    const GstStructure *s = gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr);
    guint fresh = 0;
    for (guint k = 0; k < 3; ++k) {
      GstCsdFeature f;
      fail_unless(gst_csd_structure_get_feature(s, k, &f));
      ++(f.fresh ? fresh : waited);
    }
    fail_unless_equals_int(fresh, i == 0 ? 3 : 1);  // a nanosecond is enough for one
    gst_buffer_unref(out);
  }
  GstElement *track = element(h);
  GstStructure *stats = nullptr;
  g_object_get(track, "stats", &stats, nullptr);
  guint64 counted = 0;
  fail_unless(gst_structure_get_uint64(stats, "waited", &counted));
  fail_unless_equals_uint64(counted, waited);
  gst_structure_free(stats);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(a_segment_in_bytes_is_accepted) {
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120\"");
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  gst_harness_push_event(h, gst_event_new_segment(&segment));
  fail_unless(push(h, picture(320, 240, 0)).count(0) == 1);  // a CRITICAL ends the test
  gst_harness_teardown(h);
}
GST_END_TEST

namespace {

std::string in_views(const char *mode) {
  return std::string(gray_320) + ",views=2,multiview-mode=" + mode;
}

/// Two views of 320×240, each with a GstVideoMeta. The first has texture, the second is flat.
GstBuffer *separate_views(int index) {
  constexpr gsize bytes = 320 * 240;
  GstBuffer *views = picture(320, 240, index);
  GstMemory *flat = gst_allocator_alloc(nullptr, bytes, nullptr);
  GstMapInfo map;
  gst_memory_map(flat, &map, GST_MAP_WRITE);
  std::memset(map.data, 128, bytes);
  gst_memory_unmap(flat, &map);
  gst_buffer_append_memory(views, flat);
  for (int view = 0; view < 2; ++view) {
    gsize offset[GST_VIDEO_MAX_PLANES] = {static_cast<gsize>(view) * bytes};
    gint stride[GST_VIDEO_MAX_PLANES] = {320};
    gst_buffer_add_video_meta_full(views, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 320, 240, 1, offset,
                                   stride)
        ->id = view;
  }
  return views;
}

}  // namespace

GST_START_TEST(frame_by_frame_views_are_not_tracked_as_one) {
  for (const char *mode : {"frame-by-frame", "multiview-frame-by-frame"}) {
    GstHarness *h = harness("csdtrack points=\"160,120\"", in_views(mode).c_str());
    GstElement *track = element(h);
    GstBus *bus = gst_bus_new();
    gst_element_set_bus(track, bus);
    gst_util_set_object_arg(G_OBJECT(track), "on-error", "pass");
    // A recorder goes on without tracks.
    for (int i = 0; i < 4; ++i)
      for (const auto &[id, state] : push(h, picture(320, 240, i)))
        fail_unless(state != "learning" && state != "tracked", "%s: %u is %s", mode, id, state.c_str());
    fail_unless(said(bus, GST_MESSAGE_WARNING).find("come frame by frame") != std::string::npos);
    fail_unless(said(bus, GST_MESSAGE_WARNING) == "");
    gst_util_set_object_arg(G_OBJECT(track), "on-error", "error");
    fail_unless_equals_int(gst_harness_push(h, picture(320, 240, 4)), GST_FLOW_ERROR);
    fail_unless(said(bus, GST_MESSAGE_ERROR).find("give each view a stream and a csdtrack") != std::string::npos);
    // A stream with one view is tracked.
    gst_harness_set_src_caps_str(h, in_views("left").c_str());
    fail_unless(push(h, picture(320, 240, 5)).at(0) == "learning");
    gst_element_set_bus(track, nullptr);
    gst_object_unref(bus);
    gst_object_unref(track);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

GST_START_TEST(views_in_one_picture_are_tracked_as_one_picture) {
  for (const char *mode : {"mono", "left", "right", "side-by-side", "top-bottom", "row-interleaved"}) {
    GstHarness *h = harness("csdtrack points=\"100,120;260,120\"", in_views(mode).c_str());
    for (int i = 0; i < 3; ++i) {
      // A buffer flag adds nothing to the caps.
      GstBuffer *in = picture(320, 240, i);
      GST_BUFFER_FLAG_SET(in, GST_VIDEO_BUFFER_FLAG_FIRST_IN_BUNDLE | GST_VIDEO_BUFFER_FLAG_MULTIPLE_VIEW);
      const States now = push(h, in);
      fail_unless(now.at(0) == "learning" && now.at(1) == "learning", "%s", mode);
    }
    gst_harness_teardown(h);
  }
}
GST_END_TEST

GST_START_TEST(tracks_the_first_of_separate_views) {
  GstHarness *h = harness("csdtrack", in_views("separated").c_str());
  guint n = 0;
  for (int i = 0; i < 3; ++i) n = static_cast<guint>(push(h, separate_views(i)).size());
  fail_unless(n > 10, "%u features", n);
  gst_harness_teardown(h);
}
GST_END_TEST

static Suite *csdtrack_suite() {
  Suite *suite = suite_create("csdtrack");
  TCase *tc = tcase_create("element");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, states_go_up_and_down);
  tcase_add_test(tc, given_points_have_ids_in_order_and_one_outside_is_out);
  tcase_add_test(tc, flush_size_and_stream_reset_tracks_but_framerate_does_not);
  tcase_add_test(tc, points_are_added_and_removed_during_playback);
  tcase_add_test(tc, clicks_add_and_remove_points_if_enabled);
  tcase_add_test(tc, a_finger_adds_a_point_where_it_comes_down);
  tcase_add_test(tc, no_frame_is_dropped_for_being_late);
  tcase_add_test(tc, features_wait_past_the_budget_and_are_marked);
  tcase_add_test(tc, a_segment_in_bytes_is_accepted);
  tcase_add_test(tc, frame_by_frame_views_are_not_tracked_as_one);
  tcase_add_test(tc, views_in_one_picture_are_tracked_as_one_picture);
  tcase_add_test(tc, tracks_the_first_of_separate_views);
  return suite;
}

GST_CHECK_MAIN(csdtrack)
