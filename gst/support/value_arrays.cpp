// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/value_arrays.h"

#include <array>
#include <charconv>
#include <type_traits>

#include "text/parse.h"

namespace csd {
namespace {

/// A number as the text properties write it: as short as it can be read back, with a decimal point in every locale.
std::string number_text(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string item_text(const GValue &item) {
  if (G_VALUE_HOLDS_DOUBLE(&item)) return number_text(g_value_get_double(&item));
  if (G_VALUE_HOLDS_FLOAT(&item)) return number_text(static_cast<double>(g_value_get_float(&item)));
  gchar *const text = gst_value_serialize(&item);  // of whole numbers: their digits
  if (!text) return G_VALUE_TYPE_NAME(&item);
  std::string result = text;
  g_free(text);
  return result;
}

/// The items' texts with commas between.
std::string joined(const GValue &array) {
  std::string text;
  for (guint i = 0; i < gst_value_array_get_size(&array); ++i) {
    if (i > 0) text += ',';
    text += item_text(*gst_value_array_get_value(&array, i));
  }
  return text;
}

void append(GValue &array, GValue item) {
  gst_value_array_append_and_take_value(&array, &item);
}

template <typename Number>
void append_number(GValue &array, Number number) {
  GValue item = G_VALUE_INIT;
  if constexpr (std::is_floating_point_v<Number>) {
    g_value_init(&item, G_TYPE_DOUBLE);
    g_value_set_double(&item, number);
  } else {
    g_value_init(&item, G_TYPE_INT);
    g_value_set_int(&item, number);
  }
  append(array, item);
}

}  // namespace

std::string points_text(const GValue &array) {
  std::string text;
  for (guint i = 0; i < gst_value_array_get_size(&array); ++i) {
    const GValue &point = *gst_value_array_get_value(&array, i);
    if (i > 0) text += ';';
    const std::string item = GST_VALUE_HOLDS_ARRAY(&point) ? joined(point) : item_text(point);
    text += item.empty() ? "," : item;  // an empty text would be no points at all
  }
  return text;
}

void set_points(GValue &array, const std::string &text) {
  if (is_truth(text)) return;
  for (const cv::Point2d &p : parse_points(text).value) {
    GValue point = G_VALUE_INIT;
    g_value_init(&point, GST_TYPE_ARRAY);
    append_number(point, p.x);
    append_number(point, p.y);
    append(array, point);
  }
}

std::string region_text(const GValue &array) {
  return joined(array);
}

void set_region(GValue &array, const std::string &text) {
  const auto region = parse_region(text);
  if (!region || region.value.empty()) return;
  for (const int number : {region.value.x, region.value.y, region.value.width, region.value.height})
    append_number(array, number);
}

}  // namespace csd
