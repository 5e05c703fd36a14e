// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/burnt_in.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <vector>

namespace csd {
namespace {

constexpr int max_lines = 288;        // of the copy
constexpr int block_rows = 32;        // blocks over the picture's height
constexpr double memory = 1.0;        // s, of mean and deviation
constexpr double warm_up = 0.5;       // s before the first conclusion
constexpr float sure_after = 1.8F;    // s of evidence: with 0.8, pausing tools and tissue are marked
constexpr float max_evidence = 3.0F;  // s
constexpr float doubt_rate = 0.5F;    // relative rate at which still neighbours reduce the evidence

// Chosen by viewing clips, not from measured distributions: medians over a picture were about 0.25 px on slowly moving
// tissue and 0.08 px on still tissue, after subtracting noise.
constexpr float sharp = 16;            // grey levels over two pixels of the copy
constexpr float fixed_below = 0.06F;   // px
constexpr float moving_above = 0.15F;  // px
constexpr float texture = 3;           // grey levels over two pixels; below, motion is undetermined
constexpr float dark = 32;             // grey levels: a black border has no noise to measure
constexpr float fixed_pixels = 3;      // least number in a block that is checked

/// How far to look on each of a block's four sides, in blocks, and the share of the blocks with texture that must move
/// there. The nearest reach finds lines of text, the farther ones captions. Still tissue beside a tool is still on the
/// tool's other side too; the farther reaches need a larger share to outweigh it.
constexpr struct {
  int blocks;
  float moving_share;
} reaches[] = {{4, 0.5F}, {8, 0.7F}, {12, 0.75F}};
constexpr float lit_share = 0.5F;  // of a side; below, it is the picture's edge or the dark border
constexpr int min_sides = 2;       // a corner of the picture has only two

}  // namespace

/// One value per block.
struct BurntIn::Blocks {
  cv::Mat fixed;   // CV_8UC1, 1: has sharp, fixed edges
  cv::Mat moving;  // CV_8UC1, 1: its texture moves
  cv::Mat still;   // CV_8UC1, 1: its texture is still
};

void BurntIn::reset() {
  *this = BurntIn();
}

bool BurntIn::update(const cv::Mat &luma, double dt) {
  CV_Assert(luma.type() == CV_8UC1 && !luma.empty());
  if (luma.size() != luma_size_) {
    reset();
    luma_size_ = luma.size();
    const int shrink = std::max(1, (luma.rows + max_lines - 1) / max_lines);
    const cv::Size size(std::max(1, luma.cols / shrink), std::max(1, luma.rows / shrink));
    block_ = std::max(4, (size.height + block_rows / 2) / block_rows);
    const cv::Size blocks((size.width + block_ - 1) / block_, (size.height + block_ - 1) / block_);
    mean_ = cv::Mat::zeros(size, CV_32FC1);
    deviation_ = cv::Mat::zeros(size, CV_32FC1);
    gradient_ = cv::Mat::zeros(size, CV_32FC1);
    fixed_ = cv::Mat::zeros(size, CV_8UC1);
    mask_ = cv::Mat::zeros(size, CV_8UC1);
    evidence_ = cv::Mat::zeros(blocks, CV_32FC1);
    marked_ = cv::Mat::zeros(blocks, CV_8UC1);
  }
  if (luma.size() == mean_.size()) {
    copy_ = luma;
  } else {
    cv::resize(luma, copy_, mean_.size(), 0, 0, cv::INTER_AREA);
  }
  dt = std::clamp(dt, 0.0, memory);
  accumulate(dt);
  copy_ = luma.size() == mean_.size() ? cv::Mat() : copy_;  // never shares the caller's pixels
  if (seen_ < warm_up) return false;
  weigh(sum_blocks(noise()), dt);
  return mark();
}

void BurntIn::accumulate(double dt) {
  // The first samples count equally, so that the start is as accurate as the rest.
  ++samples_;
  if (samples_ > 1) seen_ += dt;
  const auto weight = static_cast<float>(std::max(1.0 / samples_, 1 - std::exp(-dt / memory)));
  for (int y = 0; y < mean_.rows; ++y) {
    const std::uint8_t *is = copy_.ptr<std::uint8_t>(y);
    float *mean = mean_.ptr<float>(y);
    float *deviation = deviation_.ptr<float>(y);
    if (samples_ == 1) {
      for (int x = 0; x < mean_.cols; ++x) mean[x] = is[x];
      continue;
    }
    for (int x = 0; x < mean_.cols; ++x) {
      const float d = static_cast<float>(is[x]) - mean[x];
      mean[x] += weight * d;
      deviation[x] += weight * (std::abs(d) - deviation[x]);
    }
  }
}

/// The deviation at still pixels: a low quantile over the flat, lit part. Also updates gradient_.
float BurntIn::noise() {
  constexpr float step = 0.125F;
  std::array<int, 256> histogram{};
  int flat = 0;
  for (int y = 0; y < mean_.rows; ++y) {
    const float *above = mean_.ptr<float>(std::max(0, y - 1));
    const float *here = mean_.ptr<float>(y);
    const float *below = mean_.ptr<float>(std::min(mean_.rows - 1, y + 1));
    const float *deviation = deviation_.ptr<float>(y);
    float *gradient = gradient_.ptr<float>(y);
    const int last = mean_.cols - 1;
    for (int x = 1; x < last; ++x) {
      gradient[x] = std::max(std::abs(here[x + 1] - here[x - 1]), std::abs(below[x] - above[x]));
    }
    gradient[0] = std::max(std::abs(here[std::min(1, last)] - here[0]), std::abs(below[0] - above[0]));
    gradient[last] = std::max(std::abs(here[last] - here[std::max(0, last - 1)]), std::abs(below[last] - above[last]));
    for (int x = y % 2; x <= last; x += 2) {
      if (gradient[x] >= 2 * texture || here[x] < dark) continue;
      ++histogram[std::min<std::size_t>(histogram.size() - 1, static_cast<std::size_t>(deviation[x] / step))];
      ++flat;
    }
  }
  int below = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    below += histogram[i];
    if (below * 5 >= flat) return static_cast<float>(i) * step;
  }
  return 0;
}

BurntIn::Blocks BurntIn::sum_blocks(float noise) {
  const cv::Size size = evidence_.size();
  Blocks blocks{cv::Mat::zeros(size, CV_8UC1), cv::Mat::zeros(size, CV_8UC1), cv::Mat::zeros(size, CV_8UC1)};
  // Sums columns first, pixel by pixel, so that compilers vectorise it.
  const int width = mean_.cols;
  std::vector<float> fixed_sums(static_cast<std::size_t>(width)), gradient_sums(fixed_sums), deviation_sums(fixed_sums);
  const float enough = 0.5F * static_cast<float>(block_ * block_);
  for (int row = 0; row < size.height; ++row) {
    float *fixed = fixed_sums.data(), *gradients = gradient_sums.data(), *deviations = deviation_sums.data();
    for (auto *sums : {&fixed_sums, &gradient_sums, &deviation_sums}) std::fill(sums->begin(), sums->end(), 0.0F);
    for (int y = row * block_; y < std::min(mean_.rows, (row + 1) * block_); ++y) {
      const float *gradient = gradient_.ptr<float>(y);
      const float *deviation = deviation_.ptr<float>(y);
      std::uint8_t *is_fixed = fixed_.ptr<std::uint8_t>(y);
      for (int x = 0; x < width; ++x) {
        const float g = gradient[x], d = deviation[x];
        const float f = g > sharp && d < fixed_below * g ? 1.0F : 0.0F;
        const float tells = g >= texture ? 1 - f : 0.0F;
        is_fixed[x] = static_cast<std::uint8_t>(255 * f);
        fixed[x] += f;
        gradients[x] += tells * g;
        deviations[x] += tells * std::max(d - noise, 0.0F);
      }
    }
    for (int column = 0; column < size.width; ++column) {
      const int begin = column * block_, end = std::min(width, begin + block_);
      const float gradient_sum = std::accumulate(gradients + begin, gradients + end, 0.0F);
      if (std::accumulate(fixed + begin, fixed + end, 0.0F) >= fixed_pixels) {
        blocks.fixed.at<std::uint8_t>(row, column) = 1;
      } else if (gradient_sum >= enough) {
        const float deviation_sum = std::accumulate(deviations + begin, deviations + end, 0.0F);
        const bool moves = deviation_sum > moving_above * gradient_sum;
        (moves ? blocks.moving : blocks.still).at<std::uint8_t>(row, column) = 1;
      }
    }
  }
  return blocks;
}

/// Whether a block sees motion on all its sides.
class BurntIn::Surroundings {
 public:
  Surroundings(const Blocks &blocks, const cv::Mat &mean) : all_({0, 0}, blocks.moving.size()) {
    cv::Mat lit;
    cv::resize(mean, lit, all_.size(), 0, 0, cv::INTER_AREA);
    cv::threshold(lit, lit, dark, 1, cv::THRESH_BINARY);
    lit.convertTo(lit, CV_8U);
    cv::integral(lit, lit_, CV_32S);
    cv::integral(blocks.moving, moving_, CV_32S);
    // Sharp fixed edges are still too: still tissue has them all around.
    cv::integral(blocks.still | blocks.fixed, resting_, CV_32S);
  }

  bool move(int row, int column) const {
    return std::any_of(std::begin(reaches), std::end(reaches), [&](const auto &reach) {
      const int far = reach.blocks, wide = 2 * far + 1;
      const std::array<cv::Rect, 4> sides{{{column - far, row - far, far, wide},
                                           {column + 1, row - far, far, wide},
                                           {column - far, row - far, wide, far},
                                           {column - far, row + 1, wide, far}}};
      int asked = 0;
      for (const cv::Rect &side : sides) {
        const cv::Rect seen = side & all_;
        if (seen.empty() || static_cast<float>(sum(lit_, seen)) < lit_share * static_cast<float>(side.area())) continue;
        ++asked;
        const int moving = sum(moving_, seen), resting = sum(resting_, seen);
        if (moving == 0 || static_cast<float>(moving) < reach.moving_share * static_cast<float>(moving + resting))
          return false;
      }
      return asked >= min_sides;
    });
  }

 private:
  static int sum(const cv::Mat &integral, const cv::Rect &r) {
    const cv::Point end = r.br();
    return integral.at<int>(end) - integral.at<int>(r.y, end.x) - integral.at<int>(end.y, r.x) +
           integral.at<int>(r.tl());
  }

  cv::Rect all_;
  cv::Mat lit_, moving_, resting_;  // CV_32SC1, integrals of 0 and 1
};

void BurntIn::weigh(const Blocks &blocks, double dt) {
  const Surroundings surroundings(blocks, mean_);
  const auto step = static_cast<float>(dt);
  for (int row = 0; row < evidence_.rows; ++row) {
    for (int column = 0; column < evidence_.cols; ++column) {
      float &evidence = evidence_.at<float>(row, column);
      if (blocks.fixed.at<std::uint8_t>(row, column) == 0) {
        evidence -= step;
      } else if (surroundings.move(row, column)) {
        evidence += step;
      } else {
        evidence -= doubt_rate * step;
      }
      evidence = std::clamp(evidence, 0.0F, max_evidence);
      std::uint8_t &marked = marked_.at<std::uint8_t>(row, column);
      if (evidence >= sure_after) marked = 255;
      if (evidence <= 0) marked = 0;
    }
  }
}

bool BurntIn::mark() {
  bool changed = false;
  for (int y = 0; y < mask_.rows; ++y) {
    const std::uint8_t *marked = marked_.ptr<std::uint8_t>(y / block_);
    const std::uint8_t *fixed = fixed_.ptr<std::uint8_t>(y);
    std::uint8_t *mask = mask_.ptr<std::uint8_t>(y);
    std::uint8_t differs = 0;
    for (int begin = 0; begin < mask_.cols; begin += block_, ++marked) {
      for (int x = begin; x < std::min(mask_.cols, begin + block_); ++x) {
        // A pixel of a graphics block stays marked: a passing highlight may blur its edge for a moment.
        const std::uint8_t next = *marked & (mask[x] | fixed[x]);
        differs |= static_cast<std::uint8_t>(next ^ mask[x]);
        mask[x] = next;
      }
    }
    changed |= differs != 0;
  }
  return changed;
}

}  // namespace csd
