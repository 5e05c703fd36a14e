// SPDX-License-Identifier: LGPL-2.1-or-later
// A file as csd-score, csd-motion and csd-label read it: truth or tracks, .jsonl, .csv or labels.json.
#include "fuzz.h"
#include "programs/label_session.h"
#include "programs/read_input.h"
#include "programs/text_file.h"

void csd_fuzz::run(std::string_view bytes) {
  const MemoryFile file(bytes);
  std::vector<std::string> notes;
  try {
    const csd::programs::Input input = csd::programs::read_input(file.path(), notes);
    if (const auto *truth = std::get_if<csd::score::Truth>(&input))
      for (const auto &frame : truth->frames) expect(frame.points.size() == truth->ids.size());
  } catch (const csd::score::InputError &) {
  }
  try {
    const auto session = csd::programs::LabelSession::resume(csd::programs::read_text_file(file.path()), 5);
    session.csv();
  } catch (const csd::score::InputError &) {
  }
}
