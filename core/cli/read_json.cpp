// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cli/read_json.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "cli/absent_features.h"
#include "cli/feature_state.h"
#include "cli/json.h"
#include "cli/truth_table.h"

namespace csd::cli {
namespace {

using score::InputError;

bool is_object(JsonNode *node) {
  return node && JSON_NODE_HOLDS_OBJECT(node);
}
bool is_array(JsonNode *node) {
  return node && JSON_NODE_HOLDS_ARRAY(node);
}
bool is_null(JsonNode *node) {
  return !node || JSON_NODE_HOLDS_NULL(node);
}
bool is_value(JsonNode *node, GType type) {
  return node && JSON_NODE_HOLDS_VALUE(node) && json_node_get_value_type(node) == type;
}

/// A finite number, whole or not.
std::optional<double> number_of(JsonNode *node) {
  if (is_value(node, G_TYPE_INT64)) return static_cast<double>(json_node_get_int(node));
  if (is_value(node, G_TYPE_DOUBLE) && std::isfinite(json_node_get_double(node))) return json_node_get_double(node);
  return std::nullopt;
}

/// An object, and where it stands, for what is wrong with it.
class Members {
 public:
  Members(JsonObject *object, const std::string &file, std::size_t line) : object_(object), file_(file), line_(line) {}

  [[noreturn]] void fail(const std::string &what) const { throw InputError(file_, line_, what); }

  JsonNode *node(const char *name) const { return json_object_get_member(object_, name); }
  /// A whole number from 0 to `most`; none if it is null or not there.
  std::optional<std::int64_t> whole(const char *name, std::int64_t most = G_MAXINT64) const {
    JsonNode *const value = node(name);
    if (is_null(value)) return std::nullopt;
    if (!is_value(value, G_TYPE_INT64) || json_node_get_int(value) < 0 || json_node_get_int(value) > most)
      fail(std::string("`") + name + "` is no whole number from 0" +
           (most < G_MAXINT64 ? " to " + std::to_string(most) : ""));
    return json_node_get_int(value);
  }
  double number(const char *name) const {
    const auto value = number_of(node(name));
    if (!value) fail(std::string("`") + name + "` is no number");
    return *value;
  }
  std::string_view word(const char *name) const {
    JsonNode *const value = node(name);
    if (is_null(value)) return {};
    if (!is_value(value, G_TYPE_STRING)) fail(std::string("`") + name + "` is no string");
    return json_node_get_string(value);
  }
  JsonArray *array(const char *name) const {
    JsonNode *const value = node(name);
    if (!is_array(value)) fail(std::string("`") + name + "` is no array");
    return json_node_get_array(value);
  }

 private:
  JsonObject *object_;
  const std::string &file_;
  std::size_t line_;
};

Feature feature_of(JsonNode *node, const std::string &file, std::size_t line) {
  if (!is_object(node)) throw InputError(file, line, "a feature is no object");
  const Members members(json_node_get_object(node), file, line);
  const auto id = members.whole("id", no_feature - 1);
  if (!id) members.fail("a feature has no `id`");
  Feature feature;
  feature.id = static_cast<FeatureId>(*id);
  feature.x = members.number("x");
  feature.y = members.number("y");
  feature.confidence = members.number("confidence");
  if (feature.confidence < 0 || feature.confidence > 1) members.fail("a confidence is from 0 to 1");
  const std::string_view word = members.word("state");
  const auto state = state_of(word);
  if (!state) members.fail("there is no state '" + std::string(word) + "'");
  feature.state = *state;
  return feature;
}

/// What a line says, whatever its role.
struct Line {
  std::string role, algorithm;
  int width = 0, height = 0;
  score::TrackFrame frame;
};

Line line_of(JsonNode *root, const std::string &file, std::size_t number) {
  if (!is_object(root)) throw InputError(file, number, "is no JSON object");
  const Members members(json_node_get_object(root), file, number);
  const auto schema = members.whole("schema");
  if (schema != 1)
    members.fail(schema ? "schema " + std::to_string(*schema) + " is not known (1 is)" : "has no `schema`");
  constexpr int largest = 1 << 20;
  Line line;
  line.role = members.word("role");
  line.algorithm = members.word("algorithm");
  line.width = static_cast<int>(members.whole("width", largest).value_or(0));
  line.height = static_cast<int>(members.whole("height", largest).value_or(0));
  const auto frame = members.whole("frame");
  line.frame.numbered = frame.has_value();
  line.frame.frame = static_cast<std::uint64_t>(frame.value_or(0));
  line.frame.pts = members.whole("pts").value_or(no_time);
  line.frame.line = number;
  JsonArray *const features = members.array("features");
  for (guint i = 0; i < json_array_get_length(features); ++i) {
    const Feature feature = feature_of(json_array_get_element(features, i), file, number);
    if (!line.frame.features.empty() && line.frame.features.back().id >= feature.id)
      members.fail("feature " + std::to_string(feature.id) + " after feature " +
                   std::to_string(line.frame.features.back().id));
    line.frame.features.push_back(feature);
  }
  if (!line.frame.numbered && !line.frame.features.empty()) members.fail("has features, but no `frame`");
  return line;
}

void add_truth(TruthTable &truth, const Line &line, const std::string &file) {
  if (line.width && line.height) truth.size(line.width, line.height, line.frame.line);
  for (const Feature &feature : line.frame.features) {
    score::TruthPoint point{score::Presence::visible, {feature.x, feature.y}};
    if (feature.state == FeatureState::occluded)
      point.presence = score::Presence::hidden;
    else if (feature.state == FeatureState::out)
      point.presence = score::Presence::out;
    else if (feature.state != FeatureState::tracked)
      throw InputError(file, line.frame.line,
                       "a truth's states are tracked, occluded and out, not " + std::string(state_name(feature.state)));
    truth.add(line.frame.frame, line.frame.pts, feature.id, point, line.frame.line);
  }
}

void add_tracks(score::Recording &tracks, Line &&line) {
  const auto fail = [&](const std::string &what) { throw InputError(tracks.file, line.frame.line, what); };
  if (line.width && line.height) {
    if (tracks.width && (tracks.width != line.width || tracks.height != line.height))
      fail("the picture's size changes");
    tracks.width = line.width;
    tracks.height = line.height;
  }
  if (!line.algorithm.empty()) {
    if (!tracks.algorithm.empty() && tracks.algorithm != line.algorithm)
      fail("is by " + line.algorithm + ", the lines before by " + tracks.algorithm);
    tracks.algorithm = line.algorithm;
  }
  tracks.frames.push_back(std::move(line.frame));
}

}  // namespace

bool is_jsonl(const TextFile &file) {
  const std::string_view content = file.content;
  if (content.starts_with("{\"schema\"")) return true;  // also where the rest of the line is damaged
  JsonText json;
  JsonNode *const root = json.parse(content.substr(0, content.find('\n')));
  return is_object(root) && json_object_has_member(json_node_get_object(root), "features");
}

std::variant<score::Truth, score::Recording> read_jsonl(const TextFile &file, std::vector<std::string> &notes) {
  JsonText json;
  std::string role;
  TruthTable truth(file.name);
  score::Recording tracks;
  tracks.file = file.name;
  for (const TextFile::Line &text : file.lines()) {
    JsonNode *const root = json.parse(text.text);
    if (!root) throw InputError(file.name, text.number, "is no JSON: " + json.error());
    Line line = line_of(root, file.name, text.number);
    if (line.role != "track" && line.role != "truth")
      throw InputError(file.name, text.number, "`role` is '" + line.role + "', neither track nor truth");
    if (role.empty()) role = line.role;
    if (line.role != role)
      throw InputError(file.name, text.number, "`role` is " + line.role + ", in the lines before it is " + role);
    if (role == "truth")
      add_truth(truth, line, file.name);
    else
      add_tracks(tracks, std::move(line));
  }
  note_torn(file, notes);
  if (role == "truth") return truth.take();
  note_absent(tracks, notes);
  return tracks;
}

score::Truth read_labels(const TextFile &file) {
  JsonText json;
  JsonNode *const root = json.parse(file.content);
  if (!root) throw InputError(file.name, 0, "is no JSON: " + json.error());
  if (!is_object(root)) throw InputError(file.name, 0, "is no JSON object");
  JsonObject *const object = json_node_get_object(root);
  TruthTable truth(file.name);
  std::optional<guint> count;
  JsonObjectIter iterator;
  const char *name;
  JsonNode *node;
  json_object_iter_init_ordered(&iterator, object);
  while (json_object_iter_next_ordered(&iterator, &name, &node)) {
    const std::string_view key(name);
    std::uint64_t frame = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), frame);
    if (key.empty() || error != std::errc() || end != key.data() + key.size())
      throw InputError(
          file.name, 0,
          "is neither csdtrackenc's lines nor labels by frame: '" + std::string(key) + "' is no frame number");
    const auto fail = [&](const std::string &what) {
      throw InputError(file.name, 0, "frame " + std::string(key) + ": " + what);
    };
    if (is_null(node)) continue;
    if (!is_array(node)) fail("is no list of points");
    JsonArray *const points = json_node_get_array(node);
    const guint length = json_array_get_length(points);
    if (count && *count != length)
      fail("has " + std::to_string(length) + " points, the frame before has " + std::to_string(*count));
    count = length;
    for (guint i = 0; i < length; ++i) {
      JsonNode *const pair = json_array_get_element(points, i);
      score::TruthPoint point{score::Presence::hidden, {score::unknown, score::unknown}};
      if (!is_null(pair)) {
        JsonArray *const numbers = is_array(pair) ? json_node_get_array(pair) : nullptr;
        const bool two = numbers && json_array_get_length(numbers) == 2;
        const auto x = two ? number_of(json_array_get_element(numbers, 0)) : std::nullopt;
        const auto y = two ? number_of(json_array_get_element(numbers, 1)) : std::nullopt;
        if (!x || !y) fail("point " + std::to_string(i) + " is neither [x, y] nor null");
        point = {score::Presence::visible, {*x, *y}};
      }
      truth.add(frame, no_time, i, point, 0);
    }
  }
  return truth.take();
}

}  // namespace csd::cli
