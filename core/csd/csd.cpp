// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/csd.h"

#include <algorithm>

#include "base/find_id.h"
#include "track/patch_side.h"

namespace csd {
namespace {
constexpr std::int64_t step = second / 25;  // the unit of rates
}  // namespace

CsdFrame Csd::load(const FrameContext &context) {
  const auto &work = context.frame;
  const double patch = patch_side(settings_, work) / static_cast<double>(PatchPlane::side);
  return {.pyramid = pyramid_,
          .weights = weights_,
          .size = work.size(),
          .unit = work.size().height / 480.0,
          .steps = steps_,
          .time = context.time,
          .training_time = settings_.training_time,
          .patch = patch,
          .budget = context.budget,
          .colour = &work,
          .tuning = tuning_,
          .workers = workers_};
}

void Csd::track(const FrameContext &context, std::vector<Claim> &claims) {
  drop_ended();
  pyramid_.build(context.frame.luma());
  weights_.build(context.frame, context.forbidden, tuning_.highlight);
  steps_ = last_time_ == no_time
               ? 1
               : std::clamp(static_cast<double>(context.time - last_time_) / static_cast<double>(step), 0.01,
                            tuning_.max_steps);
  last_time_ = context.time;

  const auto frame = load(context);
  if (context.jumped) hide_until_found(frame);
  auto part = frame;
  part.budget = frame.budget.share(tuning_.support_share);
  support_.follow(part);
  support_.replenish(part);
  follow_queries(frame);
  auto query = queries_.begin();
  for (auto &claim : claims) {
    while (query != queries_.end() && query->id < claim.id) ++query;
    if (query == queries_.end() || query->id != claim.id) continue;  // began outside the picture: claim unchanged
    query->judged_at = context.frame.to_picture(query->point.seen_at());
    report(*query, frame, context.frame, claim);
  }
}

void Csd::hide_until_found(const CsdFrame &frame) {
  support_.hide_until_found(frame);
  for (auto &query : queries_) query.point.hide_until_found();
}

/// The supporting points are the neighbours: users' points do not affect each other. At least one is aligned in each
/// frame, even past the budget, so that none waits for ever.
void Csd::follow_queries(const CsdFrame &frame) {
  turns_.clear();
  for (auto &query : queries_) turns_.push_back(&query);
  const auto &neighbours = support_.field();
  const auto &around = support_.surroundings();
  const Shares shares{tuning_.query_share, tuning_.query_share};
  order_by_urgency(frame, turns_);
  first_alignments(frame, turns_, shares);
  compare_with_maps(frame, turns_, neighbours, Among::others);
  second_alignments(frame, turns_, shares, around.alone);
  compare_unmapped(frame, turns_, neighbours, Among::others);
  decide_visibility(frame, turns_, around);
  update_models(frame, turns_);
  // Points that began without supporting points around them, or before a cut.
  for (auto &query : queries_)
    if (query.point.reliable() && !query.point.map()) query.point.enter_chart(neighbours, support_.chart(), frame);
}

void Csd::report(const Query &query, const CsdFrame &frame, const WorkFrame &work, Claim &claim) const {
  const auto &point = query.point;
  claim.position = work.to_picture(point.state().position);
  const bool clear = support_.surroundings().blur < tuning_.max_blur;
  claim.confidence = clear ? point.confidence() : 0;
  claim.fresh = query.turn != Followed::Turn::waits;
  claim.surrounded = clear && point.map();
  if ((point.visible() && clear) || tuning_.claim_all != 0)
    claim.kind = point.learning() ? Claim::Kind::learning : Claim::Kind::tracked;
  else
    claim.kind = frame.shows(point.state().position) ? Claim::Kind::hidden : Claim::Kind::out;
}

Claim::Kind Csd::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  const auto frame = load(context);
  Query query{{TrackedPoint(frame, context.frame.to_work(position)), id}};
  query.point.enter_chart(support_.field(), support_.chart(), frame);
  const auto at =
      std::upper_bound(queries_.begin(), queries_.end(), id, [](FeatureId i, const Query &q) { return i < q.id; });
  queries_.insert(at, std::move(query));
  return Claim::Kind::learning;
}

void Csd::end(FeatureId id) {
  if (find_id(queries_, id, &Query::id) != queries_.end()) ended_.push_back(id);
}

std::optional<Csd::Judged> Csd::judged(FeatureId id) const {
  const auto at = find_id(queries_, id, &Query::id);
  if (at == queries_.end() || at->turn == Followed::Turn::waits || !at->point.evidence()) return {};
  return Judged{*at->point.evidence(), at->judged_at};
}

/// Erases all at once: one by one, each would move all behind it, and a user may remove ten thousand in one frame.
void Csd::drop_ended() {
  if (ended_.empty()) return;
  std::sort(ended_.begin(), ended_.end());
  std::erase_if(queries_, [this](const Query &q) { return std::binary_search(ended_.begin(), ended_.end(), q.id); });
  ended_.clear();
}

void Csd::forget() {
  queries_.clear();
  ended_.clear();
  support_.clear();
  last_time_ = no_time;
}

}  // namespace csd
