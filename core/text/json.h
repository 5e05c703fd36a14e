// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <json-glib/json-glib.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace csd {

struct UnrefObject {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// A parsed JSON text. It owns the nodes that it returns.
///
/// It refuses texts that json-glib 1.6 would crash on or misread: brackets nested a million deep overflow its stack, it
/// reads 99999999999999999999 as −1 and 010 as 8, and it accepts comments, single quotes, `var x =` and a second object
/// after the first.
class JsonText {
 public:
  /// Not json_parser_new_immutable(): json-glib 1.10 (Debian 13) leaves some roots mutable, and then aborts the
  /// process.
  JsonText() : parser_(json_parser_new()) {}

  /// Returns the root; null if the text is invalid JSON, or has more members and elements than `max_values` (json-glib
  /// takes 200 bytes for one): error() has the reason.
  JsonNode *parse(std::string_view text, std::size_t max_values);
  /// "is no JSON: …", to follow the name of the input.
  const std::string &error() const { return error_; }

 private:
  std::unique_ptr<JsonParser, UnrefObject> parser_;
  std::string error_;
};

}  // namespace csd
