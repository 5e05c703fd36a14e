// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "csd2012/learn/pixel_ranking.h"

namespace csd {

/// Separates an object's colours from those around it, in one of the 49 colour spaces (Collins, Liu & Leordeanu 2005,
/// whose log likelihood ratio and variance ratio are Eqs 4–6 of the paper). Values are a space's 0…255.
inline constexpr std::size_t colour_bins = 32;
using ColourHistogram = std::array<std::uint32_t, colour_bins>;  ///< counts; value v falls into bin v / 8

/// Counts the values in `area`, excluding what is outside `values` (CV_8UC1).
ColourHistogram count_colours(const cv::Mat &values, const cv::Rect &area);
std::uint32_t total(const ColourHistogram &h);
ColourHistogram sum(const ColourHistogram &a, const ColourHistogram &b);
/// `part` must be a part of `whole`.
ColourHistogram difference(const ColourHistogram &whole, const ColourHistogram &part);

/// The weight of each value: its log likelihood ratio L (Eq. 4) in 1/32, or 0 if it favours the background, because
/// mean shift needs weights that are not negative. At most 221, which is log(1/δ).
using ColourWeights = std::array<std::uint8_t, 256>;
inline constexpr double weight_of_likelihood = 32;

/// 0 everywhere if either histogram is empty. `log` must cover the larger total.
ColourWeights likelihood_weights(const ColourHistogram &object, const ColourHistogram &background, const LogTable &log);

/// How far the object exceeds the highest peak beside it, as a difference of mean likelihoods. It is the largest sum of
/// weights in a side × side window centred in `object`, minus the largest centred elsewhere in `neighbourhood`, divided
/// by the window's area and 1/32. Windows are clipped to `values` (CV_8UC1). `object` must lie in `neighbourhood`, and
/// that in `values`. `side` is odd.
double peak_difference(const cv::Mat &values, const ColourWeights &weights, const cv::Rect &object,
                       const cv::Rect &neighbourhood, int side);

}  // namespace csd
