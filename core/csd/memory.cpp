// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/memory.h"

#include <algorithm>
#include <cmath>

#include "patch/patch_fit.h"

namespace csd {
namespace {

/// Of the residual in the picture's grey levels; at least half a grey level.
double log_noise(const Alignment &seen) {
  return std::log(std::max(seen.noise * seen.gain, 0.5));
}

}  // namespace

Memory::Memory(const CsdFrame &frame, const AffineState &state)
    : medians_(Anchor::coarsest + 1), begun_(frame.time), last_sample_(frame.time) {
  for (int level = 0; level <= Anchor::coarsest; ++level) {
    const auto patch = sample(frame.pyramid, frame.weights, state, level);
    anchor_.set(level, make_anchor_level(patch));
    median_of_level(level).add(patch);
  }
}

void Memory::freeze_anchor() {
  for (int level = 0; level <= Anchor::coarsest; ++level) anchor_.set(level, median_of_level(level).make());
  medians_.clear();
}

void Memory::sample_at(const CsdFrame &frame, const AffineState &state) {
  const auto most = std::min(frame.tuning.anchor_samples, double{AnchorMedian::most});
  const double pause = static_cast<double>(frame.training_time) / std::max(most - 1, 1.0);
  if (static_cast<double>(medians_.front().size()) >= most || frame.time - last_sample_ < std::floor(pause)) return;
  for (int level = 0; level <= Anchor::coarsest; ++level)
    median_of_level(level).add(sample(frame.pyramid, frame.weights, state, level));
  last_sample_ = frame.time;
}

void Memory::learn_usual(const CsdFrame &frame, const Alignment &seen) {
  const Usual now{std::log(seen.gain), log_noise(seen), seen.bias};
  if (!usual_) {
    usual_ = now;
    return;
  }
  const double rate = std::min(1.0, frame.tuning.usual_rate * frame.steps);
  usual_->log_gain += rate * (now.log_gain - usual_->log_gain);
  usual_->log_noise += rate * (now.log_noise - usual_->log_noise);
  usual_->brightness += rate * (now.brightness - usual_->brightness);
}

void Memory::measure_self_similarity(const CsdFrame &frame, const AffineState &state) {
  if (self_similarity_) return;
  const int level = finest_level(state.scale() / frame.patch, frame.tuning);
  self_similarity_.emplace(frame.pyramid, frame.weights, anchor_.level(level), level, state, frame.tuning);
  const auto &anchor = anchor_.level(level);
  const auto &weight = anchor.tissue_share >= min_tissue ? anchor.weight : anchor.shown;
  contrast_ = std::sqrt(patch_moments(anchor, anchor.patch, weight).anchor_variance);
}

void Memory::refine(const CsdFrame &frame, const AffineState &state, double scale, const Alignment &seen) {
  const auto &tuning = frame.tuning;
  if (seen.zncc < tuning.finer_zncc || seen.inliers <= tuning.finer_inliers) return;
  for (int level = -1; level >= Anchor::finest; --level)
    if (!anchor_.has(level) && anchor_.has(level + 1) &&
        scale / frame.patch * std::ldexp(1.0, level) >= tuning.finer_scale) {
      const auto finer = make_anchor_level(sample(frame.pyramid, frame.weights, state, level));
      // Else a highlight that passes would be the level for good.
      if (finer.tissue_share >= std::min(min_tissue, anchor_.level(level + 1).tissue_share)) anchor_.set(level, finer);
    }
}

int Memory::finest_level(double zoom, const Tuning &tuning) const {
  const auto share = [this](int level) { return anchor_.level(level).shown_share; };
  int best = anchor_.fine_level(zoom);
  for (int level = best; level <= Anchor::coarsest && share(best) < tuning.min_anchor; ++level)
    if (anchor_.has(level) && share(level) > share(best)) best = level;
  return best;
}

double Memory::usual_noise() const {
  return usual_ ? std::exp(usual_->log_noise) : 0;
}

std::optional<double> Memory::gain_change(const Alignment &seen) const {
  if (!usual_ || !seen.usable) return {};
  return std::log(seen.gain) - usual_->log_gain;
}

std::optional<double> Memory::brightness_change(const Alignment &seen) const {
  if (!usual_ || !seen.usable) return {};
  return seen.bias - usual_->brightness;
}

}  // namespace csd
