// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackdec with frames in any memory: it neither maps nor copies it. csdtrackdec_gl.cpp tests OpenGL memory.
#include <string>

#include "counting_memory.h"
#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

// Twice as large as the tracked picture. Caps with and without features, and formats unknown to GstVideoInfo (from a
// later GStreamer, or invented).
constexpr const char *not_mapped[] = {
    "video/x-raw(memory:GLMemory),format=RGBA,texture-target=2D",
    "video/x-raw(memory:VAMemory),format=NV12",
    "video/x-raw(memory:DMABuf),format=DMA_DRM,drm-format=(string)NV12:0x0100000000000002",
    "video/x-raw(memory:CUDAMemory),format=P010_10LE",
    "video/x-raw(memory:D3D11Memory),format=NV12",
    "video/x-raw(memory:NVMM,meta:Another),format=NV12",
    "video/x-raw(memory:OfTomorrow),format=OF_TOMORROW",
    "video/x-raw,format=RGB8P",
};
constexpr char size[] = ",width=128,height=96,framerate=25/1";
constexpr char composition[] = GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION;

GstBuffer *opaque_frame(CountingMemory &memory, guint64 n) {
  GstBuffer *buffer = gst_buffer_new();
  gst_buffer_append_memory(buffer, memory.allocate(128 * 96));
  GST_BUFFER_PTS(buffer) = n * frame_time;
  GST_BUFFER_DURATION(buffer) = frame_time;
  return buffer;
}

/// The first feature's place.
std::pair<double, double> place_on(GstBuffer *buffer) {
  GstCsdHeader header;
  GstCsdFeature feature;
  const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  fail_unless(tracks && gst_csd_structure_get_header(tracks, &header));
  fail_unless_equals_int(header.width, 128);
  fail_unless_equals_int(header.height, 96);
  fail_unless(gst_csd_structure_get_feature(tracks, 0, &feature));
  return {feature.x, feature.y};
}

bool has_features_of(GstCaps *caps, GstCaps *others) {
  return gst_caps_features_is_equal(gst_caps_get_features(caps, 0), gst_caps_get_features(others, 0));
}

/// Answers CAPS queries in its own order instead of the filter's, as transforms do.
GstPadProbeReturn in_own_order(GstPad *, GstPadProbeInfo *info, gpointer own) {
  GstQuery *query = GST_PAD_PROBE_INFO_QUERY(info);
  if (GST_QUERY_TYPE(query) != GST_QUERY_CAPS) return GST_PAD_PROBE_OK;
  GstCaps *filter = nullptr;
  gst_query_parse_caps(query, &filter);
  g_autoptr(GstCaps) caps = gst_caps_copy(static_cast<GstCaps *>(own));
  g_autoptr(GstCaps) both =
      filter ? gst_caps_intersect_full(caps, filter, GST_CAPS_INTERSECT_FIRST) : gst_caps_ref(caps);
  gst_query_set_caps_result(query, both);
  return GST_PAD_PROBE_HANDLED;
}

}  // namespace

GST_START_TEST(no_memory_is_mapped_or_copied) {
  const std::string path = write_file("memory.jsonl", lines(0, 3));
  for (const char *start : not_mapped)
    for (const char *overlay : {"none", "meta"}) {
      const std::string text = std::string(start) + size;
      const bool meta = std::string(overlay) == "meta";
      CountingMemory memory;
      Harness harness(path, nullptr, overlay);
      if (meta)
        gst_harness_add_propose_allocation_meta(harness.h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
      gst_harness_set_src_caps_str(harness.h, text.c_str());
      for (guint64 n = 0; n < 3; ++n) {
        GstBuffer *in = opaque_frame(memory, n);
        GstMemory *const its = gst_buffer_peek_memory(in, 0);
        gst_buffer_ref(in);  // as in a tee's other branch
        GstBuffer *out = gst_harness_push_and_pull(harness.h, in);
        fail_unless(out != nullptr, "%s", text.c_str());
        fail_unless(gst_buffer_peek_memory(out, 0) == its, "%s, overlay=%s", text.c_str(), overlay);
        // The line is for 64×48 pixels, at 10.25+n, 20. Pixel centres are at integers.
        const auto [x, y] = place_on(out);
        fail_unless_equals_float(x, (10.25 + static_cast<double>(n) + 0.5) * 2 - 0.5);
        fail_unless_equals_float(y, (20 + 0.5) * 2 - 0.5);
        fail_unless((gst_buffer_get_video_overlay_composition_meta(out) != nullptr) == meta, "%s", text.c_str());
        gst_buffer_unref(in);
        gst_buffer_unref(out);
      }
      // The memory's feature stays, and the composition's is added.
      g_autoptr(GstCaps) in_caps = gst_caps_from_string(text.c_str());
      g_autoptr(GstCaps) out_caps = gst_pad_get_current_caps(harness.h->sinkpad);
      if (meta) gst_caps_features_add(gst_caps_get_features(in_caps, 0), composition);
      fail_unless(has_features_of(out_caps, in_caps), "%s, overlay=%s: %" GST_PTR_FORMAT, text.c_str(), overlay,
                  out_caps);
      fail_unless_equals_int(memory.maps(), 0);
      fail_unless_equals_int(memory.copies(), 0);
      assert_silent(harness);
    }
  CountingMemory memory;  // checks that it counts
  GstBuffer *frame = opaque_frame(memory, 0), *copy = gst_buffer_copy_deep(frame);
  GstMapInfo map;
  fail_unless(gst_buffer_map(frame, &map, GST_MAP_READ));
  gst_buffer_unmap(frame, &map);
  fail_unless_equals_int(memory.maps(), 1);
  fail_unless_equals_int(memory.copies(), 1);
  gst_buffer_unref(copy);
  gst_buffer_unref(frame);
}
GST_END_TEST

GST_START_TEST(drawing_is_refused_with_a_reason) {
  const std::string path = write_file("draw.jsonl", lines(0, 3));
  for (const char *start : not_mapped)
    for (const bool late : {false, true}) {
      const std::string text = std::string(start) + size;
      CountingMemory memory;
      Harness harness(path, nullptr, late ? "none" : "draw");
      g_autoptr(GstCaps) caps = gst_caps_from_string(text.c_str());
      // Queries get no offer of that memory.
      g_autoptr(GstCaps) offered = gst_pad_peer_query_caps(harness.h->srcpad, nullptr);
      fail_unless(gst_caps_can_intersect(offered, caps) == late, "%s", text.c_str());
      g_autoptr(GstCaps) drawn = gst_caps_from_string(gray_64);
      fail_unless(gst_caps_can_intersect(offered, drawn));
      gst_harness_set_src_caps_str(harness.h, text.c_str());
      if (late) {
        GstBuffer *out = gst_harness_push_and_pull(harness.h, opaque_frame(memory, 0));
        fail_unless_equals_int(number_on(out), 0);
        gst_buffer_unref(out);
        gst_util_set_object_arg(G_OBJECT(harness.element), "overlay", "draw");
      }
      GstFlowReturn flow = GST_FLOW_OK;  // the next frame's push tells upstream
      for (guint64 n = 1; n < 100 && flow == GST_FLOW_OK; ++n)
        flow = gst_harness_push(harness.h, opaque_frame(memory, n));
      fail_unless_equals_int(flow, GST_FLOW_NOT_NEGOTIATED);
      assert_holds(harness.said(GST_MESSAGE_ERROR), "overlay=draw can't draw into these frames");
      fail_unless_equals_int(memory.maps(), 0);
    }
}
GST_END_TEST

GST_START_TEST(compositions_work_downstream_of_caps_that_list_plain_first) {
  // As glimagesink and gloverlaycompositor do.
  const std::string path = write_file("order.jsonl", lines(0, 3));
  for (const char *memory : {"memory:GLMemory", "memory:SystemMemory"}) {
    CountingMemory counting;
    Harness harness(path, nullptr, "meta");
    gst_harness_add_propose_allocation_meta(harness.h, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    const std::string plain = std::string("video/x-raw(") + memory + ")",
                      with = std::string("video/x-raw(") + memory + "," + composition + ")";
    g_autoptr(GstCaps) own = gst_caps_from_string((plain + ";" + with).c_str());
    gst_pad_add_probe(harness.h->sinkpad, GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM, in_own_order, own, nullptr);
    gst_harness_set_src_caps_str(harness.h, (plain + ",format=RGBA" + size).c_str());
    GstBuffer *out = gst_harness_push_and_pull(harness.h, opaque_frame(counting, 0));
    fail_unless(gst_buffer_get_video_overlay_composition_meta(out) != nullptr, "%s", memory);
    gst_buffer_unref(out);
    assert_silent(harness);
  }
}
GST_END_TEST

static Suite *csdtrackdec_memory_suite() {
  Suite *s = suite_create("csdtrackdec_memory");
  TCase *tc = tcase_create("memory");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, no_memory_is_mapped_or_copied);
  tcase_add_test(tc, drawing_is_refused_with_a_reason);
  tcase_add_test(tc, compositions_work_downstream_of_caps_that_list_plain_first);
  return s;
}

GST_CHECK_MAIN(csdtrackdec_memory)
