// SPDX-License-Identifier: LGPL-2.1-or-later
// A file of .jsonl as csdtrackdec reads it, by times that advance, jump and go back. Then the same bytes as a stream,
// in pieces. The input: the file, a separator, numbers.
#include <fuzzer/FuzzedDataProvider.h>

#include "fuzz.h"
#include "record/line_splitter.h"
#include "record/track_file.h"
#include "support/guard.h"

namespace {

void seek_about(const std::string &path, FuzzedDataProvider &numbers) {
  csd::TrackFile file(path);
  std::int64_t time = 0;
  for (int i = 0; i < 16; ++i) {
    // Frame by frame, or anywhere.
    time = numbers.ConsumeBool() ? numbers.ConsumeIntegralInRange<std::int64_t>(-csd::second, G_MAXINT64 / 2)
                                 : time + csd::second / 25;
    const std::int64_t reach = csd::second / 50;
    const csd::FrameMoment frame{time, numbers.ConsumeIntegralInRange<std::int64_t>(0, 2 * reach), reach};
    if (const auto line = file.at(frame)) csd_fuzz::expect(frame.distance(line->stream_time) <= reach);
  }
}

void in_pieces(std::string_view bytes, FuzzedDataProvider &numbers) {
  csd::LineSplitter splitter;
  csd::JsonText json;
  while (!bytes.empty()) {
    const auto piece = bytes.substr(0, numbers.ConsumeIntegralInRange<std::size_t>(1, 4096));
    bytes.remove_prefix(piece.size());
    splitter.add(piece, [&](std::string_view line, bool) { csd::read_track_line(json, csd::line_text(line)); });
  }
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  const auto parts = split(bytes, 2);
  FuzzedDataProvider numbers(reinterpret_cast<const std::uint8_t *>(parts.back().data()), parts.back().size());
  const MemoryFile file(parts[0]);
  try {
    seek_about(file.path(), numbers);
  } catch (const csd::Refusal &error) {
    expect(is_utf8(error.what()));
  }
  try {
    in_pieces(parts[0], numbers);
  } catch (const csd::LineError &error) {
    expect(is_utf8(error.what()));
  }
}
