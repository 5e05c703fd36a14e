// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/csd2012.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/find_id.h"
#include "csd2012/learn/negatives.h"
#include "csd2012/search.h"
#include "csd2012/smoothed.h"
#include "track/patch_side.h"

namespace csd {

using csd2012::Choices;

/// A feature on the streaming thread.
struct Csd2012::Follower {
  Follower(FeatureId i, cv::Point2d position, std::int64_t now, std::uint64_t seed)
      : id(i), work(position), begun(now), last_seen(now), random(seed, 2 * std::uint64_t{i} + 1) {}

  FeatureId id;
  cv::Point2d work;  ///< last known position, working pixels
  std::int64_t begun, last_seen, last_lesson = 0;
  bool recursive = true;    ///< LK tracks it; else the descriptor does
  bool taken_over = false;  ///< the descriptor has searched for it
  bool in_sight = true;     ///< it was found in the last frame, near `work`
  bool learn = true;        ///< this frame is a training frame
  int lessons = 0;
  Random random;
  std::shared_ptr<FeatureLearner> learner;
  LearningQueue::Lane lane;
  std::optional<DescriptorUpdate> update;
  std::optional<AlignedPatch> aligned;
};

namespace {

/// Size of a pixel of the choices (480 lines) in working pixels: below 480 lines they shrink with the patch.
double choice_scale(const WorkFrame &frame) {
  return default_patch_size(frame.size().height) / 21.0;
}

int radius_of(const Settings &settings, const Choices &choices, const WorkFrame &frame) {
  const double radius =
      settings.search_radius ? settings.search_radius / frame.scale() : choices.search_radius * choice_scale(frame);
  return std::clamp(static_cast<int>(std::lround(radius)), 1, std::max(frame.size().width, frame.size().height));
}

cv::Rect square(cv::Point centre, int radius) {
  return {centre.x - radius, centre.y - radius, 2 * radius + 1, 2 * radius + 1};
}

NegativeRules rules_for(const Settings &settings, const Choices &choices, const WorkFrame &frame) {
  const double scale = choice_scale(frame);
  return {patch_side(settings, frame), choices.ignore_radius * scale, choices.near_radius * scale};
}

double apart(cv::Point a, cv::Point b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

cv::Point rounded(cv::Point2d p) {
  return {cvRound(p.x), cvRound(p.y)};
}

}  // namespace

Csd2012::Csd2012(const Settings &settings, Executor &executor, const Choices &choices)
    : settings_(settings), choices_(choices), counters_(std::make_shared<LearningCounters>()), queue_(executor) {}

Csd2012::~Csd2012() = default;

Csd2012::Follower *Csd2012::find(FeatureId id) {
  const auto at = find_id(followers_, id, [](const auto &follower) { return follower->id; });
  return at != followers_.end() ? at->get() : nullptr;
}

Claim::Kind Csd2012::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  auto follower = std::make_unique<Follower>(id, context.frame.to_work(position), context.time, settings_.seed);
  LearnerOptions options;
  options.patch = patch_side(settings_, context.frame);
  options.search_radius = radius_of(settings_, choices_, context.frame);
  options.pixel = choice_scale(context.frame);
  options.choices = choices_;
  follower->learner =
      std::make_shared<FeatureLearner>(options, Random(settings_.seed, 2 * std::uint64_t{id}), counters_);
  follower->lane = queue_.make_lane();
  if (choices_.co_training != 0)
    follower->aligned.emplace(pyramid_, weights_, follower->work,
                              options.patch / static_cast<double>(PatchPlane::side));
  const auto at = std::upper_bound(followers_.begin(), followers_.end(), id,
                                   [](FeatureId wanted, const auto &f) { return wanted < f->id; });
  followers_.insert(at, std::move(follower));
  return Claim::Kind::learning;
}

void Csd2012::end(FeatureId id) {
  std::erase_if(followers_, [id](const auto &follower) { return follower->id == id; });
}

void Csd2012::forget() {
  followers_.clear();
  recursive_.skip();
}

void Csd2012::track(const FrameContext &context, std::vector<Claim> &claims) {
  if (choices_.co_training != 0) {
    pyramid_.build(context.frame.luma());
    weights_.build(context.frame, context.forbidden);
  }
  recurse(context);

  for (const auto &follower : followers_) follower->update.reset();
  for (auto &claim : claims) {
    auto *follower = find(claim.id);
    claim.kind = Claim::Kind::lost;
    if (!follower) continue;
    if (follower->recursive) {
      claim.kind = Claim::Kind::learning;
    } else {
      look(context, *follower);
      if (follower->in_sight) {
        claim.kind = Claim::Kind::tracked;
      } else {
        // No position is labelled feature: it is hidden, or outside if its last patch touched the edge.
        const int half = patch_side(settings_, context.frame) / 2;
        const cv::Rect inner(half, half, context.frame.size().width - 2 * half, context.frame.size().height - 2 * half);
        claim.kind = inner.contains(rounded(follower->work)) ? Claim::Kind::hidden : Claim::Kind::out;
      }
    }
    claim.position = context.frame.to_picture(follower->work);
  }
}

/// §2.1.1: LK moves the features that are being learned, until training-time is over and they have a descriptor.
void Csd2012::recurse(const FrameContext &context) {
  std::vector<Follower *> moving;
  std::vector<cv::Point2f> points;
  for (const auto &follower : followers_)
    if (follower->recursive) {
      moving.push_back(follower.get());
      points.emplace_back(follower->work);
    }
  std::vector<unsigned char> found;
  recursive_.set_window(patch_side(settings_, context.frame));
  recursive_.track(context.frame.luma(), points, found);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    auto &follower = *moving[i];
    follower.learn = false;
    const cv::Point2d position(points[i]);
    if (!found[i] || !context.bounds().contains(context.frame.to_picture(position))) {
      follower.recursive = false;  // The descriptor takes over as learned so far.
      follower.in_sight = false;
      continue;
    }
    follower.work = position;
    follower.last_seen = context.time;
    if (const auto seen = fit(context, follower, position); seen.zncc > 0) {
      follower.aligned->accept(seen);
      follower.work = seen.state.position;
    }
    const bool training =
        context.time - follower.begun < settings_.training_time || follower.lessons < choices_.min_training_frames;
    if (training) {
      const auto apart = settings_.training_time / static_cast<std::int64_t>(choices_.max_lessons);
      follower.learn = context.time - follower.last_lesson >= apart &&
                       static_cast<double>(follower.lane.waiting()) < choices_.waiting_lessons;
    } else if (follower.lane.waiting() == 0 && follower.learner->published()) {
      follower.recursive = false;
    }
  }
}

/// The patch aligned at or near `position`; ZNCC 0 if it does not fit.
AlignedPatch::Fit Csd2012::fit(const FrameContext &context, const Follower &follower, cv::Point2d position) const {
  if (!follower.aligned) return {};
  auto found = follower.aligned->fit(pyramid_, weights_, position);
  const double way = std::hypot(found.state.position.x - position.x, found.state.position.y - position.y);
  if (found.zncc < choices_.fits || way > choices_.fit_reach * choice_scale(context.frame) ||
      !context.bounds().contains(context.frame.to_picture(found.state.position)))
    found.zncc = 0;
  return found;
}

/// §5, co-training: if the patch fits, at the descriptor's position or where the feature was in the last frame, the
/// feature is there, and the descriptor learns that.
void Csd2012::confirm(const FrameContext &context, Follower &follower, SearchResult &result) const {
  AlignedPatch::Fit seen;
  if (result.best) seen = fit(context, follower, *result.best);
  if (follower.in_sight)
    if (const auto other = fit(context, follower, follower.work); other.zncc > seen.zncc) seen = other;
  if (seen.zncc == 0) return;
  follower.aligned->accept(seen);
  result.best = seen.state.position;
}

/// §2.1.4, and the samples for §2.1.5.
void Csd2012::look(const FrameContext &context, Follower &follower) {
  const auto descriptor = follower.learner->published();
  if (!descriptor) return;
  if (!std::exchange(follower.taken_over, true)) ++learned_;
  const auto &frame = context.frame;
  const int half = descriptor->patch_size() / 2;
  const auto absence = std::max<std::int64_t>(last_time_ - follower.last_seen, 0);
  const auto [sigma, radius] =
      reach_after(choices_, absence, frame.size().width, radius_of(settings_, choices_, frame));
  const cv::Rect picture({0, 0}, frame.size());
  const auto centres = square(rounded(follower.work), radius) & picture;
  if (centres.empty()) {
    follower.in_sight = false;
    return;
  }

  // The border is replicated by half a patch, so that a feature can be tracked up to the picture's edge.
  const double pixel = choice_scale(frame);
  const int margin = csd2012::smoothing_margin(choices_.smoothing * pixel), grown = half + margin;
  gathered_ = {centres.x - grown, centres.y - grown, centres.width + 2 * grown, centres.height + 2 * grown};
  frame.gather(gathered_, descriptor->space(), raw_);
  csd2012::smooth(raw_, choices_.smoothing * pixel, channel_);
  const double min_probability =
      follower.in_sight ? choices_.min_probability : std::max(choices_.min_probability, choices_.refind_probability);
  const Best wanted{static_cast<int>(std::lround(choices_.cluster_radius * pixel)), min_probability,
                    choices_.likeness_power};
  auto result =
      search(*descriptor, channel_, centres.tl() - cv::Point(half, half), {centres, 1}, {follower.work, sigma}, wanted);
  if (follower.aligned) confirm(context, follower, result);
  follower.in_sight = result.best.has_value();
  if (result.best) {
    follower.work = *result.best;
    follower.last_seen = context.time;
    // The remaining matches are false correspondences; those outside the tissue are not learned from.
    const double ignore = rules_for(settings_, choices_, frame).ignore_radius;
    std::erase_if(result.matches, [&](cv::Point p) {
      return apart(p, rounded(*result.best)) <= ignore ||
             (!context.forbidden.empty() && context.forbidden.at<std::uint8_t>(p));
    });
    counters_->false_correspondences += result.matches.size();
  }
  if (settings_.learn_synchronously || static_cast<double>(follower.lane.waiting()) < choices_.waiting_updates)
    prepare_update(context, follower, descriptor->space(), result);
}

void Csd2012::prepare_update(const FrameContext &context, Follower &follower, const ColourSpace &space,
                             const SearchResult &result) {
  const auto rules = rules_for(settings_, choices_, context.frame);
  const auto &learner = *follower.learner;
  auto &update = follower.update.emplace();
  const auto cut = [&](cv::Point p, int side) {
    const cv::Rect where = square(p, side / 2);
    if ((where & gathered_) == where) return raw_(where - gathered_.tl()).clone();
    cv::Mat patch;
    context.frame.gather(where, space, patch);
    return patch;
  };
  if (result.best) {
    update.feature = cut(rounded(*result.best), choices_.update_warps > 0 ? learner.surroundings() : learner.grown());
    auto wrong = result.matches;
    for (int i = 0; i < static_cast<int>(choices_.false_updates) && !wrong.empty(); ++i) {
      const auto k = follower.random.below(static_cast<std::uint32_t>(wrong.size()));
      update.negatives.push_back(cut(wrong[k], learner.grown()));
      wrong[k] = wrong.back();
      wrong.pop_back();
    }
  }
  for (const auto &p : random_negatives(context.frame.size(), context.forbidden, rounded(follower.work),
                                        static_cast<int>(choices_.random_updates), rules, follower.random))
    update.negatives.push_back(cut(p, learner.grown()));
}

void Csd2012::finish(const FrameContext &context) {
  std::shared_ptr<const Snapshot> snapshot;
  bool recursing = false;
  for (const auto &follower : followers_) {
    recursing |= follower->recursive;
    if (follower->recursive && follower->learn) {
      if (!snapshot) {
        auto copy = std::make_shared<Snapshot>();
        context.frame.gather_bgr({{0, 0}, context.frame.size()}, copy->bgr);
        copy->luma = context.frame.luma().clone();
        copy->forbidden = context.forbidden.clone();
        snapshot = std::move(copy);
      }
      ++follower->lessons;
      follower->last_lesson = context.time;
      queue_.post(follower->lane, [learner = follower->learner, snapshot, position = rounded(follower->work)] {
        learner->learn(*snapshot, position);
      });
    } else if (follower->update) {
      queue_.post(follower->lane,
                  [learner = follower->learner, update = std::move(*follower->update)] { learner->update(update); });
    }
    follower->update.reset();
  }
  if (recursing)
    recursive_.keep(context.frame.luma());
  else
    recursive_.skip();
  last_time_ = context.time;
  if (settings_.learn_synchronously) queue_.wait_idle();
  queue_.rethrow();
}

void Csd2012::add_to(Stats &stats) const {
  stats.learning_time += queue_.time_spent_ns();
  stats.queue += queue_.waiting();
  stats.learned += learned_;
  stats.retrainings += counters_->retrainings;
  stats.false_correspondences += counters_->false_correspondences;
}

}  // namespace csd
