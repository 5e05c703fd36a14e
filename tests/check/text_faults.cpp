// SPDX-License-Identifier: LGPL-2.1-or-later
// Each allocation of csdtrackenc and csdtrackdec fails once, one after the other; then all from one on. Either they
// work as usual, or the stream ends with one error. A line is never half written, and a frame never has another frame's
// tracks. The elements are linked in, as in csdtrack_faults.cpp.
//
// CSDTRACK_FAULTS=N plants about N faults of each kind (10), evenly spread (0: all of them).
#include "planting.h"  // first: its OpenCV must precede check.h

#include <algorithm>
#include <string>

#include "csdtrackdec_harness.h"
#include "elements/csdtrackdec.h"
#include "elements/csdtrackenc.h"

using csd_check::attach, csd_check::frame_at, csd_check::gray_64, csd_check::number_on;

namespace {

constexpr int frames = 6;

struct Outcome {
  std::string text;  ///< the written text, or the frames' numbers
  int errors = 0;
  std::string said;  ///< by the last error
};

GstBusSyncReply only_errors(GstBus *, GstMessage *message, gpointer) {
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) return GST_BUS_PASS;
  gst_message_unref(message);
  return GST_BUS_DROP;
}

/// From READY to the end of the stream. Only the element's own work may fail.
template <class Say>
Outcome live(GType type, const char *property, const std::string &value, Say say) {
  auto *element = GST_ELEMENT(g_object_new(type, property, value.c_str(), nullptr));
  gst_object_ref_sink(element);
  if (type == GST_TYPE_CSD_TRACK_DEC) gst_util_set_object_arg(G_OBJECT(element), "overlay", "draw");
  GstBus *bus = gst_bus_new();
  gst_bus_set_sync_handler(bus, only_errors, nullptr, nullptr);
  gst_element_set_bus(element, bus);
  gst_element_set_state(element, GST_STATE_READY);
  Outcome outcome;
  counting = true;
  const bool started = gst_element_set_state(element, GST_STATE_PAUSED) != GST_STATE_CHANGE_FAILURE;
  counting = false;
  if (started) {
    GstHarness *h = gst_harness_new_with_element(element, "sink", "src");
    counting = true;
    gst_harness_set_src_caps_str(h, gray_64);
    counting = false;
    for (int n = 0; n < frames; ++n) {
      GstBuffer *frame = frame_at(static_cast<GstClockTime>(n) * csd_check::frame_time);
      if (type == GST_TYPE_CSD_TRACK_ENC)
        attach(frame, "a tracker with a name that fits no small string", static_cast<guint64>(n), 64, 48, n, 20);
      counting = true;
      const GstFlowReturn flow = gst_harness_push(h, frame);
      // csdtrackdec handles the frame in a thread of its own.
      while (flow == GST_FLOW_OK && gst_harness_buffers_in_queue(h) <= static_cast<guint>(n) &&
             !gst_bus_have_pending(bus))
        g_usleep(100);
      counting = false;
      if (flow != GST_FLOW_OK) break;
    }
    counting = true;
    gst_harness_push_event(h, gst_event_new_eos());
    counting = false;
    while (GstBuffer *buffer = gst_harness_try_pull(h)) {
      outcome.text += say(buffer);
      gst_buffer_unref(buffer);
    }
    gst_element_set_bus(element, nullptr);
    gst_harness_teardown(h);
  }
  gst_element_set_bus(element, nullptr);
  gst_element_set_state(element, GST_STATE_NULL);
  while (GstMessage *message = gst_bus_pop(bus)) {
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
      g_autoptr(GError) error = nullptr;
      gst_message_parse_error(message, &error, nullptr);
      outcome.said = error->message;
      ++outcome.errors;
    }
    gst_message_unref(message);
  }
  gst_object_unref(bus);
  gst_object_unref(element);
  return outcome;
}

Outcome encode() {
  return live(GST_TYPE_CSD_TRACK_ENC, "source", "a tracker with a name that fits no small string", [](GstBuffer *text) {
    GstMapInfo map;
    gst_buffer_map(text, &map, GST_MAP_READ);
    std::string line(reinterpret_cast<char *>(map.data), map.size);
    gst_buffer_unmap(text, &map);
    return line;
  });
}

Outcome decode() {
  static const std::string path = csd_check::write_file("tracks.jsonl", csd_check::lines(0, frames));
  return live(GST_TYPE_CSD_TRACK_DEC, "location", path,
              [](GstBuffer *frame) { return std::to_string(number_on(frame)) + "\n"; });
}

void plant(const char *name, Outcome (*life)(), bool last) {
  std::string whole;
  const auto fine = [&](const Outcome &outcome) {
    whole = outcome.text;
    fail_unless(outcome.errors == 0 && std::count(whole.begin(), whole.end(), '\n') == frames, "%s: %s", name,
                whole.c_str());
  };
  const auto look = [&](long n, const Outcome &outcome) {
    fail_unless(outcome.errors <= 1, "%s: %d errors for fault %ld", name, outcome.errors, n);
    fail_unless(outcome.errors == 1 ? whole.starts_with(outcome.text) : outcome.text == whole,
                "%s: fault %ld, %d errors, came to\n%s", name, n, outcome.errors, outcome.text.c_str());
    fail_unless(outcome.text.empty() || outcome.text.ends_with('\n'), "%s: fault %ld left a torn line", name, n);
    fail_unless(outcome.errors == 0 || outcome.said.find("memory") != std::string::npos,
                "%s: fault %ld is reported as \"%s\"", name, n, outcome.said.c_str());
    return outcome.errors > 0;
  };
  plant_each(name, operator_new, last, life, fine, look);
}

}  // namespace

GST_START_TEST(a_single_allocation_fails) {
  plant("csdtrackenc", encode, false);
  plant("csdtrackdec", decode, false);
}
GST_END_TEST

GST_START_TEST(all_allocations_fail_from_one_on) {
  plant("csdtrackenc", encode, true);
  plant("csdtrackdec", decode, true);
}
GST_END_TEST

static Suite *text_faults_suite() {
  gst_element_register_csdtrackdec(nullptr);
  Suite *suite = suite_create("text_faults");
  TCase *tcase = tcase_create("general");
  tcase_set_timeout(tcase, 0);  // meson's applies
  suite_add_tcase(suite, tcase);
  tcase_add_test(tcase, a_single_allocation_fails);
  tcase_add_test(tcase, all_allocations_fail_from_one_on);
  return suite;
}

GST_CHECK_MAIN(text_faults)
