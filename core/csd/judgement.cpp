// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/judgement.h"

#include <algorithm>
#include <cmath>

#include "csd/memory.h"

namespace csd {
namespace {

/// The anchor's self-similarity at the point's offset from the predicted position; without a map, the highest far
/// value. 1 while unknown.
double likeness_there(const CsdFrame &frame, const Look &look, const Memory &memory, const Expectation &expected) {
  const auto &tuning = frame.tuning;
  if (!memory.likeness()) return 1;
  if (!expected) return memory.likeness()->far();
  const auto off = look.fine.state.position - expected.state.position;
  const cv::Vec2d samples = look.fine.state.shape.inv() * cv::Vec2d(off.x, off.y);
  return memory.likeness()->near(samples, tuning.alike_reach +
                                              tuning.alike_per_spread * expected.map.spread / frame.unit +
                                              tuning.alike_per_distance * cv::norm(samples));
}

}  // namespace

bool told_apart(const CsdFrame &frame, const Look &look, const Memory &memory, const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const double zncc = std::min(look.fine.zncc, look.zncc_coarse);
  return look.fine.usable && zncc >= tuning.apart_zncc && look.fine.inliers >= tuning.apart_inliers &&
         look.fine.unmasked >= tuning.sure_unmasked &&
         zncc - likeness_there(frame, look, memory, expected) > tuning.apart_margin;
}

Judgement judge(const CsdFrame &frame, const Look &look, const Memory &memory, const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const auto &fine = look.fine;
  Judgement out;
  out.sure = fine.usable && fine.zncc >= tuning.sure_zncc && fine.inliers >= tuning.sure_inliers &&
             fine.unmasked >= tuning.sure_unmasked && frame.shows(fine.state.position);
  if (!fine.usable || !expected) return out;
  const double scale = expected.map.scale() * frame.unit;
  out.distance = cv::norm(expected.state.position - fine.state.position) / scale;
  if (!expected.overrules(tuning)) return out;
  const double gate = tuning.gate_floor + tuning.gate_deviations * expected.deviation +
                      tuning.gate_spreads * expected.map.spread / scale;
  const auto distortion = expected.state.shape.inv() * fine.state.shape - cv::Matx22d::eye();
  out.agrees = out.distance <= gate && cv::norm(distortion) <= tuning.max_distortion;
  out.own_motion = !out.agrees && told_apart(frame, look, memory, expected);
  out.agrees = out.agrees || out.own_motion;
  out.sure = out.sure && out.agrees;
  return out;
}

cv::Point2d fuse(const CsdFrame &frame, const Look &look, const Expectation &expected) {
  const auto &tuning = frame.tuning;
  const auto off = look.fine.state.position - expected.state.position;
  const double sd = (tuning.min_own_motion + tuning.own_motion_of_deviation * expected.deviation) *
                        expected.map.scale() * frame.unit +
                    tuning.own_motion_of_spread * expected.map.spread;
  const auto patch = position_covariance(look.fine.information).inv();
  const auto neighbours = cv::Matx22d::eye() * (1 / (sd * sd));
  const cv::Vec2d pull = (patch + neighbours).inv() * (patch * cv::Vec2d(off.x, off.y));
  return expected.state.position + cv::Point2d(pull[0], pull[1]);
}

std::optional<Evidence> evidence_for(const CsdFrame &frame, const Look &look, const Memory &memory,
                                     const Expectation &expected, const Judgement &judgement,
                                     const Surroundings &around) {
  const auto &fine = look.fine;
  const bool apart = told_apart(frame, look, memory, expected);
  const bool possible = fine.usable && judgement.agrees && (expected || around.alone || apart) &&
                        fine.unmasked >= frame.tuning.min_unmasked && frame.shows(fine.state.position);
  if (!possible) return {};
  Evidence e;
  e.zncc_fine = fine.zncc;
  e.zncc_coarse = look.zncc_coarse;
  e.unmasked = fine.unmasked;
  e.centre = fine.centre;
  e.gain = fine.gain;
  e.noise = fine.noise;
  if (const auto change = memory.brightness_change(fine)) e.brightness_change = *change - around.brightness_drift;
  e.contrast = memory.contrast();
  if (memory.likeness()) e.likeness = memory.likeness()->far();
  if (!apart)
    e.disagreement = judgement.distance / (1 + expected.deviation) * likeness_there(frame, look, memory, expected);
  return e;
}

}  // namespace csd
