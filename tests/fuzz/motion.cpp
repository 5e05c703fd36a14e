// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-motion from its input file to its tables.
#include "fuzz.h"
#include "programs/motion_report.h"
#include "programs/read_input.h"

void csd_fuzz::run(std::string_view bytes) {
  using namespace csd;
  const MemoryFile file(bytes);
  std::vector<std::string> notes;
  try {
    const programs::Input input = programs::read_input(file.path(), notes);
    const auto *tracks = std::get_if<score::Recording>(&input);
    if (!tracks) return;
    motion::SearchOptions search;
    search.window = 5;
    const programs::MotionReport report{"a", search.window, motion::analyse(motion::series_of(*tracks, {}), search),
                                        notes};
    const auto drop = [](std::string_view) {};
    programs::as_text(report);
    programs::as_csv(report);
    programs::write_series_csv(report, drop);
    programs::write_json(report, true, drop);
  } catch (const score::InputError &) {
  }
}
