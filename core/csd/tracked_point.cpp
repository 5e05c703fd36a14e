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
      last_alignment_(frame.time) {
  alignment_.fine.state = state_;
  judgement_.reliable = true;
}

void TrackedPoint::begin_chart(int chart) {
  chart_ = chart;
  reference_ = state_.position;
  offset_.begin(state_.shape);
}

void TrackedPoint::enter_chart(const NeighbourField &field, int chart, const CsdFrame &frame) {
  const auto inverse = field.inverse_map_at(state_.position, chart, frame.unit, frame.tuning);
  if (!inverse) return;
  chart_ = chart;
  reference_ = inverse(state_.position);
  offset_.begin(inverse.linear * state_.shape);
}

std::optional<double> TrackedPoint::blur(const Tuning &tuning) const {
  if (!alignment_.fine.usable || alignment_.fine.zncc < tuning.blurred_zncc) return {};
  return alignment_.gain_coarse > 0 ? std::log(alignment_.gain_coarse / alignment_.fine.gain) : 0;
}

Expectation TrackedPoint::expectation(const Tuning &tuning) const {
  return {map_, offset_.predict(map_, reference_), offset_.deviation(tuning)};
}

void TrackedPoint::set_alignment(const CsdFrame &frame, const PointAlignment &alignment) {
  alignment_ = alignment;
  judgement_ = judge(frame, alignment_, memory_, expectation(frame.tuning));
}

void TrackedPoint::first_alignment(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  alignment_ = {};
  judgement_ = {};
  const double missed = std::exchange(missed_, unknown_miss);
  if (!visible_) return;
  AlignmentPlan plan{{state_.position + velocity_ * frame.steps, state_.shape}};
  if (map_)  // the last frame's
    plan.start.shape +=
        std::min(1.0, tuning.shape_pull * frame.steps) * (offset_.predict(map_, reference_).shape - plan.start.shape);
  map_ = {};
  plan.precision = purpose_ == Purpose::support ? tuning.support_precision : tuning.query_precision;
  // A point with steady motion is found without a coarse level.
  const bool calm = purpose_ == Purpose::support && missed * frame.steps <= tuning.calm_miss * frame.unit;
  if (calm) {
    set_alignment(frame, align_point(frame, memory_, plan));
    if (reliable() && gain_change().value_or(0) < tuning.faded) align_coarser(frame, memory_, alignment_);
  }
  if (!reliable()) {
    plan.levels = static_cast<int>(tuning.levels_first);
    set_alignment(frame, align_point(frame, memory_, plan));
  }
  if (reliable()) missed_ = cv::norm(alignment_.fine.state.position - plan.start.position) / frame.steps;
}

void TrackedPoint::compare_with_map(const CsdFrame &frame, const NeighbourMap &map) {
  map_ = map;
  if (alignment_.fine.usable) set_alignment(frame, alignment_);
}

void TrackedPoint::compare_with_map(const CsdFrame &frame, const NeighbourField &field, std::size_t owner) {
  // In the first comparison reliable() is the patch's own judgement, as the map of this frame is not known yet.
  const Correspondence own{own_reference(), alignment_.fine.state.position};
  const auto map =
      field.map_at(own_reference(), chart_, frame.unit, frame.tuning, owner, nearby_, reliable() ? &own : nullptr);
  nearby_ = map.nearby;
  compare_with_map(frame, map);
}

void TrackedPoint::second_alignment(const CsdFrame &frame, bool alone) {
  const auto &tuning = frame.tuning;
  if (reliable()) return;
  AlignmentPlan plan{state_};
  plan.levels = static_cast<int>(tuning.levels_second);
  plan.precision = purpose_ == Purpose::support ? tuning.support_precision : tuning.query_precision;
  if (map_) {
    if (tuning.second_alignments < 1) return;
    const auto expected = expectation(tuning);
    plan.start = expected.state;
    if (!frame.shows(plan.start.position)) {
      alignment_ = {};
      return;
    }
    plan.position_sd = tuning.expected_share * ((1 + expected.deviation) * map_.scale() * frame.unit + map_.spread);
    set_alignment(frame, align_point(frame, memory_, plan));
    if (!reliable() && tuning.second_alignments >= 2 && purpose_ == Purpose::query) {
      const auto whole = alignment_;
      plan.inner = true;
      plan.levels = static_cast<int>(tuning.levels_inner);
      set_alignment(frame, align_point(frame, memory_, plan));
      if (!reliable()) set_alignment(frame, whole);
      // Maps do not use such points: with them, 17 of 1000 claims were apart on cutting.mp4 instead of 11, and 8
      // instead of 4 on smoke.mp4.
      judgement_.reliable = false;
    }
  } else if (alone && !visible_) {
    set_alignment(frame, align_point(frame, memory_, plan));
    judgement_.reliable = reliable() && alignment_.fine.zncc >= tuning.alone_zncc;
    judgement_.vetoed = !judgement_.reliable;
  }
  alignment_.second = true;
}

void TrackedPoint::decide_visibility(const CsdFrame &frame, const Surroundings &around) {
  const auto &tuning = frame.tuning;
  const auto expected = expectation(tuning);
  aligned_ = alignment_.fine.state;
  if (alignment_.fine.usable && expected.may_veto(tuning) && !judgement_.own_motion)
    alignment_.fine.state.position = fuse(frame, alignment_, expected);
  evidence_ = evidence_for(frame, alignment_, memory_, expected, judgement_, around);
  if (!evidence_)
    confidence_ = 0;
  else
    confidence_ = tuning.probability != 0 ? visibility(*evidence_, tuning) : reliable() ? 1 : 0;
  const bool before = std::exchange(visible_, confidence_ >= 0.5);
  if (visible_) {
    const auto moved = alignment_.fine.state.position - state_.position;
    velocity_ = before && !alignment_.second ? moved * (1 / frame.steps) : cv::Point2d();
    state_ = alignment_.fine.state;
  } else {
    judgement_.reliable = false;
    velocity_ = {};
    if (map_) state_ = expected.state;
  }
  last_alignment_ = frame.time;
  pressing_ = visible_ && (!reliable() || cv::norm(velocity_) > tuning.fast * frame.unit);
}

void TrackedPoint::update(const CsdFrame &frame) {
  const auto &seen = alignment_.fine;
  if (visible_ && reliable() && seen.zncc >= frame.tuning.good_zncc) {
    if (map_) offset_.update(map_, reference_, seen.state, seen.information, frame.steps, frame.unit, frame.tuning);
    memory_.learn_usual(frame, seen);
  }
  if (learning()) {
    if (visible_ || map_) memory_.sample_at(frame, reliable() ? aligned_ : state_);
  } else if (reliable()) {
    memory_.measure_self_similarity(frame, aligned_);
    memory_.refine(frame, aligned_, state_.scale(), seen);
  }
}

void TrackedPoint::wait() {
  rest();
  missed_ = unknown_miss;
}

bool TrackedPoint::may_rest(const CsdFrame &frame) const {
  const auto &tuning = frame.tuning;
  return reliable() && !learning() && expectation(tuning).may_veto(tuning) &&
         map_.spread <= tuning.rest_spread * frame.unit && judgement_.distance <= tuning.rest_miss &&
         missed_ * frame.steps <= tuning.rest_miss * frame.unit;
}

void TrackedPoint::rest() {
  alignment_ = {};
  judgement_ = {};
}

void TrackedPoint::follow_map(const CsdFrame &frame) {
  if (map_) state_ = offset_.predict(map_, reference_);
  const bool followed = visible_ && map_ && frame.shows(state_.position);
  confidence_ = followed ? confidence_ * std::exp2(-frame.steps / frame.tuning.half_life) : 0;
  visible_ = confidence_ >= 0.5;
  if (!visible_) velocity_ = {};
}

double TrackedPoint::urgency(const CsdFrame &frame) const {
  return static_cast<double>(frame.time - last_alignment_) * (pressing_ ? 2 : 1);
}

void TrackedPoint::hide_until_found() {
  wait();
  map_ = {};
  velocity_ = {};
  visible_ = false;
  confidence_ = 0;
}

}  // namespace csd
