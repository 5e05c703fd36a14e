// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The metadata and its C header: fields, types, several metas on a buffer, the transform function. csdtrackmeta_matrix
// tests what other elements do to it.
#include <gst/video/video.h>

#include "attach.h"
#include "meta/meta.h"

// Last, since it defines a macro `fail`.
#include <gst/check/gstcheck.h>

using csd_check::attach;

namespace {

void assert_type(const GstStructure *s, const char *field, GType type) {
  fail_unless(gst_structure_has_field_typed(s, field, type), "%s is no %s", field, g_type_name(type));
}

}  // namespace

GST_START_TEST(test_fields_and_types) {
  csd::Tracks tracks;
  tracks.frame = G_GUINT64_CONSTANT(5000000000);
  tracks.width = 641;
  tracks.height = 479;
  tracks.features = {{3, -1.25, 2.5, csd::FeatureState::learning, 1, true},
                     {4, 0, 0, csd::FeatureState::tracked, 0.5, true},
                     {5, 0, 0, csd::FeatureState::occluded, 0.25, false},
                     {6, 0, 0, csd::FeatureState::lost, 0, true},
                     {7, 0, 0, csd::FeatureState::out, 0, true},
                     {4294967294u, 0, 0, csd::FeatureState::ended, 0, true}};
  GstBuffer *buffer = gst_buffer_new();
  fail_unless(csd::add_track_meta(buffer, tracks, "here", "lk") != nullptr);

  // As seen by another program, without the header.
  GstCustomMeta *meta = gst_buffer_get_custom_meta(buffer, "GstCsdTrackMeta");
  fail_unless(meta != nullptr);
  const GstStructure *s = gst_custom_meta_get_structure(meta);
  assert_type(s, "schema", G_TYPE_INT);
  assert_type(s, "source", G_TYPE_STRING);
  assert_type(s, "algorithm", G_TYPE_STRING);
  assert_type(s, "frame", G_TYPE_UINT64);
  for (const char *field : {"width", "height", "tracked-width", "tracked-height"}) assert_type(s, field, G_TYPE_INT);
  assert_type(s, "features", GST_TYPE_ARRAY);
  fail_unless_equals_int(gst_structure_n_fields(s), 9);
  const GstStructure *f = gst_value_get_structure(gst_value_array_get_value(gst_structure_get_value(s, "features"), 0));
  assert_type(f, "id", G_TYPE_UINT);
  assert_type(f, "x", G_TYPE_DOUBLE);
  assert_type(f, "y", G_TYPE_DOUBLE);
  assert_type(f, "state", G_TYPE_STRING);
  assert_type(f, "confidence", G_TYPE_DOUBLE);
  assert_type(f, "fresh", G_TYPE_BOOLEAN);
  fail_unless_equals_int(gst_structure_n_fields(f), 6);

  GstCsdHeader header;
  GstCsdFeature feature;
  fail_unless(gst_csd_structure_get_header(s, &header));
  fail_unless_equals_string(header.source, "here");
  fail_unless_equals_string(header.algorithm, "lk");
  fail_unless_equals_uint64(header.frame, G_GUINT64_CONSTANT(5000000000));
  fail_unless(header.width == 641 && header.height == 479 && header.n_features == 6);
  const char *states[] = {"learning", "tracked", "occluded", "lost", "out", "ended"};
  for (guint i = 0; i < 6; ++i) {
    fail_unless(gst_csd_structure_get_feature(s, i, &feature));
    fail_unless_equals_string(feature.state, states[i]);
    fail_unless_equals_int(feature.fresh, i != 2);
  }
  fail_unless_equals_uint64(feature.id, 4294967294u);
  fail_unless(gst_csd_structure_get_feature(s, 0, &feature) && feature.x == -1.25 && feature.y == 2.5);
  fail_if(gst_csd_structure_get_feature(s, 6, &feature));
  gst_buffer_unref(buffer);
}
GST_END_TEST;

GST_START_TEST(test_a_source_name_that_is_not_text) {
  GstStructure *s = csd::new_tracks_structure("csdtrack", csd::Tracks{}, "a\xff", "lk");
  fail_unless_equals_string(gst_structure_get_string(s, "source"), "a\xef\xbf\xbd");
  gst_structure_free(s);
}
GST_END_TEST;

GST_START_TEST(test_is_registered_with_the_right_tags) {
  fail_unless(csd::register_track_metas());
  fail_unless(csd::register_track_metas());
  for (const char *name : {"GstCsdTrackMeta", "GstCsdTruthMeta"}) {
    const gchar *const *tags = gst_meta_api_type_get_tags(gst_meta_get_info(name)->api);
    fail_unless_equals_int(g_strv_length(const_cast<gchar **>(tags)), 3);
    for (const char *tag : {"video", "orientation", "size"}) fail_unless(g_strv_contains(tags, tag));
  }
}
GST_END_TEST;

GST_START_TEST(test_several_metas) {
  GstBuffer *buffer = gst_buffer_new();
  fail_unless(gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr) == nullptr);
  attach(buffer, "a", 1, 64, 48, 1, 1);
  attach(buffer, "b", 2, 64, 48, 2, 2);
  attach(buffer, "sim", 3, 64, 48, 3, 3, GST_CSD_TRUTH_META_NAME);
  GstBuffer *copy = gst_buffer_copy(buffer);
  for (GstBuffer *b : {buffer, copy}) {
    const auto frame = [b](const char *name, const char *source) -> guint64 {
      GstCsdHeader header;
      const GstStructure *s = gst_buffer_get_csd_tracks(b, name, source);
      return s && gst_csd_structure_get_header(s, &header) ? header.frame : 99;
    };
    fail_unless_equals_uint64(frame(GST_CSD_TRACK_META_NAME, "a"), 1);
    fail_unless_equals_uint64(frame(GST_CSD_TRACK_META_NAME, "b"), 2);
    fail_unless_equals_uint64(frame(GST_CSD_TRACK_META_NAME, ""), 2);
    fail_unless_equals_uint64(frame(GST_CSD_TRACK_META_NAME, nullptr), 2);
    fail_unless_equals_uint64(frame(GST_CSD_TRUTH_META_NAME, nullptr), 3);
    fail_unless_equals_uint64(frame(GST_CSD_TRACK_META_NAME, "sim"), 99);
    gpointer iter = nullptr;
    int n = 0;
    while (gst_buffer_iterate_csd_tracks(b, &iter, GST_CSD_TRACK_META_NAME)) ++n;
    fail_unless_equals_int(n, 2);
  }
  gst_buffer_unref(copy);
  gst_buffer_unref(buffer);
}
GST_END_TEST;

GST_START_TEST(test_unreadable_structures) {
  GstCsdHeader header;
  GstCsdFeature feature;
  GstStructure *s = gst_structure_new_empty("x");
  fail_if(gst_csd_structure_get_header(s, &header));
  fail_if(gst_csd_structure_get_feature(s, 0, &feature));
  header = GstCsdHeader{"a", "lk", 0, 1, 1, 1, 1, 0};
  gst_csd_structure_set(s, &header, nullptr);
  fail_unless(gst_csd_structure_get_header(s, &header) && header.n_features == 0);
  gst_structure_set(s, "schema", G_TYPE_INT, 2, nullptr);
  fail_if(gst_csd_structure_get_header(s, &header), "a future schema is not guessed at");
  gst_structure_free(s);
}
GST_END_TEST;

GST_START_TEST(test_scales_but_is_dropped_by_a_scaled_rectangle) {
  GstVideoInfo in, out;
  gst_video_info_set_format(&in, GST_VIDEO_FORMAT_I420, 64, 48);
  gst_video_info_set_format(&out, GST_VIDEO_FORMAT_I420, 32, 24);
  GstVideoMetaTransform data = {&in, &out};
  for (const guint left : {0u, 2u}) {
    GstBuffer *from = gst_buffer_new(), *to = gst_buffer_new();
    attach(from, "a", 0, 64, 48, 10, 20);
    GstMeta *meta = GST_META_CAST(gst_buffer_get_custom_meta(from, GST_CSD_TRACK_META_NAME));
    GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(from);
    crop->x = left;
    crop->y = 0;
    crop->width = 64;
    crop->height = 48;
    const gboolean copied =
        meta->info->transform_func(to, meta, from, gst_video_meta_transform_scale_get_quark(), &data);
    fail_unless_equals_int(copied, left == 0);
    fail_unless_equals_int(gst_buffer_get_custom_meta(to, GST_CSD_TRACK_META_NAME) != nullptr, left == 0);
    if (left == 0) {  // by hand: 10.5/2 − 0.5, 20.5/2 − 0.5
      GstCsdFeature f;
      fail_unless(
          gst_csd_structure_get_feature(gst_buffer_get_csd_tracks(to, GST_CSD_TRACK_META_NAME, nullptr), 0, &f));
      fail_unless(f.x == 4.75 && f.y == 9.75, "%f,%f", f.x, f.y);
    }
    fail_if(meta->info->transform_func(to, meta, from, g_quark_from_string("of-tomorrow"), &data));
    gst_buffer_unref(from);
    gst_buffer_unref(to);
  }
}
GST_END_TEST;

/// Other programs write the metadata, too.
GST_START_TEST(test_scales_features_beside_an_empty_one) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_I420, 64, 48);
  GstVideoMetaTransform data = {&info, &info};
  GstBuffer *from = gst_buffer_new(), *to = gst_buffer_new();
  attach(from, "a", 0, 64, 48, 10, 20);
  GstCustomMeta *meta = gst_buffer_get_custom_meta(from, GST_CSD_TRACK_META_NAME);
  GstStructure *s = gst_custom_meta_get_structure(meta);
  GValue features = G_VALUE_INIT, nothing = G_VALUE_INIT;
  g_value_init(&features, GST_TYPE_ARRAY);
  g_value_init(&nothing, GST_TYPE_STRUCTURE);
  gst_value_array_append_and_take_value(&features, &nothing);
  gst_value_array_append_value(&features, gst_value_array_get_value(gst_structure_get_value(s, "features"), 0));
  gst_structure_take_value(s, "features", &features);
  GstMeta *base = GST_META_CAST(meta);
  fail_unless(base->info->transform_func(to, base, from, gst_video_meta_transform_scale_get_quark(), &data));
  const GstStructure *scaled = gst_buffer_get_csd_tracks(to, GST_CSD_TRACK_META_NAME, nullptr);
  GstCsdHeader header;
  GstCsdFeature feature;
  fail_unless(gst_csd_structure_get_header(scaled, &header) && header.n_features == 1);
  fail_unless(gst_csd_structure_get_feature(scaled, 0, &feature) && feature.x == 10 && feature.y == 20);
  gst_buffer_unref(from);
  gst_buffer_unref(to);
}
GST_END_TEST;

static Suite *csdtrackmeta_suite() {
  Suite *s = suite_create("csdtrackmeta");
  TCase *tc = tcase_create("general");
  GstPlugin *plugin = gst_plugin_load_by_name("csdtrack");
  if (!plugin) g_error("no plugin: is GST_PLUGIN_PATH set?");
  gst_object_unref(plugin);
  suite_add_tcase(s, tc);
  tcase_add_test(tc, test_fields_and_types);
  tcase_add_test(tc, test_a_source_name_that_is_not_text);
  tcase_add_test(tc, test_is_registered_with_the_right_tags);
  tcase_add_test(tc, test_several_metas);
  tcase_add_test(tc, test_unreadable_structures);
  tcase_add_test(tc, test_scales_but_is_dropped_by_a_scaled_rectangle);
  tcase_add_test(tc, test_scales_features_beside_an_empty_one);
  return s;
}

GST_CHECK_MAIN(csdtrackmeta)
