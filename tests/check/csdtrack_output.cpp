// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack's output in a harness: messages, metas, overlays, and unchanged pixels.
#include <atomic>
#include <barrier>
#include <thread>

#include "csdtrack_harness.h"

namespace {

GstPadProbeReturn set_overlay_meta(GstPad *, GstPadProbeInfo *info, gpointer track) {
  if (GST_QUERY_TYPE(GST_PAD_PROBE_INFO_QUERY(info)) != GST_QUERY_CAPS) return GST_PAD_PROBE_OK;
  gst_util_set_object_arg(G_OBJECT(track), "overlay", "meta");
  return GST_PAD_PROBE_REMOVE;
}

int warnings(GstBus *bus) {
  int n = 0;
  while (GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_WARNING)) ++n, gst_message_unref(message);
  return n;
}

}  // namespace

GST_START_TEST(a_message_has_four_times_and_is_posted_on_change) {
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120\" training-time=0");
  GstElement *track = element(h);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  for (int i = 0; i < 5; ++i) push(h, picture(320, 240, i));
  GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT);
  fail_unless(message != nullptr);
  const GstStructure *s = gst_message_get_structure(message);
  fail_unless_equals_string(gst_structure_get_name(s), "csdtrack");
  GstCsdHeader header;
  fail_unless(gst_csd_structure_get_header(s, &header));
  fail_unless_equals_uint64(header.frame, 0);
  fail_unless_equals_int(header.width, 320);
  guint64 timestamp, stream_time, running_time, duration;
  fail_unless(gst_structure_get(s, "timestamp", G_TYPE_UINT64, &timestamp, "stream-time", G_TYPE_UINT64, &stream_time,
                                "running-time", G_TYPE_UINT64, &running_time, "duration", G_TYPE_UINT64, &duration,
                                nullptr));
  fail_unless_equals_uint64(timestamp, 0);
  fail_unless_equals_uint64(stream_time, 0);
  fail_unless_equals_uint64(running_time, 0);
  fail_unless_equals_uint64(duration, 40 * GST_MSECOND);
  gst_message_unref(message);
  int more = 0;
  while ((message = gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT))) more++, gst_message_unref(message);
  fail_unless(more <= 1, "%d", more);  // at most learning → tracked; nothing else changes
  // Every frame, but at most one message in 100 ms. With frames 40 ms apart: at 200, 320 and 440 ms.
  g_object_set(track, "post-messages", 2, "message-interval", 100 * GST_MSECOND, nullptr);
  for (int i = 5; i < 12; ++i) push(h, picture(320, 240, i));
  std::string when;
  while ((message = gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT))) {
    gst_structure_get(gst_message_get_structure(message), "running-time", G_TYPE_UINT64, &running_time, nullptr);
    when += std::to_string(running_time / GST_MSECOND) + " ";
    gst_message_unref(message);
  }
  fail_unless_equals_string(when.c_str(), "200 320 440 ");
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(a_change_held_back_by_the_interval_is_posted_at_the_end) {
  for (const bool wanted : {true, false}) {
    GstHarness *h =
        harness("csdtrack algorithm=lk points=\"160,120;96,64\" training-time=0 message-interval=1000000000");
    GstElement *track = element(h);
    GstBus *bus = gst_bus_new();
    gst_element_set_bus(track, bus);
    const auto next = [bus] { return gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT); };
    for (int i = 0; i < 4; ++i) {
      if (i == 3) g_signal_emit_by_name(track, "remove-point", 0u);
      push(h, picture(320, 240, i));
    }
    GstMessage *message = next();
    fail_unless(message != nullptr);  // from the first frame
    gst_message_unref(message);
    fail_unless(next() == nullptr);
    if (!wanted) gst_util_set_object_arg(G_OBJECT(track), "post-messages", "none");
    gst_harness_push_event(h, gst_event_new_eos());
    message = next();
    fail_unless((message != nullptr) == wanted);
    if (wanted) {
      const GstStructure *s = gst_message_get_structure(message);
      GstCsdHeader header;
      GstCsdFeature feature;
      fail_unless(gst_csd_structure_get_header(s, &header));
      fail_unless_equals_uint64(header.frame, 3);
      fail_unless(gst_csd_structure_get_feature(s, 0, &feature));
      fail_unless_equals_string(feature.state, "ended");
      fail_unless(gst_csd_structure_get_feature(s, 1, &feature));
      fail_unless_equals_string(feature.state, "tracked");
      guint64 timestamp = 0;
      fail_unless(gst_structure_get_uint64(s, "timestamp", &timestamp));
      fail_unless_equals_uint64(timestamp, 120 * GST_MSECOND);
      gst_message_unref(message);
    }
    fail_unless(next() == nullptr);
    gst_element_set_bus(track, nullptr);
    gst_object_unref(bus);
    gst_object_unref(track);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

// After the flush, EOS posts nothing, and the first frame doesn't wait for the earlier interval.
GST_START_TEST(a_flush_drops_a_message_held_back_by_the_interval) {
  const bool frames = __i__ == 1;
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120\" training-time=0 message-interval=1000000000");
  GstElement *track = element(h);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  for (int i = 0; i < 3; ++i) {
    if (i == 2) g_signal_emit_by_name(track, "reset");
    push(h, picture(320, 240, i));
  }
  gst_bus_set_flushing(bus, TRUE);  // drops the first frame's message; the third's is held back
  gst_bus_set_flushing(bus, FALSE);
  gst_harness_push_event(h, gst_event_new_flush_start());
  gst_harness_push_event(h, gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(h, gst_event_new_segment(&segment));
  if (frames)
    push(h, picture(320, 240, 0));
  else
    gst_harness_push_event(h, gst_event_new_eos());
  GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT);
  fail_unless((message != nullptr) == frames);
  if (message) {
    GstCsdHeader header;
    fail_unless(gst_csd_structure_get_header(gst_message_get_structure(message), &header));
    fail_unless_equals_uint64(header.frame, 3);
    gst_message_unref(message);
  }
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(the_end_of_a_stream_repeats_no_message) {
  GstHarness *h = harness("csdtrack algorithm=lk points=\"160,120\" training-time=0 message-interval=100000000");
  GstElement *track = element(h);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  for (int i = 0; i < 10; ++i) push(h, picture(320, 240, i));  // what the interval held back is posted by 120 ms
  gst_bus_set_flushing(bus, TRUE);
  gst_bus_set_flushing(bus, FALSE);
  gst_harness_push_event(h, gst_event_new_eos());
  fail_unless(gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT) == nullptr);
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(pixels_behind_a_tee_are_shared_not_copied) {
  for (const bool draw : {false, true}) {
    GstHarness *h = harness(draw ? "csdtrack algorithm=lk overlay=draw" : "csdtrack algorithm=lk");
    for (int i = 0; i < 3; ++i) {
      GstBuffer *in = picture(320, 240, i);
      GstBuffer *before = gst_buffer_copy_deep(in);
      GstBuffer *out = gst_harness_push_and_pull(h, gst_buffer_ref(in));  // shared, as by a tee's other branch
      fail_unless(out != in);                                             // its metas are shared
      fail_unless((gst_buffer_peek_memory(out, 0) == gst_buffer_peek_memory(in, 0)) == !draw);
      fail_unless(gst_buffer_get_csd_tracks(in, GST_CSD_TRACK_META_NAME, nullptr) == nullptr);
      fail_if(states(out).empty());
      GstMapInfo a;
      gst_buffer_map(before, &a, GST_MAP_READ);
      gst_check_buffer_data(in, a.data, a.size);
      if (draw) fail_unless(gst_buffer_memcmp(out, 0, a.data, a.size) != 0);
      gst_buffer_unmap(before, &a);
      gst_buffer_unref(before);
      gst_buffer_unref(in);
      gst_buffer_unref(out);
    }
    gst_harness_teardown(h);
  }
}
GST_END_TEST

GST_START_TEST(overlay_meta_keeps_pixels_and_warns_if_nothing_renders) {
  for (const bool renders : {true, false}) {
    GstHarness *h = gst_harness_new_parse("csdtrack algorithm=lk overlay=meta points=\"160,120\"");
    GstElement *track = element(h);
    GstBus *bus = gst_bus_new();
    gst_element_set_bus(track, bus);
    if (renders) gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    gst_harness_set_src_caps_str(h, gray_320);
    for (int i = 0; i < 3; ++i) {
      GstBuffer *in = picture(320, 240, i);
      GstBuffer *out = gst_harness_push_and_pull(h, gst_buffer_ref(in));
      fail_unless((gst_buffer_get_video_overlay_composition_meta(out) != nullptr) == renders);
      fail_unless(gst_buffer_peek_memory(out, 0) == gst_buffer_peek_memory(in, 0));
      gst_buffer_unref(in);
      gst_buffer_unref(out);
    }
    // Set again, with downstream answering as before: no new warning.
    for (int i = 3; i < 9; ++i) {
      if (i % 2)
        gst_util_set_object_arg(G_OBJECT(track), "overlay", "meta");
      else
        gst_harness_push_upstream_event(h, gst_event_new_reconfigure());
      push(h, picture(320, 240, i));
    }
    fail_unless_equals_int(warnings(bus), renders ? 0 : 1);
    gst_element_set_bus(track, nullptr);
    gst_object_unref(bus);
    gst_object_unref(track);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

GST_START_TEST(overlay_meta_set_during_caps_negotiation) {
  for (const bool renders : {true, false}) {
    GstHarness *h = gst_harness_new_parse("csdtrack algorithm=lk points=\"160,120\"");
    GstElement *track = element(h);
    GstBus *bus = gst_bus_new();
    gst_element_set_bus(track, bus);
    if (renders) gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    gst_harness_set_src_caps_str(h, gray_320);
    std::string attached;
    for (int i = 0; i < 6; ++i) {
      if (i == 2) {
        // By the time downstream gets the query, csdtrack has already offered its caps.
        gst_pad_add_probe(h->sinkpad, GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM, set_overlay_meta, track, nullptr);
        gst_harness_push_upstream_event(h, gst_event_new_reconfigure());
      }
      GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, i));
      attached += gst_buffer_get_video_overlay_composition_meta(out) ? 'x' : '.';
      gst_buffer_unref(out);
      fail_unless_equals_int(warnings(bus), !renders && i == 3 ? 1 : 0);
    }
    fail_unless_equals_string(attached.c_str(), renders ? "...xxx" : "......");
    gst_element_set_bus(track, nullptr);
    gst_object_unref(bus);
    gst_object_unref(track);
    gst_harness_teardown(h);
  }
}
GST_END_TEST

GST_START_TEST(overlay_meta_set_from_another_thread_at_any_time) {
  GstHarness *h = gst_harness_new_parse("csdtrack algorithm=lk points=\"160,120\" post-messages=none");
  GstElement *track = element(h);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
  gst_harness_set_src_caps_str(h, gray_320);
  std::atomic<bool> done = false;
  std::thread other([&] {
    for (int i = 0; !done; ++i) {
      gst_util_set_object_arg(G_OBJECT(track), "overlay", i % 2 ? "none" : "meta");
      g_usleep(static_cast<gulong>(i * 7 % 100));
    }
    gst_util_set_object_arg(G_OBJECT(track), "overlay", "meta");
  });
  for (int i = 0; i < 300; ++i) push(h, picture(320, 240, i));
  done = true;
  other.join();
  push(h, picture(320, 240, 300));
  GstBuffer *out = gst_harness_push_and_pull(h, picture(320, 240, 301));
  fail_unless(gst_buffer_get_video_overlay_composition_meta(out) != nullptr);
  gst_buffer_unref(out);
  fail_unless_equals_int(warnings(bus), 0);
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

// Either thread may win. The negotiated caps must match the final value.
GST_START_TEST(overlay_set_by_two_threads_matches_the_negotiated_caps) {
  GstHarness *h = harness(__i__ ? "csdtrackdec" : "csdtrack algorithm=lk max-features=0 post-messages=none",
                          "video/x-raw,format=GRAY8,width=32,height=32,framerate=25/1");
  GstElement *track = element(h);
  gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
  constexpr int rounds = 300;
  std::barrier turn(3);
  std::atomic<bool> over = false;
  const auto set_in_each_round = [&](int overlay) {
    return std::thread([&turn, &over, track, overlay] {
      for (int i = 0; i < rounds; ++i) {
        turn.arrive_and_wait();
        while (!over) g_object_set(track, "overlay", overlay, nullptr);
        turn.arrive_and_wait();
      }
    });
  };
  constexpr int draw = 1, meta = 2;
  std::thread one = set_in_each_round(draw), other = set_in_each_round(meta);
  int apart = 0;
  for (int i = 0; i < rounds; ++i) {
    over = false;
    turn.arrive_and_wait();
    g_usleep(100);
    over = true;
    turn.arrive_and_wait();
    gst_buffer_unref(gst_harness_push_and_pull(h, picture(32, 32, i)));
    gint value = 0;
    g_object_get(track, "overlay", &value, nullptr);
    GstCaps *caps = gst_pad_get_current_caps(h->sinkpad);
    const bool feature =
        gst_caps_features_contains(gst_caps_get_features(caps, 0), GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION);
    apart += feature != (value == meta);
    gst_caps_unref(caps);
  }
  one.join();
  other.join();
  fail_unless_equals_int(apart, 0);
  gst_object_unref(track);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(other_elements_metas_stay) {
  GstHarness *h = harness("csdtrack algorithm=lk attach-roi=true points=\"160,120;-9,0\" patch-size=21");
  GstBuffer *in = picture(320, 240, 0);
  gst_buffer_add_video_region_of_interest_meta(in, "face", 1, 2, 3, 4);
  GstCaps *caps = gst_caps_new_empty_simple("timestamp/x-unix");
  gst_buffer_add_reference_timestamp_meta(in, caps, 5, GST_CLOCK_TIME_NONE);
  gst_caps_unref(caps);
  GstBuffer *out = gst_harness_push_and_pull(h, in);
  fail_unless(gst_buffer_get_reference_timestamp_meta(out, nullptr) != nullptr);
  fail_unless_equals_int(gst_buffer_get_n_meta(out, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE), 2);
  gpointer iter = nullptr;
  bool ours = false, theirs = false;
  while (GstMeta *meta = gst_buffer_iterate_meta_filtered(out, &iter, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE)) {
    auto *roi = reinterpret_cast<GstVideoRegionOfInterestMeta *>(meta);
    theirs |= roi->roi_type == g_quark_from_string("face") && roi->x == 1 && roi->h == 4;
    if (roi->roi_type != g_quark_from_string("csdtrack")) continue;
    ours = true;  // of 21 pixels around 160,120: from 150,110 to 170,130
    fail_unless(roi->id == 0 && roi->x == 150 && roi->y == 110 && roi->w == 21 && roi->h == 21);
    gdouble x = 0;
    fail_unless(gst_structure_get_double(gst_video_region_of_interest_meta_get_param(roi, "csdtrack"), "x", &x));
    fail_unless_equals_float(x, 160.);
  }
  fail_unless(ours && theirs);
  gst_buffer_unref(out);
  gst_harness_teardown(h);
}
GST_END_TEST

GST_START_TEST(boxes_of_a_crop_rectangle_may_lie_beyond_the_caps_size) {
  // 320×240 pixels from 80,60 on of a decoder's frame of 400×300.
  GstHarness *h = harness("csdtrack algorithm=lk attach-roi=true points=300,220 patch-size=21");
  GstBuffer *in = picture(400, 300, 0);
  gst_buffer_add_video_meta(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 400, 300);
  GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(in);
  crop->x = 80, crop->y = 60, crop->width = 320, crop->height = 240;
  GstBuffer *out = gst_harness_push_and_pull(h, in);
  const GstVideoRegionOfInterestMeta *roi = gst_buffer_get_video_region_of_interest_meta(out);
  fail_unless(roi && roi->x == 370 && roi->y == 270 && roi->w == 21 && roi->h == 21);
  gst_buffer_unref(out);
  gst_harness_teardown(h);
}
GST_END_TEST

static Suite *csdtrack_output_suite() {
  Suite *suite = suite_create("csdtrack_output");
  TCase *tc = tcase_create("output");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, a_message_has_four_times_and_is_posted_on_change);
  tcase_add_test(tc, a_change_held_back_by_the_interval_is_posted_at_the_end);
  tcase_add_loop_test(tc, a_flush_drops_a_message_held_back_by_the_interval, 0, 2);
  tcase_add_test(tc, the_end_of_a_stream_repeats_no_message);
  tcase_add_test(tc, pixels_behind_a_tee_are_shared_not_copied);
  tcase_add_test(tc, overlay_meta_keeps_pixels_and_warns_if_nothing_renders);
  tcase_add_test(tc, overlay_meta_set_during_caps_negotiation);
  tcase_add_test(tc, overlay_meta_set_from_another_thread_at_any_time);
  tcase_add_loop_test(tc, overlay_set_by_two_threads_matches_the_negotiated_caps, 0, 2);
  tcase_add_test(tc, other_elements_metas_stay);
  tcase_add_test(tc, boxes_of_a_crop_rectangle_may_lie_beyond_the_caps_size);
  return suite;
}

GST_CHECK_MAIN(csdtrack_output)
