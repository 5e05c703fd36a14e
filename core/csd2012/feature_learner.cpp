// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/feature_learner.h"

#include <cmath>

#include "csd2012/search.h"
#include "csd2012/smoothed.h"
#include "image/convert.h"

namespace csd {

using csd2012::Choices;

namespace {

int scaled(double pixels, double pixel) {
  return std::max(1, static_cast<int>(std::lround(pixels * pixel)));
}

int whole(double number) {
  return static_cast<int>(number);
}

}  // namespace

FeatureLearner::FeatureLearner(const LearnerOptions &options, Random random, std::shared_ptr<LearningCounters> counters)
    : options_(options),
      margin_(csd2012::smoothing_margin(options.choices.smoothing * options.pixel)),
      random_(random),
      counters_(std::move(counters)) {}

std::shared_ptr<const Tree> FeatureLearner::published() const {
  const std::lock_guard lock(mutex_);
  return published_;
}

void FeatureLearner::publish() {
  auto tree = tree_->publish();
  const std::lock_guard lock(mutex_);
  published_.swap(tree);
}

NegativeRules FeatureLearner::rules() const {
  const auto &c = options_.choices;
  return {options_.patch, c.ignore_radius * options_.pixel, c.near_radius * options_.pixel};
}

cv::Mat FeatureLearner::smoothed(const cv::Mat &grown) const {
  cv::Mat out;
  csd2012::smooth(grown, options_.choices.smoothing * options_.pixel, out);
  return out;
}

/// §2.2.1: one for the whole tree.
ColourSpace FeatureLearner::choose_space(const ColourPatches &root) const {
  return options_.choices.colour != 0 ? choose_colour(root) : ColourSpace{1, 1, 1};
}

/// S of one frame (§2.1.2.1) without the warps: what LK, chance and likeness label, each with smoke.
ColourPatches FeatureLearner::collect(const Snapshot &snapshot, cv::Point position) {
  const auto &c = options_.choices;
  ColourPatches lesson(grown());
  cv::Mat patch, smoky;
  const auto with_smoke = [&](cv::Point p, Label label) {
    sample_patch(snapshot.bgr, p, grown(), patch);
    lesson.add(patch, label);
    for (const double density : smoke_densities) {
      patch.copyTo(smoky);
      smoke_->apply(smoky, density, random_);
      lesson.add(smoky, label);
    }
  };
  with_smoke(position, Label::feature);
  for (const auto &p : random_negatives(snapshot.bgr.size(), snapshot.forbidden, position, whole(c.random_per_lesson),
                                        rules(), random_))
    with_smoke(p, Label::not_feature);
  for (const auto &p : similar_negatives(snapshot.luma, snapshot.forbidden, position, whole(c.similar_per_lesson),
                                         c.least_similarity, scaled(c.similarity_radius, options_.pixel), rules()))
    with_smoke(p, Label::not_feature);
  return lesson;
}

void FeatureLearner::learn(const Snapshot &snapshot, cv::Point position) {
  if (!smoke_) {
    // Not in the constructor, which runs in the streaming thread: 3 ms.
    smoke_.emplace(grown(), random_,
                   options_.choices.smoke_as_printed != 0 ? SmokeEquation::as_printed : SmokeEquation::as_meant);
    warps_ = geometric_warps(options_.patch);
  }
  const auto lesson = collect(snapshot, position);
  const bool first = !tree_;
  cv::Mat patch;
  if (first) {
    auto root = lesson;
    for (const auto &warp : warps_) {
      sample_patch(snapshot.bgr, position, grown(), warp, patch);
      root.add(patch, Label::feature);
    }
    GrowthOptions growth;
    growth.search.search = options_.choices.exhaustive != 0 ? PairSearch::exhaustive : PairSearch::ranked;
    growth.stop.max_depth = whole(options_.choices.max_depth);
    growth.stop.min_samples = static_cast<std::size_t>(options_.choices.min_samples);
    growth.seed = random_.next();
    tree_.emplace(options_.patch, choose_space(root), growth);
  }
  std::vector<SampleId> wrong, positives;
  const auto add = [&](Label label) {
    patch = smoothed(patch);
    const bool errs = !first && tree_->classify(patch) != label;
    const auto id = tree_->add(patch, label);
    if (errs) wrong.push_back(id);
    if (label == Label::feature) positives.push_back(id);
  };
  for (std::size_t i = 0; i < lesson.size(); ++i) {
    lesson.convert(i, tree_->space(), patch);
    add(lesson.label(i));
  }
  // Warped in the one colour space: a third of the cost of warping B, G and R.
  cv::Mat channel;
  to_space(snapshot.bgr, tree_->space(), channel);
  for (const auto &warp : warps_) {
    sample_patch(channel, position, grown(), warp, patch);
    add(Label::feature);
  }
  if (first)
    tree_->build();
  else
    retrain(wrong);
  correct(snapshot, channel, position, positives);
  publish();
}

int FeatureLearner::retrain(const std::vector<SampleId> &samples) {
  const int replaced = tree_->retrain(samples);
  counters_->retrainings += static_cast<std::uint64_t>(replaced);
  return replaced;
}

/// §2.2.2: classify patches of the current frame, add those that are wrongly called the feature, retrain the leaves
/// that did it, and those that call the feature something else; until there are none, or A34's rounds are over.
void FeatureLearner::correct(const Snapshot &snapshot, const cv::Mat &channel, cv::Point position,
                             const std::vector<SampleId> &positives) {
  const int half = options_.patch / 2;
  const cv::Rect picture({0, 0}, snapshot.bgr.size());
  cv::Mat bordered;
  const int border = half + margin_;
  cv::copyMakeBorder(channel, bordered, border, border, border, border, cv::BORDER_REPLICATE);
  bordered = smoothed(bordered);
  const cv::Point origin(-half, -half);
  const int radius = options_.search_radius;
  const cv::Rect window = cv::Rect(position.x - radius, position.y - radius, 2 * radius + 1, 2 * radius + 1) & picture;
  const auto &c = options_.choices;
  const double ignore = c.ignore_radius * options_.pixel;

  for (int round = 0; round < whole(c.learning_rounds); ++round) {
    const auto tree = tree_->publish();
    const SpatialWeight anywhere{position};
    auto wrong = search(*tree, bordered, origin, {window, 1}, anywhere).matches;
    for (const auto &p : search(*tree, bordered, origin, {picture, whole(c.evaluation_grid)}, anywhere).matches)
      if (!window.contains(p)) wrong.push_back(p);
    std::erase_if(wrong, [&](cv::Point p) {
      return std::hypot(p.x - position.x, p.y - position.y) <= ignore ||
             (!snapshot.forbidden.empty() && snapshot.forbidden.at<unsigned char>(p) != 0);
    });
    counters_->false_correspondences += wrong.size();
    std::vector<SampleId> errors;
    for (const auto id : positives)
      if (tree_->misclassified(id)) errors.push_back(id);
    for (int i = 0; i < whole(c.errors_per_round) && !wrong.empty(); ++i) {
      const auto k = random_.below(static_cast<std::uint32_t>(wrong.size()));
      const auto p = wrong[k];
      wrong[k] = wrong.back();
      wrong.pop_back();
      errors.push_back(tree_->add(bordered({p.x, p.y, options_.patch, options_.patch}), Label::not_feature));
    }
    // Nothing errs, or nothing that the stop rules let divide.
    if (errors.empty() || retrain(errors) == 0) break;
  }
}

/// The oldest one goes for it.
void FeatureLearner::keep_positive(const cv::Mat &patch, std::vector<SampleId> &wrong) {
  const auto &c = options_.choices;
  const auto most = static_cast<std::size_t>(c.recent_positives * (1 + c.update_warps));
  const bool error = tree_->classify(patch) != Label::feature;
  SampleId id = 0;
  if (recent_.size() < most) {
    id = tree_->add(patch, Label::feature);
    recent_.push_back(id);
  } else {
    id = recent_[next_recent_];
    tree_->replace(id, patch, Label::feature);
    next_recent_ = (next_recent_ + 1) % recent_.size();
  }
  if (error && c.update_warps > 0) wrong.push_back(id);
}

void FeatureLearner::update(const DescriptorUpdate &update) {
  if (!tree_) return;
  const auto &c = options_.choices;
  std::vector<SampleId> wrong;
  if (!update.feature.empty()) {
    const int middle = update.feature.cols / 2;
    cv::Mat patch;
    sample_patch(update.feature, {static_cast<double>(middle), static_cast<double>(middle)}, grown(), patch);
    keep_positive(smoothed(patch), wrong);
    for (int i = 0; i < whole(c.update_warps); ++i) {
      const auto &warp = warps_[random_.below(static_cast<std::uint32_t>(warps_.size()))];
      sample_patch(update.feature, {static_cast<double>(middle), static_cast<double>(middle)}, grown(), warp, patch);
      keep_positive(smoothed(patch), wrong);
    }
  }
  for (const auto &raw : update.negatives) {
    const cv::Mat patch = smoothed(raw);
    const bool error = tree_->classify(patch) == Label::feature;
    counters_->false_correspondences += error;
    // Reservoir: each negative ever seen is kept with equal probability. One that was called the feature always stays,
    // in the place of another: without it the leaf could not be retrained.
    ++negatives_seen_;
    SampleId id = 0;
    if (reservoir_.size() < static_cast<std::size_t>(c.negative_reservoir)) {
      id = tree_->add(patch, Label::not_feature);
      reservoir_.push_back(id);
    } else {
      const auto slot = static_cast<std::size_t>(random_.uniform() * static_cast<double>(negatives_seen_));
      if (slot >= reservoir_.size() && !error) continue;
      id = reservoir_[slot % reservoir_.size()];
      tree_->replace(id, patch, Label::not_feature);
    }
    if (error) wrong.push_back(id);
  }
  retrain(wrong);
  publish();
}

}  // namespace csd
