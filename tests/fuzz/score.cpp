// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-score from its input files to its tables. The input: a file of truth, a separator, a file of tracks.
#include "fuzz.h"
#include "programs/palindrome_report.h"
#include "programs/read_input.h"
#include "programs/score_report.h"
#include "score/align.h"

namespace {

using namespace csd;

void report(const score::Truth &truth, const score::Recording &tracks, std::vector<std::string> &notes) {
  // Sets a size, since CSV files have none.
  score::AlignOptions options;
  options.width = 640;
  options.height = 480;
  const auto made = programs::make_report({"a"}, {{score::align(truth, tracks, options, notes)}}, notes, 3);
  programs::as_text(made);
  programs::as_markdown(made);
  programs::as_csv(made);
  programs::as_json(made);
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  const auto parts = split(bytes, 2);
  const MemoryFile first(parts[0]), second(parts.back());
  std::vector<std::string> notes;
  try {
    const programs::Input truth = programs::read_input(first.path(), notes),
                          tracks = programs::read_input(second.path(), notes);
    const auto *recording = std::get_if<score::Recording>(&tracks);
    if (!recording) return;
    if (std::holds_alternative<score::Truth>(truth)) report(std::get<score::Truth>(truth), *recording, notes);
    const programs::PalindromeReport row{{"a", "a", score::score_palindrome(*recording)}};
    programs::as_text(row);
    programs::as_json(row);
  } catch (const score::InputError &) {
  }
}
