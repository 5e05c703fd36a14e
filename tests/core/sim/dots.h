// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace csd::sim {

/// A texture of dark dots on grey. Finds them in a picture without asking the simulator.
struct Dots {
  static constexpr double sigma = 2.2;  // of a dot, pixels of the texture
  static constexpr int pitch = 36;

  cv::Mat texture;
  std::vector<cv::Point2d> centres;  // texture pixels, between the pixel lattice

  explicit Dots(cv::Size size = {860, 600}) : texture(size, CV_8UC3, cv::Scalar(170, 170, 170)) {
    for (int y = pitch / 2; y < size.height; y += pitch)
      for (int x = pitch / 2; x < size.width; x += pitch)
        centres.emplace_back(x + 0.37 * ((x / pitch + y) % 3), y + 0.29 * ((x + y / pitch) % 4));
    for (const auto &c : centres) {
      for (int y = static_cast<int>(c.y) - 9; y <= c.y + 10; ++y) {
        for (int x = static_cast<int>(c.x) - 9; x <= c.x + 10; ++x) {
          if (!cv::Rect({}, size).contains({x, y})) continue;
          const double d2 = (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y);
          const auto value = static_cast<std::uint8_t>(170 - 130 * std::exp(-d2 / (2 * sigma * sigma)) + 0.5);
          auto &pixel = texture.at<cv::Vec3b>(y, x);
          for (int k = 0; k < 3; ++k) pixel[k] = std::min(pixel[k], value);
        }
      }
    }
  }

  /// The centroid of the dot nearest to `near` in the green channel, in a disc of `radius` pixels that moves along with
  /// it. Nothing if the disc leaves the picture, holds no dot, or lies on uneven ground (a fold's edge): in the mean
  /// more than `max_unevenness` grey levels off a plane.
  static std::optional<cv::Point2d> find(const cv::Mat &bgr, cv::Point2d near, double radius,
                                         double max_unevenness = 1) {
    cv::Point2d at = near;
    for (int i = 0; i < 20; ++i) {
      const int x0 = static_cast<int>(std::floor(at.x - radius)), x1 = static_cast<int>(std::ceil(at.x + radius));
      const int y0 = static_cast<int>(std::floor(at.y - radius)), y1 = static_cast<int>(std::ceil(at.y + radius));
      if (x0 < 0 || y0 < 0 || x1 >= bgr.cols || y1 >= bgr.rows) return {};
      const auto value = [&](int x, int y) { return static_cast<double>(bgr.at<cv::Vec3b>(y, x)[1]); };
      const auto each = [&](auto visit) {
        for (int y = y0; y <= y1; ++y)
          for (int x = x0; x <= x1; ++x) {
            const double dx = x - at.x, dy = y - at.y, d = std::sqrt(dx * dx + dy * dy);
            if (d <= radius) visit(x, y, dx, dy, d);
          }
      };
      // The ground is a plane fitted to the disc's rim, since light may fall off across it.
      cv::Matx33d normal = cv::Matx33d::zeros();
      cv::Vec3d right(0, 0, 0);
      each([&](int x, int y, double dx, double dy, double d) {
        if (d < 0.8 * radius) return;
        const cv::Vec3d row(1, dx, dy);
        normal += row * row.t();
        right += value(x, y) * row;
      });
      const cv::Vec3d ground = normal.inv() * right;
      double uneven = 0, rim = 0;
      each([&](int x, int y, double dx, double dy, double d) {
        if (d < 0.8 * radius) return;
        uneven += std::abs(value(x, y) - ground[0] - ground[1] * dx - ground[2] * dy);
        rim += 1;
      });
      if (uneven > max_unevenness * rim) return {};
      double sum = 0, sx = 0, sy = 0;
      each([&](int x, int y, double dx, double dy, double) {
        const double w = 1 - value(x, y) / std::max(ground[0] + ground[1] * dx + ground[2] * dy, 1.0);
        sum += w;
        sx += w * dx;
        sy += w * dy;
      });
      if (sum < 1) return {};
      at.x += sx / sum;
      at.y += sy / sum;
      if (std::abs(sx / sum) + std::abs(sy / sum) < 1e-4) break;
    }
    return at;
  }
};

}  // namespace csd::sim
