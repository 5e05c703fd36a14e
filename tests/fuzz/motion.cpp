// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-motion from its file to its tables.
#include "cli/motion_report.h"
#include "cli/read_input.h"
#include "fuzz.h"

void csd_fuzz::run(std::string_view bytes) {
  using namespace csd;
  const MemoryFile file(bytes);
  std::vector<std::string> notes;
  try {
    const cli::Input input = cli::read_input(file.path(), notes);
    const auto *tracks = std::get_if<score::Recording>(&input);
    if (!tracks) return;
    motion::SearchOptions search;
    search.window = 5;
    const cli::MotionReport report{"a", search.window, motion::analyse(motion::series_of(*tracks, {}), search), notes};
    const auto drop = [](std::string_view) {};
    cli::as_text(report);
    cli::as_csv(report);
    cli::write_series_csv(report, drop);
    cli::write_json(report, true, drop);
  } catch (const score::InputError &) {
  }
}
