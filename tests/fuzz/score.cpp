// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-score from its files to its tables. The input: a file of truth, a separator, a file of tracks.
#include "cli/palindrome_report.h"
#include "cli/read_input.h"
#include "cli/score_report.h"
#include "fuzz.h"
#include "score/align.h"

namespace {

using namespace csd;

void report(const score::Truth &truth, const score::Recording &tracks, std::vector<std::string> &notes) {
  // A size, for files of CSV say none.
  score::AlignOptions options;
  options.width = 640;
  options.height = 480;
  const auto made = cli::make_report({"a"}, {{score::align(truth, tracks, options, notes)}}, notes, 3);
  cli::as_text(made);
  cli::as_markdown(made);
  cli::as_csv(made);
  cli::as_json(made);
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  const auto parts = split(bytes, 2);
  const MemoryFile first(parts[0]), second(parts.back());
  std::vector<std::string> notes;
  try {
    const cli::Input truth = cli::read_input(first.path(), notes), tracks = cli::read_input(second.path(), notes);
    const auto *recording = std::get_if<score::Recording>(&tracks);
    if (!recording) return;
    if (std::holds_alternative<score::Truth>(truth)) report(std::get<score::Truth>(truth), *recording, notes);
    const cli::PalindromeReport row{{"a", "a", score::score_palindrome(*recording)}};
    cli::as_text(row);
    cli::as_json(row);
  } catch (const score::InputError &) {
  }
}
