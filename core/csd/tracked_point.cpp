// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tracked_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace csd {
namespace {

// prototype.md I.2, the tight variant. Pixels are those of a 480-line picture.
constexpr double shape_deviation = 0.03;    // of each element of A0⁻¹A − 1, in a frame of 40 ms
constexpr double shape_pull = 0.3;          // towards the neighbours' shape, before looking, in 40 ms
constexpr double coarse_information = 0.6;  // of the coarse level's, as the fine level's prior
constexpr double sure_zncc = 0.6, sure_inliers = 0.5, sure_unmasked = 0.3;
constexpr double alone_zncc = 0.8;      // to be found again without neighbours
constexpr double least_unmasked = 0.1;  // of what is reported at all
// What has no look-alike where the neighbours point needs not their word: what fits so well, and better than anything
// there did.
constexpr double apart_zncc = 0.8, apart_inliers = 0.6, apart_margin = 0.2;
// How far about the place a look-alike counts, samples: as much, and so much for each pixel of the neighbours'
// disagreement with each other and of theirs with the point.
constexpr double alike_reach = 4, alike_per_spread = 0.5, alike_per_distance = 0.2;
// sd of where the neighbours put a point, of the sum of its and their deviations. With all of it faint patches slid
// away from where the neighbours had put them rightly.
constexpr double expected_share = 0.7;
constexpr double gate_floor = 1, gate_deviations = 2;
constexpr std::size_t least_judges = 5;  // neighbours that may overrule a point
constexpr double most_distortion = 0.3;
// Of a point beside its neighbours, from one frame to another: sd, of which its usual deviation makes a part, and the
// neighbours' disagreement.
constexpr double least_own_motion = 0.2, own_motion_of_deviation = 0.3, own_motion_of_spread = 0.2;
constexpr double good_zncc = 0.75;  // of a frame that offsets and gains learn from
constexpr double usual_rate = 0.1;
constexpr double finer_scale = 0.8, finer_zncc = 0.85, finer_inliers = 0.7;
constexpr double least_anchor = 0.4;  // unmasked share of the level that is aligned last
constexpr std::size_t training_samples = 12;
static_assert(training_samples + 2 <= AnchorMedian::most);
constexpr double half_life = 100;                 // of belief in what nobody looks at, frames of 40 ms
constexpr double fast = 1;                        // pixels in 40 ms
constexpr double calm_miss = 1.5;                 // pixels that the finest level finds its way over by itself
constexpr double rest_miss = 1, rest_spread = 1;  // pixels: half of a map's points are as good as all of them then
constexpr double faded = -.3;                     // change of ln gain
constexpr double blurred_zncc = .5;
constexpr double unknown_miss = std::numeric_limits<double>::infinity();

cv::Matx22d information(double deviation) {
  const double i = 1 / (deviation * deviation);
  return {i, 0, 0, i};
}

constexpr int core_reach = 5;
constexpr double core_weight = 81;  // pixels in it

/// The anchor's inner disc: where a tool or its shadow has come near, the rest tells of them.
AnchorLevel core_of(const AnchorLevel &anchor) {
  auto core = anchor;
  for (int v = -PatchPlane::radius; v <= PatchPlane::radius; ++v)
    for (int u = -PatchPlane::radius; u <= PatchPlane::radius; ++u)
      if (u * u + v * v > core_reach * core_reach) core.weight.at(u, v) = 0;
  return core;
}

/// Of the patch's unmasked pixels, whose mean is 0.
double deviation(const AnchorLevel &anchor) {
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    weight += anchor.weight.data[i];
    sum += double{anchor.weight.data[i]} * anchor.patch.data[i] * anchor.patch.data[i];
  }
  return weight > 0 ? std::sqrt(sum / weight) : 0;
}

/// ln of the residual in the picture's grey levels; what is below half a grey level is as good as none.
double log_noise(const Alignment &seen) {
  return std::log(std::max(seen.noise * seen.gain, 0.5));
}

}  // namespace

TrackedPoint::TrackedPoint(const CsdFrame &frame, cv::Point2d position, Purpose purpose)
    : purpose_(purpose),
      state_{position, frame.patch * cv::Matx22d::eye()},
      begun_(frame.time),
      last_sample_(frame.time),
      last_look_(frame.time) {
  fine_.state = state_;
  medians_.resize(Anchor::coarsest + 1);
  for (int level = 0; level <= Anchor::coarsest; ++level) {
    const auto patch = sample(frame.pyramid, frame.weights, state_, level);
    set_anchor(level, make_anchor_level(patch));
    medians_[static_cast<std::size_t>(level)].add(patch);
  }
}

void TrackedPoint::found(int chart) {
  chart_ = chart;
  reference_ = state_.position;
  offset_.begin(state_.shape);
}

void TrackedPoint::join(const NeighbourField &field, int chart, double unit) {
  const auto inverse = field.inverse_map_at(state_.position, chart, unit);
  if (!inverse) return;
  chart_ = chart;
  reference_ = inverse(state_.position);
  offset_.begin(inverse.linear * state_.shape);
}

std::optional<double> TrackedPoint::gain_change() const {
  if (!usual_known_ || !fine_.usable) return {};
  return std::log(fine_.gain) - usual_gain_;
}

std::optional<double> TrackedPoint::brightness_change() const {
  if (!usual_known_ || !fine_.usable) return {};
  return fine_.bias - usual_brightness_;
}

std::optional<double> TrackedPoint::blur() const {
  if (!fine_.usable || fine_.zncc < blurred_zncc) return {};
  return gain_coarse_ > 0 ? std::log(gain_coarse_ / fine_.gain) : 0;
}

void TrackedPoint::set_anchor(int level, const AnchorLevel &anchor) {
  const auto &weight = anchor.weight.data;
  unmasked_[static_cast<std::size_t>(level - Anchor::finest)] =
      std::accumulate(weight.begin(), weight.end(), 0.0) / PatchPlane::pixels;
  anchor_.set(level, anchor);
}

/// The finest level that the picture shows and that isn't mostly masked: what is pale by nature passes for a highlight,
/// and a coarser patch reaches beyond it. `zoom`: scale of the shape, of that where the point began.
int TrackedPoint::finest_level(double zoom) const {
  const auto share = [this](int level) { return unmasked_[static_cast<std::size_t>(level - Anchor::finest)]; };
  int best = anchor_.fine_level(zoom);
  for (int level = best; level <= Anchor::coarsest && share(best) < least_anchor; ++level)
    if (anchor_.has(level) && share(level) > share(best)) best = level;
  return best;
}

/// From coarse to fine, from `top` levels above the finest that the picture shows.
void TrackedPoint::locate(const CsdFrame &frame, const AffineState &start, double position_sd, int top, bool core) {
  fine_ = {};
  zncc_coarse_ = gain_coarse_ = 0;
  const int finest = finest_level(start.scale() / frame.patch);
  AlignPrior prior;
  AnchorLevel inner;
  core_ = core;
  prior.shape = shape_deviation * std::sqrt(frame.steps);
  if (usual_known_) prior.noise = std::exp(usual_noise_);
  if (position_sd > 0) prior.position = information(position_sd);
  auto at = start;
  bool coarse_seen = false;
  for (int level = std::min(finest + top, Anchor::coarsest); level >= finest; --level) {
    if (!anchor_.has(level)) continue;
    if (core) inner = core_of(anchor_.level(level));
    const auto &anchor = core ? inner : anchor_.level(level);
    auto seen = align(frame.pyramid, frame.weights, anchor, level, at, prior,
                      core || level > finest ? AlignModel::similarity : AlignModel::affine,
                      level > finest                 ? coarse_precision
                      : purpose_ == Purpose::support ? support_precision
                                                     : fine_precision);
    if (core) seen.unmasked *= PatchPlane::pixels / core_weight;
    if (level == finest) {
      fine_ = seen;
      if (!coarse_seen) zncc_coarse_ = seen.zncc;
    } else if (seen.usable) {
      at = seen.state;
      prior.position += coarse_information * seen.information;
      zncc_coarse_ = seen.zncc;
      gain_coarse_ = seen.gain;
      coarse_seen = true;
    }
  }
}

/// Where contrast has faded, a coarser level tells why: blur(). What was seen stays as it is: with the coarser level in
/// it, cutting.mp4 was claimed 2 % less.
void TrackedPoint::weigh_coarser(const CsdFrame &frame) {
  const int level = finest_level(fine_.state.scale() / frame.patch) + 1;
  if (level > Anchor::coarsest || !anchor_.has(level)) return;
  AlignPrior prior;
  prior.shape = shape_deviation * std::sqrt(frame.steps);
  const auto seen = align(frame.pyramid, frame.weights, anchor_.level(level), level, fine_.state, prior,
                          AlignModel::similarity, coarse_precision);
  if (seen.usable) gain_coarse_ = seen.gain;
}

/// How well the anchor fitted what lay from its place as the point now lies from where the neighbours put it; without
/// them, anywhere around. 1 while that isn't known.
double TrackedPoint::likeness_there(double unit) const {
  if (!likeness_) return 1;
  if (!map_) return likeness_->far();
  const auto off = fine_.state.position - prediction().position;
  const cv::Vec2d samples = fine_.state.shape.inv() * cv::Vec2d(off.x, off.y);
  return likeness_->near(samples,
                         alike_reach + alike_per_spread * map_.spread / unit + alike_per_distance * cv::norm(samples));
}

bool TrackedPoint::told_apart(double unit) const {
  const double zncc = std::min(fine_.zncc, zncc_coarse_);
  return fine_.usable && zncc >= apart_zncc && fine_.inliers >= apart_inliers && fine_.unmasked >= sure_unmasked &&
         zncc - likeness_there(unit) > apart_margin;
}

void TrackedPoint::judge(const CsdFrame &frame) {
  sure_ = fine_.usable && fine_.zncc >= sure_zncc && fine_.inliers >= sure_inliers && fine_.unmasked >= sure_unmasked &&
          frame.shows(fine_.state.position);
  distance_ = 0;
  agrees_ = true;
  own_motion_ = false;
  if (!fine_.usable || !map_) return;
  const double scale = map_.scale() * frame.unit;
  distance_ = cv::norm(prediction().position - fine_.state.position) / scale;
  if (map_.support < least_judges) return;
  const auto distortion = prediction().shape.inv() * fine_.state.shape - cv::Matx22d::eye();
  agrees_ = distance_ <= gate_floor + gate_deviations * offset_.deviation() + map_.spread / scale &&
            cv::norm(distortion) <= most_distortion;
  own_motion_ = !agrees_ && told_apart(frame.unit);
  agrees_ = agrees_ || own_motion_;
  sure_ = sure_ && agrees_;
}

void TrackedPoint::look(const CsdFrame &frame) {
  fine_ = {};
  sure_ = again_ = false;
  const double missed = std::exchange(missed_, unknown_miss);
  if (!visible_) return;
  AffineState start{state_.position + velocity_ * frame.steps, state_.shape};
  if (map_)  // the last frame's
    start.shape += std::min(1.0, shape_pull * frame.steps) * (prediction().shape - start.shape);
  map_ = {};
  // What moves as it did is found without a coarse level.
  const bool calm = purpose_ == Purpose::support && missed * frame.steps <= calm_miss * frame.unit;
  if (calm) {
    locate(frame, start, 0, 0, false);
    judge(frame);
  }
  if (sure_ && calm && gain_change().value_or(0) < faded) weigh_coarser(frame);
  if (!sure_) {
    locate(frame, start, 0, 1, false);
    judge(frame);
  }
  if (sure_) missed_ = cv::norm(fine_.state.position - start.position) / frame.steps;
}

void TrackedPoint::meet(const CsdFrame &frame, const NeighbourMap &map) {
  map_ = map;
  if (fine_.usable) judge(frame);
}

void TrackedPoint::meet(const CsdFrame &frame, const NeighbourField &field, std::size_t owner) {
  const auto map = field.map_at(own_reference(), chart_, frame.unit, owner, nearby_);
  nearby_ = map.nearby;
  meet(frame, map);
}

void TrackedPoint::look_again(const CsdFrame &frame, bool alone) {
  if (sure_) return;
  if (map_) {
    const auto start = prediction();
    if (!frame.shows(start.position)) {
      fine_ = {};
      return;
    }
    const double sd = expected_share * ((1 + offset_.deviation()) * map_.scale() * frame.unit + map_.spread);
    locate(frame, start, sd, 2, false);
    judge(frame);
    if (!sure_) {
      const auto whole = fine_;
      const auto coarse = zncc_coarse_;
      locate(frame, start, sd, 1, true);
      judge(frame);
      if (!sure_) {
        fine_ = whole;
        zncc_coarse_ = coarse;
        judge(frame);
      }
    }
  } else if (alone && !visible_) {
    locate(frame, state_, 0, 2, false);
    judge(frame);
    sure_ = agrees_ = agrees_ && fine_.zncc >= alone_zncc && sure_;
  }
  again_ = true;
}

/// The patch's own place, weighed against where the neighbours put it, each by what it knows (a MAP estimate). Along an
/// edge a patch knows next to nothing, however little noise there is: what bends or lies at another depth shifts it
/// there.
cv::Point2d TrackedPoint::fused(const CsdFrame &frame) const {
  const auto expected = prediction().position;
  const auto off = fine_.state.position - expected;
  const double sd = (least_own_motion + own_motion_of_deviation * offset_.deviation()) * map_.scale() * frame.unit +
                    own_motion_of_spread * map_.spread;
  const auto patch = position_covariance(fine_.information).inv();
  const cv::Vec2d pull = (patch + information(sd)).inv() * (patch * cv::Vec2d(off.x, off.y));
  return expected + cv::Point2d(pull[0], pull[1]);
}

void TrackedPoint::decide(const CsdFrame &frame, const Surroundings &around) {
  aligned_ = fine_.state;
  if (fine_.usable && map_.support >= least_judges && !own_motion_) fine_.state.position = fused(frame);
  const bool apart = told_apart(frame.unit);
  const bool possible = fine_.usable && agrees_ && (map_ || around.alone || apart) &&
                        fine_.unmasked >= least_unmasked && frame.shows(fine_.state.position);
  evidence_.reset();
  if (possible) {
    auto &e = evidence_.emplace();
    e.zncc_fine = fine_.zncc;
    e.zncc_coarse = zncc_coarse_;
    e.unmasked = fine_.unmasked;
    e.centre = fine_.centre;
    e.gain = fine_.gain;
    e.noise = fine_.noise;
    if (const auto change = brightness_change()) e.brightness_change = *change - around.brightness_drift;
    e.contrast = contrast_;
    if (likeness_) e.likeness = likeness_->far();
    if (!apart) e.disagreement = distance_ / (1 + offset_.deviation()) * likeness_there(frame.unit);
  }
  confidence_ = evidence_ ? visibility(*evidence_) : 0;
  const bool before = std::exchange(visible_, confidence_ >= 0.5);
  if (visible_) {
    velocity_ = before && !again_ ? (fine_.state.position - state_.position) * (1 / frame.steps) : cv::Point2d();
    state_ = fine_.state;
  } else {
    sure_ = false;
    velocity_ = {};
    if (map_) state_ = prediction();
  }
  last_look_ = frame.time;
  pressing_ = visible_ && (!sure_ || cv::norm(velocity_) > fast * frame.unit);
}

void TrackedPoint::pass() {
  rest();
  missed_ = unknown_miss;
}

bool TrackedPoint::may_rest(const CsdFrame &frame) const {
  return sure_ && !learning() && map_.support >= least_judges && map_.spread <= rest_spread * frame.unit &&
         distance_ <= rest_miss && missed_ * frame.steps <= rest_miss * frame.unit;
}

void TrackedPoint::rest() {
  fine_ = {};
  sure_ = again_ = false;
}

void TrackedPoint::wait(const CsdFrame &frame) {
  if (map_) state_ = prediction();
  const bool followed = visible_ && map_ && frame.shows(state_.position);
  confidence_ = followed ? confidence_ * std::exp2(-frame.steps / half_life) : 0;
  visible_ = confidence_ >= 0.5;
  if (!visible_) velocity_ = {};
}

double TrackedPoint::urgency(const CsdFrame &frame) const {
  return static_cast<double>(frame.time - last_look_) * (pressing_ ? 2 : 1);
}

void TrackedPoint::doubt() {
  pass();
  map_ = {};
  velocity_ = {};
  visible_ = false;
  confidence_ = 0;
}

void TrackedPoint::learn(const CsdFrame &frame) {
  const bool good = visible_ && sure_ && fine_.zncc >= good_zncc;
  if (good) {
    if (map_) offset_.update(map_, reference_, fine_.state, fine_.information, frame.steps, frame.unit);
    const double rate = usual_known_ ? std::min(1.0, usual_rate * frame.steps) : 1;
    usual_gain_ += rate * (std::log(fine_.gain) - usual_gain_);
    usual_noise_ += rate * (log_noise(fine_) - usual_noise_);
    usual_brightness_ += rate * (fine_.bias - usual_brightness_);
    usual_known_ = true;
  }
  if (learning()) {
    if ((visible_ || map_) &&
        frame.time - last_sample_ >= frame.training_time / static_cast<std::int64_t>(training_samples + 1) &&
        medians_.front().size() <= training_samples + 1) {
      for (int level = 0; level <= Anchor::coarsest; ++level)
        medians_[static_cast<std::size_t>(level)].add(
            sample(frame.pyramid, frame.weights, sure_ ? aligned_ : state_, level));
      last_sample_ = frame.time;
    }
    return;
  }
  if (sure_ && !likeness_) {
    const int level = finest_level(aligned_.scale() / frame.patch);
    likeness_.emplace(frame.pyramid, frame.weights, anchor_.level(level), level, aligned_);
    contrast_ = deviation(anchor_.level(level));
  }
  for (int level = -1; level >= Anchor::finest; --level)
    if (sure_ && !anchor_.has(level) && anchor_.has(level + 1) &&
        state_.scale() / frame.patch * std::ldexp(1.0, level) >= finer_scale && fine_.zncc >= finer_zncc &&
        fine_.inliers > finer_inliers)
      set_anchor(level, make_anchor_level(sample(frame.pyramid, frame.weights, aligned_, level)));
}

void TrackedPoint::freeze() {
  for (int level = 0; level <= Anchor::coarsest; ++level)
    set_anchor(level, medians_[static_cast<std::size_t>(level)].make());
  medians_.clear();
}

}  // namespace csd
