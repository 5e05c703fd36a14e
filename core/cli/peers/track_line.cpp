// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cli/peers/track_line.h"

#include <cmath>
#include <iomanip>
#include <locale>
#include <sstream>

namespace csd::peers {

namespace {

/// Nanoseconds, or what JSON says for what is unknown.
std::string time_text(std::int64_t time) {
  return time < 0 ? "null" : std::to_string(time);
}

}  // namespace

std::string track_line(std::string_view algorithm, std::uint64_t frame, const Picture &picture,
                       std::span<const FeatureId> ids, std::span<const Report> reports) {
  const cv::Rect2d bounds(-0.5, -0.5, picture.bgr.cols, picture.bgr.rows);
  std::ostringstream line;
  line.exceptions(std::ios::badbit);  // else a lack of memory would leave half a line, in silence
  line.imbue(std::locale::classic());
  line << std::fixed << std::setprecision(3);
  line << R"({"schema":1,"source":"csd-peers","role":"track","algorithm":")" << algorithm << R"(","frame":)" << frame
       << R"(,"pts":)" << time_text(picture.pts) << R"(,"duration":)" << time_text(picture.duration)
       << R"(,"running_time":)" << time_text(picture.running_time) << R"(,"stream_time":)"
       << time_text(picture.stream_time) << R"(,"reference":null,"width":)" << picture.bgr.cols << R"(,"height":)"
       << picture.bgr.rows << R"(,"features":[)";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto &r = reports[i];
    const bool in = bounds.contains(r.position);
    const auto state = !in ? FeatureState::out : r.seen ? FeatureState::tracked : FeatureState::lost;
    line << (i ? "," : "") << R"({"id":)" << ids[i] << R"(,"x":)" << r.position.x << R"(,"y":)" << r.position.y
         << R"(,"state":")" << state_name(state) << R"(","confidence":)"
         << (state == FeatureState::tracked ? "1.000" : "0.000") << '}';
  }
  line << "]}\n";
  return line.str();
}

}  // namespace csd::peers
