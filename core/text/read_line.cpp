// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/read_line.h"

#include <simdjson.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "text/feature_state.h"

namespace csd {
namespace {

using simdjson::dom::element;

constexpr std::size_t max_name = 1000;  // bytes of a name
constexpr std::int64_t max_whole = std::numeric_limits<std::int64_t>::max();

[[noreturn]] void refuse(std::string_view name, const std::string &why) {
  throw LineError("`" + std::string(name) + "` " + why);
}

/// A member of an object; none if it is missing or null.
struct Member {
  std::string_view name;
  std::optional<element> value{};

  /// A whole number from 0 to `largest`; none if null or missing.
  std::optional<std::int64_t> whole(std::int64_t largest = max_whole) const {
    if (!value) return std::nullopt;
    std::int64_t number = 0;
    if (value->get(number) == simdjson::SUCCESS && number >= 0 && number <= largest) return number;
    const bool too_large = largest < max_whole || value->is_uint64();
    refuse(name, "is no whole number from 0" + (too_large ? " to " + std::to_string(largest) : ""));
  }
  double number() const {
    double number = 0;
    if (!value || value->get(number) != simdjson::SUCCESS) refuse(name, "is no number");
    return number;
  }
  double position() const {
    const double value = number();
    if (!(std::abs(value) <= max_pixels)) refuse(name, "is beyond " + std::to_string(max_pixels) + " pixels");
    return value;
  }
  std::string_view word() const {
    if (!value) return {};
    std::string_view word;
    if (value->get(word) != simdjson::SUCCESS) refuse(name, "is no string");
    if (word.size() > max_name) refuse(name, "is longer than 1000 bytes");
    // Strings of GStreamer end there.
    if (word.find('\0') != word.npos) refuse(name, "holds a character 0");
    return word;
  }
  simdjson::dom::array array() const {
    simdjson::dom::array array;
    if (!value || value->get(array) != simdjson::SUCCESS) refuse(name, "is no array");
    return array;
  }
  /// True if missing.
  bool unless_false() const {
    bool flag = true;
    if (value && value->get(flag) != simdjson::SUCCESS) refuse(name, "is neither true nor false");
    return flag;
  }
};

/// Looks up members in one pass. Of those of one name the last counts, as for most readers.
template <typename... Members>
void find(const simdjson::dom::object &object, Members &...members) {
  const std::array<Member *, sizeof...(members)> wanted = {&members...};
  std::size_t next = 0;  // they mostly come in this order
  for (const simdjson::dom::key_value_pair member : object) {
    for (std::size_t tries = 0; tries < wanted.size(); ++tries) {
      Member &one = *wanted[next];
      next = next + 1 < wanted.size() ? next + 1 : 0;
      if (one.name != member.key) continue;
      one.value = member.value.is_null() ? std::nullopt : std::optional(member.value);
      break;
    }
  }
}

Feature feature_of(element value) {
  simdjson::dom::object object;
  if (value.get(object) != simdjson::SUCCESS) throw LineError("a feature is no object");
  Member id{"id"}, x{"x"}, y{"y"}, state{"state"}, confidence{"confidence"}, fresh{"fresh"};
  find(object, id, x, y, state, confidence, fresh);
  const auto number = id.whole(no_feature - 1);
  if (!number) throw LineError("a feature has no `id`");
  Feature feature;
  feature.id = static_cast<FeatureId>(*number);
  feature.x = x.position();
  feature.y = y.position();
  feature.confidence = confidence.number();
  if (feature.confidence < 0 || feature.confidence > 1) throw LineError("a confidence is from 0 to 1");
  const auto known = state_of(state.word());
  if (!known) throw LineError("there is no state '" + std::string(state.word()) + "'");
  feature.state = *known;
  feature.fresh = fresh.unless_false();
  return feature;
}

element parsed(JsonText &json, std::string_view text) {
  if (text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
  try {
    return json.parse(text, max_line_values);
  } catch (const JsonError &error) {
    throw LineError(error.what());
  }
}

bool is_truth(std::string_view role) {
  if (role != "track" && role != "truth")
    throw LineError("`role` is '" + std::string(role) + "', neither track nor truth");
  return role == "truth";
}

/// Two whole numbers above 0; zeros if null or missing.
std::pair<int, int> aspect_of(const Member &member) {
  if (!member.value) return {0, 0};
  const simdjson::dom::array array = member.array();
  std::array<std::int64_t, 2> numbers{};
  std::size_t count = 0;
  for (const element value : array) {
    if (count == 2 || value.get(numbers[count]) != simdjson::SUCCESS || numbers[count] < 1 ||
        numbers[count] > max_pixels)
      refuse(member.name, "is no pair of whole numbers from 1 to " + std::to_string(max_pixels));
    ++count;
  }
  if (count != 2) refuse(member.name, "is no pair of whole numbers from 1 to " + std::to_string(max_pixels));
  return {static_cast<int>(numbers[0]), static_cast<int>(numbers[1])};
}

std::vector<Feature> features_of(const simdjson::dom::array &array, bool truth) {
  std::vector<Feature> features;
  features.reserve(std::min(array.size(), max_line_features));
  for (const element value : array) {
    if (features.size() == max_line_features)
      throw LineError("has more than " + std::to_string(max_line_features) + " features");
    const Feature feature = feature_of(value);
    if (!features.empty() && features.back().id >= feature.id)
      throw LineError("feature " + std::to_string(feature.id) + " after feature " + std::to_string(features.back().id));
    if (truth && feature.state != FeatureState::tracked && feature.state != FeatureState::occluded &&
        feature.state != FeatureState::out)
      throw LineError("a truth's states are tracked, occluded and out, not " + std::string(state_name(feature.state)));
    features.push_back(feature);
  }
  return features;
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
  simdjson::dom::object object;
  if (parsed(json, text).get(object) != simdjson::SUCCESS) throw LineError("is no JSON object");
  Member schema{"schema"}, source{"source"}, role{"role"}, algorithm{"algorithm"}, frame{"frame"}, pts{"pts"};
  Member duration{"duration"}, running_time{"running_time"}, stream_time{"stream_time"};
  Member width{"width"}, height{"height"}, pixel_aspect{"pixel_aspect"}, features{"features"};
  find(object, schema, source, role, algorithm, frame, pts, duration, running_time, stream_time, width, height,
       pixel_aspect, features);
  const auto version = schema.whole();
  if (version != 1)
    throw LineError(version ? "schema " + std::to_string(*version) + " is not known (1 is)" : "has no `schema`");
  TrackLine line;
  line.truth = is_truth(role.word());
  line.source = source.word();
  line.algorithm = algorithm.word();
  line.tracks.width = static_cast<int>(width.whole(max_pixels).value_or(0));
  line.tracks.height = static_cast<int>(height.whole(max_pixels).value_or(0));
  std::tie(line.pixel_aspect_n, line.pixel_aspect_d) = aspect_of(pixel_aspect);
  const auto number = frame.whole();
  line.numbered = number.has_value();
  if (line.numbered && (line.tracks.width < 1 || line.tracks.height < 1))
    throw LineError("has no `width` or no `height`");
  line.tracks.frame = static_cast<std::uint64_t>(number.value_or(0));
  line.pts = pts.whole().value_or(no_time);
  line.duration = duration.whole().value_or(no_time);
  line.stream_time = stream_time.whole().value_or(no_time);
  line.running_time = running_time.whole().value_or(no_time);
  if (line.stream_time > max_time) throw LineError("`stream_time` is more than 146 years");
  line.tracks.features = features_of(features.array(), line.truth);
  if (!line.numbered && !line.tracks.features.empty()) throw LineError("has features, but no `frame`");
  return line;
}

}  // namespace csd
