// SPDX-License-Identifier: LGPL-2.1-or-later
// Each allocation of csdtrack and each start of a thread fails once, one after the other. Every frame must still come
// out unchanged, and tracking must go on. The element is linked in, so that the functions in faults.h replace those
// that its core and OpenCV call. GLib's allocations don't fail, since GLib ends the process then.
//
// CSDTRACK_FAULTS=N plants about N faults of each kind (10), evenly spread (0: all of them).
#include "planting.h"  // first: its OpenCV must precede check.h

#include <cstring>
#include <string>
#include <vector>

#include "csdtrack_harness.h"
#include "elements/csdtrack.h"

namespace {

constexpr int size = 128;
constexpr int frames = 14;  // all but the last may have failing allocations

/// Moves by a pixel a frame, so that there is something to track.
GstBuffer *moving(int index) {
  GstBuffer *buffer = picture(size, size, index);
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      map.data[y * size + x] = static_cast<guint8>((texture(x + index, y) + texture(2 * (x + index), 2 * y)) / 2);
  gst_buffer_unmap(buffer, &map);
  return buffer;
}

struct Outcome {
  bool started = false;
  int warnings = 0, errors = 0;
  std::string said;   ///< by the last of them
  guint claimed = 0;  ///< positions in the last frame, in which nothing fails
};

/// What applications do between frames. None of it changes the tracks.
void talk_to(GstElement *track) {
  GstStructure *stats = nullptr;
  g_object_get(track, "stats", &stats, nullptr);
  if (stats) gst_structure_free(stats);
  guint id = 0;
  g_signal_emit_by_name(track, "add-point", -1e6, 0.0, &id);
  gboolean ended = FALSE;
  g_signal_emit_by_name(track, "remove-point", id, &ended);
  g_object_set(track, "frame-budget", guint64{0}, nullptr);
  gst_element_send_event(track, gst_event_new_navigation(gst_structure_new(
                                    "application/x-gst-navigation", "event", G_TYPE_STRING, "mouse-move", "pointer_x",
                                    G_TYPE_DOUBLE, 5.0, "pointer_y", G_TYPE_DOUBLE, 5.0, nullptr)));
}

/// A whole life of the element. Calls count, and may fail, from the start of the threads to the last frame but one.
Outcome live(const char *algorithm) {
  auto *track =
      GST_ELEMENT(g_object_new(GST_TYPE_CSD_TRACK, "name", "csdtrack", "max-features", 4, "n-threads", 2, nullptr));
  gst_object_ref_sink(track);
  gst_util_set_object_arg(G_OBJECT(track), "algorithm", algorithm);
  gst_util_set_object_arg(G_OBJECT(track), "on-error", "pass");
  gst_util_set_object_arg(G_OBJECT(track), "overlay", "meta");
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  Outcome outcome;
  gst_element_set_state(track, GST_STATE_READY);
  counting = true;
  outcome.started = gst_element_set_state(track, GST_STATE_PAUSED) != GST_STATE_CHANGE_FAILURE;
  if (outcome.started) {
    counting = false;
    GstHarness *h = gst_harness_new_with_element(track, "sink", "src");
    gst_harness_add_propose_allocation_meta(h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    counting = true;
    gst_harness_set_src_caps_str(h, "video/x-raw,format=GRAY8,width=128,height=128,framerate=25/1");
    counting = false;
    for (int i = 0; i < frames; ++i) {
      GstBuffer *in = moving(i), *same = moving(i);
      counting = i + 1 < frames;
      const GstFlowReturn flow = gst_harness_push(h, in);
      if (i == frames / 2) talk_to(track);
      counting = false;
      fail_unless_equals_int(flow, GST_FLOW_OK);
      GstBuffer *out = gst_harness_try_pull(h);
      fail_unless(out != nullptr, "frame %d is missing", i);
      fail_unless_equals_uint64(GST_BUFFER_PTS(out), GST_BUFFER_PTS(same));
      GstMapInfo map;
      gst_buffer_map(same, &map, GST_MAP_READ);
      gst_check_buffer_data(out, map.data, map.size);
      gst_buffer_unmap(same, &map);
      GstCsdHeader header;
      const GstStructure *said = gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr);
      fail_unless(!said || gst_csd_structure_get_header(said, &header), "frame %d has an incomplete meta", i);
      if (i + 1 == frames)
        for (const auto &[id, state] : states(out)) outcome.claimed += state == "tracked" || state == "learning";
      gst_buffer_unref(same);
      gst_buffer_unref(out);
    }
    gst_element_set_bus(track, nullptr);
    gst_harness_teardown(h);
  }
  counting = false;
  gst_element_set_bus(track, nullptr);
  gst_element_set_state(track, GST_STATE_NULL);
  while (GstMessage *message = gst_bus_pop(bus)) {
    const GstMessageType type = GST_MESSAGE_TYPE(message);
    outcome.warnings += type == GST_MESSAGE_WARNING;
    outcome.errors += type == GST_MESSAGE_ERROR;
    if (type == GST_MESSAGE_WARNING || type == GST_MESSAGE_ERROR) {
      g_autoptr(GError) error = nullptr;
      (type == GST_MESSAGE_ERROR ? gst_message_parse_error : gst_message_parse_warning)(message, &error, nullptr);
      outcome.said = error->message;
    }
    gst_message_unref(message);
  }
  gst_object_unref(bus);
  gst_object_unref(track);
  return outcome;
}

void plant(const char *algorithm, Kind kind, bool last) {
  long warned = 0, refused = 0, recovered = 0;
  const auto life = [&] { return live(algorithm); };
  const auto fine = [&](const Outcome &whole) {
    fail_unless(whole.started && whole.claimed == 4 && whole.warnings == 0 && whole.errors == 0,
                "%s: %u claims, %d, %d", algorithm, whole.claimed, whole.warnings, whole.errors);
  };
  const auto look = [&](long n, const Outcome &outcome) {
    fail_unless(outcome.warnings <= 1, "%s: %d warnings for fault %ld", algorithm, outcome.warnings, n);
    // Only a start may fail, with an error; a frame never.
    fail_unless_equals_int(outcome.errors, outcome.started ? 0 : 1);
    fail_unless(kind == thread_start || outcome.said.empty() ||
                    outcome.said.find("Out of memory while tracking") != std::string::npos,
                "%s: fault %ld is reported as \"%s\"", algorithm, n, outcome.said.c_str());
    // lk and csd-2012 never find lost features again, by design.
    fail_unless(!outcome.started || outcome.claimed > 0 || std::strcmp(algorithm, "csd") != 0,
                "nothing is claimed after fault %ld", n);
    warned += outcome.warnings;
    refused += !outcome.started;
    recovered += outcome.claimed > 0;
    return outcome.warnings > 0 || !outcome.started;
  };
  plant_each(algorithm, kind, last, life, fine, look);
  g_print("  of the faults planted: %ld starts refused, %ld warned of, %ld with claims in the end\n", refused, warned,
          recovered);
}

}  // namespace

constexpr const char *algorithms[] = {"csd", "csd-2012", "lk"};

GST_START_TEST(a_single_allocation_fails) {
  plant(algorithms[__i__], operator_new, false);
}
GST_END_TEST

GST_START_TEST(all_allocations_fail_from_one_on) {
  plant(algorithms[__i__], operator_new, true);
}
GST_END_TEST

GST_START_TEST(opencv_allocations_fail) {
  plant(algorithms[__i__], opencv_allocation, false);
}
GST_END_TEST

GST_START_TEST(a_thread_fails_to_start) {
  plant("csd", thread_start, false);
  plant("csd", thread_start, true);
}
GST_END_TEST

static Suite *csdtrack_faults_suite() {
  gst_element_register_csdtrack(nullptr);
  let_opencv_fail();
  Suite *suite = suite_create("csdtrack_faults");
  TCase *tcase = tcase_create("general");
  tcase_set_timeout(tcase, 0);  // meson's applies
  suite_add_tcase(suite, tcase);
  tcase_add_loop_test(tcase, a_single_allocation_fails, 0, G_N_ELEMENTS(algorithms));
  tcase_add_loop_test(tcase, all_allocations_fail_from_one_on, 0, G_N_ELEMENTS(algorithms));
  tcase_add_loop_test(tcase, opencv_allocations_fail, 0, G_N_ELEMENTS(algorithms));
  tcase_add_test(tcase, a_thread_fails_to_start);
  return suite;
}

GST_CHECK_MAIN(csdtrack_faults)
