// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrack's properties: their defaults, and those whose value is parsed.
#include "bus.h"
#include "csdtrack_harness.h"

namespace {

GstMessage *message_of(const char *points, GstStateChangeReturn *result) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  GstBus *bus = gst_bus_new();
  gst_element_set_bus(track, bus);
  g_object_set(track, "points", points, nullptr);
  *result = gst_element_set_state(track, GST_STATE_READY);
  GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR);
  gst_element_set_state(track, GST_STATE_NULL);
  gst_element_set_bus(track, nullptr);
  gst_object_unref(bus);
  gst_object_unref(track);
  return message;
}

/// An array as `<1,<2.5,3>>`, with the type of each number after it: `d` for double, `i` for int.
std::string array_text(const GValue &value) {
  if (G_VALUE_HOLDS_DOUBLE(&value)) return std::to_string(g_value_get_double(&value)) + 'd';
  if (G_VALUE_HOLDS_INT(&value)) return std::to_string(g_value_get_int(&value)) + 'i';
  std::string text = "<";
  for (guint i = 0; i < gst_value_array_get_size(&value); ++i)
    text += (i > 0 ? "," : "") + array_text(*gst_value_array_get_value(&value, i));
  return text + ">";
}

/// Sets a property as gst-launch-1.0 does. Returns both properties of the pair: the array and the text.
std::string pair_after(const char *property, const char *text, const char *array, const char *plain) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  gst_util_set_object_arg(G_OBJECT(track), property, text);
  GValue value = G_VALUE_INIT;
  g_value_init(&value, GST_TYPE_ARRAY);
  g_object_get_property(G_OBJECT(track), array, &value);
  gchar *written = nullptr;
  g_object_get(track, plain, &written, nullptr);
  const std::string both = array_text(value) + " | " + written;
  g_free(written);
  g_value_unset(&value);
  gst_object_unref(track);
  return both;
}

/// Another value of that type than `value`; false for a type that is not known here.
bool another(GValue &value) {
  if (G_VALUE_HOLDS_ENUM(&value))
    g_value_set_enum(&value, g_value_get_enum(&value) == 0 ? 1 : 0);
  else if (G_VALUE_HOLDS_BOOLEAN(&value))
    g_value_set_boolean(&value, !g_value_get_boolean(&value));
  else if (G_VALUE_HOLDS_UINT(&value))
    g_value_set_uint(&value, g_value_get_uint(&value) + 1);
  else if (G_VALUE_HOLDS_UINT64(&value))
    g_value_set_uint64(&value, g_value_get_uint64(&value) + 1);
  else if (G_VALUE_HOLDS_STRING(&value))
    g_value_set_string(&value, std::strcmp(g_value_get_string(&value), "1,2") == 0 ? "3,4" : "1,2");
  else
    return false;
  return true;
}

/// Sets another value. Returns whether the property then has it; if not, it must have its old one.
bool can_be_set(GstElement *track, const GParamSpec *spec) {
  GValue old = G_VALUE_INIT, set = G_VALUE_INIT, now = G_VALUE_INIT;
  for (GValue *value : {&old, &set, &now}) {
    g_value_init(value, spec->value_type);
    if (value == &now) g_object_set_property(G_OBJECT(track), spec->name, &set);
    g_object_get_property(G_OBJECT(track), spec->name, value);
    if (value == &set) fail_unless(another(set));
  }
  const bool taken = gst_value_compare(&now, &set) == GST_VALUE_EQUAL;
  fail_unless(taken || gst_value_compare(&now, &old) == GST_VALUE_EQUAL, "%s has a third value", spec->name);
  for (GValue *value : {&old, &set, &now}) g_value_unset(value);
  return taken;
}

void count_refusals(GstDebugCategory *category, GstDebugLevel level, const gchar *, const gchar *, gint,
                    GObject *object, GstDebugMessage *message, gpointer refusals) {
  if (!GST_IS_ELEMENT(object)) return;
  const char *kind = GST_OBJECT_NAME(gst_element_get_factory(GST_ELEMENT(object)));
  *static_cast<int *>(refusals) += level == GST_LEVEL_WARNING &&
                                   std::strcmp(gst_debug_category_get_name(category), kind) == 0 &&
                                   std::strstr(gst_debug_message_get(message), "NULL and READY only") != nullptr;
}

}  // namespace

GST_START_TEST(properties_have_their_documented_defaults) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  const std::map<std::string, std::string> expected = {{"algorithm", "csd"},
                                                       {"max-features", "50"},
                                                       {"points", ""},
                                                       {"points-array", "<>"},
                                                       {"replenish", "TRUE"},
                                                       {"forget-after", "10000000000"},
                                                       {"region", ""},
                                                       {"region-array", "<>"},
                                                       {"content-area", "auto"},
                                                       {"patch-size", "0"},
                                                       {"search-radius", "0"},
                                                       {"training-time", "500000000"},
                                                       {"learning", "async"},
                                                       {"n-threads", "0"},
                                                       {"frame-budget", "0"},
                                                       {"overlay", "none"},
                                                       {"attach-meta", "TRUE"},
                                                       {"attach-roi", "FALSE"},
#ifdef CSDTRACK_ANALYTICS
                                                       {"attach-analytics", "FALSE"},
#endif
                                                       {"post-messages", "change"},
                                                       {"message-interval", "0"},
                                                       {"on-error", "error"},
                                                       {"navigation", "FALSE"},
                                                       {"seed", "1"},
                                                       {"qos", "FALSE"}};
  for (const auto &[name, text] : expected) {
    GParamSpec *spec = g_object_class_find_property(G_OBJECT_GET_CLASS(track), name.c_str());
    fail_unless(spec != nullptr, "no property %s", name.c_str());
    GValue value = G_VALUE_INIT;
    g_value_init(&value, spec->value_type);
    g_object_get_property(G_OBJECT(track), name.c_str(), &value);
    std::string shown;
    if (G_VALUE_HOLDS_ENUM(&value)) {
      auto *klass = static_cast<GEnumClass *>(g_type_class_ref(spec->value_type));
      shown = g_enum_get_value(klass, g_value_get_enum(&value))->value_nick;
      g_type_class_unref(klass);
    } else if (GST_VALUE_HOLDS_ARRAY(&value)) {
      shown = array_text(value);
    } else if (G_VALUE_HOLDS_STRING(&value)) {
      shown = g_value_get_string(&value);
    } else {
      gchar *serialized = gst_value_serialize(&value);
      for (const char *c = serialized; *c; ++c) shown += spec->value_type == G_TYPE_BOOLEAN ? g_ascii_toupper(*c) : *c;
      g_free(serialized);
    }
    fail_unless_equals_string(shown.c_str(), text.c_str());
    g_value_unset(&value);
  }
  GstElementFactory *factory = gst_element_get_factory(track);
  fail_unless_equals_int(gst_plugin_feature_get_rank(GST_PLUGIN_FEATURE(factory)), GST_RANK_NONE);
  fail_unless_equals_string(gst_element_factory_get_metadata(factory, "klass"), "Filter/Analyzer/Video");
  fail_unless(GST_IS_PRESET(track));
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(bad_points_are_quoted_and_fail_the_change_to_ready) {
  std::string many;
  for (int i = 0; i < 10001; ++i) many += "1,1;";
  const std::map<std::string, std::string> bad = {{"1,2;3", "\"3\" (point 2)"},
                                                  {"nan,2", "\"nan,2\" (point 1)"},
                                                  {"1,5,2,5", "\"1,5,2,5\""},
                                                  {"x,1", "\"x,1\""},
                                                  {";", "\"\""},
                                                  {"1e999,2", "\"1e999,2\""},
                                                  {"inf,1", "\"inf,1\""},
                                                  {"truths", "\"truths\""},
                                                  {many, "(point 10001)"}};
  for (const auto &[points, shown] : bad) {
    if (points == ";") continue;  // no points, with the optional final semicolon
    GstStateChangeReturn result;
    GstMessage *message = message_of(points.c_str(), &result);
    fail_unless_equals_int(result, GST_STATE_CHANGE_FAILURE);
    fail_unless(message != nullptr, "%s", points.c_str());
    GError *error = nullptr;
    gst_message_parse_error(message, &error, nullptr);
    fail_unless(g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_SETTINGS));
    fail_unless(std::strstr(error->message, shown.c_str()) != nullptr, "%s", error->message);
    g_error_free(error);
    gst_message_unref(message);
  }
  GstStateChangeReturn result;
  fail_unless(message_of(" 1,2 ; +3.5,-4 ;", &result) == nullptr);
  fail_unless_equals_int(result, GST_STATE_CHANGE_SUCCESS);
}
GST_END_TEST

GST_START_TEST(points_and_region_also_exist_as_arrays) {
  const auto expect = [](const char *property, const char *text, const std::string &expected) {
    const bool points = std::strncmp(property, "points", 6) == 0;
    const std::string both = points ? pair_after(property, text, "points-array", "points")
                                    : pair_after(property, text, "region-array", "region");
    fail_unless(both == expected, "%s=%s: %s", property, text, both.c_str());
  };
  const std::string two = "<<160.000000d,120.000000d>,<96.500000d,-64.250000d>>", area = "<40i,0i,560i,480i>";
  expect("points", "160,120;96.5,-64.25", two + " | 160,120;96.5,-64.25");
  expect("points-array", "<<160,120>,<96.5,-64.25>>", two + " | 160,120;96.5,-64.25");
  expect("points-array", "<>", "<> | ");
  expect("points", "truth", "<> | truth");
  expect("points", "1,2;x", "<> | 1,2;x");
  expect("region", "40,0,560,480", area + " | 40,0,560,480");
  expect("region-array", "<40,0,560.0,480>", area + " | 40,0,560,480");
  expect("region", "1,2", "<> | 1,2");
}
GST_END_TEST

GST_START_TEST(an_array_of_another_shape_is_an_error) {
  const std::pair<const char *, const char *> bad[] = {
      {"points-array", "<1,2>"},      {"points-array", "<<1>>"},      {"points-array", "<<1,2,3>>"},
      {"points-array", "<<a,2>>"},    {"points-array", "<<>>"},       {"points-array", "<<1,2>,<>>"},
      {"region-array", "<1,2>"},      {"region-array", "<1,2,3,0>"},  {"region-array", "<1,2,3.5,4>"},
      {"region-array", "<-1,2,3,4>"}, {"region-array", "<<1,2,3,4>>"}};
  for (const auto &[property, text] : bad) {
    GstElement *track = gst_element_factory_make("csdtrack", nullptr);
    gst_util_set_object_arg(G_OBJECT(track), property, text);
    fail_unless(gst_element_set_state(track, GST_STATE_READY) == GST_STATE_CHANGE_FAILURE, "%s=%s", property, text);
    gst_element_set_state(track, GST_STATE_NULL);
    gst_object_unref(track);
  }
}
GST_END_TEST

GST_START_TEST(a_region_set_in_ready_is_checked_at_paused) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_READY), GST_STATE_CHANGE_SUCCESS);
  g_object_set(track, "region", "0,0,-5,10", nullptr);
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  g_object_set(track, "region", "0,0,5,10", nullptr);
  fail_unless_equals_int(gst_element_set_state(track, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  // From PAUSED on it doesn't change.
  g_object_set(track, "region", "rubbish", nullptr);
  gchar *region = nullptr;
  g_object_get(track, "region", &region, nullptr);
  fail_unless_equals_string(region, "0,0,5,10");
  g_free(region);
  gst_element_set_state(track, GST_STATE_NULL);
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(each_property_reads_as_set_and_structural_ones_not_after_ready) {
  GstElement *track = gst_element_factory_make("csdtrack", nullptr);
  int refusals = 0, structural = 0, live = 0;
  gst_debug_set_threshold_for_name("csdtrack", GST_LEVEL_WARNING);
  (gst_debug_add_log_function)(count_refusals, &refusals, nullptr);
  guint n = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(track), &n);
  for (const bool running : {false, true}) {
    if (running) {
      g_object_set(track, "points", "", "region", "", nullptr);
      fail_unless_equals_int(gst_element_set_state(track, GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
    }
    for (guint i = 0; i < n; ++i) {
      const GParamSpec *spec = specs[i];
      if (spec->owner_type != G_OBJECT_TYPE(track) || spec->value_type == GST_TYPE_ARRAY ||
          !(spec->flags & G_PARAM_WRITABLE))
        continue;
      const bool ready_only = spec->flags & GST_PARAM_MUTABLE_READY;
      (ready_only ? structural : live) += running;
      fail_unless(can_be_set(track, spec) == !(running && ready_only), "%s, %s", spec->name,
                  running ? "in PAUSED" : "in NULL");
    }
  }
  fail_unless(structural == 14 && live >= 7, "%d structural properties, %d others", structural, live);
  fail_unless_equals_int(refusals, structural);
  (gst_debug_remove_log_function)(count_refusals);
  g_free(specs);
  gst_element_set_state(track, GST_STATE_NULL);
  gst_object_unref(track);
}
GST_END_TEST

GST_START_TEST(a_refused_setting_is_logged_by_its_element) {
  for (const auto &[kind, setting] : {std::pair{"csdsimsrc", "seed"}, {"csdtrackdec", "location"}}) {
    GstElement *element = gst_element_factory_make(kind, nullptr);
    int refusals = 0;
    gst_debug_set_threshold_for_name(kind, GST_LEVEL_WARNING);
    (gst_debug_add_log_function)(count_refusals, &refusals, nullptr);
    fail_unless(gst_element_set_state(element, GST_STATE_PAUSED) != GST_STATE_CHANGE_FAILURE);
    gst_util_set_object_arg(G_OBJECT(element), setting, "7");
    fail_unless_equals_int(refusals, 1);
    (gst_debug_remove_log_function)(count_refusals);
    gst_element_set_state(element, GST_STATE_NULL);
    gst_object_unref(element);
  }
}
GST_END_TEST

static Suite *csdtrack_properties_suite() {
  Suite *suite = suite_create("csdtrack_properties");
  TCase *tc = tcase_create("properties");
  suite_add_tcase(suite, tc);
  tcase_add_test(tc, properties_have_their_documented_defaults);
  tcase_add_test(tc, bad_points_are_quoted_and_fail_the_change_to_ready);
  tcase_add_test(tc, points_and_region_also_exist_as_arrays);
  tcase_add_test(tc, an_array_of_another_shape_is_an_error);
  tcase_add_test(tc, a_region_set_in_ready_is_checked_at_paused);
  tcase_add_test(tc, each_property_reads_as_set_and_structural_ones_not_after_ready);
  tcase_add_test(tc, a_refused_setting_is_logged_by_its_element);
  return suite;
}

GST_CHECK_MAIN(csdtrack_properties)
