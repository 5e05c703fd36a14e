// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "programs/absent_features.h"
#include "programs/truth_table.h"
#include "text/feature_state.h"

namespace csd::programs {
namespace {

using score::InputError;

/// The fields of a row. Removes quotation marks around a field: our fields don't need them, but some programs write
/// them.
std::vector<std::string_view> split(std::string_view row) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = row.find(',');
    std::string_view field = row.substr(0, comma);
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    row.remove_prefix(comma + 1);
  }
}

std::vector<std::string_view> header(const TextFile &file) {
  return split(file.first().text);
}

bool has_column(const TextFile &file, std::string_view name) {
  const auto columns = header(file);
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

/// Rows of a table, by the column names in its header.
class Table {
 public:
  explicit Table(const TextFile &file) : file_(file), columns_(header(file)), lines_(file.lines()) {}

  /// The index of a column. Throws if it is missing.
  std::size_t column(std::string_view name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end())
      throw InputError(file_.name, file_.first().number, "has no column '" + std::string(name) + "'");
    return static_cast<std::size_t>(found - columns_.begin());
  }
  std::optional<std::size_t> optional_column(std::string_view name) const {
    if (!has_column(file_, name)) return std::nullopt;
    return column(name);
  }

  /// Advances to the next row; returns false after the last. Skips a repeated header (csdtrackenc's after a flush).
  bool next() {
    for (; at_ < lines_.size(); ++at_) {
      row_ = split(lines_[at_].text);
      line_ = lines_[at_].number;
      if (row_ == columns_) continue;
      if (row_.size() != columns_.size())
        fail("has " + std::to_string(row_.size()) + " fields, the header has " + std::to_string(columns_.size()));
      ++at_;
      return true;
    }
    return false;
  }

  std::size_t line() const { return line_; }
  std::string_view text(std::size_t column) const { return row_[column]; }
  [[noreturn]] void fail(const std::string &what) const { throw InputError(file_.name, line_, what); }

  template <typename Number>
  Number number(std::size_t column) const {
    Number value{};
    const std::string_view text = row_[column];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    bool good = error == std::errc() && end == text.data() + text.size() && !text.empty();
    if constexpr (std::is_floating_point_v<Number>) good = good && std::isfinite(value);
    if (!good)
      fail("'" + std::string(text) + "' is no " +
           (std::is_floating_point_v<Number> ? "number" : "whole number from 0") + " (" +
           std::string(columns_[column]) + ")");
    return value;
  }

 private:
  const TextFile &file_;
  std::vector<std::string_view> columns_;
  std::vector<TextFile::Line> lines_;
  std::size_t at_ = 0, line_ = 1;
  std::vector<std::string_view> row_;
};

}  // namespace

bool is_truth_csv(const TextFile &file) {
  return has_column(file, "visible");
}
bool is_tracks_csv(const TextFile &file) {
  return has_column(file, "state");
}

std::vector<LabelRow> read_label_rows(const TextFile &file, std::vector<std::string> &notes) {
  Table table(file);
  const std::size_t frame = table.column("frame"), id = table.column("id"), x = table.column("x"),
                    y = table.column("y"), visible = table.column("visible");
  std::vector<LabelRow> rows;
  while (table.next()) {
    const std::string_view sight = table.text(visible);
    if (sight != "1" && sight != "0" && sight != "2")
      table.fail("visible is 1, 0 or 2 (uncertain), not '" + std::string(sight) + "'");
    LabelRow row{table.number<std::uint64_t>(frame),
                 table.number<FeatureId>(id),
                 sight.front(),
                 {score::unknown, score::unknown},
                 table.line()};
    if (sight == "1" || !table.text(x).empty() || !table.text(y).empty())
      row.position = {table.number<double>(x), table.number<double>(y)};
    rows.push_back(row);
  }
  note_torn(file, notes);
  return rows;
}

score::Truth read_truth_csv(const TextFile &file, std::vector<std::string> &notes) {
  TruthTable truth(file.name);
  for (const LabelRow &row : read_label_rows(file, notes)) {
    const score::Presence presence = row.sight == '1'   ? score::Presence::visible
                                     : row.sight == '0' ? score::Presence::hidden
                                                        : score::Presence::unlabelled;
    truth.add(row.frame, no_time, row.id, {presence, row.position}, row.line);
  }
  return truth.take();
}

score::Recording read_tracks_csv(const TextFile &file, std::vector<std::string> &notes) {
  Table table(file);
  const std::size_t frame = table.column("frame"), id = table.column("id"), x = table.column("x"),
                    y = table.column("y"), state = table.column("state"), confidence = table.column("confidence");
  const auto pts = table.optional_column("pts"), stream_time = table.optional_column("stream_time");
  const auto time = [&](const std::optional<std::size_t> &column) {
    return column && !table.text(*column).empty() ? table.number<std::int64_t>(*column) : no_time;
  };
  score::Recording tracks;
  tracks.file = file.name;
  tracks.sparse = true;
  while (table.next()) {
    const auto number = table.number<std::uint64_t>(frame);
    if (tracks.frames.empty() || tracks.frames.back().frame != number) {
      if (!tracks.frames.empty() && number < tracks.frames.back().frame)
        table.fail("frame " + std::to_string(number) + " after frame " + std::to_string(tracks.frames.back().frame));
      tracks.frames.push_back({true, number, time(pts), table.line(), {}, time(stream_time)});
    }
    std::vector<Feature> &features = tracks.frames.back().features;
    Feature feature;
    feature.id = table.number<FeatureId>(id);
    feature.x = table.number<double>(x);
    feature.y = table.number<double>(y);
    feature.confidence = table.number<double>(confidence);
    const auto known = state_of(table.text(state));
    if (!known) table.fail("there is no state '" + std::string(table.text(state)) + "'");
    feature.state = *known;
    if (feature.confidence < 0 || feature.confidence > 1) table.fail("a confidence is from 0 to 1");
    if (!features.empty() && features.back().id >= feature.id)
      table.fail("feature " + std::to_string(feature.id) + " after feature " + std::to_string(features.back().id));
    features.push_back(feature);
  }
  note_torn(file, notes);
  note_absent(tracks, notes);
  return tracks;
}

}  // namespace csd::programs
