// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_json.h"

#include <simdjson.h>

#include <charconv>
#include <optional>

#include "programs/absent_features.h"
#include "programs/truth_table.h"
#include "text/json.h"
#include "text/read_line.h"

namespace csd::programs {
namespace {

using score::InputError;

constexpr std::size_t max_label_values = 1 << 21;  // of a file: 20 points in 30000 frames

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
  if (width && height && !tracks.width) {
    tracks.width = width;
    tracks.height = height;
  }
  if (!line.algorithm.empty()) {
    if (!tracks.algorithm.empty() && tracks.algorithm != line.algorithm)
      fail("is by " + printable(line.algorithm) + ", the lines before by " + printable(tracks.algorithm));
    tracks.algorithm = line.algorithm;
  }
  tracks.frames.push_back({line.numbered, line.tracks.frame, line.pts, number, std::move(line.tracks.features),
                           line.stream_time, line.running_time, width, height});
}

}  // namespace

bool is_jsonl(const TextFile &file) {
  const std::string_view first = file.first().text;
  if (first.starts_with("{\"schema\"")) return true;  // even if the rest of the line is damaged
  JsonText json;
  try {
    return json.parse(first, max_line_values).at_key("features").error() == simdjson::SUCCESS;
  } catch (const JsonError &) {
    return false;
  }
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

namespace {

/// [x, y] or null; none of other values.
std::optional<score::TruthPoint> label_of(simdjson::dom::element value) {
  if (value.is_null()) return score::TruthPoint{score::Presence::hidden, {score::unknown, score::unknown}};
  simdjson::dom::array pair;
  score::TruthPoint point{score::Presence::visible, {}};
  if (value.get(pair) != simdjson::SUCCESS || pair.size() != 2 ||
      pair.at(0).get(point.position.x) != simdjson::SUCCESS || pair.at(1).get(point.position.y) != simdjson::SUCCESS)
    return std::nullopt;
  return point;
}

simdjson::dom::object labels_of(JsonText &json, const TextFile &file) {
  simdjson::dom::object object;
  try {
    if (json.parse(file.content, max_label_values).get(object) == simdjson::SUCCESS) return object;
  } catch (const JsonError &error) {
    throw InputError(file.name, 0, error.what());
  }
  throw InputError(file.name, 0, "is no JSON object");
}

}  // namespace

score::Truth read_labels(const TextFile &file) {
  JsonText json;
  TruthTable truth(file.name);
  std::optional<std::size_t> count;
  for (const simdjson::dom::key_value_pair member : labels_of(json, file)) {
    const std::string_view key = member.key;
    std::uint64_t frame = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), frame);
    if (key.empty() || error != std::errc() || end != key.data() + key.size())
      throw InputError(
          file.name, 0,
          "is neither csdtrackenc's lines nor labels by frame: '" + std::string(key) + "' is no frame number");
    const auto fail = [&](const std::string &what) {
      throw InputError(file.name, 0, "frame " + std::string(key) + ": " + what);
    };
    if (member.value.is_null()) continue;
    simdjson::dom::array points;
    if (member.value.get(points) != simdjson::SUCCESS) fail("is no list of points");
    FeatureId length = 0;
    for (const auto value : points) {
      const auto point = label_of(value);
      if (!point) fail("point " + std::to_string(length) + " is neither [x, y] nor null");
      truth.add(frame, no_time, length++, *point, 0);
    }
    if (count.value_or(length) != length)
      fail("has " + std::to_string(length) + " points, the frame before has " + std::to_string(*count));
    count = length;
  }
  return truth.take();
}

}  // namespace csd::programs
