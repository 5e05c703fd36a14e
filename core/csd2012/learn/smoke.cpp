// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/smoke.h"

#include <algorithm>
#include <cmath>

namespace csd {

namespace {

/// Circular convolution of each row of a side × side field with a symmetric kernel; the result is transposed, so that
/// two calls filter rows and columns.
std::vector<double> filter_rows(const std::vector<double> &in, std::size_t side, const std::vector<double> &kernel) {
  std::vector<double> out(in.size()), around(3 * side), sums(side);
  for (std::size_t y = 0; y < side; ++y) {
    const double *row = in.data() + y * side;
    for (std::size_t turn = 0; turn < 3; ++turn) std::copy_n(row, side, around.data() + turn * side);
    for (std::size_t x = 0; x < side; ++x) sums[x] = kernel[0] * row[x];
    for (std::size_t k = 1; k < kernel.size(); ++k)
      for (std::size_t x = 0; x < side; ++x) sums[x] += kernel[k] * (around[side + x + k] + around[side + x - k]);
    for (std::size_t x = 0; x < side; ++x) out[x * side + y] = sums[x];
  }
  return out;
}

}  // namespace

std::uint8_t smoke_pixel(std::uint8_t p, double d, double c, SmokeEquation equation) {
  const double share = equation == SmokeEquation::as_meant ? d : 1 - d;
  const double value = (1 - share) * p + share * c * 255;
  return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
}

Smoke::Smoke(int patch_size, Random &random, SmokeEquation equation)
    : patch_size_(patch_size), side_(smoke_field_patches * patch_size), equation_(equation) {
  CV_Assert(patch_size >= 1 && patch_size <= 255);
  const auto side = static_cast<std::size_t>(side_);
  field_.resize(side * side);
  for (double &x : field_) x = random.normal();

  const double sigma = smoke_smoothness * patch_size;
  std::vector<double> kernel(static_cast<std::size_t>(std::ceil(3 * sigma)) + 1);
  for (std::size_t k = 0; k < kernel.size(); ++k) {
    const double r = static_cast<double>(k) / sigma;
    kernel[k] = std::exp(-r * r / 2);
  }
  field_ = filter_rows(filter_rows(field_, side, kernel), side, kernel);

  double sum = 0, squares = 0;
  for (const double x : field_) sum += x;
  const double mean = sum / static_cast<double>(field_.size());
  for (const double x : field_) squares += (x - mean) * (x - mean);
  const double scale = 1 / std::sqrt(squares / static_cast<double>(field_.size()));
  for (double &x : field_) x = (x - mean) * scale;
}

void Smoke::apply(cv::Mat &patch, double density, Random &random) const {
  CV_Assert(patch.type() == CV_8UC3 && patch.rows <= patch_size_ && patch.cols <= patch_size_);
  const auto side = static_cast<std::size_t>(side_);
  const auto anywhere = [&] { return std::size_t{random.below(static_cast<std::uint32_t>(side_))}; };
  const std::size_t dx = anywhere(), dy = anywhere(), cx = anywhere(), cy = anywhere();
  // The field is periodic and larger than a patch.
  const auto wrapped = [side](std::size_t i) { return i < side ? i : i - side; };
  for (int y = 0; y < patch.rows; ++y) {
    auto *row = patch.ptr<cv::Vec3b>(y);
    const double *densities = field_.data() + wrapped(dy + static_cast<std::size_t>(y)) * side;
    const double *colours = field_.data() + wrapped(cy + static_cast<std::size_t>(y)) * side;
    for (int x = 0; x < patch.cols; ++x) {
      const auto u = static_cast<std::size_t>(x);
      const double d = std::clamp(density + smoke_density_deviation * densities[wrapped(dx + u)], 0.0, 1.0);
      const double c = std::clamp(smoke_colour_mean + smoke_colour_deviation * colours[wrapped(cx + u)], 0.0, 1.0);
      for (int k = 0; k < 3; ++k) row[x][k] = smoke_pixel(row[x][k], d, c, equation_);
    }
  }
}

}  // namespace csd
