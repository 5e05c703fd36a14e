// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/centre.h"

#include <algorithm>

#include "track/patch_map.h"

namespace csd {
namespace {

constexpr int reach = 3;
constexpr double least_known = 0.3;  // of the anchor's weights there

template <class T>
double bilinear(const cv::Mat &m, double x, double y) {
  const int x0 = std::clamp(static_cast<int>(x), 0, m.cols - 2), y0 = std::clamp(static_cast<int>(y), 0, m.rows - 2);
  const double fx = x - x0, fy = y - y0;
  const T *a = m.ptr<T>(y0) + x0, *b = m.ptr<T>(y0 + 1) + x0;
  return (a[0] + fx * (a[1] - a[0])) * (1 - fy) + (b[0] + fx * (b[1] - b[0])) * fy;
}

}  // namespace

double centre_inliers(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                      const Alignment &seen, double noise) {
  const int frame_level = matching_level(seen.state, level);
  const auto map = patch_map(seen.state, level, frame_level);
  const auto &picture = pyramid.level(frame_level), &glare = weights.level(frame_level);
  const double c = 3 * std::max(noise, 2.0);
  double known = 0, fits = 0;
  for (int v = -reach; v <= reach; ++v)
    for (int u = -reach; u <= reach; ++u) {
      const double x = map.origin.x + map.step(0, 0) * u + map.step(0, 1) * v;
      const double y = map.origin.y + map.step(1, 0) * u + map.step(1, 1) * v;
      const double weight = anchor.weight.at(u, v);
      known += weight;
      if (x < 0 || y < 0 || x > picture.cols - 1 || y > picture.rows - 1) continue;
      const double clear = glare.empty() ? 1 : bilinear<std::uint8_t>(glare, x, y) / 255;
      const double q =
          ((bilinear<std::uint16_t>(picture, x, y) / 256 - seen.bias) / seen.gain - anchor.patch.at(u, v)) / c;
      fits += weight * clear / ((1 + q * q) * (1 + q * q));
    }
  constexpr int samples = (2 * reach + 1) * (2 * reach + 1);
  return known >= least_known * samples ? fits / known : seen.inliers;
}

}  // namespace csd
