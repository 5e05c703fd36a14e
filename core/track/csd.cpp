// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/csd.h"

#include <algorithm>

namespace csd {
namespace {
constexpr std::int64_t step = second / 25;  // what rates are given for
constexpr double most_steps = 10;           // after a gap: farther ahead nothing is known
}  // namespace

CsdFrame Csd::load(const FrameContext &context) {
  return {pyramid_, weights_,     context.frame.size(),   context.frame.size().height / 480.0,
          steps_,   context.time, settings_.training_time};
}

// After a DISCONT or a jump of the PTS nothing may be claimed until it has been confirmed; FrameContext does not tell
// of them yet. That will be a flag there, and here a reset of every point's visible().
void Csd::track(const FrameContext &context, std::vector<Claim> &claims) {
  pyramid_.build(context.frame.luma());
  weights_.build(context.frame, context.forbidden);
  steps_ =
      last_time_ == no_time
          ? 1
          : std::clamp(static_cast<double>(context.time - last_time_) / static_cast<double>(step), 0.01, most_steps);
  last_time_ = context.time;

  const auto frame = load(context);
  support_.follow(frame);
  support_.replenish(frame);
  auto query = queries_.begin();
  for (auto &claim : claims) {
    while (query != queries_.end() && query->id < claim.id) ++query;
    if (query == queries_.end() || query->id != claim.id) continue;  // began outside the picture: its claim stays
    follow(query->point, frame);
    report(query->point, frame, context.frame, claim);
  }
}

/// One user's point, by the field of the supporting points: no other user's point has a say.
void Csd::follow(TrackedPoint &point, const CsdFrame &frame) const {
  const auto &field = support_.field();
  point.look(frame);
  point.meet(frame, field.map_at(point.own_reference(), point.chart(), frame.unit));
  point.look_again(frame);
  point.decide(frame, support_.surroundings());
  point.learn(frame);
  // What began where nothing was known of the tissue around it, or before a cut.
  if (point.sure() && !point.map()) point.join(field, support_.chart(), frame.unit);
}

void Csd::report(const TrackedPoint &point, const CsdFrame &frame, const WorkFrame &work, Claim &claim) {
  claim.position = work.to_picture(point.state().position);
  claim.confidence = point.confidence();
  if (point.visible())
    claim.kind = point.learning() ? Claim::Kind::learning : Claim::Kind::tracked;
  else
    claim.kind = frame.shows(point.state().position) ? Claim::Kind::hidden : Claim::Kind::out;
}

Claim::Kind Csd::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  const auto frame = load(context);
  Query query{id, TrackedPoint(frame, context.frame.to_work(position))};
  query.point.join(support_.field(), support_.chart(), frame.unit);
  const auto at =
      std::upper_bound(queries_.begin(), queries_.end(), id, [](FeatureId i, const Query &q) { return i < q.id; });
  queries_.insert(at, std::move(query));
  return Claim::Kind::learning;
}

void Csd::end(FeatureId id) {
  std::erase_if(queries_, [id](const Query &q) { return q.id == id; });
}

void Csd::forget() {
  queries_.clear();
  support_.clear();
  last_time_ = no_time;
}

}  // namespace csd
