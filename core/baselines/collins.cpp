// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/collins.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "baselines/mean_shift.h"
#include "image/colour_rows.h"
#include "image/colour_space.h"
#include "track/patch_side.h"

namespace csd {

namespace {

// docs/baselines.md gives the sources.
constexpr std::size_t kept_spaces = 5;
constexpr double ring_of_side = 0.75;   // the background ring's width
constexpr int frames_per_ranking = 10;  // frames with the feature visible
constexpr double min_mass = 0.1;        // share of the first frame's; below, the object is hidden
constexpr double reach_of_side = 2;     // greatest mean shift in a frame
constexpr double edge_of_side = 0.25;   // closer to the picture's edge, the feature has crossed it

cv::Rect square(cv::Point centre, int radius) {
  return {centre.x - radius, centre.y - radius, 2 * radius + 1, 2 * radius + 1};
}

cv::Point rounded(cv::Point2d p) {
  return {cvRound(p.x), cvRound(p.y)};
}

}  // namespace

struct CollinsMeanShift::Target {
  struct Space {
    std::size_t index = 0;  ///< in colour_spaces()
    ColourWeights weights{};
  };
  FeatureId id = 0;
  cv::Point2d work;
  std::array<ColourHistogram, 49> first{};  ///< of the object in its first frame, in each space
  std::array<Space, kept_spaces> kept;
  std::uint64_t first_mass = 0;
  int age = 0;  ///< frames in which it was visible
};

/// The colours around a position, as planes from which each space is computed at once.
struct CollinsMeanShift::Planes {
  Planes(const WorkFrame &frame, cv::Point2d centre, int radius)
      : area(square(rounded(centre), radius) & cv::Rect({0, 0}, frame.size())) {
    cv::Mat bgr;
    frame.gather_bgr(area, bgr);
    cv::split(bgr, plane);
  }
  void convert(std::size_t space, cv::Mat &values) const {
    values.create(area.size(), CV_8UC1);
    rgb_to_space(colour_spaces()[space], plane[2].data, plane[1].data, plane[0].data, area.area(), values.data);
  }
  /// Converts working pixels to pixels of the planes.
  cv::Point2d inside(cv::Point2d work) const { return work - cv::Point2d(area.tl()); }

  cv::Rect area;  ///< working pixels
  cv::Mat plane[3];
};

CollinsMeanShift::CollinsMeanShift(const Settings &settings, ColourRanking ranking)
    : settings_(settings), ranking_(ranking) {}

CollinsMeanShift::~CollinsMeanShift() = default;

void CollinsMeanShift::set_side(int side) {
  if (side == side_) return;
  side_ = side;
  const int around = side + 2 * static_cast<int>(std::lround(ring_of_side * side));
  log_.emplace(static_cast<std::size_t>(std::max(around * around, 2 * side * side)));
}

std::optional<cv::Point2d> CollinsMeanShift::look(const WorkFrame &frame, Target &target) {
  const Planes planes(frame, target.work, side_ / 2 + static_cast<int>(reach_of_side * side_));
  std::array<cv::Mat, kept_spaces> values;
  std::vector<double> x, y;
  for (std::size_t i = 0; i < kept_spaces; ++i) {
    planes.convert(target.kept[i].index, values[i]);
    if (const auto found = mean_shift(values[i], target.kept[i].weights, planes.inside(target.work), side_)) {
      x.push_back(found->x);
      y.push_back(found->y);
    }
  }
  if (x.size() <= kept_spaces / 2) return std::nullopt;
  const auto median = [](std::vector<double> &v) {
    std::sort(v.begin(), v.end());
    return (v[(v.size() - 1) / 2] + v[v.size() / 2]) / 2;
  };
  const cv::Point2d fused(median(x), median(y));
  std::uint64_t mass = 0;
  for (std::size_t i = 0; i < kept_spaces; ++i)
    mass += window_mass(values[i], target.kept[i].weights, fused, side_).mass;
  if (mass == 0 || static_cast<double>(mass) < min_mass * static_cast<double>(target.first_mass)) return std::nullopt;
  return fused + cv::Point2d(planes.area.tl());
}

// The object's histogram is the mean of the first frame's and this one's, which limits drift.
void CollinsMeanShift::rank(const WorkFrame &frame, Target &target) {
  const int half = side_ / 2, ring = static_cast<int>(std::lround(ring_of_side * side_));
  // Windows centred on the ring's outermost pixels extend half a side further.
  const Planes planes(frame, target.work, half + ring + (ranking_ == ColourRanking::peak_difference ? half : 0));
  const cv::Rect all({0, 0}, planes.area.size());
  const auto centre = rounded(planes.inside(target.work));
  const cv::Rect object = square(centre, half) & all, neighbourhood = square(centre, half + ring) & all;

  std::vector<double> scores;
  std::array<ColourWeights, 49> weights;
  cv::Mat values;
  for (std::size_t s = 0; s < colour_spaces().size(); ++s) {
    planes.convert(s, values);
    const auto now = count_colours(values, object);
    const auto background = difference(count_colours(values, neighbourhood), now);
    if (target.age == 0) target.first[s] = now;
    const auto mixed = sum(target.first[s], now);
    weights[s] = likelihood_weights(mixed, background, *log_);
    scores.push_back(ranking_ == ColourRanking::variance_ratio
                         ? variance_ratio(mixed, total(mixed), background, total(background), *log_)
                         : peak_difference(values, weights[s], object, neighbourhood, side_));
  }
  std::vector<std::uint16_t> ranked;
  rank_pixels(scores, kept_spaces, ranked);
  for (std::size_t i = 0; i < kept_spaces; ++i) target.kept[i] = {ranked[i], weights[ranked[i]]};
}

void CollinsMeanShift::update(const WorkFrame &frame, Target &target) {
  const int half = side_ / 2, ring = static_cast<int>(std::lround(ring_of_side * side_));
  const Planes planes(frame, target.work, half + ring);
  const auto object = square(rounded(planes.inside(target.work)), half);
  cv::Mat values;
  for (auto &space : target.kept) {
    planes.convert(space.index, values);
    const auto now = count_colours(values, object);
    const auto background = difference(count_colours(values, {{0, 0}, values.size()}), now);
    space.weights = likelihood_weights(sum(target.first[space.index], now), background, *log_);
  }
}

void CollinsMeanShift::track(const FrameContext &context, std::vector<Claim> &claims) {
  set_side(patch_side(settings_, context.frame));
  const auto size = context.frame.size();
  const double edge = edge_of_side * side_;
  std::vector<FeatureId> gone;
  auto target = targets_.begin();
  for (auto &claim : claims) {
    while (target != targets_.end() && target->id < claim.id) ++target;
    claim.kind = Claim::Kind::lost;
    if (target == targets_.end() || target->id != claim.id) continue;
    const auto found = look(context.frame, *target);
    claim.kind = Claim::Kind::hidden;
    claim.position = context.frame.to_picture(found.value_or(target->work));
    if (!found) continue;
    // An object that leaves the picture pulls its window along until the edge stops it. If its centre is on the edge,
    // half of its visible part lies within a quarter of its side.
    if (found->x < edge || found->y < edge || found->x > size.width - 1 - edge || found->y > size.height - 1 - edge) {
      claim.kind = Claim::Kind::out;
      gone.push_back(claim.id);
      continue;
    }
    claim.kind = Claim::Kind::tracked;
    target->work = *found;
    if (++target->age % frames_per_ranking == 0)
      rank(context.frame, *target);
    else
      update(context.frame, *target);
  }
  for (const auto id : gone) end(id);
}

Claim::Kind CollinsMeanShift::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  set_side(patch_side(settings_, context.frame));
  Target target;
  target.id = id;
  target.work = context.frame.to_work(position);
  rank(context.frame, target);
  const Planes planes(context.frame, target.work, side_ / 2);
  cv::Mat values;
  for (const auto &space : target.kept) {
    planes.convert(space.index, values);
    target.first_mass += window_mass(values, space.weights, planes.inside(target.work), side_).mass;
  }
  const auto at =
      std::upper_bound(targets_.begin(), targets_.end(), id, [](FeatureId i, const Target &t) { return i < t.id; });
  targets_.insert(at, target);
  return Claim::Kind::tracked;
}

void CollinsMeanShift::end(FeatureId id) {
  std::erase_if(targets_, [id](const Target &t) { return t.id == id; });
}

void CollinsMeanShift::forget() {
  targets_.clear();
}

}  // namespace csd
