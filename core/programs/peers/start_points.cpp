// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/start_points.h"

#include <filesystem>
#include <stdexcept>
#include <utility>
#include <variant>

#include "base/setting_text.h"
#include "programs/read_input.h"
#include "text/parse.h"

namespace csd::peers {

namespace {

/// The points visible in the truth, or claimed by a tracker, in the first frame.
StartPoints first_of(const score::Truth &truth) {
  if (truth.frames.empty() || truth.frames.front().frame != 0) throw score::InputError(truth.file, 0, "has no frame 0");
  StartPoints points{{}, {}, truth.width, truth.height};
  for (std::size_t i = 0; i < truth.ids.size(); ++i) {
    const score::TruthPoint &point = truth.frames.front().points[i];
    if (point.presence != score::Presence::visible) continue;
    points.ids.push_back(truth.ids[i]);
    points.positions.push_back(point.position);
  }
  return points;
}

StartPoints first_of(const score::Recording &tracks) {
  if (tracks.frames.empty() || !tracks.frames.front().numbered || tracks.frames.front().frame != 0)
    throw score::InputError(tracks.file, 0, "has no frame 0");
  StartPoints points{{}, {}, tracks.width, tracks.height};
  for (const Feature &feature : tracks.frames.front().features) {
    if (!claims_position(feature.state)) continue;
    points.ids.push_back(feature.id);
    points.positions.emplace_back(feature.x, feature.y);
  }
  return points;
}

}  // namespace

StartPoints read_start_points(const std::string &text_or_file) {
  StartPoints points;
  std::error_code ignored;
  if (std::filesystem::exists(text_or_file, ignored)) {
    std::vector<std::string> notes;  // notes on skipped data only matter for scoring
    points = std::visit([](const auto &input) { return first_of(input); }, programs::read_input(text_or_file, notes));
  } else {
    auto parsed = parse_points(text_or_file);
    if (!parsed) throw std::runtime_error(shown_text(text_or_file) + " is no file, and as " + parsed.error);
    points.positions = std::move(parsed.value);
    for (FeatureId id = 0; id < points.positions.size(); ++id) points.ids.push_back(id);
  }
  if (points.ids.empty()) throw std::runtime_error(text_or_file + ": no visible points in the first frame");
  return points;
}

StartPoints thinned(const StartPoints &points, std::size_t wanted) {
  const auto n = points.ids.size();
  if (wanted == 0 || wanted >= n) return points;
  StartPoints out{{}, {}, points.width, points.height};
  for (std::size_t i = 0; i < wanted; ++i) {
    out.ids.push_back(points.ids[i * n / wanted]);
    out.positions.push_back(points.positions[i * n / wanted]);
  }
  return out;
}

}  // namespace csd::peers
