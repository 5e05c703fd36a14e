// SPDX-License-Identifier: LGPL-2.1-or-later
// Each allocation of csdsimsrc fails once, one after the other; then all from one on. Either all frames come out, or
// the stream ends with an error that says why. Once there is memory again, the same element makes the scene. The
// element is linked in, as in csdtrack_faults.cpp.
//
// CSDTRACK_FAULTS=N plants about N faults of each kind (10), evenly spread (0: all of them).
#include "planting.h"  // first: its OpenCV must precede check.h

#include <string>

#include "elements/csdsimsrc.h"
#include "meta/csdtrackmeta.h"

namespace {

constexpr int frames = 3;

struct Outcome {
  int frames = 0, with_truth = 0;
  std::string error;  ///< and its details
};

/// From READY to the end of the stream, or to its first error.
Outcome play(GstElement *pipeline, bool faulty) {
  Outcome outcome;
  GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
  const gulong handler = g_signal_connect(
      sink, "handoff", G_CALLBACK(+[](GstElement *, GstBuffer *buffer, GstPad *, Outcome *o) {
        ++o->frames;
        o->with_truth += gst_buffer_get_csd_tracks(buffer, GST_CSD_TRUTH_META_NAME, nullptr) != nullptr;
      }),
      &outcome);
  GstBus *bus = gst_element_get_bus(pipeline);
  counting = faulty;
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstMessage *end = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE,
                                               static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  counting = false;
  if (GST_MESSAGE_TYPE(end) == GST_MESSAGE_ERROR) {
    GError *error = nullptr;
    gchar *detail = nullptr;
    gst_message_parse_error(end, &error, &detail);
    outcome.error = std::string(error->message) + " " + (detail ? detail : "");
    g_error_free(error);
    g_free(detail);
  }
  gst_message_unref(end);
  gst_element_set_state(pipeline, GST_STATE_READY);
  gst_bus_set_flushing(bus, TRUE);
  gst_bus_set_flushing(bus, FALSE);
  gst_object_unref(bus);
  g_signal_handler_disconnect(sink, handler);
  gst_object_unref(sink);
  return outcome;
}

void plant(Kind kind, bool last) {
  GstElement *pipeline = gst_pipeline_new(nullptr), *sink = gst_element_factory_make("fakesink", "sink");
  auto *source =
      GST_ELEMENT(g_object_new(GST_TYPE_CSD_SIM_SRC, "name", "source", "num-buffers", frames, "features", 4, nullptr));
  gst_util_set_object_arg(G_OBJECT(source), "scenario", "mixed");
  g_object_set(sink, "signal-handoffs", TRUE, "sync", FALSE, nullptr);
  gst_bin_add_many(GST_BIN(pipeline), source, sink, nullptr);
  GstCaps *caps = gst_caps_from_string("video/x-raw,format=I420,width=32,height=32");
  fail_unless(gst_element_link_filtered(source, sink, caps));
  gst_caps_unref(caps);

  const auto life = [&] { return play(pipeline, true); };
  const auto fine = [](const Outcome &whole) {
    fail_unless(whole.frames == frames && whole.with_truth == frames && whole.error.empty(), "%d frames: %s",
                whole.frames, whole.error.c_str());
  };
  const auto look = [&](long n, const Outcome &outcome) {
    if (outcome.error.empty()) {
      fail_unless(outcome.frames == frames && outcome.with_truth == frames, "fault %ld is silent: %d frames", n,
                  outcome.frames);
      return false;
    }
    fail_unless(outcome.error.starts_with("Out of memory"), "fault %ld: %s", n, outcome.error.c_str());
    const Outcome again = play(pipeline, false);
    fail_unless(again.frames == frames && again.error.empty(), "no recovery after fault %ld: %s", n,
                again.error.c_str());
    return true;
  };
  plant_each("csdsimsrc", kind, last, life, fine, look);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(pipeline);
}

}  // namespace

GST_START_TEST(a_single_allocation_fails) {
  plant(operator_new, false);
}
GST_END_TEST

GST_START_TEST(all_allocations_fail_from_one_on) {
  plant(operator_new, true);
}
GST_END_TEST

GST_START_TEST(opencv_allocations_fail) {
  plant(opencv_allocation, false);
}
GST_END_TEST

static Suite *csdsimsrc_faults_suite() {
  gst_element_register_csdsimsrc(nullptr);
  let_opencv_fail();
  Suite *suite = suite_create("csdsimsrc_faults");
  TCase *tcase = tcase_create("general");
  tcase_set_timeout(tcase, 0);  // meson's applies
  suite_add_tcase(suite, tcase);
  tcase_add_test(tcase, a_single_allocation_fails);
  tcase_add_test(tcase, all_allocations_fail_from_one_on);
  tcase_add_test(tcase, opencv_allocations_fail);
  return suite;
}

GST_CHECK_MAIN(csdsimsrc_faults)
