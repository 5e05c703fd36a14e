// SPDX-License-Identifier: LGPL-2.1-or-later
// A line of .jsonl as csdtrackdec gets it from a file or a text track, and as the programs read it.
#include "fuzz.h"
#include "record/markup.h"
#include "text/read_line.h"

namespace {

void read(csd::JsonText &json, std::string_view text) {
  try {
    const csd::TrackLine line = csd::read_track_line(json, csd::line_text(text));
    csd_fuzz::expect(line.tracks.features.size() <= csd::max_line_features);
    csd_fuzz::expect(csd_fuzz::is_utf8(line.source) && csd_fuzz::is_utf8(line.algorithm));
  } catch (const csd::LineError &error) {
    csd_fuzz::expect(csd_fuzz::is_utf8(error.what()));
  }
}

}  // namespace

void csd_fuzz::run(std::string_view text) {
  csd::JsonText json;
  read(json, text);
  read(json, csd::unescape_markup(text));
}
