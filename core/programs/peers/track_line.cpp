// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/track_line.h"

#include "text/write_line.h"

namespace csd::peers {

namespace {

std::optional<std::uint64_t> known(std::int64_t time) {
  return time < 0 ? std::nullopt : std::optional(static_cast<std::uint64_t>(time));
}

}  // namespace

std::string track_line(std::string_view algorithm, std::uint64_t frame, const Picture &picture,
                       std::span<const FeatureId> ids, std::span<const Report> reports) {
  const cv::Rect2d bounds(-0.5, -0.5, picture.bgr.cols, picture.bgr.rows);
  LineHead head;
  head.source = "csd-peers";
  head.algorithm = algorithm;
  head.frame = frame;
  head.pts = known(picture.pts);
  head.duration = known(picture.duration);
  head.running_time = known(picture.running_time);
  head.stream_time = known(picture.stream_time);
  head.width = picture.bgr.cols;
  head.height = picture.bgr.rows;
  std::string text;
  JsonLine line(text, head);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto &r = reports[i];
    const bool in = bounds.contains(r.position);
    const auto state = !in ? FeatureState::out : r.seen ? FeatureState::tracked : FeatureState::lost;
    line.add({ids[i], r.position.x, r.position.y, state_name(state), state == FeatureState::tracked ? 1.0 : 0.0});
  }
  line.end();
  return text + '\n';
}

}  // namespace csd::peers
