// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackenc: CSV, whose frames without features are GAP events, and peers of another form linked in mid-stream.
#include "csdtrackenc_harness.h"

using csd_check::assert_text, csd_check::frame, csd_check::frame_time, csd_check::Harness, csd_check::Json,
    csd_check::text_in, csd_check::tracked_frame, csd_check::video_caps;

namespace {

constexpr char csv_head[] = "frame,pts,stream_time,id,x,y,state,confidence,fresh\n";

/// The GAP events since the last call: `begin+duration;` in ns, "?" for an unknown duration.
std::string gaps(Harness &harness) {
  std::string out;
  while (GstEvent *event = gst_harness_try_pull_event(harness.h)) {
    GstClockTime begin = 0, duration = 0;
    if (GST_EVENT_TYPE(event) == GST_EVENT_GAP) {
      gst_event_parse_gap(event, &begin, &duration);
      out += std::to_string(begin) + "+" + (GST_CLOCK_TIME_IS_VALID(duration) ? std::to_string(duration) : "?") + ";";
    }
    gst_event_unref(event);
  }
  return out;
}

/// A peer of csdtrackenc that takes only `caps`, and writes down what comes: texts of buffers, media types of caps.
struct Peer {
  GstPad *pad;
  std::vector<std::string> seen;
  explicit Peer(const char *caps) {
    GstCaps *taken = gst_caps_from_string(caps);
    GstPadTemplate *of = gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, taken);
    pad = gst_pad_new_from_template(of, "sink");
    gst_object_unref(of);
    gst_caps_unref(taken);
    gst_object_ref_sink(pad);
    g_object_set_data(G_OBJECT(pad), "peer", this);
    gst_pad_set_chain_function(pad, [](GstPad *p, GstObject *, GstBuffer *buffer) {
      of_pad(p)->seen.push_back(text_in(buffer));
      gst_buffer_unref(buffer);
      return GST_FLOW_OK;
    });
    gst_pad_set_event_function(pad, [](GstPad *p, GstObject *, GstEvent *event) -> gboolean {
      if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
        GstCaps *caps = nullptr;
        gst_event_parse_caps(event, &caps);
        of_pad(p)->seen.push_back(gst_structure_get_name(gst_caps_get_structure(caps, 0)));
      }
      if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) of_pad(p)->seen.push_back("EOS");
      gst_event_unref(event);
      return TRUE;
    });
    gst_pad_set_active(pad, TRUE);
  }
  ~Peer() {
    gst_pad_set_active(pad, FALSE);
    gst_object_unref(pad);
  }
  static Peer *of_pad(GstPad *p) { return static_cast<Peer *>(g_object_get_data(G_OBJECT(p), "peer")); }
};

/// csdtrackenc with video coming in, to be linked to one peer after another.
struct Relinked {
  GstHarness *h = gst_harness_new_with_padnames("csdtrackenc", "sink", nullptr);
  GstPad *src = gst_element_get_static_pad(h->element, "src");
  explicit Relinked(Peer &peer) {
    fail_unless_equals_int(gst_pad_link(src, peer.pad), GST_PAD_LINK_OK);
    gst_harness_play(h);
    gst_harness_set_src_caps_str(h, video_caps);
  }
  ~Relinked() {
    gst_object_unref(src);
    gst_harness_teardown(h);
  }
  void push(guint64 n) { fail_unless_equals_int(gst_harness_push(h, tracked_frame(n)), GST_FLOW_OK); }
  void relink(Peer &from, Peer &to) {
    fail_unless(gst_pad_unlink(src, from.pad));
    fail_unless_equals_int(gst_pad_link(src, to.pad), GST_PAD_LINK_OK);
  }
};

}  // namespace

GST_START_TEST(test_csv) {
  Harness harness("text/csv");
  harness.push(tracked_frame(3));
  GstBuffer *header = nullptr;
  assert_text(harness.pull(&header), csv_head);
  fail_unless(GST_BUFFER_FLAG_IS_SET(header, GST_BUFFER_FLAG_HEADER));
  gst_buffer_unref(header);
  assert_text(harness.pull(),
              "15,120000000,120000000,0,31.204,0.000,tracked,0.931,true\n"
              "15,120000000,120000000,7,0.000,0.000,lost,0.000,false\n");

  GstCaps *caps = gst_pad_get_current_caps(harness.h->sinkpad);
  const GValue *headers = gst_structure_get_value(gst_caps_get_structure(caps, 0), "streamheader");
  fail_unless(headers && gst_value_array_get_size(headers) == 1);
  GstBuffer *in_caps = gst_value_get_buffer(gst_value_array_get_value(headers, 0));
  fail_unless_equals_int(gst_buffer_memcmp(in_caps, 0, csv_head, sizeof csv_head - 1), 0);
  fail_unless_equals_int(gst_buffer_get_size(in_caps), sizeof csv_head - 1);
  gst_caps_unref(caps);
}
GST_END_TEST;

GST_START_TEST(test_csv_header_without_frames_and_after_flush) {
  Harness harness("text/csv");
  gst_harness_push_event(harness.h, gst_event_new_flush_start());
  gst_harness_push_event(harness.h, gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(harness.h, gst_event_new_segment(&segment));
  gst_harness_push_event(harness.h, gst_event_new_eos());
  assert_text(harness.pull(), csv_head);
  gst_harness_push_event(harness.h, gst_event_new_flush_start());
  gst_harness_push_event(harness.h, gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(harness.h, gst_event_new_segment(&segment));
  harness.push(frame(0));
  harness.push(frame(1));
  assert_text(harness.pull(), csv_head);
  fail_unless_equals_int(gst_harness_buffers_in_queue(harness.h), 0);
}
GST_END_TEST;

GST_START_TEST(in_csv_a_frame_without_features_is_a_gap) {
  Harness harness("text/csv");
  harness.push(frame(3));
  harness.push(tracked_frame(4));
  GstBuffer *bare = frame(5);
  GST_BUFFER_DURATION(bare) = GST_CLOCK_TIME_NONE;
  harness.push(bare);
  assert_text(harness.pull(), csv_head);
  fail_unless(harness.pull().starts_with("16,160000000,"));
  assert_text(gaps(harness), "120000000+40000000;200000000+?;");

  // Without a time it is nothing at all.
  bare = frame(6);
  GST_BUFFER_PTS(bare) = GST_CLOCK_TIME_NONE;
  fail_unless_equals_int(harness.push(bare), GST_FLOW_OK);
  fail_unless_equals_int(gst_harness_buffers_in_queue(harness.h), 0);
  assert_text(gaps(harness), "");

  // JSON has a line for such a frame, and no GAP.
  Harness json("application/x-ndjson");
  json.push(frame(0));
  fail_unless_equals_int(Json(json.pull()).features().size(), 0);
  assert_text(gaps(json), "");
}
GST_END_TEST

GST_START_TEST(a_discontinuity_in_a_gap_is_flagged_on_the_next_rows) {
  Harness harness("text/csv");
  GstBuffer *jump = frame(3);
  GST_BUFFER_FLAG_SET(jump, GST_BUFFER_FLAG_DISCONT);
  harness.push(tracked_frame(0));
  harness.push(jump);
  for (guint64 n : {4, 5}) harness.push(tracked_frame(n));
  harness.pull();  // the header
  for (const bool discont : {false, true, false}) {
    GstBuffer *rows = nullptr;
    harness.pull(&rows);
    fail_unless_equals_int(GST_BUFFER_FLAG_IS_SET(rows, GST_BUFFER_FLAG_DISCONT), discont);
    gst_buffer_unref(rows);
  }
}
GST_END_TEST

GST_START_TEST(a_gap_that_is_refused_says_why) {
  Harness harness("text/csv");
  fail_unless_equals_int(harness.push(frame(0)), GST_FLOW_OK);
  GstPad *src = gst_element_get_static_pad(harness.h->element, "src");
  gst_pad_set_active(src, FALSE);
  fail_unless_equals_int(harness.push(frame(1)), GST_FLOW_FLUSHING);
  gst_object_unref(src);
}
GST_END_TEST

/// Also where the header doesn't reach the sink, so that it prerolls on a GAP.
GST_START_TEST(a_sink_prerolls_on_frames_without_features) {
  for (const char *between : {"", "! queue ", "! identity drop-buffer-flags=header ! queue "}) {
    GstElement *pipeline = csd_check::launch(std::string("videotestsrc num-buffers=3 ! ") + video_caps +
                                             " ! csdtrackenc ! text/csv " + between + "! fakesink sync=true name=out");
    fail_unless_equals_int(gst_element_set_state(pipeline, GST_STATE_PAUSED), GST_STATE_CHANGE_ASYNC);
    fail_unless_equals_int(gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE),
                           GST_STATE_CHANGE_SUCCESS);
    fail_unless(csd_check::play(pipeline) == nullptr);
  }
}
GST_END_TEST

GST_START_TEST(a_peer_of_another_form_is_negotiated_with) {
  // What a peer gets first after the link: caps, then in CSV the header, then what the frame says.
  const struct {
    const char *caps;
    std::string begin;
  } peers[] = {{"application/x-ndjson", "{\"schema\":1"},
               {"text/csv", csv_head},
               {"text/x-raw,format=utf8", "{\"schema\":1"},
               {"meta/x-klv,parsed=true", "\x06\x0e\x2b\x34"},
               {"text/csv", csv_head}};
  std::vector<std::unique_ptr<Peer>> linked;
  linked.push_back(std::make_unique<Peer>("application/x-ndjson"));
  Relinked enc(*linked.back());
  enc.push(0);
  guint64 n = 1;
  for (const auto &peer : peers) {
    linked.push_back(std::make_unique<Peer>(peer.caps));
    enc.relink(**(linked.end() - 2), *linked.back());
    enc.push(n++);
    const auto &seen = linked.back()->seen;
    fail_unless(seen.size() >= 2, "%s: %u", peer.caps, unsigned(seen.size()));
    assert_text(seen[0], std::string(peer.caps).substr(0, std::string(peer.caps).find(',')));
    fail_unless(seen[1].starts_with(peer.begin), "%s: %s", peer.caps, seen[1].c_str());
  }
}
GST_END_TEST

/// An event takes the sticky caps along to the new peer, so they are chosen before it.
GST_START_TEST(an_event_is_not_sent_after_old_caps) {
  Peer lines("application/x-ndjson"), rows("text/csv");
  Relinked enc(lines);
  enc.push(0);
  enc.relink(lines, rows);
  gst_harness_push_event(enc.h, gst_event_new_gap(frame_time, frame_time));
  gst_harness_push_event(enc.h, gst_event_new_eos());
  fail_unless_equals_int(rows.seen.size(), 3);
  assert_text(rows.seen[0], "text/csv");
  assert_text(rows.seen[1], csv_head);
  assert_text(rows.seen[2], "EOS");
}
GST_END_TEST

static Suite *csdtrackenc_csv_suite() {
  Suite *s = suite_create("csdtrackenc_csv");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, test_csv);
  tcase_add_test(tc, test_csv_header_without_frames_and_after_flush);
  tcase_add_test(tc, in_csv_a_frame_without_features_is_a_gap);
  tcase_add_test(tc, a_discontinuity_in_a_gap_is_flagged_on_the_next_rows);
  tcase_add_test(tc, a_gap_that_is_refused_says_why);
  tcase_add_test(tc, a_sink_prerolls_on_frames_without_features);
  tcase_add_test(tc, a_peer_of_another_form_is_negotiated_with);
  tcase_add_test(tc, an_event_is_not_sent_after_old_caps);
  return s;
}

GST_CHECK_MAIN(csdtrackenc_csv)
