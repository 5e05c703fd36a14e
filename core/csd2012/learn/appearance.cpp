// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/appearance.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace csd {

namespace {

double between(const double (&range)[2], Random &random) {
  return range[0] + (range[1] - range[0]) * random.uniform();
}

}  // namespace

void add_highlight(cv::Mat &patch, double pixel, Random &random) {
  CV_Assert(patch.type() == CV_8UC3);
  const double angle = CV_PI * random.uniform(), c = std::cos(angle), s = std::sin(angle);
  const double length = pixel * between(highlight_axis, random), width = length * between(highlight_share, random);
  const double cx = patch.cols * random.uniform(), cy = patch.rows * random.uniform();
  for (int y = 0; y < patch.rows; ++y) {
    auto *row = patch.ptr<cv::Vec3b>(y);
    for (int x = 0; x < patch.cols; ++x) {
      const double u = (c * (x - cx) + s * (y - cy)) / length, v = (c * (y - cy) - s * (x - cx)) / width;
      const double r = u * u + v * v, share = std::exp(-r * r);
      for (int k = 0; k < 3; ++k) row[x][k] = cv::saturate_cast<unsigned char>((1 - share) * row[x][k] + share * 255);
    }
  }
}

void blur_by_motion(cv::Mat &patch, double pixel, Random &random) {
  CV_Assert(patch.type() == CV_8UC3);
  const double angle = CV_PI * random.uniform(), half = pixel * between(blur_length, random) / 2;
  const int reach = static_cast<int>(std::ceil(half));
  cv::Mat kernel(2 * reach + 1, 2 * reach + 1, CV_32FC1, cv::Scalar(0));
  constexpr int steps = 64;
  for (int i = 0; i <= steps; ++i) {
    const double t = half * (2.0 * i / steps - 1);
    kernel.at<float>(reach + cvRound(t * std::sin(angle)), reach + cvRound(t * std::cos(angle))) += 1.F / (steps + 1);
  }
  cv::filter2D(patch, patch, -1, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
}

void compress(cv::Mat &patch, Random &random) {
  CV_Assert(patch.type() == CV_8UC3);
  const double step = between(codec_step, random);
  const auto before = [&] { return static_cast<int>(random.below(codec_block)); };
  const auto whole = [](int pixels) { return (codec_block - pixels % codec_block) % codec_block; };
  const int left = before(), top = before();
  cv::Mat grown, block, coefficients;
  cv::copyMakeBorder(patch, grown, top, whole(top + patch.rows), left, whole(left + patch.cols), cv::BORDER_REPLICATE);
  std::vector<cv::Mat> channels;
  cv::split(grown, channels);
  for (auto &channel : channels)
    for (int y = 0; y < channel.rows; y += codec_block)
      for (int x = 0; x < channel.cols; x += codec_block) {
        cv::Mat place = channel(cv::Rect(x, y, codec_block, codec_block));
        place.convertTo(block, CV_32F);
        cv::dct(block, coefficients);
        for (float &value : cv::Mat_<float>(coefficients))
          value = static_cast<float>(step * std::round(static_cast<double>(value) / step));
        cv::idct(coefficients, block);
        block.convertTo(place, CV_8U);
      }
  cv::merge(channels, grown);
  grown(cv::Rect(left, top, patch.cols, patch.rows)).copyTo(patch);
}

}  // namespace csd
