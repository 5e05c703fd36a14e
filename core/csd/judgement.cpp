// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/judgement.h"

#include <algorithm>
#include <cmath>

#include "csd/memory.h"

namespace csd {
namespace {

/// The anchor's self-similarity at the point's offset from the predicted position; without a map, the highest far
/// value. 1 while unknown.
double self_similarity_there(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                             const Expectation &expected) {
  const auto &tuning = frame.tuning;
  if (!memory.self_similarity()) return 1;
  if (!expected) return memory.self_similarity()->far();
  const auto off = alignment.fine.state.position - expected.state.position;
  const cv::Vec2d samples = alignment.fine.state.shape.inv() * cv::Vec2d(off.x, off.y);
  return memory.self_similarity()->near(
      samples, tuning.self_similarity_reach + tuning.self_similarity_per_spread * expected.map.spread / frame.unit +
                   tuning.self_similarity_per_distance * cv::norm(samples));
}

}  // namespace

bool is_distinctive(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                    const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const double zncc = std::min(alignment.fine.zncc, alignment.zncc_coarse);
  return alignment.fine.usable && zncc >= tuning.distinctive_zncc &&
         alignment.fine.inliers >= tuning.distinctive_inliers && alignment.fine.unmasked >= tuning.reliable_unmasked &&
         zncc - self_similarity_there(frame, alignment, memory, expected) > tuning.distinctive_margin;
}

Judgement judge(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const auto &fine = alignment.fine;
  Judgement out;
  out.reliable = fine.usable && fine.zncc >= tuning.reliable_zncc && fine.inliers >= tuning.reliable_inliers &&
                 fine.unmasked >= tuning.reliable_unmasked && frame.shows(fine.state.position);
  if (!fine.usable || !expected) return out;
  const double scale = expected.map.scale() * frame.unit;
  out.distance = cv::norm(expected.state.position - fine.state.position) / scale;
  if (!expected.may_veto(tuning)) return out;
  const double gate = tuning.gate_floor + tuning.gate_deviations * expected.deviation +
                      tuning.gate_spreads * expected.map.spread / scale;
  const auto distortion = expected.state.shape.inv() * fine.state.shape - cv::Matx22d::eye();
  const bool agrees = out.distance <= gate && cv::norm(distortion) <= tuning.max_distortion;
  out.own_motion = !agrees && is_distinctive(frame, alignment, memory, expected);
  out.vetoed = !agrees && !out.own_motion;
  out.reliable = out.reliable && !out.vetoed;
  return out;
}

cv::Point2d fuse(const CsdFrame &frame, const PointAlignment &alignment, const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const auto off = alignment.fine.state.position - expected.state.position;
  const double sd = (tuning.min_own_motion + tuning.own_motion_of_deviation * expected.deviation) *
                        expected.map.scale() * frame.unit +
                    tuning.own_motion_of_spread * expected.map.spread;
  const auto patch = position_covariance(alignment.fine.information).inv();
  const auto neighbours = cv::Matx22d::eye() * (1 / (sd * sd));
  const cv::Vec2d pull = (patch + neighbours).inv() * (patch * cv::Vec2d(off.x, off.y));
  return expected.state.position + cv::Point2d(pull[0], pull[1]);
}

std::optional<Evidence> evidence_for(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                                     const Expectation &expected, const Judgement &judgement,
                                     const Surroundings &around) {
  const auto &fine = alignment.fine;
  const bool distinctive = is_distinctive(frame, alignment, memory, expected);
  const bool possible = fine.usable && !judgement.vetoed && (expected || around.alone || distinctive) &&
                        fine.unmasked >= frame.tuning.min_unmasked && frame.shows(fine.state.position);
  if (!possible) return {};
  Evidence e;
  e.zncc_fine = fine.zncc;
  e.zncc_coarse = alignment.zncc_coarse;
  e.unmasked = fine.unmasked;
  e.centre = fine.centre;
  e.gain = fine.gain;
  e.noise = fine.noise;
  if (const auto change = memory.brightness_change(fine)) e.brightness_change = *change - around.brightness_drift;
  e.contrast = memory.contrast();
  if (memory.self_similarity()) e.self_similarity = memory.self_similarity()->far();
  if (!distinctive)
    e.disagreement =
        judgement.distance / (1 + expected.deviation) * self_similarity_there(frame, alignment, memory, expected);
  return e;
}

}  // namespace csd
