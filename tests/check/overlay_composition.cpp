// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay_composition.h"

#include <gst/base/gstbasetransform.h>
#include <gtest/gtest.h>

#include <string>

#include "caps/frame_mapping.h"
#include "overlay/overlay_painter.h"
#include "scene.h"

namespace {

/// A minimal in-place element that attaches compositions as OverlayNegotiation decides.
struct Stage {
  GstBaseTransform parent;
  csd::OverlayNegotiation *negotiation;
  csd::OverlayComposition *composition;
  int attached, refusals;
};
struct StageClass {
  GstBaseTransformClass parent_class;
};

Stage *stage_of(gpointer object) {
  return static_cast<Stage *>(object);
}
gpointer stage_parent = nullptr;

GstCaps *stage_transform_caps(GstBaseTransform *base, GstPadDirection direction, GstCaps *caps, GstCaps *filter) {
  GstCaps *all = stage_of(base)->negotiation->transform_caps(direction, caps);
  if (!filter) return all;
  GstCaps *some = gst_caps_intersect_full(filter, all, GST_CAPS_INTERSECT_FIRST);
  gst_caps_unref(all);
  return some;
}

gboolean stage_set_caps(GstBaseTransform *base, GstCaps *in, GstCaps *out) {
  stage_of(base)->negotiation->set_caps(in, out);
  return TRUE;
}

gboolean stage_accept_caps(GstBaseTransform *base, GstPadDirection direction, GstCaps *caps) {
  GstCaps *complete = csd::complete_caps(caps);
  const gboolean accepted = GST_BASE_TRANSFORM_CLASS(stage_parent)->accept_caps(base, direction, complete);
  gst_caps_unref(complete);
  return accepted;
}

GstFlowReturn stage_transform_ip(GstBaseTransform *base, GstBuffer *buffer) {
  Stage *stage = stage_of(base);
  stage->negotiation->settle();
  if (stage->negotiation->take_refusal()) ++stage->refusals;
  if (!stage->negotiation->may_attach()) return GST_FLOW_OK;
  csd::Tracks tracks;
  tracks.width = 320, tracks.height = 240;
  csd::Feature f;
  f.id = 5, f.x = 100, f.y = 100, f.state = csd::FeatureState::tracked;
  tracks.features.push_back(f);
  stage->composition->attach(buffer, tracks, 0, 0, 240);
  ++stage->attached;
  return GST_FLOW_OK;
}

void stage_finalize(GObject *object) {
  delete stage_of(object)->negotiation;
  delete stage_of(object)->composition;
  G_OBJECT_CLASS(stage_parent)->finalize(object);
}

void stage_class_init(gpointer klass, gpointer) {
  stage_parent = g_type_class_peek_parent(klass);
  G_OBJECT_CLASS(klass)->finalize = stage_finalize;
  auto *base = GST_BASE_TRANSFORM_CLASS(klass);
  base->transform_caps = stage_transform_caps;
  base->set_caps = stage_set_caps;
  base->accept_caps = stage_accept_caps;
  base->transform_ip = stage_transform_ip;
  GstCaps *caps = csd::template_caps();
  gst_element_class_add_pad_template(GST_ELEMENT_CLASS(klass),
                                     gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps));
  gst_element_class_add_pad_template(GST_ELEMENT_CLASS(klass),
                                     gst_pad_template_new("src", GST_PAD_SRC, GST_PAD_ALWAYS, caps));
  gst_element_class_set_static_metadata(GST_ELEMENT_CLASS(klass), "Stage", "Filter", "Test", "csdtrack");
  gst_caps_unref(caps);
}

void stage_init(GTypeInstance *instance, gpointer) {
  Stage *stage = stage_of(instance);
  stage->negotiation = new csd::OverlayNegotiation(GST_BASE_TRANSFORM_SRC_PAD(stage));
  stage->composition = new csd::OverlayComposition;
  stage->negotiation->set_wanted(true);
  gst_base_transform_set_in_place(&stage->parent, TRUE);
  gst_base_transform_set_prefer_passthrough(&stage->parent, FALSE);
}

void register_stage() {
  const GType type = g_type_register_static_simple(GST_TYPE_BASE_TRANSFORM, "CsdTestStage", sizeof(StageClass),
                                                   stage_class_init, sizeof(Stage), stage_init, GTypeFlags(0));
  gst_element_register(nullptr, "csdteststage", GST_RANK_NONE, type);
}

struct Outcome {
  bool ran = false;
  int attached = 0, refusals = 0;
  std::string caps;
};

/// Answers the allocation query of the sink "render" like a sink that renders compositions.
GstPadProbeReturn render(GstPad *, GstPadProbeInfo *info, gpointer) {
  GstQuery *query = GST_PAD_PROBE_INFO_QUERY(info);
  if (GST_QUERY_TYPE(query) != GST_QUERY_ALLOCATION) return GST_PAD_PROBE_OK;
  gst_query_add_allocation_meta(query, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
  return GST_PAD_PROBE_HANDLED;
}

Outcome run(const std::string &text, bool renders = false) {
  Outcome out;
  GError *error = nullptr;
  GstElement *pipeline = gst_parse_launch(text.c_str(), &error);
  EXPECT_EQ(error, nullptr) << error->message;
  GstElement *stage = gst_bin_get_by_name(GST_BIN(pipeline), "stage");
  if (renders) {
    GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "render");
    GstPad *pad = gst_element_get_static_pad(sink, "sink");
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_QUERY_DOWNSTREAM, render, nullptr, nullptr);
    gst_object_unref(pad);
    gst_object_unref(sink);
  }
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *message = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE,
                                                   static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  out.ran = GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS;
  gst_message_unref(message);
  GstPad *src = gst_element_get_static_pad(stage, "src");
  if (GstCaps *caps = gst_pad_get_current_caps(src)) {
    gchar *string = gst_caps_to_string(caps);
    out.caps = string;
    g_free(string);
    gst_caps_unref(caps);
  }
  gst_object_unref(src);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  out.attached = stage_of(stage)->attached;
  out.refusals = stage_of(stage)->refusals;
  gst_object_unref(bus);
  gst_object_unref(stage);
  gst_object_unref(pipeline);
  return out;
}

constexpr char feature[] = "meta:GstVideoOverlayComposition";
const std::string source = "videotestsrc num-buffers=5 ! video/x-raw,width=320,height=240 ! csdteststage name=stage ! ";

TEST(OverlayNegotiation, AttachesWhereDownstreamRenders) {
  const Outcome out = run(source + "fakesink name=render", true);
  EXPECT_TRUE(out.ran);
  EXPECT_EQ(out.attached, 5);
  EXPECT_EQ(out.refusals, 0);
  EXPECT_NE(out.caps.find(feature), std::string::npos) << out.caps;
  const Outcome queued = run(source + "queue ! fakesink name=render", true);
  EXPECT_TRUE(queued.ran);
  EXPECT_EQ(queued.attached, 5);
}

TEST(OverlayNegotiation, WarnsOnceIfDownstreamTakesTheCapsWithoutRendering) {
  for (const char *sink : {"fakesink", "identity ! fakesink"}) {
    const Outcome out = run(source + sink);
    EXPECT_TRUE(out.ran) << sink;
    EXPECT_EQ(out.attached, 0) << sink;
    EXPECT_EQ(out.refusals, 1) << sink;
    EXPECT_EQ(out.caps.find(feature), std::string::npos) << out.caps;
  }
}

TEST(OverlayNegotiation, WarnsOnceIfDownstreamRefusesTheFeature) {
  for (const char *sink : {"video/x-raw ! fakesink", "videoconvert ! video/x-raw,format=RGB ! fakesink"}) {
    const Outcome out = run(source + sink);
    EXPECT_TRUE(out.ran) << sink;
    EXPECT_EQ(out.attached, 0) << sink;
    EXPECT_EQ(out.refusals, 1) << sink;
  }
}

TEST(OverlayNegotiation, KeepsUpstreamsFeatureWithoutAQuery) {
  // The feature comes from an upstream stage that was allowed to set it. The sink need not confirm it again.
  const Outcome out =
      run("videotestsrc num-buffers=5 ! video/x-raw,width=320,height=240 ! csdteststage ! csdteststage name=stage ! "
          "fakesink name=render",
          true);
  EXPECT_TRUE(out.ran);
  EXPECT_EQ(out.attached, 5);
  EXPECT_NE(out.caps.find(feature), std::string::npos) << out.caps;
}

TEST(CompleteCaps, AdmitStreamsThatDoNotNameTheirInterlacing) {
  const Outcome out = run(
      "videotestsrc num-buffers=5 ! video/x-raw,format=I420,width=320,height=240 ! capssetter join=false replace=true "
      "caps=video/x-raw,format=I420,width=320,height=240,framerate=30/1 ! csdteststage name=stage ! fakesink");
  EXPECT_TRUE(out.ran);
}

TEST(OverlayNegotiation, OffersBothDownstreamAndRemovesNothing) {
  Stage *stage = stage_of(g_object_ref_sink(gst_element_factory_make("csdteststage", nullptr)));
  csd::OverlayNegotiation &negotiation = *stage->negotiation;
  GstCaps *plain = gst_caps_from_string("video/x-raw, format=I420");
  GstCaps *with = gst_caps_from_string("video/x-raw(meta:GstVideoOverlayComposition), format=I420");
  const auto offered = [&](GstPadDirection direction, GstCaps *caps) {
    GstCaps *out = negotiation.transform_caps(direction, caps);
    gchar *text = gst_caps_to_string(out);
    std::string s = text;
    g_free(text);
    gst_caps_unref(out);
    return s;
  };
  const std::string p = "video/x-raw, format=(string)I420";
  const std::string f = "video/x-raw(meta:GstVideoOverlayComposition), format=(string)I420";
  const std::string g = "video/x-raw(memory:SystemMemory, meta:GstVideoOverlayComposition), format=(string)I420";
  negotiation.set_wanted(false);
  EXPECT_EQ(offered(GST_PAD_SINK, plain), p) << "not wanted: unchanged";
  negotiation.set_wanted(true);
  EXPECT_EQ(offered(GST_PAD_SINK, plain), g + "; " + f + "; " + p);
  EXPECT_EQ(offered(GST_PAD_SINK, with), f);
  EXPECT_EQ(offered(GST_PAD_SRC, with), p + "; " + f);
  EXPECT_EQ(offered(GST_PAD_SRC, plain), p);
  gst_caps_unref(plain);
  gst_caps_unref(with);
  gst_object_unref(stage);
}

TEST(OverlayComposition, LooksLikeThePainter) {
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_RGB, 320, 240);
  const scene::Buffer painted = scene::make(info), blended = scene::make(info);
  csd::Tracks tracks;
  tracks.width = 320, tracks.height = 240;
  for (std::size_t s = 0; s < csd::feature_states; ++s) {
    csd::Feature f;
    f.id = static_cast<csd::FeatureId>(10 * s), f.state = static_cast<csd::FeatureState>(s);
    f.x = 20.0 + 50.0 * static_cast<double>(s), f.y = 100.3;
    tracks.features.push_back(f);
  }
  csd::OverlayComposition().attach(blended.get(), tracks, 0, 0, 240);
  GstVideoOverlayCompositionMeta *meta = gst_buffer_get_video_overlay_composition_meta(blended.get());
  ASSERT_NE(meta, nullptr);
  EXPECT_EQ(gst_video_overlay_composition_n_rectangles(meta->overlay), 5u) << "ended is not drawn";
  scene::Frame a(info, painted.get(), GST_MAP_READWRITE), b(info, blended.get(), GST_MAP_READWRITE);
  csd::OverlayPainter().draw(a, info, nullptr, tracks);
  ASSERT_TRUE(gst_video_overlay_composition_blend(meta->overlay, &b));
  const auto *p = static_cast<const std::uint8_t *>(a.data[0]), *q = static_cast<const std::uint8_t *>(b.data[0]);
  int worst = 0;
  for (int i = 0; i < 320 * 240 * 3; ++i) worst = std::max(worst, std::abs(p[i] - q[i]));
  EXPECT_LE(worst, 3);
}

TEST(OverlayComposition, KeepsAnEarlierComposition) {
  const scene::Buffer buffer(gst_buffer_new());
  csd::Tracks tracks;
  tracks.width = 320, tracks.height = 240;
  csd::Feature f;
  f.x = f.y = 100;
  tracks.features.push_back(f);
  csd::OverlayComposition first, second;
  first.attach(buffer.get(), tracks, 0, 0, 240);
  second.attach(buffer.get(), tracks, 0, 0, 240);
  GstVideoOverlayCompositionMeta *meta = gst_buffer_get_video_overlay_composition_meta(buffer.get());
  ASSERT_NE(meta, nullptr);
  EXPECT_EQ(gst_video_overlay_composition_n_rectangles(meta->overlay), 2u);
}

}  // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  register_stage();
  return RUN_ALL_TESTS();
}
