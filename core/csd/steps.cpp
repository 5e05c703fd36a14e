// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/steps.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

using Turn = Followed::Turn;

/// The most urgent first. Equally urgent points are ordered by multiples of the golden ratio, which spreads them over
/// the picture; their ids follow its rows.
void order(const CsdFrame &frame, std::vector<Followed *> &points) {
  if (!frame.budget.limited()) return;
  const auto place = [](const Followed *p) { return std::fmod(static_cast<double>(p->id) * 0.6180339887498949, 1); };
  std::sort(points.begin(), points.end(), [&](const Followed *a, const Followed *b) {
    const double u = a->point.urgency(frame), v = b->point.urgency(frame);
    return u != v ? u > v : place(a) < place(b);
  });
  // Points that maps may use come first, however many new or hidden ones there are.
  const auto most = static_cast<std::ptrdiff_t>(frame.tuning.min_at_visible);
  auto first = points.begin();
  for (auto p = first; p != points.end() && first - points.begin() < most; ++p)
    if ((*p)->established && (*p)->point.visible()) std::rotate(first++, p, p + 1);
}

/// Each point independently. With a budget, sequentially: whether one waits depends on those before.
template <class Step>
void each(const CsdFrame &frame, const std::vector<Followed *> &points, Step step) {
  const auto workers = frame.budget.limited() ? SideBySide() : frame.workers;
  workers.each(points.size(), [&](std::size_t i) { step(*points[i]); });
}

void look(const CsdFrame &frame, const std::vector<Followed *> &points, const Company &company, const Shares &shares) {
  const auto budget = frame.budget.share(shares.first);
  std::size_t looked = 0, sure = 0;  // counted only with a budget
  each(frame, points, [&](Followed &p) {
    const bool few = sure < NeighbourField::most && p.point.visible();
    if (company.may_rest(frame, p)) {
      p.turn = Turn::rests;
      p.point.rest();
    } else if (budget.limited() && looked >= (few ? shares.more : shares.least) && budget.spent()) {
      p.turn = Turn::waits;
      p.point.pass();
    } else {
      p.turn = Turn::looks;
      p.point.look(frame);
      if (!budget.limited()) return;
      ++looked;
      sure += p.point.sure();
    }
  });
}

void look_again(const CsdFrame &frame, const std::vector<Followed *> &points, const Company &company,
                const Shares &shares) {
  const auto budget = frame.budget.share(shares.all);
  std::size_t looked = 0;  // counted only with a budget
  each(frame, points, [&](Followed &p) {
    if (p.turn != Turn::looks || p.point.sure() || (!p.point.visible() && !company.searched_for(p))) return;
    if (budget.limited() && looked++ >= shares.least && budget.spent()) {
      p.turn = Turn::waits;
      p.point.pass();
    } else {
      p.point.look_again(frame, company.alone());
    }
  });
}

/// All points, or only those without a map.
enum class Whom { all, unmapped };
void meet(const CsdFrame &frame, const std::vector<Followed *> &points, const Company &company, Whom whom) {
  each(frame, points, [&](Followed &p) {
    if (whom == Whom::all || !p.point.map()) p.point.meet(frame, company.field(), company.owner(p));
  });
}

}  // namespace

void follow(const CsdFrame &frame, std::vector<Followed *> &points, Company &company, const Shares &shares) {
  order(frame, points);
  look(frame, points, company, shares);
  company.gather(frame);
  meet(frame, points, company, Whom::all);
  company.met(frame);
  look_again(frame, points, company, shares);
  company.gather(frame);
  // Points without a map were aligned on their own: chance matches rarely agree on a motion.
  meet(frame, points, company, Whom::unmapped);
  company.looked(frame);
  each(frame, points, [&](Followed &p) {
    p.turn == Turn::looks ? p.point.decide(frame, company.surroundings()) : p.point.wait(frame);
  });
  company.gather(frame);
  each(frame, points, [&](Followed &p) {
    if (p.turn == Turn::looks) p.point.learn(frame);
    if (p.point.ripe(frame) && !frame.budget.spent()) p.point.freeze();
  });
}

}  // namespace csd
