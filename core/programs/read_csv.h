// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "programs/text_file.h"
#include "score/types.h"

namespace csd::programs {

/// Whether the first line has the columns of that kind. Readers skip columns that they don't know.
bool is_truth_csv(const TextFile &file);   ///< has `visible`
bool is_tracks_csv(const TextFile &file);  ///< has `state`

/// A row of manual truth.
struct LabelRow {
  std::uint64_t frame;
  FeatureId id;
  char sight;            ///< '1' visible, '0' hidden, '2' uncertain
  cv::Point2d position;  ///< unknown if the row has none, which is only valid for a point that isn't visible
  std::size_t line;
};
std::vector<LabelRow> read_label_rows(const TextFile &file, std::vector<std::string> &notes);

/// Manual truth: frame,id,x,y,visible, rows in any order; `visible` is 1 yes, 0 no (x,y may be empty), 2 uncertain: not
/// scored. All throw score::InputError.
score::Truth read_truth_csv(const TextFile &file, std::vector<std::string> &notes);

/// Output of csdtrackenc as text/csv (docs/metadata.md).
score::Recording read_tracks_csv(const TextFile &file, std::vector<std::string> &notes);

}  // namespace csd::programs
