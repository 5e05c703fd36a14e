// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <simdjson.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

// The last include, since it defines a macro `fail`.
#include <gst/check/gstcheck.h>

namespace csd_check {

/// A line of JSON. What is asked of it and isn't there, or is of another type, throws.
class Json {
 public:
  explicit Json(const std::string &line) : parser_(std::make_unique<simdjson::dom::parser>()) {
    const auto error = parser_->parse(line).get(root_);
    fail_unless(!error, "%s: %s", line.c_str(), simdjson::error_message(error));
  }
  simdjson::dom::element operator[](const char *member) const { return root_.at_key(member); }
  simdjson::dom::object object() const { return root_; }
  simdjson::dom::array features() const { return root_.at_key("features"); }

 private:
  std::unique_ptr<simdjson::dom::parser> parser_;
  simdjson::dom::element root_;
};

inline const char *text(simdjson::dom::element value) {
  return value.get_c_str();
}

inline std::string text_in(GstBuffer *buffer) {
  gpointer data = nullptr;
  gsize size = 0;
  gst_buffer_extract_dup(buffer, 0, -1, &data, &size);
  const std::string text(static_cast<char *>(data), size);
  g_free(data);
  return text;
}

inline std::vector<std::string> lines_of(const std::string &text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace csd_check
