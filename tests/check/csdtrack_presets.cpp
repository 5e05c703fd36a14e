// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrack's presets, saved and loaded by GStreamer.
#include <glib/gstdio.h>
#include <gst/check/gstcheck.h>

#include <map>
#include <set>
#include <string>

namespace {

/// Where presets are saved. GLib reads the environment once, so it is set before main().
std::string home() {
  g_autofree gchar *made = g_dir_make_tmp("csdtrack_presets-XXXXXX", nullptr);
  g_setenv("XDG_DATA_HOME", made, TRUE);
  g_unsetenv("GST_PRESET_PATH");
  return made;
}
const std::string folder = home();

/// All properties that a user may set.
std::map<std::string, std::string> values_of(GstElement *track) {
  std::map<std::string, std::string> values;
  guint n = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(track), &n);
  for (guint i = 0; i < n; ++i) {
    const std::string name = specs[i]->name;
    if (!(specs[i]->flags & G_PARAM_WRITABLE) || name == "name" || name == "parent") continue;
    GValue value = G_VALUE_INIT;
    g_object_get_property(G_OBJECT(track), specs[i]->name, &value);
    gchar *text = gst_value_serialize(&value);
    values[name] = text ? text : "";
    g_free(text);
    g_value_unset(&value);
  }
  g_free(specs);
  return values;
}

/// Another value than the default.
void change(GstElement *track, GParamSpec *spec) {
  GValue value = G_VALUE_INIT;
  g_value_init(&value, spec->value_type);
  g_param_value_set_default(spec, &value);
  if (G_VALUE_HOLDS_BOOLEAN(&value))
    g_value_set_boolean(&value, !g_value_get_boolean(&value));
  else if (G_VALUE_HOLDS_ENUM(&value))
    g_value_set_enum(&value, g_value_get_enum(&value) == 0 ? 1 : 0);
  else if (G_VALUE_HOLDS_UINT(&value))
    g_value_set_uint(&value, g_value_get_uint(&value) + 1);
  else if (G_VALUE_HOLDS_UINT64(&value))
    g_value_set_uint64(&value, g_value_get_uint64(&value) + 1);
  else
    fail("no other value for %s", spec->name);
  g_object_set_property(G_OBJECT(track), spec->name, &value);
  g_value_unset(&value);
}

/// Saves what `saved` has and loads it into a new element.
GstElement *loaded(GstElement *saved) {
  fail_unless(gst_preset_save_preset(GST_PRESET(saved), "mine"));
  GstElement *track = gst_element_factory_make("csdtrack", "fresh");
  fail_unless(gst_preset_load_preset(GST_PRESET(track), "mine"));
  return track;
}

void remove_saved() {
  const std::string below = folder + "/gstreamer-1.0", presets = below + "/presets";
  for (const char *end : {"", ".bak"}) g_remove((presets + "/GstCsdTrack.prs" + end).c_str());
  for (const std::string &each : {presets, below, folder}) g_rmdir(each.c_str());
}

}  // namespace

GST_START_TEST(every_value_comes_back) {
  const std::map<std::string, const char *> texts = {{"points", "100.5,80;1,2"}, {"region", "1,2,30,40"}};
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  const auto usual = values_of(track);
  guint n = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(track), &n);
  for (guint i = 0; i < n; ++i) {
    const std::string name = specs[i]->name;
    if (!usual.contains(name) || g_str_has_suffix(specs[i]->name, "-array")) continue;
    if (texts.contains(name))
      g_object_set(track, specs[i]->name, texts.at(name), nullptr);
    else
      change(track, specs[i]);
  }
  g_free(specs);
  GstElement *again = loaded(track);
  const auto expected = values_of(track), found = values_of(again);
  for (const auto &[name, value] : expected) {
    fail_unless(value != usual.at(name), "%s has no other value in this test", name.c_str());
    fail_unless(found.at(name) == value, "%s: %s for %s", name.c_str(), found.at(name).c_str(), value.c_str());
  }
  gchar *name = gst_element_get_name(again);
  fail_unless_equals_string(name, "fresh");
  g_free(name);
  gst_object_unref(again);
  gst_object_unref(track);
}
GST_END_TEST

/// One after the other into the same preset, so that an earlier value may not come back either.
GST_START_TEST(points_and_region_are_saved_once) {
  const std::pair<const char *, const char *> cases[] = {{"100.5,80;-1,2", "1,2,30,40"},
                                                         {"truth", ""},
                                                         {"0.1,0.3333333333333", "0,0,5,5"},
                                                         {" 1,2 ; +3.5,-4 ;", "7,8,9,10"},
                                                         {"", ""}};
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  for (const auto &[points, region] : cases) {
    g_object_set(track, "points", points, "region", region, nullptr);
    GstElement *again = loaded(track);
    gchar *points_again = nullptr, *region_again = nullptr;
    g_object_get(again, "points", &points_again, "region", &region_again, nullptr);
    fail_unless_equals_string(points_again, points);
    fail_unless_equals_string(region_again, region);
    g_free(points_again);
    g_free(region_again);
    gst_object_unref(again);
  }
  std::set<std::string> names;
  gchar **saved = gst_preset_get_property_names(GST_PRESET(track));
  for (gchar **name = saved; *name; ++name) names.insert(*name);
  g_strfreev(saved);
  for (const char *name : {"points", "region", "qos", "seed"}) fail_unless(names.contains(name), "%s", name);
  for (const char *name : {"points-array", "region-array", "name", "parent", "stats"})
    fail_if(names.contains(name), "%s", name);
  gst_object_unref(track);
}
GST_END_TEST

static Suite *csdtrack_presets_suite() {
  Suite *suite = suite_create("csdtrack_presets");
  TCase *tc = tcase_create("presets");
  suite_add_tcase(suite, tc);
  tcase_add_unchecked_fixture(tc, nullptr, remove_saved);
  tcase_add_test(tc, every_value_comes_back);
  tcase_add_test(tc, points_and_region_are_saved_once);
  return suite;
}

GST_CHECK_MAIN(csdtrack_presets)
