// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/steps.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

using Turn = Followed::Turn;

/// Each point independently. With a budget, sequentially: whether one waits depends on those before.
template <class Step>
void each(const CsdFrame &frame, const Points &points, Step step) {
  const auto workers = frame.budget.limited() ? SideBySide() : frame.workers;
  workers.each(points.size(), [&](std::size_t i) { step(*points[i]); });
}

void compare(const CsdFrame &frame, Followed &p, const NeighbourField &field, Among among) {
  p.point.compare_with_map(frame, field, among == Among::themselves ? p.id : NeighbourField::nobody);
}

}  // namespace

/// Equally urgent points are ordered by multiples of the golden ratio, which spreads them over the picture; their ids
/// follow its rows.
void order_by_urgency(const CsdFrame &frame, Points &points) {
  if (!frame.budget.limited()) return;
  const auto place = [](const Followed *p) { return std::fmod(static_cast<double>(p->id) * 0.6180339887498949, 1); };
  std::sort(points.begin(), points.end(), [&](const Followed *a, const Followed *b) {
    const double u = a->point.urgency(frame), v = b->point.urgency(frame);
    return u != v ? u > v : place(a) < place(b);
  });
  // Points that maps may use come first, however many new or hidden ones there are.
  const auto most_first = static_cast<std::ptrdiff_t>(frame.tuning.min_at_visible);
  auto first = points.begin();
  for (auto p = first; p != points.end() && first - points.begin() < most_first; ++p)
    if ((*p)->established && (*p)->point.visible()) std::rotate(first++, p, p + 1);
}

void first_alignments(const CsdFrame &frame, const Points &points, const Shares &shares, const Choice &may_rest) {
  const auto budget = frame.budget.share(shares.first);
  std::size_t aligned = 0, reliable = 0;  // counted only with a budget
  each(frame, points, [&](Followed &p) {
    const bool few = reliable < NeighbourField::most && p.point.visible();
    if (may_rest && may_rest(p)) {
      p.turn = Turn::rests;
      p.point.rest();
    } else if (budget.limited() && aligned >= (few ? shares.more : shares.least) && budget.spent()) {
      p.turn = Turn::waits;
      p.point.wait();
    } else {
      p.turn = Turn::aligns;
      p.point.first_alignment(frame);
      if (!budget.limited()) return;
      ++aligned;
      reliable += p.point.reliable();
    }
  });
}

void compare_with_maps(const CsdFrame &frame, const Points &points, const NeighbourField &field, Among among) {
  each(frame, points, [&](Followed &p) { compare(frame, p, field, among); });
}

void second_alignments(const CsdFrame &frame, const Points &points, const Shares &shares, bool alone,
                       const Choice &searched_for) {
  const auto budget = frame.budget.share(shares.all);
  std::size_t aligned = 0;  // counted only with a budget
  each(frame, points, [&](Followed &p) {
    if (p.turn != Turn::aligns || p.point.reliable()) return;
    if (!p.point.visible() && searched_for && !searched_for(p)) return;
    if (budget.limited() && aligned++ >= shares.least && budget.spent()) {
      p.turn = Turn::waits;
      p.point.wait();
    } else {
      p.point.second_alignment(frame, alone);
    }
  });
}

void compare_unmapped(const CsdFrame &frame, const Points &points, const NeighbourField &field, Among among) {
  each(frame, points, [&](Followed &p) {
    if (!p.point.map()) compare(frame, p, field, among);
  });
}

void decide_visibility(const CsdFrame &frame, const Points &points, const Surroundings &around) {
  each(frame, points, [&](Followed &p) {
    p.turn == Turn::aligns ? p.point.decide_visibility(frame, around) : p.point.follow_map(frame);
  });
}

void update_models(const CsdFrame &frame, const Points &points) {
  each(frame, points, [&](Followed &p) {
    if (p.turn == Turn::aligns) p.point.update(frame);
    if (p.point.training_over(frame) && !frame.budget.spent()) p.point.freeze_anchor();
  });
}

}  // namespace csd
