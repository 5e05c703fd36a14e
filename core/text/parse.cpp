// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/parse.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "base/setting_text.h"
#include "base/types.h"

namespace csd {
namespace {

constexpr std::string_view points_help =
    "Write pixels with a decimal point, and a semicolon between points: \"100,50;210.5,80\".";
constexpr std::string_view region_help = "Write x,y,width,height in whole pixels: \"40,0,560,480\".";

/// Like std::from_chars, independent of the locale, but also accepts a plus sign.
template <typename Number>
std::optional<Number> number(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const char *const end = text.data() + text.size();
  const auto [stop, problem] = std::from_chars(text.data(), end, value);
  if (text.empty() || problem != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == text.npos) return parts;
    text.remove_prefix(at + 1);
  }
}

}  // namespace

Parsed<std::vector<cv::Point2d>> parse_points(std::string_view text) {
  Parsed<std::vector<cv::Point2d>> result;
  text = trimmed(text);
  if (!text.empty() && text.back() == ';') text.remove_suffix(1);
  if (text.empty()) return result;

  const auto fail = [&](std::string_view part, std::string_view why) {
    result.error = "points: " + shown_text(trimmed(part)) + " (point " + std::to_string(result.value.size() + 1) +
                   ") " + std::string(why) + ". " + std::string(points_help);
    result.value.clear();
    return result;
  };
  while (true) {
    const auto end = text.find(';');
    const std::string_view part = text.substr(0, end);
    if (result.value.size() == csd::max_points)
      return fail(part, "is one too many: at most " + std::to_string(csd::max_points) + " points can be tracked");
    const auto coordinates = split(part, ',');
    if (coordinates.size() != 2) return fail(part, "is not x,y");
    const auto x = number<double>(coordinates[0]), y = number<double>(coordinates[1]);
    if (!x || !y) return fail(part, "is not x,y");
    if (!std::isfinite(*x) || !std::isfinite(*y)) return fail(part, "is not finite");
    result.value.emplace_back(*x, *y);
    if (end == text.npos) return result;
    text.remove_prefix(end + 1);
  }
}

bool is_truth(std::string_view text) {
  return trimmed(text) == "truth";
}

Parsed<cv::Rect> parse_region(std::string_view text) {
  Parsed<cv::Rect> result;
  text = trimmed(text);
  if (text.empty()) return result;

  const auto fail = [&](std::string_view part, std::string_view why) {
    result.error = "region: " + shown_text(trimmed(part)) + " " + std::string(why) + ". " + std::string(region_help);
    result.value = {};
    return result;
  };
  const auto parts = split(text, ',');
  if (parts.size() != 4) return fail(text, "is not x,y,width,height");
  int values[4];
  for (std::size_t i = 0; i < 4; ++i) {
    const auto value = number<int>(parts[i]);
    if (!value) return fail(parts[i], "is not a whole number of pixels");
    // 32768 lines and columns are more than GStreamer's caps ever carry; it keeps x + width far from overflow.
    if (*value < (i < 2 ? 0 : 1) || *value > 32768)
      return fail(parts[i], i < 2 ? "is not in 0…32768" : "is not in 1…32768");
    values[i] = *value;
  }
  result.value = {values[0], values[1], values[2], values[3]};
  return result;
}

}  // namespace csd
