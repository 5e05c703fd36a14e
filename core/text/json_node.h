// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <json-glib/json-glib.h>

#include <cmath>
#include <optional>

namespace csd {

// Typed access to nodes. A null node is a missing member.

inline bool is_object(JsonNode *node) {
  return node && JSON_NODE_HOLDS_OBJECT(node);
}
inline bool is_array(JsonNode *node) {
  return node && JSON_NODE_HOLDS_ARRAY(node);
}
inline bool is_null(JsonNode *node) {
  return !node || JSON_NODE_HOLDS_NULL(node);
}
inline bool is_value(JsonNode *node, GType type) {
  return node && JSON_NODE_HOLDS_VALUE(node) && json_node_get_value_type(node) == type;
}

/// A finite number, whole or not.
inline std::optional<double> number_of(JsonNode *node) {
  if (is_value(node, G_TYPE_INT64)) return static_cast<double>(json_node_get_int(node));
  if (is_value(node, G_TYPE_DOUBLE) && std::isfinite(json_node_get_double(node))) return json_node_get_double(node);
  return std::nullopt;
}

}  // namespace csd
