// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/steps.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

using Turn = Followed::Turn;

/// The most urgent first. Points that are as urgent as each other take turns all over the picture: their ids go along
/// its rows, multiples of the golden ratio don't.
void order(const CsdFrame &frame, std::vector<Followed *> &points) {
  if (!frame.budget.limited()) return;
  const auto place = [](const Followed *p) { return std::fmod(static_cast<double>(p->id) * 0.6180339887498949, 1); };
  std::sort(points.begin(), points.end(), [&](const Followed *a, const Followed *b) {
    const double u = a->point.urgency(frame), v = b->point.urgency(frame);
    return u != v ? u > v : place(a) < place(b);
  });
  // Those that maps may stand on come first, however many new or hidden ones there are.
  const auto most = static_cast<std::ptrdiff_t>(frame.tuning.least_at_visible);
  auto first = points.begin();
  for (auto p = first; p != points.end() && first - points.begin() < most; ++p)
    if ((*p)->established && (*p)->point.visible()) std::rotate(first++, p, p + 1);
}

void look(const CsdFrame &frame, std::vector<Followed *> &points, const Company &company, const Shares &shares) {
  const auto budget = frame.budget.share(shares.first);
  std::size_t looked = 0, sure = 0;
  for (auto *p : points) {
    const bool few = sure < NeighbourField::most && p->point.visible();
    if (company.may_rest(frame, *p)) {
      p->turn = Turn::rests;
      p->point.rest();
    } else if (looked >= (few ? shares.more : shares.least) && budget.spent()) {
      p->turn = Turn::waits;
      p->point.pass();
    } else {
      p->turn = Turn::looks;
      p->point.look(frame);
      ++looked;
      sure += p->point.sure();
    }
  }
}

void look_again(const CsdFrame &frame, std::vector<Followed *> &points, const Company &company, const Shares &shares) {
  const auto budget = frame.budget.share(shares.all);
  std::size_t looked = 0;
  for (auto *p : points) {
    if (p->turn != Turn::looks || p->point.sure() || (!p->point.visible() && !company.searched_for(*p))) continue;
    if (looked++ < shares.least || !budget.spent()) {
      p->point.look_again(frame, company.alone());
    } else {
      p->turn = Turn::waits;
      p->point.pass();
    }
  }
}

}  // namespace

void follow(const CsdFrame &frame, std::vector<Followed *> &points, Company &company, const Shares &shares) {
  order(frame, points);
  look(frame, points, company, shares);
  company.gather(frame);
  for (auto *p : points) p->point.meet(frame, company.field(), company.owner(*p));
  company.met(frame);
  look_again(frame, points, company, shares);
  company.gather(frame);
  // What had no map has looked for itself alone: chance likenesses don't agree on a motion.
  for (auto *p : points)
    if (!p->point.map()) p->point.meet(frame, company.field(), company.owner(*p));
  company.looked(frame);
  for (auto *p : points) p->turn == Turn::looks ? p->point.decide(frame, company.surroundings()) : p->point.wait(frame);
  company.gather(frame);
  for (auto *p : points) {
    if (p->turn == Turn::looks) p->point.learn(frame);
    if (p->point.ripe(frame) && !frame.budget.spent()) p->point.freeze();
  }
}

}  // namespace csd
