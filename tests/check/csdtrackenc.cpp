// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackenc: each form read back by a reader that isn't ours, and how it behaves in a pipeline.
#include <glib/gstdio.h>
#include <gst/check/gstharness.h>
#include <json-glib/json-glib.h>
#include <signal.h>
#include <sys/wait.h>

#include <clocale>
#include <memory>
#include <sstream>

#include "attach.h"

// Last, for it defines a macro `fail`.
#include <gst/check/gstcheck.h>

using csd_check::attach;

namespace {

constexpr char video_caps[] = "video/x-raw,format=I420,width=64,height=48,framerate=25/1";
constexpr GstClockTime frame_time = 40 * GST_MSECOND;
constexpr char csv_head[] = "frame,pts,stream_time,id,x,y,state,confidence,fresh\n";

struct Harness {
  GstHarness *h = gst_harness_new("csdtrackenc");
  explicit Harness(const char *out = nullptr, const char *in = video_caps) {
    if (out) gst_harness_set_sink_caps_str(h, out);
    gst_harness_set_src_caps_str(h, in);
  }
  ~Harness() { gst_harness_teardown(h); }
  GstFlowReturn push(GstBuffer *frame) { return gst_harness_push(h, frame); }
  std::string pull(GstBuffer **kept = nullptr) {
    GstBuffer *buffer = gst_harness_pull(h);
    gpointer data = nullptr;
    gsize size = 0;
    gst_buffer_extract_dup(buffer, 0, -1, &data, &size);
    std::string text(static_cast<char *>(data), size);
    g_free(data);
    if (kept)
      *kept = buffer;
    else
      gst_buffer_unref(buffer);
    return text;
  }
};

GstBuffer *frame(guint64 n) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, 64 * 48 * 3 / 2, nullptr);
  GST_BUFFER_PTS(buffer) = n * frame_time;
  GST_BUFFER_DURATION(buffer) = frame_time;
  return buffer;
}

GstBuffer *tracked_frame(guint64 n, const char *source = "csdtrack0") {
  GstBuffer *buffer = frame(n);
  attach(buffer, source, n + 12, 64, 48, 31.2044, -0.0001);
  return buffer;
}

using Json = std::unique_ptr<JsonNode, decltype(&json_node_unref)>;

Json parse(const std::string &line) {
  GError *error = nullptr;
  JsonNode *node = json_from_string(line.c_str(), &error);
  fail_unless(node && !error, "%s: %s", line.c_str(), error ? error->message : "");
  fail_unless(JSON_NODE_HOLDS_OBJECT(node));
  return Json(node, json_node_unref);
}

JsonObject *object(const Json &json) {
  return json_node_get_object(json.get());
}

void assert_members(JsonObject *o, std::vector<std::string> expected) {
  GList *names = json_object_get_members(o);
  fail_unless_equals_int(g_list_length(names), expected.size());
  GList *name = names;
  for (const std::string &e : expected) {
    fail_unless_equals_string(static_cast<char *>(name->data), e.c_str());
    name = name->next;
  }
  g_list_free(names);
}

void assert_type(JsonObject *o, const char *member, GType type) {
  JsonNode *node = json_object_get_member(o, member);
  fail_unless(node && JSON_NODE_HOLDS_VALUE(node) && json_node_get_value_type(node) == type, "%s", member);
}

/// fail_unless_equals_string() keeps the pointer only, so a temporary would be gone.
void assert_text(const std::string &text, const std::string &expected) {
  fail_unless_equals_string(text.c_str(), expected.c_str());
}

std::string temporary(const char *name) {
  static std::string dir;
  if (dir.empty()) dir = g_dir_make_tmp("csdtrackenc-XXXXXX", nullptr);
  return dir + "/" + name;
}

std::string read_file(const std::string &path) {
  gchar *data = nullptr;
  gsize size = 0;
  fail_unless(g_file_get_contents(path.c_str(), &data, &size, nullptr), "%s", path.c_str());
  std::string text(data, size);
  g_free(data);
  g_remove(path.c_str());
  return text;
}

std::vector<std::string> lines_of(const std::string &text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Frames 0…n−1, all but the second with tracks, to `tail`.
GstElement *tracked_pipeline(int n, const std::string &tail) {
  GstElement *pipeline = csd_check::launch("videotestsrc num-buffers=" + std::to_string(n) + " ! " + video_caps +
                                           " ! identity name=in ! " + tail);
  csd_check::probe(pipeline, "in", "src", [](GstBuffer *b, unsigned i) {
    if (i != 1) attach(b, "csdtrack0", i, 64, 48, 1.5 * i, 2);
  });
  return pipeline;
}

void play_to_end(GstElement *pipeline) {
  GError *error = csd_check::play(pipeline);
  fail_unless(error == nullptr, "%s", error ? error->message : "");
}

bool have(const char *factory) {
  GstElementFactory *f = gst_element_factory_find(factory);
  if (f) gst_object_unref(f);
  if (!f) g_printerr("SKIP: there is no %s here\n", factory);
  return f != nullptr;
}

}  // namespace

GST_START_TEST(test_line_is_the_documented_one) {
  Harness harness;
  harness.push(tracked_frame(12));
  GstBuffer *buffer = nullptr;
  const std::string line = harness.pull(&buffer);
  fail_unless_equals_string(
      line.c_str(),
      "{\"schema\":1,\"source\":\"csdtrack0\",\"role\":\"track\",\"algorithm\":\"csd-2012\",\"frame\":24,"
      "\"pts\":480000000,\"duration\":40000000,\"running_time\":480000000,\"stream_time\":480000000,"
      "\"reference\":null,\"width\":64,\"height\":48,\"features\":["
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
  const Json json = parse(harness.pull());
  JsonObject *o = object(json);
  assert_members(o, {"schema", "source", "role", "algorithm", "frame", "pts", "duration", "running_time", "stream_time",
                     "reference", "width", "height", "features"});
  for (const char *m : {"schema", "frame", "pts", "duration", "running_time", "stream_time", "width", "height"})
    assert_type(o, m, G_TYPE_INT64);
  for (const char *m : {"source", "role", "algorithm"}) assert_type(o, m, G_TYPE_STRING);
  fail_unless(json_object_get_null_member(o, "reference"));
  JsonArray *features = json_object_get_array_member(o, "features");
  fail_unless_equals_int(json_array_get_length(features), 2);
  JsonObject *f = json_array_get_object_element(features, 0);
  assert_members(f, {"id", "x", "y", "state", "confidence"});
  assert_type(f, "id", G_TYPE_INT64);
  for (const char *m : {"x", "y", "confidence"}) assert_type(f, m, G_TYPE_DOUBLE);
  assert_type(f, "state", G_TYPE_STRING);
  f = json_array_get_object_element(features, 1);
  assert_members(f, {"id", "x", "y", "state", "confidence", "fresh"});
  assert_type(f, "fresh", G_TYPE_BOOLEAN);
}
GST_END_TEST;

GST_START_TEST(test_unknown_is_null) {
  Harness harness;
  GstBuffer *bare = frame(0);
  GST_BUFFER_PTS(bare) = GST_BUFFER_DURATION(bare) = GST_CLOCK_TIME_NONE;
  harness.push(bare);
  const Json json = parse(harness.pull());
  for (const char *m : {"source", "algorithm", "frame", "pts", "duration", "running_time", "stream_time", "reference"})
    fail_unless(json_object_get_null_member(object(json), m), "%s", m);
  fail_unless_equals_int(json_object_get_int_member(object(json), "width"), 64);
  fail_unless_equals_int(json_object_get_int_member(object(json), "height"), 48);
  fail_unless_equals_int(json_array_get_length(json_object_get_array_member(object(json), "features")), 0);
}
GST_END_TEST;

GST_START_TEST(test_times_follow_the_segment) {
  Harness harness;
  // From 1 s of the stream, at double speed, 10 s after the pipeline began.
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
  const Json json = parse(harness.pull());
  fail_unless_equals_uint64(json_object_get_int_member(object(json), "pts"), 2 * GST_SECOND);
  fail_unless_equals_uint64(json_object_get_int_member(object(json), "running_time"), 10500 * GST_MSECOND);
  fail_unless_equals_uint64(json_object_get_int_member(object(json), "stream_time"), 4 * GST_SECOND);
}
GST_END_TEST;

GST_START_TEST(test_reference_timestamp) {
  Harness harness;
  GstBuffer *buffer = tracked_frame(0);
  GstCaps *caps = gst_caps_from_string("timestamp/x-ntp, clock=(string)\"a \\\"b\\\"\"");
  gst_buffer_add_reference_timestamp_meta(buffer, caps, G_GUINT64_CONSTANT(3900000000000000001), GST_CLOCK_TIME_NONE);
  harness.push(buffer);
  const Json json = parse(harness.pull());
  JsonObject *reference = json_object_get_object_member(object(json), "reference");
  assert_members(reference, {"caps", "ns"});
  GstCaps *back = gst_caps_from_string(json_object_get_string_member(reference, "caps"));
  fail_unless(back && gst_caps_is_equal(back, caps));
  fail_unless_equals_uint64(json_object_get_int_member(reference, "ns"), G_GUINT64_CONSTANT(3900000000000000001));
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
    const Json json = parse(line);
    fail_unless_equals_string(json_object_get_string_member(object(json), "source"), name);
  }
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
    const Json json = parse(harness.pull());
    if (json_object_get_null_member(object(json), "source")) return std::string("none");
    return std::string(json_object_get_string_member(object(json), "source"));
  };
  assert_text(written(nullptr), "second");
  assert_text(written("first"), "first");
  assert_text(written("second"), "second");
  assert_text(written("third"), "none");
}
GST_END_TEST;

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
  harness.push(frame(4));
  GstBuffer *empty = nullptr;
  harness.pull(&empty);
  fail_unless_equals_int(gst_buffer_get_size(empty), 0);
  fail_unless_equals_uint64(GST_BUFFER_PTS(empty), 4 * frame_time);
  gst_buffer_unref(empty);

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
  assert_text(harness.pull(), "");
  assert_text(harness.pull(), "");
}
GST_END_TEST;

GST_START_TEST(test_text_has_a_duration_and_no_newline) {
  Harness harness("text/x-raw,format=utf8");
  GstBuffer *in = tracked_frame(0), *out = nullptr;
  GST_BUFFER_DURATION(in) = GST_CLOCK_TIME_NONE;
  harness.push(in);
  const std::string line = harness.pull(&out);
  fail_unless(line.back() == '}');
  fail_unless(json_object_get_null_member(object(parse(line)), "duration"), "that the frame had none is still said");
  fail_unless_equals_uint64(GST_BUFFER_DURATION(out), frame_time);
  gst_buffer_unref(out);
}
GST_END_TEST;

GST_START_TEST(test_any_memory_and_events) {
  Harness harness(nullptr, "video/x-raw(memory:Whatever),format=Unheard,width=64,height=48,framerate=0/1");
  fail_unless_equals_int(harness.push(frame(0)), GST_FLOW_OK);
  parse(harness.pull());
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

GST_START_TEST(test_file_has_a_line_per_frame) {
  const std::string path = temporary("t.jsonl");
  play_to_end(
      tracked_pipeline(50, "tee name=t ! queue ! fakesink t. ! queue ! csdtrackenc ! filesink location=" + path));
  const std::vector<std::string> lines = lines_of(read_file(path));
  fail_unless_equals_int(lines.size(), 50);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json json = parse(lines[i]);
    fail_unless_equals_uint64(json_object_get_int_member(object(json), "pts"), i * frame_time);
    JsonArray *features = json_object_get_array_member(object(json), "features");
    fail_unless_equals_int(json_array_get_length(features), i == 1 ? 0 : 2);
    if (i != 1)
      fail_unless(json_object_get_double_member(json_array_get_object_element(features, 0), "x") == 1.5 * double(i));
  }
}
GST_END_TEST;

GST_START_TEST(test_csv_in_german_by_python) {
  const char *old = setlocale(LC_ALL, "de_DE.UTF-8");
  if (!old) {
    g_printerr("SKIP: the locale de_DE.UTF-8 is not installed; in C instead\n");
  } else {
    fail_unless_equals_string(localeconv()->decimal_point, ",");
  }
  const std::string path = temporary("t.csv");
  play_to_end(tracked_pipeline(4, "csdtrackenc ! text/csv ! filesink location=" + path));
  Harness harness;
  harness.push(tracked_frame(12));
  const std::string line = harness.pull();
  setlocale(LC_ALL, "C");
  fail_unless(line.find("\"x\":31.204,") != std::string::npos, "%s", line.c_str());

  const std::string command =
      "/usr/bin/python3 " + std::string(g_getenv("CSDTRACK_CHECK_DIR")) + "/read_csv.py " + path;
  gchar *out = nullptr, *err = nullptr;
  gint status = 1;
  fail_unless(g_spawn_command_line_sync(command.c_str(), &out, &err, &status, nullptr) && status == 0, "%s", err);
  fail_unless_equals_string(out,
                            "0 0 0 0 0.0 2.0 tracked 0.931 true 9\n"
                            "0 0 0 7 0.0 0.0 lost 0.0 false 9\n"
                            "2 80000000 80000000 0 3.0 2.0 tracked 0.931 true 9\n"
                            "2 80000000 80000000 7 0.0 0.0 lost 0.0 false 9\n"
                            "3 120000000 120000000 0 4.5 2.0 tracked 0.931 true 9\n"
                            "3 120000000 120000000 7 0.0 0.0 lost 0.0 false 9\n");
  g_free(out);
  g_free(err);
  read_file(path);
}
GST_END_TEST;

GST_START_TEST(test_travels_in_matroska) {
  if (!have("matroskamux") || !have("x264enc") || !have("h264parse")) return;
  const std::string path = temporary("t.mkv");
  play_to_end(tracked_pipeline(
      60, "tee name=t matroskamux name=m ! filesink location=" + path +
              " t. ! queue ! x264enc ! h264parse ! m. t. ! queue max-size-time=5000000000 max-size-buffers=0 "
              "max-size-bytes=0 ! csdtrackenc ! m.subtitle_0"));
  std::vector<std::string> lines;
  std::vector<GstClockTime> times;
  GstElement *pipeline = csd_check::launch("filesrc location=" + path +
                                           " ! matroskademux name=d d.subtitle_0 ! queue ! fakesink name=out "
                                           "d.video_0 ! queue ! fakesink");
  csd_check::probe(pipeline, "out", "sink", [&](GstBuffer *buffer, unsigned) {
    GstMapInfo map;
    gst_buffer_map(buffer, &map, GST_MAP_READ);
    std::string text(reinterpret_cast<char *>(map.data), map.size);
    gst_buffer_unmap(buffer, &map);
    // matroskademux hands out pango-markup: its escaping is undone here.
    for (const auto &[markup, plain] : {std::pair{"&quot;", "\""}, {"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}})
      for (std::size_t at; (at = text.find(markup)) != std::string::npos;) text.replace(at, strlen(markup), plain);
    lines.push_back(text.c_str());
    times.push_back(GST_BUFFER_PTS(buffer));
  });
  play_to_end(pipeline);
  g_remove(path.c_str());
  fail_unless_equals_int(lines.size(), 60);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json json = parse(lines[i]);
    fail_unless_equals_uint64(json_object_get_int_member(object(json), "pts"), i * frame_time);
    fail_unless_equals_uint64(times[i], i * frame_time);
    JsonArray *features = json_object_get_array_member(object(json), "features");
    fail_unless_equals_int(json_array_get_length(features), i == 1 ? 0 : 2);
  }
}
GST_END_TEST;

GST_START_TEST(test_full_disk) {
  GError *error =
      csd_check::play(tracked_pipeline(100, "csdtrackenc ! filesink buffer-mode=unbuffered location=/dev/full"));
  fail_unless(g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NO_SPACE_LEFT));
  g_error_free(error);
}
GST_END_TEST;

GST_START_TEST(test_nothing_in_common_is_an_error) {
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
  gst_element_set_state(sink, GST_STATE_NULL);
  gst_harness_teardown(h);
  gst_object_unref(src);
  gst_object_unref(peer);
  gst_object_unref(sink);
  gst_object_unref(bus);
}
GST_END_TEST;

GST_START_TEST(test_killed) {
  const std::string path = temporary("k.jsonl");
  const std::string location = "location=" + path;
  const char *argv[] = {"gst-launch-1.0", "-q",
                        "videotestsrc",   "!",
                        video_caps,       "!",
                        "csdtrackenc",    "!",
                        "filesink",       "buffer-mode=unbuffered",
                        location.c_str(), nullptr};
  GPid pid = 0;
  fail_unless(g_spawn_async(nullptr, const_cast<char **>(argv), nullptr,
                            static_cast<GSpawnFlags>(G_SPAWN_SEARCH_PATH | G_SPAWN_DO_NOT_REAP_CHILD), nullptr, nullptr,
                            &pid, nullptr));
  GStatBuf file = {};
  for (int i = 0; i < 1000 && file.st_size < 20000; ++i) {
    g_usleep(10000);
    if (g_stat(path.c_str(), &file) != 0) file.st_size = 0;
  }
  kill(pid, SIGKILL);
  int status = 0;
  waitpid(pid, &status, 0);
  fail_unless(WIFSIGNALED(status));
  std::vector<std::string> lines = lines_of(read_file(path));
  fail_unless(lines.size() > 50, "%u lines", unsigned(lines.size()));
  lines.pop_back();  // it may be torn
  for (std::size_t i = 0; i < lines.size(); ++i)
    fail_unless_equals_uint64(json_object_get_int_member(object(parse(lines[i])), "pts"), i * frame_time);
}
GST_END_TEST;

static Suite *csdtrackenc_suite() {
  Suite *s = suite_create("csdtrackenc");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_test(tc, test_line_is_the_documented_one);
  tcase_add_test(tc, test_json_fields_and_types);
  tcase_add_test(tc, test_unknown_is_null);
  tcase_add_test(tc, test_times_follow_the_segment);
  tcase_add_test(tc, test_reference_timestamp);
  tcase_add_test(tc, test_names_are_escaped);
  tcase_add_test(tc, test_source);
  tcase_add_test(tc, test_csv);
  tcase_add_test(tc, test_csv_header_without_frames_and_after_flush);
  tcase_add_test(tc, test_text_has_a_duration_and_no_newline);
  tcase_add_test(tc, test_any_memory_and_events);
  tcase_add_test(tc, test_file_has_a_line_per_frame);
  tcase_add_test(tc, test_csv_in_german_by_python);
  tcase_add_test(tc, test_travels_in_matroska);
  tcase_add_test(tc, test_full_disk);
  tcase_add_test(tc, test_nothing_in_common_is_an_error);
  tcase_add_test(tc, test_killed);
  return s;
}

GST_CHECK_MAIN(csdtrackenc)
