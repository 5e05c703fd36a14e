// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <vector>

#include "track/patch_kernels.h"

namespace csd::scalar {

namespace {

template <class Visit>
void for_each_sample(Visit visit) {
  for (int y = -PatchPlane::radius; y <= PatchPlane::radius; ++y)
    for (int x = -PatchPlane::radius; x <= PatchPlane::radius; ++x) visit(x, y, PatchPlane::index(x, y));
}

template <class T>
double bilinear(const cv::Mat &m, double x, double y) {
  const int x0 = std::clamp(static_cast<int>(x), 0, m.cols - 2), y0 = std::clamp(static_cast<int>(y), 0, m.rows - 2);
  const double fx = x - x0, fy = y - y0;
  const T *a = m.ptr<T>(y0) + x0, *b = m.ptr<T>(y0 + 1) + x0;
  return (a[0] + fx * (a[1] - a[0])) * (1 - fy) + (b[0] + fx * (b[1] - b[0])) * fy;
}

}  // namespace

double sample_patch(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                    PatchPlane &weight) {
  int inside = 0;
  const double right = level.cols - 1, bottom = level.rows - 1;
  for_each_sample([&](int vx, int vy, std::size_t i) {
    const double x = map.origin.x + map.step(0, 0) * vx + map.step(0, 1) * vy;
    const double y = map.origin.y + map.step(1, 0) * vx + map.step(1, 1) * vy;
    const bool in = x >= -inside_tolerance && y >= -inside_tolerance && x <= right + inside_tolerance &&
                    y <= bottom + inside_tolerance;
    const double cx = std::clamp(x, 0., right), cy = std::clamp(y, 0., bottom);
    value.data[i] = static_cast<float>(bilinear<std::uint16_t>(level, cx, cy) / 256);
    weight.data[i] = !in               ? 0.F
                     : weights.empty() ? 1.F
                                       : static_cast<float>(bilinear<std::uint8_t>(weights, cx, cy) / 255);
    inside += in;
  });
  return static_cast<double>(inside) / PatchPlane::pixels;
}

void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit) {
  const auto &T = anchor.patch.data, &I = value.data, &m = weight.data;
  double s1 = 0, sT = 0, sTT = 0, sI = 0, sIT = 0;
  for_each_sample([&](int, int, std::size_t i) {
    const double w = m[i] * robust.data[i], t = T[i], v = I[i];
    s1 += w, sT += w * t, sTT += w * t * t, sI += w * v, sIT += w * v * t;
  });
  const double spread = s1 * sTT - sT * sT;
  fit.gain = std::max<double>(spread > 0 ? (s1 * sIT - sI * sT) / spread : 0, smallest_gain);
  fit.bias = s1 > 0 ? (sI - fit.gain * sT) / s1 : 0;

  PatchPlane r;
  std::vector<float> sizes;
  for_each_sample([&](int, int, std::size_t i) {
    r.data[i] = static_cast<float>((I[i] - fit.bias) / fit.gain - T[i]);
    if (m[i] > counted_weight) sizes.push_back(std::abs(r.data[i]));
  });
  fit.counted = static_cast<int>(sizes.size());
  fit.noise = 0;
  if (!sizes.empty()) {
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    fit.noise = 1.48 * *middle;
  }

  const double c = 3 * std::max(fit.noise, 2.);
  fit.weight = fit.inliers = 0;
  fit.gradient.fill(0);
  double change = 0;
  const auto jacobian = [&](int vx, int vy, std::size_t i) {
    const double x = vx / 10., y = vy / 10., tx = anchor.gradient_x.data[i], ty = anchor.gradient_y.data[i];
    return std::array<double, unknowns>{T[i], 1, x * tx, y * tx, x * ty, y * ty, tx, ty};
  };
  for_each_sample([&](int vx, int vy, std::size_t i) {
    const double q = 1 + (r.data[i] / c) * (r.data[i] / c), w = m[i] / (q * q);
    change += std::abs(w - double{m[i]} * robust.data[i]);
    robust.data[i] = static_cast<float>(1 / (q * q));
    fit.weight += m[i];
    fit.inliers += w;
    const auto J = jacobian(vx, vy, i);
    for (std::size_t a = 0; a < unknowns; ++a) fit.gradient[a] += w * J[a] * r.data[i];
  });
  if (fit.drift >= 0) fit.drift += change;
  if (fit.drift >= 0 && fit.drift < largest_drift * fit.inliers) return;
  fit.drift = 0;
  fit.matrix = {};
  for_each_sample([&](int vx, int vy, std::size_t i) {
    const auto J = jacobian(vx, vy, i);
    for (std::size_t a = 0; a < unknowns; ++a)
      for (std::size_t b = a; b < unknowns; ++b) fit.matrix[a][b] += double{m[i]} * robust.data[i] * J[a] * J[b];
  });
}

PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight) {
  double s1 = 0, sT = 0, sTT = 0, sI = 0, sII = 0, sIT = 0;
  for_each_sample([&](int, int, std::size_t i) {
    const double w = weight.data[i], t = anchor.patch.data[i], v = value.data[i];
    s1 += w, sT += w * t, sTT += w * t * t, sI += w * v, sII += w * v * v, sIT += w * v * t;
  });
  PatchMoments out;
  out.weight = s1;
  if (s1 > 0) {
    out.frame_variance = std::max(sII / s1 - (sI / s1) * (sI / s1), 0.);
    out.anchor_variance = std::max(sTT / s1 - (sT / s1) * (sT / s1), 0.);
    out.covariance = sIT / s1 - (sI / s1) * (sT / s1);
  }
  return out;
}

}  // namespace csd::scalar
