// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace csd {
namespace {

constexpr int fraction_bits = 8, one = 1 << fraction_bits;
/// Positions are clamped to ±this: far outside any picture, and an int holds it in units of 1/256.
constexpr double far = 1 << 20;
/// Lower bound of the third homogeneous coordinate; a patch in front of the camera has values near 1.
constexpr double horizon = 1e-6;

/// A coordinate in 1/256 pixels, clamped so that it and its right neighbour lie in 0…size-1.
struct Tap {
  int low, high, fraction;
  Tap(double position, int size) {
    const int fixed = static_cast<int>(std::floor(std::clamp(position, -far, far) * one + 0.5));
    low = fixed >> fraction_bits;
    fraction = fixed & (one - 1);
    high = std::clamp(low + 1, 0, size - 1);
    low = std::clamp(low, 0, size - 1);
  }
};

template <int channels>
void interpolate(const cv::Mat &source, const Tap &x, const Tap &y, std::uint8_t *out) {
  const std::uint8_t *top = source.ptr(y.low), *bottom = source.ptr(y.high);
  for (int c = 0; c < channels; ++c) {
    const int a = channels * x.low + c, b = channels * x.high + c;
    const int upper = top[a] * (one - x.fraction) + top[b] * x.fraction;
    const int lower = bottom[a] * (one - x.fraction) + bottom[b] * x.fraction;
    const int sum = upper * (one - y.fraction) + lower * y.fraction;
    out[c] = static_cast<std::uint8_t>((sum + (1 << (2 * fraction_bits - 1))) >> (2 * fraction_bits));
  }
}

template <int channels>
void sample(const cv::Mat &source, cv::Point2d centre, int half, const Warp &warp, cv::Mat &out) {
  const bool affine = warp(2, 0) == 0 && warp(2, 1) == 0;
  const double everywhere = 1 / std::max(warp(2, 2), horizon);
  for (int v = -half; v <= half; ++v) {
    std::uint8_t *to = out.ptr(v + half);
    for (int u = -half; u <= half; ++u, to += channels) {
      const double w = affine ? everywhere : 1 / std::max(warp(2, 0) * u + warp(2, 1) * v + warp(2, 2), horizon);
      const Tap x(centre.x + (warp(0, 0) * u + warp(0, 1) * v + warp(0, 2)) * w, source.cols);
      const Tap y(centre.y + (warp(1, 0) * u + warp(1, 1) * v + warp(1, 2)) * w, source.rows);
      interpolate<channels>(source, x, y, to);
    }
  }
}

void check(const cv::Mat &source, cv::Point2d centre, int side, const Warp &warp) {
  const bool finite = std::all_of(warp.val, warp.val + 9, [](double v) { return std::isfinite(v); });
  if (side < 1 || side % 2 == 0) throw std::invalid_argument("sample_patch: the side of a patch is odd");
  if (source.empty() || (source.type() != CV_8UC1 && source.type() != CV_8UC3))
    throw std::invalid_argument("sample_patch: the source is 8 bit, of 1 or 3 channels");
  if (!finite || !std::isfinite(centre.x) || !std::isfinite(centre.y))
    throw std::invalid_argument("sample_patch: centre and warp are finite");
}

}  // namespace

void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, const Warp &warp, cv::Mat &out) {
  check(source, centre, side, warp);
  out.create(side, side, source.type());
  if (source.channels() == 1)
    sample<1>(source, centre, side / 2, warp, out);
  else
    sample<3>(source, centre, side / 2, warp, out);
}

void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, cv::Mat &out) {
  check(source, centre, side, Warp::eye());
  const cv::Point corner(static_cast<int>(std::clamp(centre.x, -far, far)) - side / 2,
                         static_cast<int>(std::clamp(centre.y, -far, far)) - side / 2);
  const cv::Rect where(corner, cv::Size(side, side));
  const bool whole = centre.x == std::floor(centre.x) && centre.y == std::floor(centre.y);
  if (whole && (where & cv::Rect({0, 0}, source.size())) == where)
    source(where).copyTo(out);
  else
    sample_patch(source, centre, side, Warp::eye(), out);
}

}  // namespace csd
