// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <variant>

#include "programs/text_file.h"
#include "score/types.h"

namespace csd::programs {

/// Whether the first line is one of csdtrackenc's: an object with `features`.
bool is_jsonl(const TextFile &file);

/// JSON lines (docs/metadata.md): Truth if their role is `truth`, else Recording. Throws score::InputError.
std::variant<score::Truth, score::Recording> read_jsonl(const TextFile &file, std::vector<std::string> &notes);

/// VL-SurgPT's labels.json: {"FRAME": [[x,y] | null, …], …}; ids are indices into the lists; null is a point that is
/// not visible. Throws score::InputError.
score::Truth read_labels(const TextFile &file);

}  // namespace csd::programs
