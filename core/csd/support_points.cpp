// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/support_points.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "image/tools.h"
#include "track/types.h"

namespace csd {
namespace {

// Pixels are those of a 480-line picture.
constexpr double cell_side = 32;         // 20 × 15 cells at 640×480
constexpr double most_cells = 1200;      // of a picture that is very wide or very high
constexpr double least_distance = 14.4;  // of a new point from the others
constexpr double gap = 30;               // the same, when others have been there for a while
constexpr double edge = 8;               // a new point's distance from the picture's
constexpr std::size_t most_in_cell = 2;
constexpr std::size_t most_points = 1200;
constexpr double quality = 0.003;          // of the picture's best corner
constexpr float least_eigenvalue = 0.05F;  // a mean slope of .1 grey levels a pixel; less is noise
constexpr int corner_window = 7;           // pixels of level 1
constexpr double clear_weight = 230;       // of 255: no highlight near

constexpr double recalled_spread = 8;  // of what a similarity of the whole picture puts somewhere

constexpr std::size_t least_agreeing = 5;  // points that make a motion believed after none was known

constexpr std::int64_t replenish_every = second / 2;
constexpr std::int64_t new_chart_after = second;
constexpr std::int64_t trial = second / 2;  // a new point's, before its neighbours believe it
constexpr double trial_deviation = 1.5;     // of its offset, at most
constexpr std::int64_t young_lost_for = second / 2, lost_for = 10 * second;

// Looks in a frame, whatever the budget: at points that were visible, and some at others, to find again what comes
// back; more where fewer than a map stands on are seen, lest the scene seem to be gone when something comes in front.
constexpr std::size_t least_looks = 24, least_at_visible = 18, more_looks = 96;
// Frames, for what is hidden while enough others are seen. With 2 the six real clips take a sixth less time, and .003
// less is claimed and .002 less apart; with 4 a fifth, and .008.
constexpr std::size_t search_every = 2;
constexpr double first_looks = 0.6, looks = 0.85;  // of the budget, from its begin; the rest is for anchors

/// Cells of the picture, and how many points each has.
class Cells {
 public:
  Cells(const CsdFrame &frame)
      : side_(std::max(cell_side * frame.unit, std::sqrt(frame.size.area() / most_cells))),
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

void SupportPoints::doubt(const CsdFrame &frame) {
  for (auto &s : points_) {
    s.point.doubt();
    s.covered = frame.time;  // nobody could have seen it in a gap
  }
  last_sure_ = last_begin_ = frame.time;
}

/// The first looks, for as long as there is time; where all is calm, half of the points rest. Points that are as urgent
/// as each other take turns all over the picture: their ids go along its rows, multiples of the golden ratio don't.
void SupportPoints::look(const CsdFrame &frame) {
  turns_.clear();
  for (auto &s : points_) turns_.push_back(&s);
  if (frame.budget.limited()) {
    const auto place = [](const Support *s) { return std::fmod(static_cast<double>(s->id) * 0.6180339887498949, 1); };
    std::sort(turns_.begin(), turns_.end(), [&](const Support *a, const Support *b) {
      const double u = a->point.urgency(frame), v = b->point.urgency(frame);
      return u != v ? u > v : place(a) < place(b);
    });
    // Those that maps may stand on come first, however many new or hidden ones there are.
    auto first = turns_.begin();
    for (auto s = first; s != turns_.end() && first - turns_.begin() < static_cast<std::ptrdiff_t>(least_at_visible);
         ++s)
      if ((*s)->established && (*s)->point.visible()) std::rotate(first++, s, s + 1);
  }
  const auto budget = frame.budget.share(first_looks);
  ++frames_;
  std::size_t looked = 0, sure = 0, late = 0;
  for (auto *s : turns_) {
    // Every other frame, and of those beside each other not both in one.
    const bool rests = s->established && (s->id + frames_) % 2 == 0 && s->point.may_rest(frame);
    const bool few = sure < NeighbourField::most && s->point.visible();
    s->waits = rests || (looked >= (few ? more_looks : least_looks) && budget.spent());
    if (!s->waits) {
      s->point.look(frame);
      ++looked;
      sure += s->point.sure();
    } else if (rests) {
      s->point.rest();
    } else {
      s->point.pass();
      ++late;
    }
  }
  share_ = 1 - static_cast<double>(late) / static_cast<double>(std::max<std::size_t>(turns_.size(), 1));
}

void SupportPoints::collect() {
  field_.clear();
  for (const auto &support : points_)
    if (support.established && support.point.sure())
      field_.add(support.id, support.point.chart(), {support.point.own_reference(), support.point.seen_at()});
  field_.drop_small_charts(least_agreeing);
}

/// What all points together say of the frame: smoke and a new exposure change them all.
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
  const auto if_sure = [](auto change) {
    return [change](const TrackedPoint &p) { return p.sure() ? (p.*change)() : std::nullopt; };
  };
  surroundings_.gain_drift = median_of(if_sure(&TrackedPoint::gain_change));
  surroundings_.brightness_drift = median_of(if_sure(&TrackedPoint::brightness_change));
  surroundings_.blur = median_of([](const TrackedPoint &p) { return p.blur(); });
  std::size_t expected = 0;
  for (const auto &s : points_)
    if (s.established && (s.point.chart() == chart_ || s.point.map()) &&
        (!s.point.map() || frame.shows(s.point.expected_at())))
      ++expected;
  surroundings_.alone = expected < least_agreeing;
}

/// A chart that nothing is seen of: where the whole picture says that its points are, do they agree?
void SupportPoints::recall(const CsdFrame &frame) {
  NeighbourField found;
  const int chart = recall_.find(frame, field_, share_, found);
  if (chart < 0) return;
  for (auto &s : points_) {
    if (s.point.chart() != chart) continue;
    auto map = found.map_at(s.point.own_reference(), chart, frame.unit, s.id);
    map.spread = std::max(map.spread, recalled_spread * frame.unit);
    s.waits = false;
    s.point.meet(frame, map);
    s.point.look_again(frame, false);
  }
  collect();
  for (auto &s : points_)
    if (s.point.chart() == chart) s.point.meet(frame, field_, s.id);
  collect();
  if (field_.size(chart) == 0) return;
  // The same tissue may have founded a chart meanwhile: its points go over to the elder one.
  for (auto &s : points_)
    if (s.point.chart() > chart && s.point.sure()) {
      recall_.forget(s.point.chart());
      s.point.join(field_, chart, frame.unit);
    }
  collect();
  chart_ = chart;
}

void SupportPoints::follow(const CsdFrame &frame) {
  look(frame);
  collect();
  for (auto &s : points_) s.point.meet(frame, field_, s.id);
  const bool due = recall_.due(frame, field_, share_);
  const auto budget = frame.budget.share(looks);
  std::size_t looks_again = 0;
  const bool enough = field_.size() >= least_looks;
  for (auto *s : turns_) {
    if (s->waits) continue;
    if (enough && !due && !s->point.visible() && (s->id + frames_) % search_every != 0) continue;
    s->waits = looks_again++ >= least_looks && !s->point.sure() && budget.spent();
    s->waits ? s->point.pass() : s->point.look_again(frame, due);
  }
  // What has no map has looked for itself alone: chance likenesses don't agree on a motion.
  collect();
  for (auto &s : points_)
    if (!s.point.map()) s.point.meet(frame, field_, s.id);

  if (due) recall(frame);

  sum_up(frame);
  for (auto &s : points_) s.waits ? s.point.wait(frame) : s.point.decide(frame, surroundings_);
  collect();
  recall_.remember(frame, field_, chart_);
  for (auto &s : points_) {
    if (!s.waits) s.point.learn(frame);
    if (s.point.ripe(frame) && !frame.budget.spent()) s.point.freeze();
    const bool out = s.point.map() && !frame.shows(s.point.state().position);
    const auto elsewhere = [&] { return recall_.knows(s.point.chart()) && field_.size(s.point.chart()) == 0; };
    if (s.point.visible() || out || elsewhere()) s.covered = frame.time;
    if (!s.established && s.point.chart() >= 0 && frame.time - s.begun >= trial && s.point.sure() &&
        s.point.offset().deviation() <= trial_deviation)
      s.established = true;
    if (s.established && s.point.sure()) last_sure_ = frame.time;
  }
}

void SupportPoints::replenish(const CsdFrame &frame) {
  if (!points_.empty() && frame.time - last_begin_ < replenish_every) return;
  drop(frame);
  begin(frame);
  last_begin_ = frame.time;
}

void SupportPoints::drop(const CsdFrame &frame) {
  std::erase_if(points_,
                [&](const Support &s) { return frame.time - s.covered > (s.established ? lost_for : young_lost_for); });
  // What a zoom out has crowded together: the eldest know the tissue best.
  Cells cells(frame);
  std::size_t outside = 0;
  for (const auto &s : points_) outside += !frame.shows(s.point.state().position);
  std::erase_if(points_, [&](const Support &s) {
    const auto position = s.point.state().position;
    if (!frame.shows(position)) return outside > most_points && outside-- > most_points;
    return s.point.visible() && ++cells.count(position) > most_in_cell;
  });
}

void SupportPoints::begin(const CsdFrame &frame) {
  const bool founding = points_.empty() || frame.time - last_sure_ > new_chart_after;
  if (founding && blank(frame)) return;
  Cells cells(frame);
  for (const auto &s : points_) {
    const auto position = s.point.state().position;
    // When another chart is to be founded, nobody knows where the points of the old one are.
    if (frame.shows(position) && !(founding && !s.point.visible())) ++cells.count(position);
  }
  bool full = true;
  for (int y = 0; y < cells.rows(); ++y)
    for (int x = 0; x < cells.columns(); ++x) full &= cells.count(x, y) > 0;
  if (full) return;

  const auto &half = frame.pyramid.level(1);
  half.convertTo(level_, CV_32F, 1.0 / 256);
  cv::cornerMinEigenVal(level_, corners_, corner_window);
  double best = 0;
  cv::minMaxLoc(corners_, nullptr, &best);
  const float least = std::max(least_eigenvalue, static_cast<float>(quality * best));
  const auto &weights = frame.weights.level(1);
  if (frame.colour) {
    find_tools(*frame.colour, tools_);
    cv::resize(tools_, tools_, half.size(), 0, 0, cv::INTER_NEAREST);
    corners_.setTo(0, tools_);
  }
  const int margin = static_cast<int>(std::lround(edge * frame.unit / 2));
  const cv::Rect inner(margin, margin, half.cols - 2 * margin, half.rows - 2 * margin);
  // What sways across the border of two cells leaves one of them empty for a while: no gap that wants a point.
  const double apart = (founding ? least_distance : gap) * frame.unit;
  const auto begun = points_.size();
  if (founding && begun == 0) chart_ = -1;
  for (int y = 0; y < cells.rows(); ++y)
    for (int x = 0; x < cells.columns(); ++x) {
      if (cells.count(x, y) > 0) continue;
      const auto rect = cells.half_rect(x, y, half.size()) & inner;
      // Asking all points at each pixel took longer than all that is tracked: 9 ms at 720 lines.
      near_.clear();
      for (const auto &s : points_) {
        const auto p = s.point.state().position;
        if (p.x > 2 * rect.x - apart && p.x < 2 * (rect.x + rect.width) + apart && p.y > 2 * rect.y - apart &&
            p.y < 2 * (rect.y + rect.height) + apart)
          near_.push_back(p);
      }
      float strongest = least;
      cv::Point at(-1, -1);
      for (int v = rect.y; v < rect.y + rect.height; ++v)
        for (int u = rect.x; u < rect.x + rect.width; ++u)
          if (corners_.at<float>(v, u) > strongest && weights.at<std::uint8_t>(v, u) >= clear_weight) {
            const cv::Point2d p(2 * u, 2 * v);
            if (std::any_of(near_.begin(), near_.end(),
                            [&](cv::Point2d other) { return (other - p).dot(other - p) < apart * apart; }))
              continue;
            strongest = corners_.at<float>(v, u);
            at = {2 * u, 2 * v};
          }
      if (at.x < 0) continue;
      points_.push_back(
          {TrackedPoint(frame, at, TrackedPoint::Purpose::support), frame.time, frame.time, false, next_id_++});
    }
  if (points_.size() == begun) return;
  if (founding) {
    ++chart_;
    last_sure_ = frame.time;
  }
  for (auto i = begun; i < points_.size(); ++i) {
    auto &s = points_[i];
    if (founding) {
      s.point.found(chart_);
      s.established = true;
    } else {
      s.point.join(field_, chart_, frame.unit);
    }
  }
  collect();
}

}  // namespace csd
