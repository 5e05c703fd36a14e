// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/read_line.h"

#include <cmath>
#include <optional>

#include "text/feature_state.h"
#include "text/json_node.h"

namespace csd {
namespace {

constexpr std::size_t max_name = 1000;  // bytes of a name

/// Reads the members of an object and checks them.
class Members {
 public:
  explicit Members(JsonObject *object) : object_(object) {}

  JsonNode *node(const char *name) const { return json_object_get_member(object_, name); }
  /// A whole number from 0 to `most`; none if null or missing.
  std::optional<std::int64_t> whole(const char *name, std::int64_t most = G_MAXINT64) const {
    JsonNode *const value = node(name);
    if (is_null(value)) return std::nullopt;
    if (!is_value(value, G_TYPE_INT64) || json_node_get_int(value) < 0 || json_node_get_int(value) > most)
      throw LineError(std::string("`") + name + "` is no whole number from 0" +
                      (most < G_MAXINT64 ? " to " + std::to_string(most) : ""));
    return json_node_get_int(value);
  }
  double number(const char *name) const {
    const auto value = number_of(node(name));
    if (!value) throw LineError(std::string("`") + name + "` is no number");
    return *value;
  }
  double position(const char *name) const {
    const double value = number(name);
    if (!(std::abs(value) <= max_pixels))
      throw LineError(std::string("`") + name + "` is beyond " + std::to_string(max_pixels) + " pixels");
    return value;
  }
  std::string_view word(const char *name) const {
    JsonNode *const value = node(name);
    if (is_null(value)) return {};
    if (!is_value(value, G_TYPE_STRING)) throw LineError(std::string("`") + name + "` is no string");
    const std::string_view word = json_node_get_string(value);
    if (word.size() > max_name) throw LineError(std::string("`") + name + "` is longer than 1000 bytes");
    // Half a surrogate pair (\ud800), which json-glib may let through. Metas and messages must be UTF-8.
    if (!g_utf8_validate(word.data(), static_cast<gssize>(word.size()), nullptr))
      throw LineError(std::string("`") + name + "` holds half a character");
    return word;
  }
  JsonArray *array(const char *name) const {
    JsonNode *const value = node(name);
    if (!is_array(value)) throw LineError(std::string("`") + name + "` is no array");
    return json_node_get_array(value);
  }
  /// True if missing.
  bool unless_false(const char *name) const {
    JsonNode *const value = node(name);
    if (is_null(value)) return true;
    if (!is_value(value, G_TYPE_BOOLEAN)) throw LineError(std::string("`") + name + "` is neither true nor false");
    return json_node_get_boolean(value);
  }

 private:
  JsonObject *object_;
};

Feature feature_of(JsonNode *node) {
  if (!is_object(node)) throw LineError("a feature is no object");
  const Members members(json_node_get_object(node));
  const auto id = members.whole("id", no_feature - 1);
  if (!id) throw LineError("a feature has no `id`");
  Feature feature;
  feature.id = static_cast<FeatureId>(*id);
  feature.x = members.position("x");
  feature.y = members.position("y");
  feature.confidence = members.number("confidence");
  if (feature.confidence < 0 || feature.confidence > 1) throw LineError("a confidence is from 0 to 1");
  const std::string_view word = members.word("state");
  const auto state = state_of(word);
  if (!state) throw LineError("there is no state '" + std::string(word) + "'");
  feature.state = *state;
  feature.fresh = members.unless_false("fresh");
  return feature;
}

bool is_truth(std::string_view role) {
  if (role != "track" && role != "truth")
    throw LineError("`role` is '" + std::string(role) + "', neither track nor truth");
  return role == "truth";
}

}  // namespace

std::string_view line_text(std::string_view bytes) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (bytes.starts_with(mark)) bytes.remove_prefix(mark.size());
  return bytes.substr(0, bytes.find_last_not_of(line_blanks) + 1);
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool long_control = c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (long_control) ++i;
    out += long_control || c < 0x20 || c == 0x7f ? '?' : text[i];
  }
  return out;
}

TrackLine read_track_line(JsonText &json, std::string_view text) {
  if (text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
  JsonNode *const root = json.parse(text, max_line_values);
  if (!root) throw LineError(json.error());
  if (!is_object(root)) throw LineError("is no JSON object");
  const Members members(json_node_get_object(root));
  const auto schema = members.whole("schema");
  if (schema != 1)
    throw LineError(schema ? "schema " + std::to_string(*schema) + " is not known (1 is)" : "has no `schema`");
  TrackLine line;
  line.truth = is_truth(members.word("role"));
  line.source = members.word("source");
  line.algorithm = members.word("algorithm");
  line.tracks.width = static_cast<int>(members.whole("width", max_pixels).value_or(0));
  line.tracks.height = static_cast<int>(members.whole("height", max_pixels).value_or(0));
  const auto frame = members.whole("frame");
  line.numbered = frame.has_value();
  if (line.numbered && (line.tracks.width < 1 || line.tracks.height < 1))
    throw LineError("has no `width` or no `height`");
  line.tracks.frame = static_cast<std::uint64_t>(frame.value_or(0));
  line.pts = members.whole("pts").value_or(no_time);
  line.duration = members.whole("duration").value_or(no_time);
  line.stream_time = members.whole("stream_time").value_or(no_time);
  if (line.stream_time > max_time) throw LineError("`stream_time` is more than 146 years");
  JsonArray *const array = members.array("features");
  const guint count = json_array_get_length(array);
  if (count > max_line_features) throw LineError("has more than " + std::to_string(max_line_features) + " features");
  std::vector<Feature> &features = line.tracks.features;
  features.reserve(count);
  for (guint i = 0; i < count; ++i) {
    features.push_back(feature_of(json_array_get_element(array, i)));
    if (i > 0 && features[i - 1].id >= features[i].id)
      throw LineError("feature " + std::to_string(features[i].id) + " after feature " +
                      std::to_string(features[i - 1].id));
    if (line.truth && features[i].state != FeatureState::tracked && features[i].state != FeatureState::occluded &&
        features[i].state != FeatureState::out)
      throw LineError("a truth's states are tracked, occluded and out, not " +
                      std::string(state_name(features[i].state)));
  }
  if (!line.numbered && count > 0) throw LineError("has features, but no `frame`");
  return line;
}

}  // namespace csd
