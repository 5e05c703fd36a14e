// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/feature_learner.h"

#include <array>
#include <cmath>

#include "image/patch.h"
#include "image/warps.h"
#include "learn/colour_choice.h"
#include "learn/negatives.h"
#include "track/csd2012_choices.h"
#include "track/search.h"

namespace csd {

using namespace csd2012;

namespace {

int scaled(double pixels, double pixel) {
  return std::max(1, static_cast<int>(std::lround(pixels * pixel)));
}

}  // namespace

FeatureLearner::FeatureLearner(const LearnerOptions &options, Random random, std::shared_ptr<LearningCounters> counters)
    : options_(options), random_(random), smoke_(options.patch, random_), counters_(std::move(counters)) {}

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
  return {options_.patch, ignore_radius * options_.pixel, near_radius * options_.pixel};
}

/// S of one frame (§2.1.2): what is labelled by LK and by chance and likeness, each with smoke; and the feature's
/// warps.
void FeatureLearner::collect(const Snapshot &snapshot, cv::Point position) {
  lesson_.clear();
  labels_.clear();
  const auto add = [this](cv::Mat patch, Label label) {
    lesson_.push_back(std::move(patch));
    labels_.push_back(label);
  };
  const auto cut = [&](cv::Point p, const cv::Matx33d &warp) {
    cv::Mat patch;
    sample_patch(snapshot.bgr, p, warp, options_.patch, patch);
    return patch;
  };
  const auto with_smoke = [&](const cv::Mat &patch, Label label) {
    for (const double density : smoke_densities) {
      cv::Mat smoky;
      smoke_.apply(patch, density, options_.smoke, random_, smoky);
      add(smoky, label);
    }
    add(patch, label);
  };
  with_smoke(cut(position, cv::Matx33d::eye()), Label::feature);
  for (const auto &warp : geometric_warps()) add(cut(position, warp), Label::feature);

  auto negatives =
      random_negatives(snapshot.bgr.size(), snapshot.forbidden, position, random_per_lesson, rules(), random_);
  const auto similar = similar_negatives(snapshot.luma, snapshot.forbidden, position, similar_per_lesson,
                                         least_similarity, scaled(similarity_radius, options_.pixel), rules());
  negatives.insert(negatives.end(), similar.begin(), similar.end());
  for (const auto &p : negatives) with_smoke(cut(p, cv::Matx33d::eye()), Label::not_feature);
}

void FeatureLearner::learn(const Snapshot &snapshot, cv::Point position) {
  collect(snapshot, position);
  const bool first = !tree_;
  if (first) {
    GrowthOptions growth;
    growth.search.search = options_.pair_search;
    growth.seed = random_.next();
    tree_.emplace(options_.patch, choose_colour_space(lesson_, labels_), growth);
  }
  std::vector<SampleId> added;
  cv::Mat channel;
  for (std::size_t i = 0; i < lesson_.size(); ++i) {
    to_space(lesson_[i], tree_->space(), channel);
    added.push_back(tree_->add(channel, labels_[i]));
  }
  if (first)
    tree_->build();
  else
    retrain(added);
  correct(snapshot, position);
  publish();
}

void FeatureLearner::retrain(const std::vector<SampleId> &samples) {
  counters_->retrainings += static_cast<std::uint64_t>(tree_->retrain(samples));
}

/// §2.2.2: classify patches of the current frame, add those that are wrongly called the feature, retrain the leaves
/// that did it; until there are none, or A34's rounds are over.
void FeatureLearner::correct(const Snapshot &snapshot, cv::Point position) {
  const int half = options_.patch / 2;
  const cv::Rect picture({0, 0}, snapshot.bgr.size());
  cv::Mat bordered, channel;
  to_space(snapshot.bgr, tree_->space(), channel);
  cv::copyMakeBorder(channel, bordered, half, half, half, half, cv::BORDER_REPLICATE);
  const cv::Point origin(-half, -half);
  const int radius = options_.search_radius;
  const cv::Rect window = cv::Rect(position.x - radius, position.y - radius, 2 * radius + 1, 2 * radius + 1) & picture;
  const double ignore = ignore_radius * options_.pixel;

  for (int round = 0; round < learning_rounds; ++round) {
    const auto tree = tree_->publish();
    const SpatialWeight anywhere{position};
    auto wrong = search(*tree, bordered, origin, {window, 1}, anywhere).matches;
    const auto elsewhere = search(*tree, bordered, origin, {picture, evaluation_grid}, anywhere).matches;
    wrong.insert(wrong.end(), elsewhere.begin(), elsewhere.end());
    std::erase_if(wrong, [&](cv::Point p) {
      return std::hypot(p.x - position.x, p.y - position.y) <= ignore ||
             (!snapshot.forbidden.empty() && snapshot.forbidden.at<unsigned char>(p) != 0);
    });
    if (wrong.empty()) break;
    counters_->false_correspondences += wrong.size();
    std::vector<SampleId> added;
    for (int i = 0; i < errors_per_round && !wrong.empty(); ++i) {
      const auto k = random_.below(static_cast<std::uint32_t>(wrong.size()));
      const auto p = wrong[k];
      wrong[k] = wrong.back();
      wrong.pop_back();
      added.push_back(tree_->add(bordered({p.x, p.y, options_.patch, options_.patch}), Label::not_feature));
    }
    retrain(added);
  }
}

void FeatureLearner::update(const DescriptorUpdate &update) {
  if (!tree_) return;
  std::vector<SampleId> wrong;
  for (const auto &patch : update.positives) {
    if (recent_.size() < static_cast<std::size_t>(recent_positives)) {
      recent_.push_back(tree_->add(patch, Label::feature));
    } else {
      tree_->replace(recent_[next_recent_], patch, Label::feature);
      next_recent_ = (next_recent_ + 1) % recent_.size();
    }
  }
  for (const auto &patch : update.negatives) {
    const bool error = tree_->classify(patch) == Label::feature;
    counters_->false_correspondences += error;
    // Reservoir: each negative ever seen is kept with equal probability. One that was called the feature always stays,
    // in the place of another: without it the leaf could not be retrained.
    ++negatives_seen_;
    SampleId id = 0;
    if (reservoir_.size() < static_cast<std::size_t>(negative_reservoir)) {
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
