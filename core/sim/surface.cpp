// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/surface.h"

#include <algorithm>
#include <cmath>

#include "sim/camera.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_relief = 200, stream_pulse = 201, stream_beat = 202;

// The fold: a ridge across the picture above its middle that leans towards +v over the tissue there.
constexpr double fold_v = -95, fold_across = 46, fold_along = 190, fold_height = 85, fold_lean = 135;

double gaussian(double du, double dv, double inverse) {
  const double x = (du * du + dv * dv) * inverse;
  return x > 32 ? 0 : exp_of(-x);  // 1e−14: nothing, even in thousandths of a pixel
}

double inverse_of(double sigma) {
  return 1 / (2 * sigma * sigma);
}

/// The ventricle: a quick contraction and a slow filling. About −1…1; `turns` of the period.
double heartbeat(double turns) {
  return 0.75 * sin_turns(turns) + 0.3 * sin_turns(2 * turns + 0.06) + 0.1 * sin_turns(3 * turns + 0.2);
}

double breathing(double turns) {
  return sin_turns(turns) + 0.22 * sin_turns(2 * turns + 0.1);
}

double fold_at(double u, double v) {
  // The ridge is slightly oblique.
  const double du = u - 20, dv = v - fold_v - 0.12 * du;
  return exp_of(-du * du * inverse_of(fold_along) - dv * dv * inverse_of(fold_across));
}

}  // namespace

Surface::Surface(const Effects &effects, std::uint64_t seed)
    : fold_(effects[Effect::fold]),
      sheets_(effects, seed),
      cavity_(effects[Effect::cavity]),
      grasp_(effects[Effect::grasp]),
      seed_(seed) {
  Random random(seed, stream_relief);
  // A jittered 4 × 3 grid, alternating up and down, so that no seed gives a flat scene.
  for (int i = 0; i < bumps; ++i) {
    const int column = i % 4, row = i / 4;
    const double u = (column - 1.5) * 250 + random.uniform(-90, 90), v = (row - 1) * 250 + random.uniform(-90, 90);
    const double sign = (i + row) % 2 != 0 ? 1 : -1;
    relief_[static_cast<std::size_t>(i)] = {u, v, inverse_of(random.uniform(75, 130)), sign * random.uniform(14, 34)};
  }

  const double strong = effects[Effect::heart_strong], mild = effects[Effect::heart_mild];
  const double liver = effects[Effect::liver];
  const double heart = 19 * strong + 6 * mild + 1.2 * liver;
  const double breath = 7 * liver + 2 * strong + 1.5 * mild;
  Random pulse(seed, stream_pulse);
  for (int i = 0; i < gaussians; ++i) {
    auto &p = pulses_[static_cast<std::size_t>(i)];
    const int column = i % 4, row = i / 4;
    p.u = (column - 1.5) * 170 + pulse.uniform(-60, 60);
    p.v = (row - 1) * 180 + pulse.uniform(-60, 60);
    p.inverse = inverse_of(pulse.uniform(85, 150));
    const auto direction = [&](double sideways, double up) {
      const double turn = pulse.uniform(), size = pulse.uniform(0.6, 1.2);
      return cv::Vec3d(sideways * size * cos_turns(turn), sideways * size * sin_turns(turn),
                       up * size * (pulse.below(2) != 0 ? 1 : -1));
    };
    p.cardiac = direction(heart, heart);
    p.breath = direction(breath, 1.6 * breath);
    p.noise = direction(0.06 * (heart + breath), 0.06 * (heart + breath));
    p.lag = pulse.uniform(-0.08, 0.08);
  }
  drift_ = {3 * liver + strong, 15 * liver + 4 * strong + 2 * mild, 11 * liver};

  reach_ = std::abs(drift_[1]) * 1.3 + std::abs(drift_[0]) * 1.3;
  double together = 0;
  for (const auto &p : pulses_) {
    together += 0.45 * (1.15 * cv::norm(p.cardiac) + 1.22 * cv::norm(p.breath) + cv::norm(p.noise));
  }
  reach_ += together * 0.5 + fold_ * fold_lean * 1.3 + sheets_.reach() + cavity_.reach() + grasp_reach(grasp_);
}

Surface::Moment Surface::at(double time) const {
  Moment moment;
  // Beats and breaths vary: their rates and depths wander a little.
  const double beats = heart_rate * time + 0.12 * wander(seed_, stream_beat, 0.4 * time);
  const double breaths = breath_rate * time + 0.05 * wander(seed_, stream_beat + 1, 0.15 * time);
  const double depth = 1 + 0.1 * wander(seed_, stream_beat + 2, 0.3 * time);
  const double b = depth * breathing(breaths);
  for (std::size_t i = 0; i < pulses_.size(); ++i) {
    const Pulse &p = pulses_[i];
    const double random = wander(seed_, stream_beat + 10 + i, 2.5 * time);
    moment.push_[i] = heartbeat(beats + p.lag) * p.cardiac + b * p.breath + random * p.noise;
  }
  moment.shift_ = b * drift_;
  if (fold_ > 0) {
    const double breathes = 1 + 0.18 * b + 0.06 * heartbeat(beats);
    moment.fold_ = fold_ * breathes * cv::Vec3d(0, fold_lean, fold_height);
  }
  if (sheets_.any()) {
    moment.sheets_ = &sheets_;
    moment.cuts_ = sheets_.at(time);
  }
  if (grasp_ > 0) {
    moment.grasp_ = grasp_at(time, grasp_, seed_);
    moment.grasped_ = moment.grasp_.pull != cv::Vec3d(0, 0, 0);
    moment.grasped_sheet_ = Sheets::sheet_of(sheets_.place(moment.grasp_.hold.x, moment.grasp_.hold.y));
  }
  return moment;
}

cv::Vec3d Surface::Moment::at(const Place &place, std::uint8_t sheet) const {
  cv::Vec3d p = whole(place, sheet);
  if (sheets_) p += sheets_->shift(cuts_, place.cuts, sheet);
  return p;
}

cv::Vec3d Surface::Moment::bed(const Place &place) const {
  constexpr double behind = 28;  // units
  const cv::Vec3d p = whole(place, place.sheet) + Sheets::bed_shift(cuts_, place.cuts);
  const cv::Vec3d ray = p - cv::Vec3d(0, 0, nominal_distance);
  return p + (behind / std::sqrt(ray.dot(ray))) * ray;
}

cv::Vec3d Surface::Moment::whole(const Place &place, std::uint8_t sheet) const {
  cv::Vec3d p = place.rest + shift_ + place.fold * fold_;
  for (std::size_t i = 0; i < push_.size(); ++i) p += place.pulse[i] * push_[i];
  // A grasp on one sheet doesn't pull at the other; the two lips of a cut move together.
  if (grasped_ && ((sheet ^ grasped_sheet_) & Sheets::upper) == 0) p += grasp_.at(place.u, place.v);
  return p;
}

Surface::Place Surface::place(double u, double v) const {
  Place p;
  p.u = u;
  p.v = v;
  double relief = 0;
  cv::Vec3d along_u{1, 0, 0}, along_v{0, 1, 0};
  for (const Bump &bump : relief_) {
    const double du = u - bump.u, dv = v - bump.v, height = bump.height * gaussian(du, dv, bump.inverse);
    relief += height;
    along_u[2] -= 2 * bump.inverse * height * du;
    along_v[2] -= 2 * bump.inverse * height * dv;
  }
  p.rest = {u, v, relief};
  if (cavity_.any()) {
    constexpr double step = 0.5;
    p.rest = cavity_.at(u, v, relief);
    const double by_u = step * along_u[2], by_v = step * along_v[2];
    along_u = (cavity_.at(u + step, v, relief + by_u) - cavity_.at(u - step, v, relief - by_u)) * (0.5 / step);
    along_v = (cavity_.at(u, v + step, relief + by_v) - cavity_.at(u, v - step, relief - by_v)) * (0.5 / step);
  }
  for (std::size_t i = 0; i < pulses_.size(); ++i) {
    p.pulse[i] = gaussian(u - pulses_[i].u, v - pulses_[i].v, pulses_[i].inverse);
  }
  if (fold_ > 0) {
    constexpr double step = 0.5;
    p.fold = fold_at(u, v);
    const double du = fold_at(u + step, v) - fold_at(u - step, v), dv = fold_at(u, v + step) - fold_at(u, v - step);
    const cv::Vec3d push = cv::Vec3d(0, fold_lean, fold_height) * (fold_ / (2 * step));
    along_u += du * push;
    along_v += dv * push;
  }
  if (sheets_.any()) {
    p.cuts = sheets_.place(u, v);
    p.sheet = Sheets::sheet_of(p.cuts);
  }
  const cv::Vec3d n = along_u.cross(along_v);
  p.normal = n / std::sqrt(n.dot(n));
  if (cavity_.any()) {
    // Walls are seen obliquely: shades folds relative to a wall without.
    const cv::Vec3d lamp = cv::Vec3d(0, 0, nominal_distance) - p.rest;
    const double faces = p.normal.dot(lamp) / std::sqrt(lamp.dot(lamp));
    p.normal = {0, 0, std::clamp(0.77 * faces / cavity_.facing(u, v), 0.6, 1.0)};
  }
  return p;
}

}  // namespace csd::sim
