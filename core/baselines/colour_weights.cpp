// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/colour_weights.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace csd {

namespace {
constexpr int bin_shift = 3;
}

ColourHistogram count_colours(const cv::Mat &values, const cv::Rect &area) {
  CV_Assert(values.type() == CV_8UC1);
  // Two tables in turn: incrementing the same bin twice in a row would wait for the first store.
  std::array<ColourHistogram, 2> part{};
  const auto inside = area & cv::Rect({0, 0}, values.size());
  for (int y = inside.y; y < inside.y + inside.height; ++y) {
    const auto *row = values.ptr(y) + inside.x;
    int x = 0;
    for (; x + 2 <= inside.width; x += 2) {
      ++part[0][row[x] >> bin_shift];
      ++part[1][row[x + 1] >> bin_shift];
    }
    if (x < inside.width) ++part[0][row[x] >> bin_shift];
  }
  return sum(part[0], part[1]);
}

std::uint32_t total(const ColourHistogram &h) {
  return std::accumulate(h.begin(), h.end(), std::uint32_t{0});
}

ColourHistogram sum(const ColourHistogram &a, const ColourHistogram &b) {
  ColourHistogram out;
  std::transform(a.begin(), a.end(), b.begin(), out.begin(), std::plus<>());
  return out;
}

ColourHistogram difference(const ColourHistogram &whole, const ColourHistogram &part) {
  ColourHistogram out;
  std::transform(whole.begin(), whole.end(), part.begin(), out.begin(), std::minus<>());
  return out;
}

ColourWeights likelihood_weights(const ColourHistogram &object, const ColourHistogram &background,
                                 const LogTable &log) {
  ColourWeights weights{};
  const auto objects = total(object), others = total(background);
  if (objects == 0 || others == 0) return weights;
  for (std::size_t bin = 0; bin < colour_bins; ++bin) {
    const double l = std::max(log[object[bin]] - log[objects], log.floor()) -
                     std::max(log[background[bin]] - log[others], log.floor());
    const auto weight = static_cast<std::uint8_t>(std::lround(std::max(l, 0.0) * weight_of_likelihood));
    std::fill_n(weights.begin() + static_cast<std::ptrdiff_t>(bin << bin_shift), 1 << bin_shift, weight);
  }
  return weights;
}

double peak_difference(const cv::Mat &values, const ColourWeights &weights, const cv::Rect &object,
                       const cv::Rect &neighbourhood, int side) {
  cv::Mat image, mass;
  cv::LUT(values, cv::Mat(1, 256, CV_8UC1, const_cast<std::uint8_t *>(weights.data())), image);
  cv::boxFilter(image, mass, CV_32S, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  int peak = 0, beside = 0;
  for (int y = neighbourhood.y; y < neighbourhood.y + neighbourhood.height; ++y) {
    const auto *row = mass.ptr<int>(y);
    const bool crosses = y >= object.y && y < object.y + object.height;
    const int begin = crosses ? object.x : neighbourhood.x + neighbourhood.width;
    const int end = crosses ? object.x + object.width : begin;
    for (int x = neighbourhood.x; x < begin; ++x) beside = std::max(beside, row[x]);
    for (int x = begin; x < end; ++x) peak = std::max(peak, row[x]);
    for (int x = end; x < neighbourhood.x + neighbourhood.width; ++x) beside = std::max(beside, row[x]);
  }
  return (peak - beside) / (weight_of_likelihood * side * side);
}

}  // namespace csd
