// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/lk.h"

#include <algorithm>

#include "track/patch_side.h"

namespace csd {

void LucasKanade::track(const FrameContext &context, std::vector<Claim> &claims) {
  recursive_.set_window(patch_side(settings_, context.frame));
  std::vector<cv::Point2f> work(points_.size());
  std::vector<unsigned char> found;
  std::transform(points_.begin(), points_.end(), work.begin(), [](const Point &p) { return p.work; });
  recursive_.track(context.frame.luma(), work, found);

  std::vector<Point> kept;
  std::size_t i = 0;
  for (auto &claim : claims) {
    while (i < points_.size() && points_[i].id < claim.id) ++i;
    claim.kind = Claim::Kind::lost;
    if (i == points_.size() || points_[i].id != claim.id) continue;
    const auto position = context.frame.to_picture(work[i]);
    if (!found[i]) continue;
    claim.position = position;
    if (!context.bounds().contains(position)) {
      claim.kind = Claim::Kind::out;
      continue;
    }
    claim.kind = Claim::Kind::tracked;
    kept.push_back({claim.id, work[i]});
  }
  points_.swap(kept);
}

Claim::Kind LucasKanade::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  const auto at =
      std::upper_bound(points_.begin(), points_.end(), id, [](FeatureId i, const Point &p) { return i < p.id; });
  points_.insert(at, {id, cv::Point2f(context.frame.to_work(position))});
  return Claim::Kind::tracked;
}

void LucasKanade::end(FeatureId id) {
  std::erase_if(points_, [id](const Point &p) { return p.id == id; });
}

void LucasKanade::finish(const FrameContext &context) {
  recursive_.set_window(patch_side(settings_, context.frame));
  if (points_.empty())
    recursive_.skip();
  else
    recursive_.keep(context.frame.luma());
}

void LucasKanade::forget() {
  points_.clear();
  recursive_.skip();
}

}  // namespace csd
