// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/merge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace csd {
namespace {

/// Points in square cells of the query radius.
class Neighbours {
 public:
  explicit Neighbours(double radius) : radius_(std::max(radius, 1.0)) {}

  bool any_near(cv::Point2d p) const {
    const cv::Point home = cell(p);
    for (int row = home.y - 1; row <= home.y + 1; ++row) {
      for (int column = home.x - 1; column <= home.x + 1; ++column) {
        const auto there = cells_.find({row, column});
        if (there == cells_.end()) continue;
        for (const cv::Point2d &q : there->second) {
          const cv::Point2d d = q - p;
          if (d.dot(d) < radius_ * radius_) return true;
        }
      }
    }
    return false;
  }
  void add(cv::Point2d p) {
    const cv::Point home = cell(p);
    cells_[{home.y, home.x}].push_back(p);
  }

 private:
  cv::Point cell(cv::Point2d p) const { return {index(p.x), index(p.y)}; }
  /// Given points may lie anywhere: those far outside share the outermost cells.
  int index(double at) const { return cvFloor(std::clamp(at / radius_, -1e9, 1e9)); }

  double radius_;
  std::map<std::pair<int, int>, std::vector<cv::Point2d>> cells_;
};

}  // namespace

std::vector<cv::Point2d> merge_by_rank(const Candidates &a, const Candidates &b, double radius,
                                       std::span<const cv::Point2d> taken) {
  Neighbours kept(radius);
  for (const cv::Point2d &p : taken) kept.add(p);
  std::vector<cv::Point2d> merged;
  const auto offer = [&](const Candidates &from, std::size_t i) {
    if (i >= from.size() || kept.any_near(from[i].at)) return;
    kept.add(from[i].at);
    merged.push_back(from[i].at);
  };
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    offer(a, i);
    offer(b, i);
  }
  return merged;
}

std::vector<cv::Point2d> spread(const std::vector<cv::Point2d> &ranked, cv::Size size, double bucket,
                                std::size_t wanted, std::span<const cv::Point2d> taken) {
  const int columns = std::max(1, cvCeil(size.width / bucket));
  const int rows = std::max(1, cvCeil(size.height / bucket));
  std::vector<std::size_t> filled(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  // Clamped before the conversion to int: given points may lie anywhere.
  const auto index = [bucket](double at, int count) {
    return cvFloor(std::clamp((at + 0.5) / bucket, 0.0, count - 1.0));
  };
  const auto bucket_of = [&](cv::Point2d p) -> std::size_t & {
    const int column = index(p.x, columns), row = index(p.y, rows);
    return filled[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  };
  for (const cv::Point2d &p : taken) ++bucket_of(p);

  // A point's round is its rank in its bucket.
  std::vector<std::pair<std::size_t, std::size_t>> turns;  // round, index in ranked
  turns.reserve(ranked.size());
  for (std::size_t i = 0; i < ranked.size(); ++i) turns.emplace_back(bucket_of(ranked[i])++, i);
  std::sort(turns.begin(), turns.end());
  turns.resize(std::min(wanted, turns.size()));

  std::vector<std::size_t> chosen;
  chosen.reserve(turns.size());
  for (const auto &turn : turns) chosen.push_back(turn.second);
  std::sort(chosen.begin(), chosen.end());
  std::vector<cv::Point2d> result;
  result.reserve(chosen.size());
  for (const std::size_t i : chosen) result.push_back(ranked[i]);
  return result;
}

}  // namespace csd
