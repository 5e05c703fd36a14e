// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cli/peers/start_points.h"

#include <json-glib/json-glib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "parse.h"

namespace csd::peers {

namespace {

struct Source {
  std::string name;
  std::size_t line = 1;
  [[noreturn]] void fail(const std::string &text) const {
    throw std::runtime_error(name + ":" + std::to_string(line) + ": " + text);
  }
};

bool is_visible(std::string_view state) {
  return state == "tracked" || state == "learning" || state == "1";
}

StartPoints from_json(const std::string &line, const Source &source) {
  struct Unref {
    void operator()(JsonParser *p) const { g_object_unref(p); }
  };
  const std::unique_ptr<JsonParser, Unref> parser(json_parser_new_immutable());
  if (!json_parser_load_from_data(parser.get(), line.data(), static_cast<gssize>(line.size()), nullptr))
    source.fail("no JSON");
  auto *const root = json_parser_get_root(parser.get());
  if (!root || !JSON_NODE_HOLDS_OBJECT(root)) source.fail("no object");
  auto *const frame = json_node_get_object(root);
  if (json_object_get_int_member_with_default(frame, "schema", 0) != 1) source.fail("\"schema\" is not 1");
  if (json_object_get_int_member_with_default(frame, "frame", -1) != 0) source.fail("the first frame must be frame 0");
  auto *const member = json_object_get_member(frame, "features");
  if (!member || !JSON_NODE_HOLDS_ARRAY(member)) source.fail("no \"features\"");
  auto *const features = json_node_get_array(member);
  StartPoints points;
  for (guint i = 0; i < json_array_get_length(features); ++i) {
    auto *const node = json_array_get_element(features, i);
    if (!JSON_NODE_HOLDS_OBJECT(node)) source.fail("a feature is no object");
    auto *const f = json_node_get_object(node);
    const auto id = json_object_get_int_member_with_default(f, "id", -1);
    const cv::Point2d at(json_object_get_double_member_with_default(f, "x", NAN),
                         json_object_get_double_member_with_default(f, "y", NAN));
    const char *state = json_object_get_string_member_with_default(f, "state", "");
    if (id < 0 || id >= no_feature || !std::isfinite(at.x) || !std::isfinite(at.y)) source.fail("a feature is damaged");
    if (!is_visible(state)) continue;
    points.ids.push_back(static_cast<FeatureId>(id));
    points.positions.push_back(at);
  }
  return points;
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  for (;;) {
    const auto comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == line.npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

template <class Number>
Number number(std::string_view text, const Source &source) {
  Number value{};
  const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || stop != text.data() + text.size() || !std::isfinite(static_cast<double>(value)))
    source.fail("\"" + std::string(text) + "\" is no number");
  return value;
}

StartPoints from_csv(const std::string &header, std::istream &in, Source source) {
  const auto names = fields_of(header);
  const auto column = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto frame = column("frame"), id = column("id"), x = column("x"), y = column("y");
  const auto visible = std::min(column("visible"), column("state"));
  if (std::max({frame, id, x, y, visible}) == names.size())
    source.fail("neither csdtrackenc's JSON nor CSV with frame,id,x,y and visible or state");
  StartPoints points;
  bool first = false;
  for (std::string line; std::getline(in, line);) {
    ++source.line;
    const auto fields = fields_of(line);
    if (fields.size() != names.size()) {
      if (in.eof()) break;  // torn
      source.fail("another number of columns than the header has");
    }
    if (number<std::uint64_t>(fields[frame], source) != 0) continue;
    first = true;
    if (!is_visible(fields[visible])) continue;
    points.ids.push_back(number<FeatureId>(fields[id], source));
    points.positions.emplace_back(number<double>(fields[x], source), number<double>(fields[y], source));
  }
  if (!first) source.fail("there is no frame 0");
  return points;
}

}  // namespace

StartPoints read_start_points(const std::string &text_or_file) {
  StartPoints points;
  std::error_code ignored;
  if (std::filesystem::exists(text_or_file, ignored)) {
    std::ifstream in(text_or_file);
    std::string line;
    if (!std::getline(in, line)) throw std::runtime_error(text_or_file + ": can't be read or is empty");
    const Source source{text_or_file};
    points = line[line.find_first_not_of(" \t") == line.npos ? 0 : line.find_first_not_of(" \t")] == '{'
                 ? from_json(line, source)
                 : from_csv(line, in, source);
  } else {
    auto parsed = parse_points(text_or_file);
    if (!parsed) throw std::runtime_error("points: neither a file nor points: " + parsed.error);
    points.positions = std::move(parsed.value);
    for (FeatureId id = 0; id < points.positions.size(); ++id) points.ids.push_back(id);
  }
  if (points.ids.empty()) throw std::runtime_error(text_or_file + ": no visible points in the first frame");
  return points;
}

StartPoints thinned(const StartPoints &points, std::size_t most) {
  const auto n = points.ids.size();
  if (most == 0 || most >= n) return points;
  StartPoints out;
  for (std::size_t i = 0; i < most; ++i) {
    out.ids.push_back(points.ids[i * n / most]);
    out.positions.push_back(points.positions[i * n / most]);
  }
  return out;
}

}  // namespace csd::peers
