// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tracked_point.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace csd {
namespace {
constexpr double unknown_miss = std::numeric_limits<double>::infinity();
}  // namespace

TrackedPoint::TrackedPoint(const CsdFrame &frame, cv::Point2d position, Purpose purpose)
    : purpose_(purpose),
      state_{position, frame.patch * cv::Matx22d::eye()},
      memory_(frame, state_),
      last_look_(frame.time) {
  look_.fine.state = state_;
  judgement_.sure = true;
}

void TrackedPoint::found(int chart) {
  chart_ = chart;
  reference_ = state_.position;
  offset_.begin(state_.shape);
}

void TrackedPoint::join(const NeighbourField &field, int chart, const CsdFrame &frame) {
  const auto inverse = field.inverse_map_at(state_.position, chart, frame.unit, frame.tuning);
  if (!inverse) return;
  chart_ = chart;
  reference_ = inverse(state_.position);
  offset_.begin(inverse.linear * state_.shape);
}

std::optional<double> TrackedPoint::blur(const Tuning &tuning) const {
  if (!look_.fine.usable || look_.fine.zncc < tuning.blurred_zncc) return {};
  return look_.gain_coarse > 0 ? std::log(look_.gain_coarse / look_.fine.gain) : 0;
}

Expectation TrackedPoint::expectation(const Tuning &tuning) const {
  return {map_, offset_.predict(map_, reference_), offset_.deviation(tuning)};
}

void TrackedPoint::see(const CsdFrame &frame, const Look &look) {
  look_ = look;
  judgement_ = judge(frame, look_, memory_, expectation(frame.tuning));
}

void TrackedPoint::look(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  look_ = {};
  judgement_ = {};
  const double missed = std::exchange(missed_, unknown_miss);
  if (!visible_) return;
  LookPlan plan{{state_.position + velocity_ * frame.steps, state_.shape}};
  if (map_)  // the last frame's
    plan.start.shape +=
        std::min(1.0, tuning.shape_pull * frame.steps) * (offset_.predict(map_, reference_).shape - plan.start.shape);
  map_ = {};
  plan.precision = purpose_ == Purpose::support ? tuning.support_precision : tuning.query_precision;
  // A point with steady motion is found without a coarse level.
  const bool calm = purpose_ == Purpose::support && missed * frame.steps <= tuning.calm_miss * frame.unit;
  if (calm) {
    see(frame, look_at(frame, memory_, plan));
    if (sure() && gain_change().value_or(0) < tuning.faded) weigh_coarser(frame, memory_, look_);
  }
  if (!sure()) {
    plan.levels = static_cast<int>(tuning.levels_first);
    see(frame, look_at(frame, memory_, plan));
  }
  if (sure()) missed_ = cv::norm(look_.fine.state.position - plan.start.position) / frame.steps;
}

void TrackedPoint::meet(const CsdFrame &frame, const NeighbourMap &map) {
  map_ = map;
  if (look_.fine.usable) see(frame, look_);
}

void TrackedPoint::meet(const CsdFrame &frame, const NeighbourField &field, std::size_t owner) {
  // In the first meeting sure() is the patch's own judgement, as the map of this frame is not known yet.
  const Correspondence own{own_reference(), look_.fine.state.position};
  const auto map =
      field.map_at(own_reference(), chart_, frame.unit, frame.tuning, owner, nearby_, sure() ? &own : nullptr);
  nearby_ = map.nearby;
  meet(frame, map);
}

void TrackedPoint::look_again(const CsdFrame &frame, bool alone) {
  const auto &tuning = frame.tuning;
  if (sure()) return;
  LookPlan plan{state_};
  plan.levels = static_cast<int>(tuning.levels_again);
  plan.precision = purpose_ == Purpose::support ? tuning.support_precision : tuning.query_precision;
  if (map_) {
    if (tuning.looks_again < 1) return;
    const auto expected = expectation(tuning);
    plan.start = expected.state;
    if (!frame.shows(plan.start.position)) {
      look_ = {};
      return;
    }
    plan.position_sd = tuning.expected_share * ((1 + expected.deviation) * map_.scale() * frame.unit + map_.spread);
    see(frame, look_at(frame, memory_, plan));
    if (!sure() && tuning.looks_again >= 2 && purpose_ == Purpose::query) {
      const auto whole = look_;
      plan.inner = true;
      plan.levels = static_cast<int>(tuning.levels_inner);
      see(frame, look_at(frame, memory_, plan));
      if (!sure()) see(frame, whole);
      // Maps do not use such points: with them, 17 of 1000 claims were apart on cutting.mp4 instead of 11, and 8
      // instead of 4 on smoke.mp4.
      judgement_.sure = false;
    }
  } else if (alone && !visible_) {
    see(frame, look_at(frame, memory_, plan));
    judgement_.sure = judgement_.agrees = sure() && look_.fine.zncc >= tuning.alone_zncc;
  }
  look_.again = true;
}

void TrackedPoint::decide(const CsdFrame &frame, const Surroundings &around) {
  const auto &tuning = frame.tuning;
  const auto expected = expectation(tuning);
  aligned_ = look_.fine.state;
  if (look_.fine.usable && expected.overrules(tuning) && !judgement_.own_motion)
    look_.fine.state.position = fuse(frame, look_, expected);
  evidence_ = evidence_for(frame, look_, memory_, expected, judgement_, around);
  if (!evidence_)
    confidence_ = 0;
  else
    confidence_ = tuning.probability != 0 ? visibility(*evidence_, tuning) : sure() ? 1 : 0;
  const bool before = std::exchange(visible_, confidence_ >= 0.5);
  if (visible_) {
    const auto moved = look_.fine.state.position - state_.position;
    velocity_ = before && !look_.again ? moved * (1 / frame.steps) : cv::Point2d();
    state_ = look_.fine.state;
  } else {
    judgement_.sure = false;
    velocity_ = {};
    if (map_) state_ = expected.state;
  }
  last_look_ = frame.time;
  pressing_ = visible_ && (!sure() || cv::norm(velocity_) > tuning.fast * frame.unit);
}

void TrackedPoint::learn(const CsdFrame &frame) {
  const auto &seen = look_.fine;
  if (visible_ && sure() && seen.zncc >= frame.tuning.good_zncc) {
    if (map_) offset_.update(map_, reference_, seen.state, seen.information, frame.steps, frame.unit, frame.tuning);
    memory_.learn_usual(frame, seen);
  }
  if (learning()) {
    if (visible_ || map_) memory_.sample_at(frame, sure() ? aligned_ : state_);
  } else if (sure()) {
    memory_.measure_likeness(frame, aligned_);
    memory_.refine(frame, aligned_, state_.scale(), seen);
  }
}

void TrackedPoint::pass() {
  rest();
  missed_ = unknown_miss;
}

bool TrackedPoint::may_rest(const CsdFrame &frame) const {
  const auto &tuning = frame.tuning;
  return sure() && !learning() && expectation(tuning).overrules(tuning) &&
         map_.spread <= tuning.rest_spread * frame.unit && judgement_.distance <= tuning.rest_miss &&
         missed_ * frame.steps <= tuning.rest_miss * frame.unit;
}

void TrackedPoint::rest() {
  look_ = {};
  judgement_ = {};
}

void TrackedPoint::wait(const CsdFrame &frame) {
  if (map_) state_ = offset_.predict(map_, reference_);
  const bool followed = visible_ && map_ && frame.shows(state_.position);
  confidence_ = followed ? confidence_ * std::exp2(-frame.steps / frame.tuning.half_life) : 0;
  visible_ = confidence_ >= 0.5;
  if (!visible_) velocity_ = {};
}

double TrackedPoint::urgency(const CsdFrame &frame) const {
  return static_cast<double>(frame.time - last_look_) * (pressing_ ? 2 : 1);
}

void TrackedPoint::doubt() {
  pass();
  map_ = {};
  velocity_ = {};
  visible_ = false;
  confidence_ = 0;
}

}  // namespace csd
