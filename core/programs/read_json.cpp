// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_json.h"

#include <charconv>
#include <optional>

#include "programs/absent_features.h"
#include "programs/truth_table.h"
#include "text/json.h"
#include "text/json_node.h"
#include "text/read_line.h"

namespace csd::programs {
namespace {

using score::InputError;

constexpr std::size_t max_label_values = 1 << 21;  // of a file: 20 points in 30000 frames; 400 MB to json-glib

const char *role_of(bool truth) {
  return truth ? "truth" : "track";
}

void add_truth(TruthTable &truth, const TrackLine &line, std::size_t number) {
  const Tracks &tracks = line.tracks;
  if (tracks.width && tracks.height) truth.size(tracks.width, tracks.height, number);
  for (const Feature &feature : tracks.features) {
    score::TruthPoint point{score::Presence::visible, {feature.x, feature.y}};
    if (feature.state == FeatureState::occluded)
      point.presence = score::Presence::hidden;
    else if (feature.state == FeatureState::out)
      point.presence = score::Presence::out;
    truth.add(tracks.frame, line.pts, feature.id, point, number);
  }
}

void add_tracks(score::Recording &tracks, TrackLine &&line, std::size_t number) {
  const auto fail = [&](const std::string &what) { throw InputError(tracks.file, number, what); };
  const int width = line.tracks.width, height = line.tracks.height;
  if (width && height) {
    if (tracks.width && (tracks.width != width || tracks.height != height)) fail("the picture's size changes");
    tracks.width = width;
    tracks.height = height;
  }
  if (!line.algorithm.empty()) {
    if (!tracks.algorithm.empty() && tracks.algorithm != line.algorithm)
      fail("is by " + printable(line.algorithm) + ", the lines before by " + printable(tracks.algorithm));
    tracks.algorithm = line.algorithm;
  }
  tracks.frames.push_back({line.numbered, line.tracks.frame, line.pts, number, std::move(line.tracks.features)});
}

}  // namespace

bool is_jsonl(const TextFile &file) {
  const std::string_view first = file.first().text;
  if (first.starts_with("{\"schema\"")) return true;  // even if the rest of the line is damaged
  JsonText json;
  JsonNode *const root = json.parse(first, max_line_values);
  return is_object(root) && json_object_has_member(json_node_get_object(root), "features");
}

std::variant<score::Truth, score::Recording> read_jsonl(const TextFile &file, std::vector<std::string> &notes) {
  JsonText json;
  std::optional<bool> is_truth;
  TruthTable truth(file.name);
  score::Recording tracks;
  tracks.file = file.name;
  const std::vector<TextFile::Line> lines = file.lines();
  if (lines.empty()) throw InputError(file.name, 0, "has no whole line");
  for (const TextFile::Line &text : lines) {
    TrackLine line;
    try {
      line = read_track_line(json, text.text);
    } catch (const LineError &error) {
      throw InputError(file.name, text.number, error.what());
    }
    if (is_truth.value_or(line.truth) != line.truth)
      throw InputError(
          file.name, text.number,
          std::string("`role` is ") + role_of(line.truth) + ", in the lines before it is " + role_of(*is_truth));
    is_truth = line.truth;
    if (line.truth)
      add_truth(truth, line, text.number);
    else
      add_tracks(tracks, std::move(line), text.number);
  }
  note_torn(file, notes);
  if (is_truth.value_or(false)) return truth.take();
  note_absent(tracks, notes);
  return tracks;
}

score::Truth read_labels(const TextFile &file) {
  JsonText json;
  JsonNode *const root = json.parse(file.content, max_label_values);
  if (!root) throw InputError(file.name, 0, json.error());
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

}  // namespace csd::programs
