// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <json-glib/json-glib.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

// The last include, since it defines a macro `fail`.
#include <gst/check/gstcheck.h>

namespace csd_check {

using Json = std::unique_ptr<JsonNode, decltype(&json_node_unref)>;

inline Json parse(const std::string &line) {
  GError *error = nullptr;
  JsonNode *node = json_from_string(line.c_str(), &error);
  fail_unless(node && !error, "%s: %s", line.c_str(), error ? error->message : "");
  fail_unless(JSON_NODE_HOLDS_OBJECT(node));
  return Json(node, json_node_unref);
}

inline JsonObject *object(const Json &json) {
  return json_node_get_object(json.get());
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
