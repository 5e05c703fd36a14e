// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/line_pieces.h"

#include <utility>

#include "record/text_pieces.h"
#include "text/read_line.h"

namespace csd {

void LinePieces::add(std::string_view piece, const TextTime &time, bool missing, const TakeLine &take,
                     const LoseLine &lose) {
  piece = line_text(piece);
  if (piece.empty()) return;
  const bool rest = is_rest_of_line(piece);
  if ((!rest || missing) && unfinished()) {
    lose("its rest is missing");
    clear();
  }
  if (rest && !unfinished()) return;  // its start was before a seek, or is lost
  if (!rest) begun_time_ = time;
  if (begun_.size() + piece.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
  begun_ += piece;
  if (!goes_on(piece)) take(std::exchange(begun_, {}), begun_time_);
}

}  // namespace csd
