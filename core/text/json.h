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

/// A JSON text that was parsed. The nodes it hands out are its own.
///
/// A text that json-glib 1.6 would not survive, or would read as something else than JSON says, is refused: brackets
/// nested a million deep overflow its stack, 99999999999999999999 is −1 to it and 010 is 8, and it knows comments,
/// single quotes, `var x =` and a second object behind the first.
class JsonText {
 public:
  /// Not json_parser_new_immutable(): json-glib 1.10 (Debian 13) leaves some roots mutable, and aborts the process
  /// then.
  JsonText() : parser_(json_parser_new()) {}

  /// Gives the root; null if the text is no JSON, or has more members and elements than `max_values` (json-glib takes
  /// 200 bytes for one): error() says why.
  JsonNode *parse(std::string_view text, std::size_t max_values);
  /// "is no JSON: …", to follow the name of what was parsed.
  const std::string &error() const { return error_; }

 private:
  std::unique_ptr<JsonParser, UnrefObject> parser_;
  std::string error_;
};

}  // namespace csd
