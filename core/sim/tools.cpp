// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tools.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_tools = 600;
constexpr float gripping = 17;  // pixels at 480 lines: the radius of a grasping instrument
constexpr float shadow_x = 13, shadow_y = 17, shadow_soft = 22, shadow_depth = 0.5F;  // pixels at 480 lines

// Pixels. Thinner rods cover next to nothing, and their lengths get lost in rounding errors.
constexpr float thinnest = 0.05F;

/// 0…1 over an edge of one pixel.
float coverage(float outside) {
  return clamp01(0.5F - outside);
}

/// An instrument's entry point and movements. Positions are fractions of the picture's width and height.
struct Instrument {
  double port_x, port_y;  // far outside the picture
  double begin, end;      // in each cycle, seconds
  double from_x, to_x;    // range of its tip's sweep…
  double from_y, to_y;    // …and of its reach
  double phase;           // of its movements, in half turns
  bool coloured;
};
constexpr Instrument instruments[] = {{1.35, 1.0, 1.2, 11, 0.12, 0.8, 0.2, 0.85, 0, true},
                                      {-0.35, 0.75, 8.5, 18.5, 0.85, 0.2, 0.2, 0.85, 1, false},
                                      {0.75, -0.5, 4, 14, 0.25, 0.75, 0.55, 0.95, 0.6, false},
                                      {0.2, 1.5, 6, 16, 0.8, 0.3, 0.1, 0.45, 1.5, true}};
constexpr std::size_t ordinary = 2;  // this many up to strength 1; the others come in further as it rises to 2

cv::Point2f direction(double turns) {
  return {static_cast<float>(cos_turns(turns)), static_cast<float>(sin_turns(turns))};
}

}  // namespace

Tools::Tools(double time, double strength, std::uint64_t seed, cv::Size size, const std::optional<Grip> &grip)
    : scale_(static_cast<float>(size.height) / 480) {
  if (grip) add(grip->port, grip->tip, gripping * scale_, 0.008 + 0.05 * grip->open, grip->coloured);
  if (strength <= 0) return;
  const float w = static_cast<float>(size.width), h = static_cast<float>(size.height);
  const double thickness = strength <= 1 ? std::sqrt(strength) : std::min(strength, 2.0);
  const auto radius = static_cast<float>(29 * thickness) * scale_;
  if (radius < thinnest) return;
  // In turns, overlapping; each sweeps to and fro while it is in.
  for (std::size_t i = 0; i < std::size(instruments); ++i) {
    const Instrument &it = instruments[i];
    const auto stream = stream_tools + 10 * i;
    const double in = each_cycle(time, it.begin, 1.5, it.end, 1.5) * (i < ordinary ? 1 : clamp01(strength - 1));
    if (in <= 0) continue;
    const double sweep = 0.5 + 0.5 * sin_turns(time / 5.3 + 0.31 * it.phase + 0.1 * wander(seed, stream, time / 2));
    const double reach = 0.5 + 0.5 * sin_turns(time / 3.7 + 0.5 * it.phase + 0.1 * wander(seed, stream + 1, time / 2));
    const float out = static_cast<float>(1 - in);
    const cv::Point2f port(static_cast<float>(it.port_x) * w, static_cast<float>(it.port_y) * h);
    const auto tip_x = static_cast<float>(lerp(it.from_x, it.to_x, sweep)) * w;
    const auto tip_y = static_cast<float>(lerp(it.from_y, it.to_y, reach)) * h;
    const cv::Point2f tip = cv::Point2f(tip_x, tip_y) + (port - cv::Point2f(tip_x, tip_y)) * out * 0.95F;
    add(port, tip, radius, 0.02 + 0.045 * (0.5 + 0.5 * sin_turns(time / 1.9 + 0.2 * it.phase)), it.coloured);
  }
}

void Tools::add(cv::Point2f port, cv::Point2f tip, float radius, double open, bool coloured) {
  const cv::Point2f axis = tip - port;
  const float length = std::sqrt(axis.dot(axis));
  const cv::Point2f d = axis * (1 / length);
  const auto turns_of = [](cv::Point2f v, double turns) {
    const cv::Point2f r = direction(turns);
    return cv::Point2f(v.x * r.x - v.y * r.y, v.x * r.y + v.y * r.x);
  };
  const float jaw = 2.5F * radius, neck = 0.8F * radius;
  const cv::Point2f wrist = tip - d * jaw, joint = wrist - d * (1.6F * radius);
  const cv::Point2f shift(shadow_x * scale_, shadow_y * scale_);
  shadows_.push_back({port + shift, tip + shift, radius, 0.4F * radius, Material::black});
  rods_.push_back({port, joint, 1.08F * radius, radius, coloured ? Material::plastic : Material::black});
  rods_.push_back({joint, wrist, 0.92F * radius, neck, Material::steel});
  for (const double side : {-1.0, 1.0}) {
    const cv::Point2f end = wrist + turns_of(d, side * open) * jaw;
    rods_.push_back({wrist, end, 0.5F * radius, 0.2F * radius, Material::steel});
  }
}

Tools::Hit Tools::hit(const Rod &rod, float x, float y) {
  const cv::Point2f axis = rod.b - rod.a, p = cv::Point2f(x, y) - rod.a;
  const float length2 = axis.dot(axis), t = clamp01(p.dot(axis) / length2);
  const cv::Point2f off = p - axis * t;
  const float radius = rod.radius_a + t * (rod.radius_b - rod.radius_a);
  const float distance = std::sqrt(off.dot(off)), side = axis.x * off.y - axis.y * off.x;
  return {distance - radius, std::clamp((side < 0 ? -distance : distance) / radius, -1.0F, 1.0F), t};
}

template <class Paint>
void Tools::visit(const Rod &rod, float grow, cv::Size size, Paint paint) {
  const float r = std::max(rod.radius_a, rod.radius_b) + grow;
  const cv::Point2f axis = rod.b - rod.a;
  const float length = std::sqrt(axis.dot(axis));
  const float top = std::min(rod.a.y, rod.b.y) - r, bottom = std::max(rod.a.y, rod.b.y) + r;
  const float left = std::min(rod.a.x, rod.b.x) - r, right = std::max(rod.a.x, rod.b.x) + r;
  const int y0 = std::max(0, static_cast<int>(top)), y1 = std::min(size.height - 1, static_cast<int>(bottom) + 1);
  for (int y = y0; y <= y1; ++y) {
    float x0 = left, x1 = right;
    // The strip of width 2r along the axis meets a row in a short piece, unless they are nearly parallel.
    if (std::abs(axis.y) > 0.05F * length) {
      const float middle = rod.a.x + axis.x * ((static_cast<float>(y) - rod.a.y) / axis.y);
      const float half = r * length / std::abs(axis.y);
      x0 = std::max(x0, middle - half);
      x1 = std::min(x1, middle + half);
    }
    const int first = static_cast<int>(std::max(x0, 0.0F));
    const int last = static_cast<int>(std::min(x1 + 1, static_cast<float>(size.width - 1)));
    for (int x = first; x <= last; ++x) paint(x, y, hit(rod, static_cast<float>(x), static_cast<float>(y)));
  }
}

float Tools::cover(cv::Point2d pixel) const {
  float covered = 0;
  for (const Rod &rod : rods_) {
    covered = std::max(covered, coverage(hit(rod, static_cast<float>(pixel.x), static_cast<float>(pixel.y)).outside));
  }
  return covered;
}

void Tools::draw(Canvas &canvas) const {
  const cv::Size size = canvas.size();
  const float soft = shadow_soft * scale_;
  for (const Rod &shadow : shadows_) {
    visit(shadow, soft, size, [&](int x, int y, const Hit &h) {
      const float keep = 1 - shadow_depth * smoothstep(0.5F - h.outside / (2 * soft));
      for (std::size_t c = 0; c < 3; ++c) canvas.row(c, y)[x] *= keep;
    });
  }
  for (const Rod &rod : rods_) {
    visit(rod, 1, size, [&](int x, int y, const Hit &h) {
      const float alpha = coverage(h.outside);
      if (alpha <= 0) return;
      // A cylinder with the lamp at the camera: bright along its middle, a highlight beside it, reflected tissue at its
      // edges.
      const float round = std::sqrt(std::max(0.0F, 1 - h.across * h.across));
      const float stripe_at = (h.across + 0.25F) * (rod.material == Material::steel ? 5.0F : 7.0F);
      const float stripe = std::max(0.0F, 1 - stripe_at * stripe_at);
      float base = 0, mirror = 0, shine = 0;
      switch (rod.material) {
        case Material::steel:
          base = 45 + 120 * round;
          mirror = 70;
          shine = 170;
          break;
        case Material::black:
          base = 14 + 34 * round;
          mirror = 26;
          shine = 110;
          break;
        case Material::plastic:
          base = 38 + 105 * round;
          mirror = 30;
          shine = 45;
          break;
      }
      // Turned rings in the shaft, so that it has texture.
      const float ring = h.along * 14 - std::floor(h.along * 14);
      if (rod.material != Material::steel && ring < 0.06F) base *= 0.72F;
      const float grey = base + shine * stripe * stripe, red = mirror * (1 - round);
      const float colour[3] = {grey * 1.03F + 0.25F * red, grey + 0.2F * red, grey * 0.97F + red};
      for (std::size_t c = 0; c < 3; ++c) {
        float &p = canvas.row(c, y)[x];
        p += alpha * (colour[c] - p);
      }
    });
  }
}

}  // namespace csd::sim
