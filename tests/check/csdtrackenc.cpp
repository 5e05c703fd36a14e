// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackenc: each form read back by an independent reader, and its behaviour in a pipeline.
#include <gst/video/video.h>

#include "csdtrackenc_harness.h"

using csd_check::assert_text, csd_check::attach, csd_check::frame, csd_check::frame_time, csd_check::Harness,
    csd_check::Json, csd_check::lines_of, csd_check::text, csd_check::tracked_frame, csd_check::video_caps;

namespace {

using Type = simdjson::dom::element_type;

void assert_members(simdjson::dom::object object, const std::vector<std::string> &expected) {
  std::vector<std::string> names;
  for (const auto member : object) names.emplace_back(member.key);
  fail_unless(names == expected);
}

void assert_type(simdjson::dom::object object, const char *member, Type type) {
  fail_unless(object.at_key(member).type() == type, "%s", member);
}

}  // namespace

GST_START_TEST(test_the_line_is_as_documented) {
  Harness harness;
  harness.push(tracked_frame(12));
  GstBuffer *buffer = nullptr;
  const std::string line = harness.pull(&buffer);
  fail_unless_equals_string(
      line.c_str(),
      "{\"schema\":1,\"source\":\"csdtrack0\",\"role\":\"track\",\"algorithm\":\"csd-2012\",\"frame\":24,"
      "\"pts\":480000000,\"duration\":40000000,\"running_time\":480000000,\"stream_time\":480000000,"
      "\"reference\":null,\"width\":64,\"height\":48,\"pixel_aspect\":[1,1],\"features\":["
      "{\"id\":0,\"x\":31.204,\"y\":0.000,\"state\":\"tracked\",\"confidence\":0.931},"
      "{\"id\":7,\"x\":0.000,\"y\":0.000,\"state\":\"lost\",\"confidence\":0.000,\"fresh\":false}]}\n");
  fail_unless_equals_uint64(GST_BUFFER_PTS(buffer), 12 * frame_time);
  fail_unless_equals_uint64(GST_BUFFER_DURATION(buffer), frame_time);
  gst_buffer_unref(buffer);
  GstCaps *caps = gst_pad_get_current_caps(harness.h->sinkpad);
  fail_unless(gst_structure_has_name(gst_caps_get_structure(caps, 0), "application/x-ndjson"), "the first choice");
  gst_caps_unref(caps);
}
GST_END_TEST;

GST_START_TEST(test_json_fields_and_types) {
  Harness harness("application/x-ndjson");
  harness.push(tracked_frame(1));
  const Json json(harness.pull());
  const simdjson::dom::object o = json.object();
  assert_members(o, {"schema", "source", "role", "algorithm", "frame", "pts", "duration", "running_time", "stream_time",
                     "reference", "width", "height", "pixel_aspect", "features"});
  for (const char *m : {"schema", "frame", "pts", "duration", "running_time", "stream_time", "width", "height"})
    assert_type(o, m, Type::INT64);
  for (const char *m : {"source", "role", "algorithm"}) assert_type(o, m, Type::STRING);
  fail_unless(json["reference"].is_null());
  const auto features = json.features();
  fail_unless_equals_int(features.size(), 2);
  simdjson::dom::object f = features.at(0);
  assert_members(f, {"id", "x", "y", "state", "confidence"});
  assert_type(f, "id", Type::INT64);
  for (const char *m : {"x", "y", "confidence"}) assert_type(f, m, Type::DOUBLE);
  assert_type(f, "state", Type::STRING);
  f = features.at(1);
  assert_members(f, {"id", "x", "y", "state", "confidence", "fresh"});
  assert_type(f, "fresh", Type::BOOL);
}
GST_END_TEST;

GST_START_TEST(test_unknown_values_are_null) {
  Harness harness;
  GstBuffer *bare = frame(0);
  GST_BUFFER_PTS(bare) = GST_BUFFER_DURATION(bare) = GST_CLOCK_TIME_NONE;
  harness.push(bare);
  const Json json(harness.pull());
  for (const char *m : {"source", "algorithm", "frame", "pts", "duration", "running_time", "stream_time", "reference"})
    fail_unless(json[m].is_null(), "%s", m);
  fail_unless_equals_int(std::int64_t(json["width"]), 64);
  fail_unless_equals_int(std::int64_t(json["height"]), 48);
  fail_unless_equals_int(json.features().size(), 0);
}
GST_END_TEST;

GST_START_TEST(test_times_follow_the_segment) {
  Harness harness;
  // From a stream time of 1 s, at double speed, 10 s after the pipeline began.
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.rate = 2;
  segment.start = segment.time = segment.position = GST_SECOND;
  segment.base = 10 * GST_SECOND;
  segment.time = 3 * GST_SECOND;
  fail_unless(gst_harness_push_event(harness.h, gst_event_new_segment(&segment)));
  GstBuffer *buffer = tracked_frame(0);
  GST_BUFFER_PTS(buffer) = 2 * GST_SECOND;
  harness.push(buffer);
  const Json json(harness.pull());
  fail_unless_equals_uint64(std::int64_t(json["pts"]), 2 * GST_SECOND);
  fail_unless_equals_uint64(std::int64_t(json["running_time"]), 10500 * GST_MSECOND);
  fail_unless_equals_uint64(std::int64_t(json["stream_time"]), 4 * GST_SECOND);
}
GST_END_TEST;

GST_START_TEST(test_reference_timestamp) {
  Harness harness;
  GstBuffer *buffer = tracked_frame(0);
  GstCaps *caps = gst_caps_from_string("timestamp/x-ntp, clock=(string)\"a \\\"b\\\"\"");
  gst_buffer_add_reference_timestamp_meta(buffer, caps, G_GUINT64_CONSTANT(3900000000000000001), GST_CLOCK_TIME_NONE);
  harness.push(buffer);
  const Json json(harness.pull());
  const simdjson::dom::object reference = json["reference"];
  assert_members(reference, {"caps", "ns"});
  GstCaps *back = gst_caps_from_string(text(reference["caps"]));
  fail_unless(back && gst_caps_is_equal(back, caps));
  fail_unless_equals_uint64(std::uint64_t(reference["ns"]), G_GUINT64_CONSTANT(3900000000000000001));
  gst_caps_unref(back);
  gst_caps_unref(caps);
}
GST_END_TEST;

GST_START_TEST(test_names_are_escaped) {
  Harness harness;
  for (const char *name : {"a\"b\\c\n\x01", "größe 追跡"}) {
    harness.push(tracked_frame(0, name));
    const std::string line = harness.pull();
    fail_unless_equals_int(lines_of(line).size(), 1);
    const Json json(line);
    fail_unless_equals_string(text(json["source"]), name);
  }
}
GST_END_TEST;

GST_START_TEST(test_role) {
  Harness harness;
  GstBuffer *both = tracked_frame(0, "tracker");
  attach(both, "simulator", 3, 64, 48, 5.5, 6.25, GST_CSD_TRUTH_META_NAME);
  harness.push(gst_buffer_ref(both));
  Json json(harness.pull());
  fail_unless_equals_string(text(json["role"]), "track");
  fail_unless_equals_string(text(json["source"]), "tracker");

  gst_util_set_object_arg(G_OBJECT(harness.h->element), "role", "truth");
  harness.push(both);
  json = Json(harness.pull());
  fail_unless_equals_string(text(json["role"]), "truth");
  fail_unless_equals_string(text(json["source"]), "simulator");
  fail_unless_equals_int(std::int64_t(json["frame"]), 3);
  const auto feature = json.features().at(0);
  fail_unless_equals_float(double(feature["x"]), 5.5);
  fail_unless_equals_float(double(feature["y"]), 6.25);

  harness.push(tracked_frame(1, "tracker"));  // without truth
  json = Json(harness.pull());
  fail_unless_equals_string(text(json["role"]), "truth");
  fail_unless(json["frame"].is_null());
}
GST_END_TEST;

GST_START_TEST(test_source) {
  const auto written = [](const char *source) {
    Harness harness;
    if (source) g_object_set(harness.h->element, "source", source, nullptr);
    GstBuffer *buffer = tracked_frame(0, "first");
    attach(buffer, "second", 9, 64, 48, 5, 5);
    attach(buffer, "truth", 9, 64, 48, 5, 5, GST_CSD_TRUTH_META_NAME);
    harness.push(buffer);
    const Json json(harness.pull());
    if (json["source"].is_null()) return std::string("none");
    return std::string(text(json["source"]));
  };
  assert_text(written(nullptr), "second");
  assert_text(written("first"), "first");
  assert_text(written("second"), "second");
  assert_text(written("third"), "none");
}
GST_END_TEST;

GST_START_TEST(test_text_has_a_duration_and_no_newline) {
  Harness harness("text/x-raw,format=utf8");
  GstBuffer *in = tracked_frame(0), *out = nullptr;
  GST_BUFFER_DURATION(in) = GST_CLOCK_TIME_NONE;
  harness.push(in);
  const std::string line = harness.pull(&out);
  fail_unless(line.back() == '}');
  fail_unless(Json(line)["duration"].is_null(), "the line still says that the frame had none");
  fail_unless_equals_uint64(GST_BUFFER_DURATION(out), frame_time);
  gst_buffer_unref(out);
}
GST_END_TEST;

GST_START_TEST(test_accepts_any_memory_and_passes_events) {
  Harness harness(nullptr, "video/x-raw(memory:Whatever),format=Unheard,width=64,height=48,framerate=0/1");
  fail_unless_equals_int(harness.push(frame(0)), GST_FLOW_OK);
  Json{harness.pull()};
  gst_harness_push_event(harness.h, gst_event_new_gap(frame_time, frame_time));
  bool gap = false;
  std::string id;
  while (GstEvent *event = gst_harness_try_pull_event(harness.h)) {
    gap |= GST_EVENT_TYPE(event) == GST_EVENT_GAP;
    if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START) {
      const gchar *stream_id = nullptr;
      gst_event_parse_stream_start(event, &stream_id);
      id = stream_id;
    }
    gst_event_unref(event);
  }
  fail_unless(gap);
  fail_unless(g_str_has_suffix(id.c_str(), "/csdtracks"), "%s", id.c_str());
  GstCaps *caps = gst_caps_from_string(video_caps);
  GstQuery *query = gst_query_new_allocation(caps, FALSE);
  fail_unless(gst_pad_peer_query(harness.h->srcpad, query));
  fail_unless(gst_query_find_allocation_meta(query, g_type_from_name("GstVideoMetaAPI"), nullptr));
  gst_query_unref(query);
  gst_caps_unref(caps);
}
GST_END_TEST;

GST_START_TEST(test_qos_ends_here_and_other_events_pass) {
  Harness harness;
  harness.push(frame(0));
  harness.pull();
  gst_harness_push_upstream_event(harness.h, gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 2., GST_SECOND, GST_SECOND));
  gst_harness_push_upstream_event(harness.h, gst_event_new_latency(GST_SECOND));
  bool qos = false, latency = false;
  while (GstEvent *event = gst_harness_try_pull_upstream_event(harness.h)) {
    qos |= GST_EVENT_TYPE(event) == GST_EVENT_QOS;
    latency |= GST_EVENT_TYPE(event) == GST_EVENT_LATENCY;
    gst_event_unref(event);
  }
  fail_unless(latency && !qos);
}
GST_END_TEST;

GST_START_TEST(test_caps_without_a_common_format_are_an_error) {
  GstHarness *h = gst_harness_new_with_padnames("csdtrackenc", "sink", nullptr);
  GstElement *sink = gst_element_factory_make("capsfilter", nullptr);
  GstCaps *caps = gst_caps_from_string("audio/x-raw");
  g_object_set(sink, "caps", caps, nullptr);
  gst_caps_unref(caps);
  GstPad *src = gst_element_get_static_pad(h->element, "src"), *peer = gst_element_get_static_pad(sink, "sink");
  fail_unless_equals_int(gst_pad_link_full(src, peer, GST_PAD_LINK_CHECK_NOTHING), GST_PAD_LINK_OK);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(h->element, bus);
  gst_element_set_state(sink, GST_STATE_PLAYING);
  gst_harness_play(h);
  gst_harness_set_src_caps_str(h, video_caps);
  fail_unless_equals_int(gst_harness_push(h, frame(0)), GST_FLOW_NOT_NEGOTIATED);
  GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
  GError *error = nullptr;
  fail_unless(message != nullptr);
  gst_message_parse_error(message, &error, nullptr);
  fail_unless(g_error_matches(error, GST_CORE_ERROR, GST_CORE_ERROR_NEGOTIATION));
  fail_unless(strstr(error->message, "application/x-ndjson") != nullptr);
  g_error_free(error);
  gst_message_unref(message);
  gst_bus_set_flushing(bus, TRUE);  // its messages hold references to the element
  gst_element_set_state(sink, GST_STATE_NULL);
  gst_harness_teardown(h);
  gst_object_unref(src);
  gst_object_unref(peer);
  gst_object_unref(sink);
  gst_object_unref(bus);
}
GST_END_TEST;

GST_START_TEST(a_crop_rectangle_added_later_moves_the_tracks) {
  Harness h("application/x-ndjson");
  const struct {
    guint frame_width, crop_width;  // of a frame tracked as 64×48
    int width;                      // as written
    double x;                       // of feature 0, at 31.2044
    unsigned features;
  } cases[] = {{64, 50, 50, 31.204 - 10, 2}, {64, 64, 64, 31.204, 2}, {80, 64, 64, 31.204, 2}, {80, 50, 64, 0, 0}};
  for (const auto &c : cases) {
    GstBuffer *buffer = tracked_frame(0);
    gst_buffer_add_video_meta(buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, c.frame_width, 48);
    GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(buffer);
    crop->x = c.crop_width == 50 ? 10 : 0;
    crop->width = c.crop_width;
    crop->height = 48;
    fail_unless_equals_int(h.push(buffer), GST_FLOW_OK);
    const Json line(h.pull());
    const auto features = line.features();
    fail_unless_equals_int(std::int64_t(line["width"]), c.width);
    fail_unless_equals_int(features.size(), c.features);
    if (c.features) fail_unless(ABS(double(features.at(0)["x"]) - c.x) < 0.0011);
  }
}
GST_END_TEST

/// The stream tags since the last call: each stream's title, language, codec, and "|".
static std::string stream_tags(Harness &harness) {
  std::string out;
  while (GstEvent *event = gst_harness_try_pull_event(harness.h)) {
    GstTagList *tags = nullptr;
    if (GST_EVENT_TYPE(event) == GST_EVENT_TAG) gst_event_parse_tag(event, &tags);
    if (tags && gst_tag_list_get_scope(tags) == GST_TAG_SCOPE_STREAM) {
      for (const char *tag : {GST_TAG_TITLE, GST_TAG_LANGUAGE_CODE, GST_TAG_LANGUAGE_NAME, GST_TAG_VIDEO_CODEC})
        if (const gchar *value = nullptr; gst_tag_list_peek_string_index(tags, tag, 0, &value))
          out += value + std::string(" ");
      out += "|";
    }
    gst_event_unref(event);
  }
  return out;
}

GST_START_TEST(the_track_is_tagged_once_a_stream) {
  Harness harness;
  for (guint64 i = 0; i < 2; ++i) fail_unless_equals_int(harness.push(tracked_frame(i)), GST_FLOW_OK);
  fail_unless(stream_tags(harness) == "csdtrack zxx |");
  // Another stream. The third one has its own tags.
  gst_harness_push_event(harness.h, gst_event_new_stream_start("another"));
  fail_unless_equals_int(harness.push(tracked_frame(2)), GST_FLOW_OK);
  fail_unless(stream_tags(harness) == "csdtrack zxx |");
  gst_harness_push_event(harness.h, gst_event_new_stream_start("a third"));
  GstTagList *tags = gst_tag_list_new(GST_TAG_TITLE, "Video", GST_TAG_LANGUAGE_CODE, "de", GST_TAG_LANGUAGE_NAME,
                                      "Deutsch", GST_TAG_VIDEO_CODEC, "H.264", nullptr);
  gst_tag_list_set_scope(tags, GST_TAG_SCOPE_STREAM);
  gst_harness_push_event(harness.h, gst_event_new_tag(tags));
  fail_unless_equals_int(harness.push(tracked_frame(3)), GST_FLOW_OK);
  fail_unless(stream_tags(harness) == "csdtrack zxx |");
}
GST_END_TEST

static Suite *csdtrackenc_suite() {
  Suite *s = suite_create("csdtrackenc");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, test_the_line_is_as_documented);
  tcase_add_test(tc, test_json_fields_and_types);
  tcase_add_test(tc, test_unknown_values_are_null);
  tcase_add_test(tc, test_times_follow_the_segment);
  tcase_add_test(tc, test_reference_timestamp);
  tcase_add_test(tc, test_names_are_escaped);
  tcase_add_test(tc, test_role);
  tcase_add_test(tc, test_source);
  tcase_add_test(tc, test_text_has_a_duration_and_no_newline);
  tcase_add_test(tc, test_accepts_any_memory_and_passes_events);
  tcase_add_test(tc, test_qos_ends_here_and_other_events_pass);
  tcase_add_test(tc, test_caps_without_a_common_format_are_an_error);
  tcase_add_test(tc, the_track_is_tagged_once_a_stream);
  tcase_add_test(tc, a_crop_rectangle_added_later_moves_the_tracks);
  return s;
}

GST_CHECK_MAIN(csdtrackenc)
