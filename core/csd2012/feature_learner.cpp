// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/feature_learner.h"

#include <cmath>

#include "csd2012/learn/appearance.h"
#include "csd2012/search.h"
#include "csd2012/smoothed.h"

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

std::shared_ptr<const Forest> FeatureLearner::published() const {
  const std::lock_guard lock(mutex_);
  return published_;
}

void FeatureLearner::publish() {
  std::vector<std::shared_ptr<const Tree>> trees;
  for (const auto &member : members_) trees.push_back(member.tree.publish());
  auto forest = std::make_shared<const Forest>(std::move(trees));
  const std::lock_guard lock(mutex_);
  published_.swap(forest);
}

NegativeRules FeatureLearner::rules() const {
  const auto &c = options_.choices;
  return {options_.patch, c.ignore_radius * options_.pixel, c.near_radius * options_.pixel};
}

/// Patch i of a stack.
cv::Mat FeatureLearner::place(const cv::Mat &stack, std::size_t i) const {
  const int row = static_cast<int>(i) * grown();
  return stack.rowRange(row, row + grown());
}

std::vector<cv::Mat> FeatureLearner::smoothed(const cv::Mat &stack) const {
  return csd2012::smooth_each(stack, options_.choices.smoothing * options_.pixel);
}

FeatureLearner::Samples FeatureLearner::smoothed(const cv::Mat &stack, const std::vector<Label> &labels) const {
  const auto patches = smoothed(stack);
  Samples samples;
  samples.reserve(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) samples.emplace_back(patches[i].clone(), labels[i]);
  return samples;
}

/// §2.2.1: one for the whole tree. `root`: the first training frame's patches, without the warps.
ColourSpace FeatureLearner::choose_space(const Snapshot &snapshot, cv::Point position, ColourPatches root) {
  if (options_.choices.colour == 0) return {1, 1, 1};
  cv::Mat patch;
  for (const auto &warp : warps_) {
    sample_patch(snapshot.bgr, position, grown(), warp, patch);
    root.add(patch, Label::feature);
  }
  if (options_.choices.colour == 1) return choose_colour(root);
  ColourPatches compared(options_.patch);  // smoothed, as the tests compare them
  const auto patches = smoothed(root.stack());
  for (std::size_t i = 0; i < patches.size(); ++i) compared.add(patches[i], root.label(i));
  return choose_colour_of_pairs(compared, random_);
}

/// S of one frame (§2.1.2.1) without the warps: LK's positive, random and similar negatives, each with smoke and the
/// other appearance models.
ColourPatches FeatureLearner::collect(const Snapshot &snapshot, cv::Point position) {
  const auto &c = options_.choices;
  ColourPatches lesson(grown());
  cv::Mat patch, changed;
  const auto take = [&](cv::Point p, Label label) {
    sample_patch(snapshot.bgr, p, grown(), patch);
    lesson.add(patch, label);
    const auto add_copies = [&](double count, const auto &change) {
      for (int i = 0; i < whole(count); ++i) {
        patch.copyTo(changed);
        change();
        lesson.add(changed, label);
      }
    };
    for (const double density : smoke_densities) add_copies(1, [&] { smoke_->apply(changed, density, random_); });
    add_copies(c.highlights, [&] { add_highlight(changed, options_.pixel, random_); });
    add_copies(c.blurs, [&] { blur_by_motion(changed, options_.pixel, random_); });
    add_copies(c.compressions, [&] { compress(changed, random_); });
  };
  take(position, Label::feature);
  for (const auto &p : random_negatives(snapshot.bgr.size(), snapshot.forbidden, position, whole(c.random_per_lesson),
                                        rules(), random_))
    take(p, Label::not_feature);
  for (const auto &p : similar_negatives(snapshot.luma, snapshot.forbidden, position, whole(c.similar_per_lesson),
                                         c.min_similarity, scaled(c.similarity_radius, options_.pixel), rules()))
    take(p, Label::not_feature);
  return lesson;
}

void FeatureLearner::plant(const ColourSpace &space) {
  const auto &c = options_.choices;
  GrowthOptions growth;
  growth.search.search = c.exhaustive != 0 ? PairSearch::exhaustive : PairSearch::ranked;
  growth.search.stop_at_zero = c.widest_test == 0;
  growth.search.random_pairs = static_cast<std::size_t>(c.random_pairs);
  growth.search.top_pixels = static_cast<std::size_t>(c.top_pixels);
  growth.own_patches = c.likeness_power > 0 ? static_cast<std::size_t>(c.own_patches) : 0;
  growth.stop.max_depth = whole(c.max_depth);
  growth.stop.min_samples = static_cast<std::size_t>(c.min_samples);
  std::vector<Member> members;  // all or none: if memory runs out, the next training frame tries again
  for (int i = 0; i < whole(c.trees); ++i) {
    growth.seed = random_.next();
    members.push_back({GrowingTree(options_.patch, space, growth)});
  }
  members_ = std::move(members);
}

/// Trees on the same samples would be the same: each gets its own share of them.
bool FeatureLearner::takes_part() {
  return options_.choices.trees <= 1 || random_.uniform() < options_.choices.sample_share;
}

void FeatureLearner::learn(const Snapshot &snapshot, cv::Point position) {
  if (!smoke_) {
    // Not in the constructor, which runs in the streaming thread: it takes 3 ms.
    smoke_.emplace(grown(), random_,
                   options_.choices.smoke_as_printed != 0 ? SmokeEquation::as_printed : SmokeEquation::as_meant);
    warps_ = geometric_warps(options_.patch);
  }
  const auto lesson = collect(snapshot, position);
  const bool first = members_.empty();
  if (first) plant(choose_space(snapshot, position, lesson));
  const auto &space = members_.front().tree.space();
  const auto &[channel, picture] = snapshot.in(space, options_.choices.smoothing * options_.pixel, options_.patch / 2);
  auto labels = lesson.labels();
  labels.insert(labels.end(), warps_.size(), Label::feature);
  cv::Mat stack(static_cast<int>(labels.size()) * grown(), grown(), CV_8UC1);
  lesson.convert(space, stack.rowRange(0, static_cast<int>(lesson.size()) * grown()));
  // Warping in the one colour space costs a third of warping B, G and R.
  for (std::size_t i = 0; i < warps_.size(); ++i) {
    cv::Mat patch = place(stack, lesson.size() + i);
    sample_patch(channel, position, grown(), warps_[i], patch);
  }
  const auto samples = smoothed(stack, labels);
  for (auto &member : members_) learn(member, samples, picture, snapshot.forbidden, position, first);
  publish();
}

void FeatureLearner::learn(Member &member, const Samples &samples, const cv::Mat &picture, const cv::Mat &forbidden,
                           cv::Point position, bool first) {
  std::vector<SampleId> wrong, positives;
  for (const auto &[patch, label] : samples) {
    if (!takes_part()) continue;
    const bool errs = !first && member.tree.classify(patch) != label;
    const auto id = member.tree.add(patch, label);
    if (errs) wrong.push_back(id);
    if (label == Label::feature) positives.push_back(id);
  }
  if (first)
    member.tree.build();
  else
    retrain(member.tree, wrong);
  correct(member, picture, forbidden, position, positives);
}

int FeatureLearner::retrain(GrowingTree &tree, const std::vector<SampleId> &samples) {
  const int replaced = tree.retrain(samples);
  counters_->retrainings += static_cast<std::uint64_t>(replaced);
  return replaced;
}

/// §2.2.2: classifies patches of the current frame, adds the false positives, and retrains the leaves that
/// misclassified them or the feature, until there are no errors or the rounds are used up. `picture`: smoothed, with a
/// border of half a patch.
void FeatureLearner::correct(Member &member, const cv::Mat &picture, const cv::Mat &forbidden, cv::Point position,
                             const std::vector<SampleId> &positives) {
  const int half = options_.patch / 2, radius = options_.search_radius;
  const cv::Point origin(-half, -half);
  const cv::Rect all(0, 0, picture.cols - 2 * half, picture.rows - 2 * half);
  const cv::Rect window = cv::Rect(position.x - radius, position.y - radius, 2 * radius + 1, 2 * radius + 1) & all;
  const auto &c = options_.choices;
  const double ignore = c.ignore_radius * options_.pixel;

  for (int round = 0; round < whole(c.learning_rounds); ++round) {
    const Forest alone({member.tree.publish()});
    const SpatialWeight anywhere{position};
    auto wrong = search(alone, picture, origin, {window, 1}, anywhere).matches;
    for (const auto &p : search(alone, picture, origin, {all, whole(c.evaluation_grid)}, anywhere).matches)
      if (!window.contains(p)) wrong.push_back(p);
    std::erase_if(wrong, [&](cv::Point p) {
      return std::hypot(p.x - position.x, p.y - position.y) <= ignore ||
             (!forbidden.empty() && forbidden.at<unsigned char>(p) != 0);
    });
    counters_->false_correspondences += wrong.size();
    std::vector<SampleId> errors;
    for (const auto id : positives)
      if (member.tree.misclassified(id)) errors.push_back(id);
    for (int i = 0; i < whole(c.errors_per_round) && !wrong.empty(); ++i) {
      const auto k = random_.below(static_cast<std::uint32_t>(wrong.size()));
      const auto p = wrong[k];
      wrong[k] = wrong.back();
      wrong.pop_back();
      errors.push_back(member.tree.add(picture({p.x, p.y, options_.patch, options_.patch}), Label::not_feature));
    }
    // No errors, or none in a leaf that the stop rules let divide.
    if (errors.empty() || retrain(member.tree, errors) == 0) break;
  }
}

/// Replaces the oldest one when full.
SampleId FeatureLearner::keep_positive(Member &member, const cv::Mat &patch) {
  const auto &c = options_.choices;
  if (member.recent.size() < static_cast<std::size_t>(c.recent_positives * (1 + c.update_warps))) {
    member.recent.push_back(member.tree.add(patch, Label::feature));
    return member.recent.back();
  }
  const auto id = member.recent[member.next_recent];
  member.tree.replace(id, patch, Label::feature);
  member.next_recent = (member.next_recent + 1) % member.recent.size();
  return id;
}

/// Reservoir sampling: each negative is kept with equal probability. A false positive is always kept, in the place of
/// another: without it the leaf could not be retrained.
std::optional<SampleId> FeatureLearner::keep_negative(Member &member, const cv::Mat &patch, bool error) {
  ++member.negatives_seen;
  if (member.reservoir.size() < static_cast<std::size_t>(options_.choices.negative_reservoir)) {
    member.reservoir.push_back(member.tree.add(patch, Label::not_feature));
    return member.reservoir.back();
  }
  const auto slot = static_cast<std::size_t>(random_.uniform() * static_cast<double>(member.negatives_seen));
  if (slot >= member.reservoir.size() && !error) return std::nullopt;
  const auto id = member.reservoir[slot % member.reservoir.size()];
  member.tree.replace(id, patch, Label::not_feature);
  return id;
}

void FeatureLearner::update(const DescriptorUpdate &update) {
  if (members_.empty()) return;
  const int warps = whole(options_.choices.update_warps);
  const std::size_t features = update.feature.empty() ? 0 : 1 + static_cast<std::size_t>(warps);
  std::vector<Label> labels(features, Label::feature);
  labels.insert(labels.end(), update.negatives.size(), Label::not_feature);
  cv::Mat stack(static_cast<int>(labels.size()) * grown(), grown(), CV_8UC1);
  const double middle = update.feature.cols / 2;
  for (std::size_t i = 0; i < features; ++i) {
    cv::Mat patch = place(stack, i);
    const auto warp = i == 0 ? Warp::eye() : warps_[random_.below(static_cast<std::uint32_t>(warps_.size()))];
    sample_patch(update.feature, {middle, middle}, grown(), warp, patch);
  }
  for (std::size_t i = 0; i < update.negatives.size(); ++i) update.negatives[i].copyTo(place(stack, features + i));
  const auto samples = smoothed(stack, labels);
  for (auto &member : members_) this->update(member, samples);
  publish();
}

void FeatureLearner::update(Member &member, const Samples &samples) {
  std::vector<SampleId> wrong;
  for (const auto &[patch, label] : samples) {
    if (!takes_part()) continue;
    const bool error = member.tree.classify(patch) != label;
    if (label == Label::feature) {
      const auto id = keep_positive(member, patch);
      if (error && options_.choices.update_warps > 0) wrong.push_back(id);
    } else {
      counters_->false_correspondences += error;
      const auto id = keep_negative(member, patch, error);
      if (error && id) wrong.push_back(*id);
    }
  }
  retrain(member.tree, wrong);
}

}  // namespace csd
