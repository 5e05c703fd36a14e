// SPDX-License-Identifier: LGPL-2.1-or-later
#include "learn/colour_choice.h"

#include "image/convert.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>

#include "learn/pixel_ranking.h"

namespace csd {

namespace {

constexpr int max_span = 6;  // |w1| + |w2| + |w3|

/// Of the highest 16, or of all if there are fewer. Leaves them in another order.
double mean_of_best(std::span<double> v) {
  const std::size_t best = std::min(colour_choice_pixels, v.size());
  std::partial_sort(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(best), v.end(), std::greater<>());
  return std::accumulate(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(best), 0.0) / static_cast<double>(best);
}

/// The score of one space. `planes`: [patch][B, G, R][pixel]. The counts stand at [pixel][class][bin]: the pixels of a
/// patch fall into histograms of their own, so no increment waits for the one before.
double score(ColourSpace space, std::span<const std::uint8_t> planes, const ColourPatches &patches,
             std::uint32_t features, const LogTable &log, std::vector<std::uint32_t> &counts,
             std::vector<std::uint16_t> &mixed) {
  const std::size_t pixels = mixed.size();
  const int bits = histogram_bits(patches.size());
  const std::size_t bins = std::size_t{1} << bits;

  // The bin of each value of mix(): apply() depends on it alone.
  const int span = space.span();
  std::array<std::uint8_t, 255 * max_span + 1> bin{};
  for (int f = 0; f <= 255 * span; ++f)
    bin[static_cast<std::size_t>(f)] = static_cast<std::uint8_t>((f / span) >> (8 - bits));

  std::fill(counts.begin(), counts.end(), 0);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint8_t *b = planes.data() + i * 3 * pixels, *g = b + pixels, *r = g + pixels;
    for (std::size_t p = 0; p < pixels; ++p) mixed[p] = static_cast<std::uint16_t>(space.mix(r[p], g[p], b[p]));
    std::uint32_t *histogram = counts.data() + (patches.label(i) == Label::feature ? 0 : bins);
    for (std::size_t p = 0; p < pixels; ++p) ++histogram[p * 2 * bins + bin[mixed[p]]];
  }

  std::vector<double> v(pixels);
  const auto others = static_cast<std::uint32_t>(patches.size()) - features;
  for (std::size_t p = 0; p < pixels; ++p) {
    const std::uint32_t *t = counts.data() + p * 2 * bins;
    v[p] = variance_ratio({t, bins}, features, {t + bins, bins}, others, log);
  }
  return mean_of_best(v);
}

}  // namespace

ColourPatches::ColourPatches(int patch_size) : patch_size_(patch_size) {
  CV_Assert(patch_size >= 3 && patch_size <= 255 && patch_size % 2 == 1);
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

void ColourPatches::convert(const ColourSpace &space, cv::Mat out) const {
  const int rows = static_cast<int>(size()) * patch_size_;
  CV_Assert(out.type() == CV_8UC1 && out.rows == rows && out.cols == patch_size_ && out.isContinuous());
  // As one row a patch: the kernel behind it has less to do at row ends.
  const int count = static_cast<int>(size()), pixels = patch_size_ * patch_size_;
  const cv::Mat in(count, pixels, CV_8UC3, const_cast<std::uint8_t *>(bytes_.data()));
  cv::Mat to(count, pixels, CV_8UC1, out.data);
  to_space(in, space, to);
}

std::array<double, 49> colour_scores(const ColourPatches &patches) {
  const auto side = static_cast<std::size_t>(patches.patch_size()), pixels = side * side;
  std::vector<std::uint8_t> planes(patches.size() * 3 * pixels);
  std::uint32_t features = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint8_t *in = patches.patch(i).data;
    std::uint8_t *out = planes.data() + i * 3 * pixels;
    for (std::size_t p = 0; p < pixels; ++p)
      for (std::size_t k = 0; k < 3; ++k) out[k * pixels + p] = in[3 * p + k];
    features += patches.label(i) == Label::feature;
  }
  const LogTable log(patches.size());
  std::vector<std::uint32_t> counts(pixels * 2 * (std::size_t{1} << histogram_bits(patches.size())));
  std::vector<std::uint16_t> mixed(pixels);
  std::array<double, 49> scores{};
  for (std::size_t s = 0; s < scores.size(); ++s)
    scores[s] = score(colour_spaces()[s], planes, patches, features, log, counts, mixed);
  return scores;
}

namespace {

ColourSpace best_of(const std::array<double, 49> &scores) {
  return colour_spaces()[static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin())];
}

}  // namespace

std::array<double, 49> colour_scores_of_pairs(const ColourPatches &patches, Random &random) {
  constexpr std::size_t pairs = 256;
  const auto pixels = static_cast<std::uint32_t>(patches.patch_size() * patches.patch_size());
  std::array<std::array<std::uint32_t, 2>, pairs> ends{};
  for (auto &[p1, p2] : ends) {
    p1 = random.below(pixels);
    p2 = (p1 + 1 + random.below(pixels - 1)) % pixels;
  }
  // [patch][pair][B G R]; a space's difference is its mix of these.
  std::vector<std::int16_t> differences;
  differences.reserve(patches.size() * pairs * 3);
  std::uint32_t features = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::uint8_t *in = patches.patch(i).data;
    for (const auto &[p1, p2] : ends)
      for (std::size_t c = 0; c < 3; ++c)
        differences.push_back(static_cast<std::int16_t>(in[3 * p1 + c] - in[3 * p2 + c]));
    features += patches.label(i) == Label::feature;
  }
  const auto others = static_cast<std::uint32_t>(patches.size()) - features;
  const std::size_t bins = std::size_t{1} << histogram_bits(patches.size());
  const LogTable log(patches.size());
  std::vector<std::uint32_t> counts(pairs * 2 * bins);  // [pair][class][bin]
  std::array<double, 49> scores{};
  for (std::size_t s = 0; s < scores.size(); ++s) {
    const auto &space = colour_spaces()[s];
    std::fill(counts.begin(), counts.end(), 0);
    const std::int16_t *d = differences.data();
    for (std::size_t i = 0; i < patches.size(); ++i) {
      std::uint32_t *histogram = counts.data() + (patches.label(i) == Label::feature ? 0 : bins);
      for (std::size_t k = 0; k < pairs; ++k, d += 3, histogram += 2 * bins) {
        // Tissue's differences are small: the bins reach to ±64, the outermost on from there.
        const int mixed = (space.b * d[0] + space.g * d[1] + space.r * d[2]) / space.span();
        ++histogram[static_cast<std::size_t>(std::clamp(mixed + 64, 0, 127)) * bins / 128];
      }
    }
    std::array<double, pairs> v{};
    for (std::size_t k = 0; k < pairs; ++k) {
      const std::uint32_t *t = counts.data() + k * 2 * bins;
      v[k] = variance_ratio({t, bins}, features, {t + bins, bins}, others, log);
    }
    scores[s] = mean_of_best(v);
  }
  return scores;
}

ColourSpace choose_colour_of_pairs(const ColourPatches &patches, Random &random) {
  return best_of(colour_scores_of_pairs(patches, random));
}

ColourSpace choose_colour(const ColourPatches &patches) {
  return best_of(colour_scores(patches));
}

}  // namespace csd
