// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/colour_choice.h"

#include "image/convert.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>

#include "csd2012/learn/pixel_ranking.h"

namespace csd {

namespace {

constexpr int max_span = 6;  // |w1| + |w2| + |w3|

/// Mean of the highest 16, or of all if there are fewer. Reorders them.
double mean_of_best(std::span<double> v) {
  const std::size_t best = std::min(colour_choice_pixels, v.size());
  std::partial_sort(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(best), v.end(), std::greater<>());
  return std::accumulate(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(best), 0.0) / static_cast<double>(best);
}

/// The score of each space from `things` per patch: pixels, or pairs of them. `make(space, bits)` returns a function of
/// i and fall, which calls fall(k, bin) for each thing k of patch i; bin is one of 2^bits.
///
/// Counts are laid out [thing][class][bin]: each thing of a patch has its own histogram, so no increment waits for the
/// previous one.
template <class Make>
std::array<double, 49> scores_by(const ColourPatches &patches, std::size_t things, Make make) {
  std::uint32_t features = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) features += patches.label(i) == Label::feature;
  const auto others = static_cast<std::uint32_t>(patches.size()) - features;
  const LogTable log(patches.size());
  const int bits = histogram_bits(patches.size());
  const std::size_t bins = std::size_t{1} << bits;
  std::vector<std::uint32_t> counts(things * 2 * bins);
  std::vector<double> v(things);
  std::array<double, 49> scores{};
  for (std::size_t s = 0; s < scores.size(); ++s) {
    const auto bins_of = make(colour_spaces()[s], bits);
    std::fill(counts.begin(), counts.end(), 0);
    for (std::size_t i = 0; i < patches.size(); ++i) {
      std::uint32_t *histogram = counts.data() + (patches.label(i) == Label::feature ? 0 : bins);
      bins_of(i, [&](std::size_t k, std::size_t bin) { ++histogram[k * 2 * bins + bin]; });
    }
    for (std::size_t k = 0; k < things; ++k) {
      const std::uint32_t *t = counts.data() + k * 2 * bins;
      v[k] = variance_ratio({t, bins}, features, {t + bins, bins}, others, log);
    }
    scores[s] = mean_of_best(v);
  }
  return scores;
}

ColourSpace best_of(const std::array<double, 49> &scores) {
  return colour_spaces()[static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin())];
}

}  // namespace

ColourPatches::ColourPatches(int patch_size) : patch_size_(patch_size) {
  check_patch_size(patch_size);
}

void ColourPatches::add(const cv::Mat &patch, Label label) {
  CV_Assert(patch.type() == CV_8UC3 && patch.rows == patch_size_ && patch.cols == patch_size_);
  const auto row_bytes = static_cast<std::size_t>(patch_size_) * 3;
  for (int y = 0; y < patch_size_; ++y) {
    const std::uint8_t *row = patch.ptr(y);
    bytes_.insert(bytes_.end(), row, row + row_bytes);
  }
  labels_.push_back(label);
}

cv::Mat ColourPatches::patch(std::size_t i) const {
  const auto bytes = static_cast<std::size_t>(patch_size_ * patch_size_) * 3;
  return {patch_size_, patch_size_, CV_8UC3, const_cast<std::uint8_t *>(bytes_.data() + i * bytes)};
}

cv::Mat ColourPatches::stack() const {
  return {static_cast<int>(size()) * patch_size_, patch_size_, CV_8UC3, const_cast<std::uint8_t *>(bytes_.data())};
}

void ColourPatches::convert(const ColourSpace &space, cv::Mat out) const {
  const int rows = static_cast<int>(size()) * patch_size_;
  CV_Assert(out.type() == CV_8UC1 && out.rows == rows && out.cols == patch_size_ && out.isContinuous());
  // One row per patch: the kernel has fewer row ends.
  const int count = static_cast<int>(size()), pixels = patch_size_ * patch_size_;
  const cv::Mat in(count, pixels, CV_8UC3, const_cast<std::uint8_t *>(bytes_.data()));
  cv::Mat to(count, pixels, CV_8UC1, out.data);
  to_space(in, space, to);
}

std::array<double, 49> colour_scores(const ColourPatches &patches) {
  const auto side = static_cast<std::size_t>(patches.patch_size()), pixels = side * side;
  std::vector<std::uint8_t> planes(patches.size() * 3 * pixels);  // [patch][B, G, R][pixel]
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint8_t *in = patches.patch(i).data;
    std::uint8_t *out = planes.data() + i * 3 * pixels;
    for (std::size_t p = 0; p < pixels; ++p)
      for (std::size_t k = 0; k < 3; ++k) out[k * pixels + p] = in[3 * p + k];
  }
  std::vector<std::uint16_t> mixed(pixels);
  return scores_by(patches, pixels, [&](ColourSpace space, int bits) {
    // The bin of each value of mix(), on which alone apply() depends.
    const int span = space.span();
    std::array<std::uint8_t, 255 * max_span + 1> bin{};
    for (int f = 0; f <= 255 * span; ++f)
      bin[static_cast<std::size_t>(f)] = static_cast<std::uint8_t>((f / span) >> (8 - bits));
    return [&, space, bin](std::size_t i, auto fall) {
      const std::uint8_t *b = planes.data() + i * 3 * pixels, *g = b + pixels, *r = g + pixels;
      for (std::size_t p = 0; p < pixels; ++p) mixed[p] = static_cast<std::uint16_t>(space.mix(r[p], g[p], b[p]));
      for (std::size_t p = 0; p < pixels; ++p) fall(p, bin[mixed[p]]);
    };
  });
}

std::array<double, 49> colour_scores_of_pairs(const ColourPatches &patches, Random &random) {
  constexpr std::size_t pairs = 256;
  const auto pixels = static_cast<std::uint32_t>(patches.patch_size() * patches.patch_size());
  std::array<std::array<std::uint32_t, 2>, pairs> ends{};
  for (auto &[p1, p2] : ends) {
    p1 = random.below(pixels);
    p2 = (p1 + 1 + random.below(pixels - 1)) % pixels;
  }
  // [patch][pair][B G R]; a space's difference is a linear combination of them.
  std::vector<std::int16_t> differences;
  differences.reserve(patches.size() * pairs * 3);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint8_t *in = patches.patch(i).data;
    for (const auto &[p1, p2] : ends)
      for (std::size_t c = 0; c < 3; ++c)
        differences.push_back(static_cast<std::int16_t>(in[3 * p1 + c] - in[3 * p2 + c]));
  }
  return scores_by(patches, pairs, [&](ColourSpace space, int bits) {
    // The bin of each difference. Those within tissue are small: the bins cover ±64, and the outermost ones everything
    // beyond.
    const int span = space.span(), largest = 255 * span;
    std::array<std::uint8_t, 2 * 255 * max_span + 1> bin{};
    for (int f = -largest; f <= largest; ++f) {
      const int value = std::clamp(f / span + 64, 0, 127);
      bin[static_cast<std::size_t>(f + largest)] = static_cast<std::uint8_t>((value << bits) >> 7);
    }
    return [&, space, largest, bin](std::size_t i, auto fall) {
      const std::int16_t *d = differences.data() + i * pairs * 3;
      for (std::size_t k = 0; k < pairs; ++k, d += 3)
        fall(k, bin[static_cast<std::size_t>(space.b * d[0] + space.g * d[1] + space.r * d[2] + largest)]);
    };
  });
}

ColourSpace choose_colour(const ColourPatches &patches) {
  return best_of(colour_scores(patches));
}

ColourSpace choose_colour_of_pairs(const ColourPatches &patches, Random &random) {
  return best_of(colour_scores_of_pairs(patches, random));
}

}  // namespace csd
