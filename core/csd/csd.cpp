// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/csd.h"

#include <algorithm>

#include "track/patch_side.h"

namespace csd {
namespace {
constexpr std::int64_t step = second / 25;  // what rates are given for
constexpr double most_steps = 10;           // after a gap: farther ahead nothing is known
// Of a frame's budget, from its begin: supporting points, then looks at the user's, then these points' anchors.
constexpr double support_share = 0.5, looks_share = 0.85;
// ln of contrast. A lens as wet as that hides all, however well patches still fit. Of the sequences of
// tests/bench/accuracy.cpp and the real clips only the one with a wiped lens comes near it.
constexpr double most_blur = 0.15;
// Of what detection begins. Points on an edge slide along it: on cholecystectomy.mp4 12 % of the claims that a
// palindrome compares were apart, with this 3 %; on smoke.mp4 80 % of the samples are claimed instead of 72 %.
constexpr double alike = 0.9;
}  // namespace

double Csd::most_alike() const {
  return alike;
}

CsdFrame Csd::load(const FrameContext &context) {
  const auto &work = context.frame;
  const double patch = patch_side(settings_, work) / static_cast<double>(PatchPlane::side);
  return {
      pyramid_, weights_,       work.size(), work.size().height / 480.0, steps_, context.time, settings_.training_time,
      patch,    context.budget, &work};
}

void Csd::track(const FrameContext &context, std::vector<Claim> &claims) {
  drop_ended();
  pyramid_.build(context.frame.luma());
  weights_.build(context.frame, context.forbidden);
  steps_ =
      last_time_ == no_time
          ? 1
          : std::clamp(static_cast<double>(context.time - last_time_) / static_cast<double>(step), 0.01, most_steps);
  last_time_ = context.time;

  const auto frame = load(context);
  if (context.jumped) doubt(frame);
  auto part = frame;
  part.budget = frame.budget.share(support_share);
  support_.follow(part);
  support_.replenish(part);
  follow_queries(frame);
  auto query = queries_.begin();
  for (auto &claim : claims) {
    while (query != queries_.end() && query->id < claim.id) ++query;
    if (query == queries_.end() || query->id != claim.id) continue;  // began outside the picture: its claim stays
    query->judged_at = context.frame.to_picture(query->point.seen_at());
    report(*query, frame, context.frame, claim);
  }
}

void Csd::doubt(const CsdFrame &frame) {
  support_.doubt(frame);
  for (auto &query : queries_) query.point.doubt();
}

/// The most urgent first; one in each frame, however late it is, so that none waits for ever.
void Csd::follow_queries(const CsdFrame &frame) {
  turns_.clear();
  for (auto &query : queries_) turns_.push_back(&query);
  if (frame.budget.limited())
    std::stable_sort(turns_.begin(), turns_.end(),
                     [&](const Query *a, const Query *b) { return a->point.urgency(frame) > b->point.urgency(frame); });
  const auto budget = frame.budget.share(looks_share);
  for (auto *query : turns_) {
    query->waits = query != turns_.front() && budget.spent();
    follow(*query, frame);
  }
  for (auto &query : queries_)
    if (query.point.ripe(frame) && !frame.budget.spent()) query.point.freeze();
}

/// One user's point, by the field of the supporting points: no other user's point has a say.
void Csd::follow(Query &query, const CsdFrame &frame) const {
  auto &point = query.point;
  query.waits ? point.pass() : point.look(frame);
  point.meet(frame, support_.field());
  if (query.waits) return point.wait(frame);
  point.look_again(frame, support_.surroundings().alone);
  point.decide(frame, support_.surroundings());
  point.learn(frame);
  // What began where nothing was known of the tissue around it, or before a cut.
  if (point.sure() && !point.map()) point.join(support_.field(), support_.chart(), frame.unit);
}

void Csd::report(const Query &query, const CsdFrame &frame, const WorkFrame &work, Claim &claim) const {
  const auto &point = query.point;
  claim.position = work.to_picture(point.state().position);
  const bool clear = support_.surroundings().blur < most_blur;
  claim.confidence = clear ? point.confidence() : 0;
  claim.fresh = !query.waits;
  claim.surrounded = clear && point.map();
  if (point.visible() && clear)
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
  const auto at =
      std::lower_bound(queries_.begin(), queries_.end(), id, [](const Query &q, FeatureId i) { return q.id < i; });
  if (at != queries_.end() && at->id == id) ended_.push_back(id);
}

std::optional<Csd::Judgement> Csd::judgement(FeatureId id) const {
  const auto at =
      std::lower_bound(queries_.begin(), queries_.end(), id, [](const Query &q, FeatureId i) { return q.id < i; });
  if (at == queries_.end() || at->id != id || at->waits || !at->point.evidence()) return {};
  return Judgement{*at->point.evidence(), at->judged_at};
}

/// All at once: each would move all behind it, and a user may remove ten thousand in one frame.
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
