// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/support_points.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "content/tools.h"

namespace csd {
namespace {

/// Grid cells of the picture, with the number of points in each.
class Cells {
 public:
  Cells(const CsdFrame &frame)
      : side_(std::max(frame.tuning.cell_side * frame.unit, std::sqrt(frame.size.area() / frame.tuning.max_cells))),
        columns_(std::max(1, static_cast<int>(std::lround(frame.size.width / side_)))),
        rows_(std::max(1, static_cast<int>(std::lround(frame.size.height / side_)))),
        size_(frame.size),
        count_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  std::size_t of(cv::Point2d p) const {
    const int x = std::clamp(static_cast<int>((p.x + 0.5) * columns_ / size_.width), 0, columns_ - 1);
    const int y = std::clamp(static_cast<int>((p.y + 0.5) * rows_ / size_.height), 0, rows_ - 1);
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }
  std::size_t &count(cv::Point2d p) { return count_[of(p)]; }
  std::size_t count(int x, int y) const {
    return count_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// The cell's rectangle in level 1 of the pyramid.
  cv::Rect half_rect(int x, int y, cv::Size half) const {
    const cv::Point a(x * half.width / columns_, y * half.height / rows_);
    const cv::Point b((x + 1) * half.width / columns_, (y + 1) * half.height / rows_);
    return {a, b};
  }

 private:
  double side_;
  int columns_, rows_;
  cv::Size size_;
  std::vector<std::size_t> count_;
};

}  // namespace

void SupportPoints::clear() {
  *this = {};
}

void SupportPoints::hide_until_found(const CsdFrame &frame) {
  for (auto &s : points_) {
    s.point.hide_until_found();
    s.covered = frame.time;  // it could not be visible during a gap
  }
  last_reliable_ = last_begin_ = frame.time;
}

/// Every other frame; neighbouring points alternate.
bool SupportPoints::may_rest(const CsdFrame &frame, const Followed &support) const {
  return support.established && (support.id + frames_) % 2 == 0 && support.point.may_rest(frame);
}

bool SupportPoints::searched_for(const CsdFrame &frame, const Followed &support) const {
  return searching_ || (support.id + frames_) % std::max<std::size_t>(1, count(frame.tuning.search_every)) == 0;
}

void SupportPoints::rebuild_field(const CsdFrame &frame) {
  field_.clear();
  for (const auto &support : points_)
    if (support.established && support.point.reliable())
      field_.add(support.id, support.point.chart(), {support.point.own_reference(), support.point.seen_at()});
  field_.drop_small_charts(count(frame.tuning.min_agreeing));
}

/// Statistics over all points: smoke and exposure changes affect them all.
void SupportPoints::sum_up(const CsdFrame &frame) {
  const auto median_of = [this](auto change) {
    changes_.clear();
    for (const auto &s : points_)
      if (const auto c = change(s.point)) changes_.push_back(*c);
    if (changes_.empty()) return 0.0;
    const auto middle = changes_.begin() + static_cast<std::ptrdiff_t>(changes_.size() / 2);
    std::nth_element(changes_.begin(), middle, changes_.end());
    return *middle;
  };
  const auto if_reliable = [](auto change) {
    return [change](const TrackedPoint &p) { return p.reliable() ? (p.*change)() : std::nullopt; };
  };
  surroundings_.gain_drift = median_of(if_reliable(&TrackedPoint::gain_change));
  surroundings_.brightness_drift = median_of(if_reliable(&TrackedPoint::brightness_change));
  surroundings_.blur = median_of([&](const TrackedPoint &p) { return p.blur(frame.tuning); });
  std::size_t expected = 0;
  for (const auto &s : points_)
    if (s.established && (s.point.chart() == chart_ || s.point.map()) &&
        (!s.point.map() || frame.shows(s.point.expected_at())))
      ++expected;
  surroundings_.alone = expected < count(frame.tuning.min_agreeing);
}

/// For a chart that is out of view and that recall found: checks whether its points, aligned at the predicted
/// positions, agree.
void SupportPoints::recall(const CsdFrame &frame) {
  NeighbourField found;
  const int chart = recall_.find(frame, field_, share_, found);
  if (chart < 0) return;
  for (auto &s : points_) {
    if (s.point.chart() != chart) continue;
    auto map = found.map_at(s.point.own_reference(), chart, frame.unit, frame.tuning, s.id);
    map.spread = std::max(map.spread, frame.tuning.recalled_spread * frame.unit);
    s.turn = Followed::Turn::aligns;
    s.point.compare_with_map(frame, map);
    s.point.second_alignment(frame, false);
  }
  rebuild_field(frame);
  for (auto &s : points_)
    if (s.point.chart() == chart) s.point.compare_with_map(frame, field_, s.id);
  rebuild_field(frame);
  if (field_.size(chart) == 0) return;
  // The same tissue may have started a newer chart meanwhile: its points enter the older one.
  for (auto &s : points_)
    if (s.point.chart() > chart && s.point.reliable()) {
      recall_.forget(s.point.chart());
      s.point.enter_chart(field_, chart, frame);
    }
  rebuild_field(frame);
  chart_ = chart;
}

void SupportPoints::follow(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  turns_.clear();
  for (auto &s : points_) turns_.push_back(&s);
  ++frames_;
  const Shares shares{tuning.first_share, tuning.query_share, count(tuning.min_aligned), count(tuning.more_aligned)};
  order_by_urgency(frame, turns_);
  first_alignments(frame, turns_, shares, [&](const Followed &s) { return may_rest(frame, s); });
  rebuild_field(frame);
  compare_with_maps(frame, turns_, field_, Among::themselves);
  plan_search(frame);
  second_alignments(frame, turns_, shares, due_, [&](const Followed &s) { return searched_for(frame, s); });
  rebuild_field(frame);
  compare_unmapped(frame, turns_, field_, Among::themselves);
  if (due_) recall(frame);
  sum_up(frame);
  decide_visibility(frame, turns_, surroundings_);
  rebuild_field(frame);
  update_models(frame, turns_);
  recall_.remember(frame, field_, chart_);
  age(frame);
}

/// Which hidden points are searched for in this frame, and whether a lost scene is.
void SupportPoints::plan_search(const CsdFrame &frame) {
  const auto late =
      std::count_if(points_.begin(), points_.end(), [](const Support &s) { return s.turn == Followed::Turn::waits; });
  share_ = 1 - static_cast<double>(late) / static_cast<double>(std::max<std::size_t>(points_.size(), 1));
  due_ = recall_.due(frame, field_, share_);
  searching_ = due_ || field_.size() < count(frame.tuning.min_aligned);
}

/// Establishes new points that have moved with their neighbours for a while, and updates `covered`.
void SupportPoints::age(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  for (auto &s : points_) {
    const bool out = s.point.map() && !frame.shows(s.point.state().position);
    const auto elsewhere = [&] { return recall_.knows(s.point.chart()) && field_.size(s.point.chart()) == 0; };
    if (s.point.visible() || out || elsewhere()) s.covered = frame.time;
    if (!s.established && s.point.chart() >= 0 && frame.time - s.begun >= nanoseconds(tuning.trial) &&
        s.point.reliable() && s.point.offset().deviation(tuning) <= tuning.trial_deviation)
      s.established = true;
    if (s.established && s.point.reliable()) last_reliable_ = frame.time;
  }
}

void SupportPoints::replenish(const CsdFrame &frame) {
  if (!points_.empty() && frame.time - last_begin_ < nanoseconds(frame.tuning.replenish_every)) return;
  drop(frame);
  begin(frame);
  last_begin_ = frame.time;
}

void SupportPoints::drop(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  std::erase_if(points_, [&](const Support &s) {
    return frame.time - s.covered > nanoseconds(s.established ? tuning.lost_for : tuning.young_lost_for);
  });
  // A zoom out crowds points: the oldest know the tissue best.
  Cells cells(frame);
  const auto max_outside = count(tuning.max_points);
  std::size_t outside = 0;
  for (const auto &s : points_) outside += !frame.shows(s.point.state().position);
  std::erase_if(points_, [&](const Support &s) {
    const auto position = s.point.state().position;
    if (!frame.shows(position)) return outside > max_outside && outside-- > max_outside;
    return s.point.visible() && ++cells.count(position) > count(tuning.max_in_cell);
  });
}

void SupportPoints::begin(const CsdFrame &frame) {
  const auto &tuning = frame.tuning;
  const bool new_chart = points_.empty() || frame.time - last_reliable_ > nanoseconds(tuning.new_chart_after);
  if (new_chart && blank(frame)) return;
  Cells cells(frame);
  for (const auto &s : points_) {
    const auto position = s.point.state().position;
    // When a new chart is due, the positions of the old chart's points are unknown.
    if (frame.shows(position) && !(new_chart && !s.point.visible())) ++cells.count(position);
  }
  bool full = true;
  for (int y = 0; y < cells.rows(); ++y)
    for (int x = 0; x < cells.columns(); ++x) full &= cells.count(x, y) > 0;
  if (full) return;

  const auto &half = frame.pyramid.level(1);
  half.convertTo(level_, CV_32F, 1.0 / 256);
  cv::cornerMinEigenVal(level_, corners_, static_cast<int>(tuning.corner_window));
  double best = 0;
  cv::minMaxLoc(corners_, nullptr, &best);
  const float least = static_cast<float>(std::max(tuning.min_eigenvalue, tuning.quality * best));
  const auto &weights = frame.weights.level(1);
  if (frame.colour && tuning.avoid_tools != 0) {
    find_tools(*frame.colour, tools_);
    cv::resize(tools_, tools_, half.size(), 0, 0, cv::INTER_NEAREST);
    corners_.setTo(0, tools_);
  }
  const int margin = static_cast<int>(std::lround(tuning.edge * frame.unit / 2));
  const cv::Rect inner(margin, margin, half.cols - 2 * margin, half.rows - 2 * margin);
  // A point that sways across the border of two cells leaves one empty for a while: that gap needs no new point.
  const double distance = (new_chart ? tuning.min_distance : tuning.gap) * frame.unit;
  const auto begun = points_.size();
  if (new_chart && begun == 0) chart_ = -1;
  for (int y = 0; y < cells.rows(); ++y)
    for (int x = 0; x < cells.columns(); ++x) {
      if (cells.count(x, y) > 0) continue;
      const auto rect = cells.half_rect(x, y, half.size()) & inner;
      // Testing all points at each pixel took 9 ms at 720 lines, longer than all tracking.
      near_.clear();
      for (const auto &s : points_) {
        const auto p = s.point.state().position;
        if (p.x > 2 * rect.x - distance && p.x < 2 * (rect.x + rect.width) + distance && p.y > 2 * rect.y - distance &&
            p.y < 2 * (rect.y + rect.height) + distance)
          near_.push_back(p);
      }
      float strongest = least;
      cv::Point at(-1, -1);
      for (int v = rect.y; v < rect.y + rect.height; ++v)
        for (int u = rect.x; u < rect.x + rect.width; ++u)
          if (corners_.at<float>(v, u) > strongest && weights.at<std::uint8_t>(v, u) >= tuning.clear_weight) {
            const cv::Point2d p(2 * u, 2 * v);
            if (std::any_of(near_.begin(), near_.end(),
                            [&](cv::Point2d other) { return squared(other - p) < distance * distance; }))
              continue;
            strongest = corners_.at<float>(v, u);
            at = {2 * u, 2 * v};
          }
      if (at.x < 0) continue;
      points_.push_back(
          {{TrackedPoint(frame, at, TrackedPoint::Purpose::support), next_id_++}, frame.time, frame.time});
    }
  if (points_.size() == begun) return;
  if (new_chart) {
    ++chart_;
    last_reliable_ = frame.time;
  }
  for (auto i = begun; i < points_.size(); ++i) {
    auto &s = points_[i];
    if (new_chart) {
      s.point.begin_chart(chart_);
      s.established = true;
    } else {
      s.point.enter_chart(field_, chart_, frame);
    }
  }
  rebuild_field(frame);
}

}  // namespace csd
