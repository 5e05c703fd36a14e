// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <json-glib/json-glib.h>

#include <memory>
#include <string>
#include <string_view>

namespace csd::cli {

struct UnrefObject {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// A JSON text that was parsed. The nodes it hands out are its own.
class JsonText {
 public:
  JsonText() : parser_(json_parser_new_immutable()) {}

  /// Gives the root; null if the text is no JSON (error() says why).
  JsonNode *parse(std::string_view text) {
    GError *error = nullptr;
    error_.clear();
    if (json_parser_load_from_data(parser_.get(), text.data(), static_cast<gssize>(text.size()), &error))
      return json_parser_get_root(parser_.get());
    error_ = error->message;
    g_error_free(error);
    return nullptr;
  }
  const std::string &error() const { return error_; }

 private:
  std::unique_ptr<JsonParser, UnrefObject> parser_;
  std::string error_;
};

}  // namespace csd::cli
