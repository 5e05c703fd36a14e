// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "text/json.h"

namespace csd::programs {

/// json-glib's builder with C++ types. Non-finite numbers become null.
class JsonWriter {
 public:
  JsonWriter() : builder_(json_builder_new()) {}

  JsonWriter &begin_object() { return json_builder_begin_object(builder_.get()), *this; }
  JsonWriter &end_object() { return json_builder_end_object(builder_.get()), *this; }
  JsonWriter &begin_array() { return json_builder_begin_array(builder_.get()), *this; }
  JsonWriter &end_array() { return json_builder_end_array(builder_.get()), *this; }
  JsonWriter &key(std::string_view name) {
    json_builder_set_member_name(builder_.get(), std::string(name).c_str());
    return *this;
  }
  JsonWriter &value(double number) {
    if (std::isfinite(number))
      json_builder_add_double_value(builder_.get(), number);
    else
      json_builder_add_null_value(builder_.get());
    return *this;
  }
  JsonWriter &whole(std::uint64_t number) {
    json_builder_add_int_value(builder_.get(), static_cast<gint64>(number));
    return *this;
  }
  /// A file name may be any bytes, but JSON is UTF-8.
  JsonWriter &text(const std::string &string) {
    gchar *const valid = g_utf8_make_valid(string.c_str(), static_cast<gssize>(string.size()));
    json_builder_add_string_value(builder_.get(), valid);
    g_free(valid);
    return *this;
  }
  template <typename Numbers>
  JsonWriter &values(const Numbers &numbers) {
    begin_array();
    for (const double number : numbers) value(number);
    return end_array();
  }

  std::string finish() {
    std::unique_ptr<JsonGenerator, UnrefObject> generator(json_generator_new());
    JsonNode *const root = json_builder_get_root(builder_.get());
    json_generator_set_root(generator.get(), root);
    json_generator_set_pretty(generator.get(), TRUE);
    json_generator_set_indent(generator.get(), 1);
    gchar *const data = json_generator_to_data(generator.get(), nullptr);
    std::string text = std::string(data) + "\n";
    g_free(data);
    json_node_unref(root);
    return text;
  }

 private:
  std::unique_ptr<JsonBuilder, UnrefObject> builder_;
};

}  // namespace csd::programs
