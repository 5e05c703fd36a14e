// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bench/bound.h"

#include <fstream>
#include <optional>
#include <stdexcept>

#include "bench/i420.h"
#include "csd/memory.h"
#include "csd/neighbour_map.h"
#include "csd/point_alignment.h"
#include "image/work_frame.h"
#include "score/sensitivity.h"

namespace csd::bench {
namespace {

/// How the tissue around each point has moved since the first frame, from its neighbours' true places.
class TrueMotion {
 public:
  TrueMotion(const std::vector<sim::TruthPoint> &first, const std::vector<sim::TruthPoint> &now) : first_(first) {
    for (std::size_t k = 0; k < now.size(); ++k)
      if (now[k].visibility != sim::Visibility::out) field_.add(k, 0, {at(first[k]), at(now[k])});
  }
  cv::Matx22d shape(std::size_t k) const { return field_.map_at(at(first_[k]), 0, 1, {}).linear; }

 private:
  static cv::Point2d at(const sim::TruthPoint &p) { return {p.x, p.y}; }
  const std::vector<sim::TruthPoint> &first_;
  NeighbourField field_;
};

}  // namespace

Bound align_from_truth(const Rendered &rendered) {
  const double far = score::tolerance(picture_size.height, score::headline_pixels), near = far * 2 / 5;
  std::vector<std::optional<Memory>> memories(rendered.truth[0].size());
  std::vector<std::uint8_t> picture(frame_bytes);
  std::ifstream in(rendered.file, std::ios::binary);
  WorkFrame work;
  Pyramid pyramid;
  GlareWeights weights;
  double visible = 0, within_2 = 0, within_5 = 0, claimed = 0, wrong = 0;
  for (std::size_t i = 0; i < rendered.truth.size(); ++i) {
    if (!in.read(reinterpret_cast<char *>(picture.data()), frame_bytes))
      throw std::runtime_error(rendered.file + " is too short");
    work.load(view_of(picture.data(), picture_size));
    pyramid.build(work.luma());
    weights.build(work, {});
    const CsdFrame frame{.pyramid = pyramid,
                         .weights = weights,
                         .size = work.size(),
                         .unit = work.size().height / 480.0,
                         .time = static_cast<std::int64_t>(i) * second / 25,
                         .training_time = second / 2};
    const TrueMotion motion(rendered.truth[0], rendered.truth[i]);
    for (std::size_t k = 0; k < memories.size(); ++k) {
      auto &memory = memories[k];
      const auto &truth = rendered.truth[i][k];
      const AffineState there{{truth.x, truth.y}, motion.shape(k)};
      const bool seen = truth.visibility == sim::Visibility::visible;
      if (i == 0 && seen) memory.emplace(frame, there);
      if (!memory || i == 0 || !frame.shows(there.position)) continue;
      if (memory->learning()) {
        if (seen) memory->sample_at(frame, there);
        if (memory->training_over(frame)) memory->freeze_anchor();
      }
      const auto alignment = align_point(frame, *memory, {there, 0, 1});
      const auto &fine = alignment.fine;
      const double off = fine.usable ? cv::norm(fine.state.position - there.position) : 1e9;
      const auto &tuning = frame.tuning;
      const bool believed = fine.usable && std::min(fine.zncc, alignment.zncc_coarse) >= tuning.reliable_zncc &&
                            fine.inliers >= tuning.reliable_inliers;
      visible += seen;
      within_2 += seen && off <= near;
      within_5 += seen && off <= far;
      claimed += believed;
      wrong += believed && (!seen || off > far);
      if (!believed || off > far) continue;
      if (!memory->learning()) memory->refine(frame, there, there.scale(), fine);
    }
  }
  return {within_2 / std::max(visible, 1.0), within_5 / std::max(visible, 1.0), wrong / std::max(claimed, 1.0)};
}

}  // namespace csd::bench
