// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/sheets.h"

#include <algorithm>
#include <cmath>

#include "sim/events.h"
#include "sim/ieee_math.h"
#include "sim/surface.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_sheets = 210, stream_opening = 215;

// Sliding. Units and seconds at strength 1.
constexpr double slides = 30, slide_period = 3.1, covers = 18, cover_period = 4.7;
constexpr double min_overlap = 22;  // more than the depth of the edge's waves, so no gap opens
constexpr double thickness = 9, curl = 14;

// The cut.
constexpr double half_length = 120, opening = 23, max_open = 68, falloff = 80;  // opening < falloff: nothing folds
constexpr double opens_at = 0.8, opens_for = 2.2, lip_height = 6;

/// An irregular edge: no edge of tissue is straight.
double wave(double along) {
  return 5 * sin_turns(along / 170) + 2 * sin_turns(along / 61 + 0.3);
}

cv::Point2d direction(double turns) {
  return {cos_turns(turns), sin_turns(turns)};
}

/// Left of a direction in the picture, right in the plane, because y points down.
cv::Point2d beside_of(cv::Point2d d) {
  return {-d.y, d.x};
}

}  // namespace

Sheets::Sheets(const Effects &effects, std::uint64_t seed) : slide_(effects[Effect::slide]) {
  // Independent random numbers, so that the effects don't change each other.
  const auto random = [&](std::int64_t i) { return 2 * hashed(seed, stream_sheets, i) - 1; };
  edge_ = {50 * random(0), 35 * random(1)};
  edge_along_ = direction((random(2) < 0 ? 0.08 : 0.42) + 0.03 * random(3));
  gape_ = std::min(opening * effects[Effect::tear], max_open);
  cut_ = {45 * random(4), 30 * random(5)};
  cut_along_ = direction(0.5 * random(6));
}

Sheets::Place Sheets::place(double u, double v) const {
  Place p;
  if (slide_ > 0) {
    const cv::Point2d d = cv::Point2d(u, v) - edge_;
    p.along = d.dot(edge_along_);
    p.inside = d.dot(beside_of(edge_along_)) + wave(p.along);
  }
  if (gape_ > 0) {
    const cv::Point2d d = cv::Point2d(u, v) - cut_;
    const double along = d.dot(cut_along_), x = along / half_length;
    p.beside = d.dot(beside_of(cut_along_)) + 0.6 * wave(1.7 * along);
    p.within = 1 - x * x;
    if (p.within > 0) p.lens = p.within * std::sqrt(p.within);  // pointed, and smooth at its ends
  }
  return p;
}

Sheets::Moment Sheets::at(double time) const {
  Moment m;
  if (slide_ > 0) {
    const double begun = smoothstep(time / 0.8);
    m.has_upper = true;
    m.along = slides * slide_ * begun * sin_turns(time / slide_period);
    m.over = min_overlap + covers * slide_ * (1 - begun * sin_turns(time / cover_period));
    const cv::Point2d by = m.along * edge_along_ - m.over * beside_of(edge_along_);
    m.slid = {by.x, by.y, 0};
  }
  if (gape_ > 0) {
    // Tears open in steps, then gapes with each breath.
    const double torn = stick_slip((time - opens_at) / opens_for, 7, stream_opening, 0);
    const double breath = 1 + 0.12 * smoothstep((time - opens_at - opens_for) / 2) * sin_turns(breath_rate * time);
    m.gape = gape_ * torn * breath;
    const cv::Point2d by = beside_of(cut_along_);
    m.apart = {by.x, by.y, 0};
  }
  return m;
}

cv::Vec3d Sheets::shift(const Moment &moment, const Place &place, std::uint8_t sheet) const {
  cv::Vec3d by(0, 0, 0);
  if ((sheet & upper) != 0) {
    by = moment.slid;
    by[2] += thickness * (0.25 + 0.75 * smoothstep(place.inside / curl));
  }
  if (moment.gape > 0 && place.lens > 0) {
    const bool second = (sheet & second_lip) != 0;
    const double from_edge = std::max(second ? place.beside : -place.beside, 0.0);
    const double open = moment.gape * place.lens;
    by += (second ? open : -open) * exp_of(-from_edge / falloff) * moment.apart;
    by[2] += lip_height * std::min(open / opening, 1.5) * exp_of(-from_edge / 22);
  }
  return by;
}

bool Sheets::bared(const Moment &moment, const Place &place) {
  return moment.gape > 0 && place.within > -3 && std::abs(place.beside) < 2 * falloff + moment.gape;
}

double Sheets::shade(const Moment &moment, const Place &place, int sheet) const {
  const double open = moment.gape * place.lens;
  if (sheet == bed) return 0.45 + 0.5 * smoothstep((open - std::abs(place.beside)) / 16);
  double gain = 1;
  if ((sheet & upper) != 0) {
    gain = 0.72 + 0.28 * smoothstep(place.inside / 9);
  } else if (moment.has_upper) {
    // The waves of the upper sheet's edge move with it.
    const double bare = -(place.inside - wave(place.along) + moment.over + wave(place.along - moment.along));
    gain = 1 - 0.5 * exp_of(-std::max(bare, 0.0) / 15);
  }
  if (open > 0) gain *= 1 - 0.4 * std::min(open / 8, 1.0) * exp_of(-std::abs(place.beside) / 4);
  return gain;
}

double Sheets::reach() const {
  double slid = 0;
  if (slide_ > 0) slid = slides * slide_ + min_overlap + 2 * covers * slide_;
  return slid + 1.12 * gape_;
}

}  // namespace csd::sim
