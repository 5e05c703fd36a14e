// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_input.h"

#include <filesystem>

#include "programs/read_csv.h"
#include "programs/read_json.h"
#include "programs/read_stir.h"
#include "text/read_line.h"

namespace csd::programs {

Input read_input(const std::string &path, std::vector<std::string> &notes) {
  if (std::filesystem::is_directory(path)) return read_stir(path);
  const TextFile file = read_text_file(path);
  if (is_jsonl(file)) return read_jsonl(file, notes);
  const TextFile::Line first = file.first();
  if (first.text[first.text.find_first_not_of(line_blanks)] == '{') return read_labels(file);
  if (is_truth_csv(file)) return read_truth_csv(file, notes);
  if (is_tracks_csv(file)) return read_tracks_csv(file, notes);
  throw score::InputError(path, first.number,
                          "neither JSON nor a header of CSV (frame,id,x,y,visible of truth; "
                          "frame,pts,stream_time,id,x,y,state,confidence,fresh of tracks)");
}

}  // namespace csd::programs
