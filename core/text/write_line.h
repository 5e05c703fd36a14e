// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/types.h"

namespace csd {

/// Appends a string of JSON; `text` is UTF-8.
void append_json_string(std::string &out, std::string_view text);

/// What is written about a frame: docs/metadata.md has the schema. Unknown values are null in JSON and empty in CSV.
///
/// Numbers have a decimal point and JSON's form in every locale. x, y and confidence have 3 decimals.
struct LineHead {
  std::optional<std::string_view> source, algorithm;
  std::string_view role = "track";
  std::optional<std::uint64_t> frame;
  std::optional<std::uint64_t> pts, duration, running_time, stream_time;  ///< ns
  std::optional<std::string_view> reference_caps;                         ///< none: the frame has no reference
  std::optional<std::uint64_t> reference_time;                            ///< ns
  int width = 0, height = 0;                                              ///< 0: unknown
  int pixel_aspect_n = 0, pixel_aspect_d = 0;  ///< the shape of the picture's pixels, width to height; 0: unknown
};

struct LineFeature {
  FeatureId id = 0;
  double x = 0, y = 0;
  std::string_view state;
  double confidence = 0;
  bool fresh = true;
};

/// Each feature in a JSON line starts with this, and nothing else in it does: in names a backslash precedes each
/// quotation mark.
inline constexpr std::string_view json_feature_begin = "{\"id\":";

/// Appends a frame as one JSON object, without a newline: the head, the features, the end.
class JsonLine {
 public:
  JsonLine(std::string &out, const LineHead &head);
  void add(const LineFeature &feature);
  void end();

 private:
  std::string &out_;
  bool first_ = true;
};

/// The header of CsvRows, with its newline.
inline constexpr std::string_view csv_header = "frame,pts,stream_time,id,x,y,state,confidence,fresh\n";

/// Appends a row for each feature of a frame, each with its newline.
class CsvRows {
 public:
  CsvRows(std::string &out, const LineHead &head);
  void add(const LineFeature &feature);

 private:
  std::string &out_;
  std::string frame_;  ///< the columns shared by all rows of a frame
};

}  // namespace csd
