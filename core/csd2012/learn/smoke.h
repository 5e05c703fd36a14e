// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <vector>

#include "base/random.h"

namespace csd {

/// The three densities of §2.1.2.2: d is normally distributed around each, with smoke_density_deviation.
inline constexpr std::array<double, 3> smoke_densities{0.15, 0.25, 0.4};
inline constexpr double smoke_density_deviation = 0.05;
/// The smoke's colour C (equal in R, G and B), as an intensity in [0,1].
inline constexpr double smoke_colour_mean = 0.6;
inline constexpr double smoke_colour_deviation = 0.1;

/// σ of the field's Gaussian, as a share of the patch ("smooth spatial distribution").
inline constexpr double smoke_smoothness = 0.25;
/// Side of the field, in patches: large enough that two cutouts are hardly ever the same.
inline constexpr int smoke_field_patches = 6;

/// The two readings of Eq. 1.
enum class SmokeEquation : std::uint8_t {
  as_meant,   ///< P′ = (1−d)·P + d·C: more smoke where d is larger, as the text and Fig. 4 have it
  as_printed  ///< P′ = d·P + (1−d)·C
};

/// Eq. 1 for one intensity in 0…255 with C in [0,1]; rounded to nearest.
std::uint8_t smoke_pixel(std::uint8_t p, double d, double c, SmokeEquation equation = SmokeEquation::as_meant);

/// Diathermy smoke for image patches (§2.1.2.2, Eq. 1).
///
/// d and C vary smoothly over the patch: with constants, Eq. 1 is monotone and could not change any test P1 > P2. Both
/// are cut from one periodic field: white noise under a Gaussian (smoke_smoothness), rescaled to mean 0 and variance 1
/// (the filter removes nearly all variance). A cutout costs a hundredth of filtering anew.
class Smoke {
 public:
  /// `random` generates the field. patch_size: side in pixels.
  Smoke(int patch_size, Random &random, SmokeEquation equation = SmokeEquation::as_meant);

  /// Adds smoke to a CV_8UC3 patch of at most patch_size × patch_size. `density`: the mean of d, one of
  /// smoke_densities; d and C are clamped to [0,1]. Throws cv::Exception on another type or a larger patch.
  void apply(cv::Mat &patch, double density, Random &random) const;

  /// The field: field_size() × field_size() numbers, row by row, periodic.
  const std::vector<double> &field() const { return field_; }
  int field_size() const { return side_; }

 private:
  int patch_size_;
  int side_;
  SmokeEquation equation_;
  std::vector<double> field_;
};

}  // namespace csd
