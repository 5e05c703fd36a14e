// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/grasp.h"

#include <algorithm>
#include <cmath>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_grasp = 220;
constexpr double every = 5;  // seconds between grasps
// Seconds from the start of each grasp.
constexpr double comes = 0.1, there = 0.5, closed = 0.65, pulls = 0.7, pulled = 2.7, lets_go = 3.5, gone = 4.5;
constexpr double springs_back = 0.16;  // seconds, until it first swings back through its rest position

constexpr double far_sideways = 38, far_up = 18, sigma = 62;  // units at strength 1
constexpr double tip = 9;                                     // units: size of a jaw, which holds the tissue as a whole

struct Port {
  double x, y;
  bool coloured;
};
constexpr Port ports[] = {{1.4, 0.9, true}, {-0.4, 0.75, false}, {1.25, -0.35, false}, {-0.25, 1.35, true}};

/// 1 while held, then a damped oscillation to 0.
double held(double since) {
  if (since <= 0) return 1;
  const double x = since / springs_back;
  return cos_turns(0.25 * x) * exp_of(-0.9 * x) * smoothstep((6 - x) / 2);
}

}  // namespace

cv::Vec3d Grasp::at(double u, double v) const {
  const double du = u - hold.x, dv = v - hold.y;
  // A cusp, blunted by the width of the jaws.
  const double r = std::sqrt(du * du + dv * dv + tip * tip) - tip;
  return exp_of(-r / sigma) * pull;
}

Grasp grasp_at(double time, double strength, std::uint64_t seed) {
  Grasp g;
  if (strength <= 0) return g;
  const double k = floor_of(time / every), t = time - k * every;
  const auto index = static_cast<std::int64_t>(k);
  const auto random = [&](std::uint64_t i) { return hashed(seed, stream_grasp + i, index); };
  g.hold = {240 * random(0) - 120, 170 * random(1) - 85};
  const Port &port = ports[static_cast<std::size_t>(4 * random(2))];
  g.port = {port.x, port.y};
  g.coloured = port.coloured;
  g.in = window(t, comes, there - comes, gone, gone - lets_go - 0.1);
  g.open = 1 - smoothstep((t - there) / (closed - there)) + smoothstep((t - lets_go) / 0.1);
  g.sigma = sigma * std::max(strength, 1.0);

  // Pulls roughly towards its port, then moves the tissue about.
  const double turns = 0.16 * random(3) - 0.08 + 0.05 * sin_turns((t - pulled) / 1.3) * smoothstep((t - pulled) / 0.5);
  const cv::Vec2d d(g.port.x - 0.5, 0.75 * (g.port.y - 0.5));
  const double c = cos_turns(turns), s = sin_turns(turns), length = std::sqrt(d.dot(d));
  const double far = strength * (0.75 + 0.25 * random(4)) *
                     stick_slip((t - pulls) / (pulled - pulls), seed, stream_grasp + 9, index) * held(t - lets_go);
  g.pull = far * cv::Vec3d(far_sideways * (c * d[0] - s * d[1]) / length, far_sideways * (s * d[0] + c * d[1]) / length,
                           far_up);
  return g;
}

double grasp_reach(double strength) {
  return far_sideways * strength;
}

}  // namespace csd::sim
