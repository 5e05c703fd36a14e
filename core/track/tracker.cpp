// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/tracker.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/find_id.h"
#include "content/content_area.h"
#include "content/specular.h"
#include "content/tools.h"
#include "detect/detect.h"
#include "image/gray_window.h"
#include "image/pyramid.h"
#include "image/work_frame.h"
#include "track/algorithm.h"
#include "track/life.h"
#include "track/patch_side.h"
#include "track/requests.h"
#include "track/stream_clock.h"

namespace csd {

namespace {

// A recording may fade in: the first detection does not find all features.
constexpr std::int64_t settle_for = 2 * second;
constexpr std::int64_t replenish_every = second / 2;  // detection costs as much as ten frames of tracking

constexpr std::int64_t shun_for = 5 * second;  // no feature starts here again after a false start

constexpr double min_contrast = 1;  // grey levels, of a picture in which to detect features

struct FalseStart {
  cv::Point2d position;
  std::int64_t time;
};

Settings limited(Settings settings) {
  if (settings.points.size() > max_points) settings.points.resize(max_points);
  return settings;
}

}  // namespace

struct Tracker::Impl {
  Impl(const Settings &s, std::unique_ptr<Algorithm> a)
      : settings(limited(s)), algorithm(std::move(a)), requests(settings) {}

  const Tracks &process(const FrameView *view, cv::Size size, std::int64_t pts, std::int64_t duration, bool discont);
  void take_requests();
  void end_all();
  void follow(const FrameContext &context);
  void forget_old();
  void leave_graphics(const FrameContext &context);
  Life &enter(FeatureId id, cv::Point2d position, bool given, const FrameContext *context);
  void show(Life &life, const FrameContext &context);
  void enter_given(const FrameContext *context);
  bool replenishes() const { return settings.replenish && algorithm->replenishes(); }
  void drop_false_starts();
  void detect_more(const FrameContext &context);
  void come_and_go(const FrameContext &context);
  void end(Life &life);
  void report(cv::Size size);

  Settings settings;
  std::unique_ptr<Algorithm> algorithm;
  Requests requests;

  // Owned by the streaming thread.
  WorkFrame frame;
  GrayWindow window;
  ContentAreaFinder content_area;
  cv::Mat nowhere;          // empty forbidden area, for content-area=full
  std::vector<Life> lives;  // by ascending id
  std::vector<Claim> claims;
  Requests::Taken asked;
  std::vector<StartPoint> offered;
  std::vector<FalseStart> false_starts;
  Tracks tracks;
  cv::Size last_size, last_work_size;
  bool stream_begun = false;         // the given points have begun
  bool points_begun_before = false;  // … in an earlier stream: now they need new ids
  std::size_t detected = 0;          // features detected in this stream
  std::int64_t first_detection = 0, last_detection = 0;
  bool failed = false;  // process() threw: the next process_blind() is about the same frame
  StreamClock clock;
  std::int64_t time = 0;  // of this frame

  mutable std::mutex stats_mutex;
  Stats stats;
};

void Tracker::Impl::take_requests() {
  requests.take(asked);
  if (asked.reset) {
    end_all();
    window.reset();
  }
  asked.reset = false;
  for (const auto id : asked.removed) {
    std::erase_if(asked.added, [id](const StartPoint &p) { return p.id == id; });
    const auto life = find_id(lives, id, [](const Life &l) { return l.feature.id; });
    if (life != lives.end()) end(*life);
  }
  asked.removed.clear();
}

void Tracker::Impl::end(Life &life) {
  if (life.feature.state == FeatureState::ended) return;
  algorithm->end(life.feature.id);
  life.end();
}

void Tracker::Impl::end_all() {
  for (auto &life : lives) life.end();
  false_starts.clear();
  stream_begun = false;
  detected = 0;
  content_area.reset();
  algorithm->forget();
}

void Tracker::Impl::follow(const FrameContext &context) {
  claims.clear();
  for (const auto &life : lives)
    if (life.feature.state != FeatureState::ended) {
      Claim claim;
      claim.id = life.feature.id;
      claim.position = {life.feature.x, life.feature.y};
      claims.push_back(claim);
    }
  algorithm->track(context, claims);
  clock.seen();
  std::size_t i = 0;
  for (auto &life : lives)
    if (life.feature.state != FeatureState::ended) life.apply(claims[i++], time);
}

// The algorithm does not know a point that starts outside the picture (no begin()): its claim stays out.
Life &Tracker::Impl::enter(FeatureId id, cv::Point2d position, bool given, const FrameContext *context) {
  Life life;
  life.feature.id = id;
  life.feature.x = position.x;
  life.feature.y = position.y;
  life.start = life.claimed = position;
  life.given = given;
  life.last_claim = life.gone_since = time;
  life.feature.state = context && !context->bounds().contains(position) ? FeatureState::out : FeatureState::lost;
  const auto at = std::upper_bound(lives.begin(), lives.end(), id,
                                   [](FeatureId wanted, const Life &l) { return wanted < l.feature.id; });
  return *lives.insert(at, life);
}

// A point that came while no frame was usable, or whose begin() threw, begins in the first frame in which it can.
void Tracker::Impl::show(Life &life, const FrameContext &context) {
  if (life.begun || life.feature.state == FeatureState::ended || !context.bounds().contains(life.start)) return;
  const auto kind = algorithm->begin(life.feature.id, life.start, context);
  life.begun = true;
  life.apply({life.feature.id, kind, life.start, 1}, time);
}

// Enters all points or, on an exception, none: the next frame tries again.
void Tracker::Impl::enter_given(const FrameContext *context) {
  lives.reserve(lives.size() + offered.size() + settings.points.size() + asked.added.size());
  if (settings.points_from_start) {
    if (!stream_begun)
      for (const auto &point : offered) {
        // A frame reports an id only once: the old feature with this id gives way to the new one.
        std::erase_if(lives, [&](const Life &l) { return l.feature.id == point.id; });
        enter(point.id, point.position, true, context);
      }
    stream_begun |= !offered.empty();
    offered.clear();
  } else if (!stream_begun) {
    stream_begun = true;
    FeatureId first = 0;
    if (points_begun_before) first = requests.take_ids(settings.points.size());
    points_begun_before = true;
    for (std::size_t i = 0; i < settings.points.size(); ++i)
      enter(first + static_cast<FeatureId>(i), settings.points[i], true, context);
  }
  for (const auto &point : asked.added) enter(point.id, point.position, true, context);
  asked.added.clear();
}

void Tracker::Impl::detect_more(const FrameContext &context) {
  if (!settings.points.empty() || settings.points_from_start) return;
  const auto alive = std::count_if(lives.begin(), lives.end(),
                                   [](const Life &l) { return !l.given && l.feature.state != FeatureState::ended; });
  const auto wanted = static_cast<std::ptrdiff_t>(settings.max_features) -
                      (replenishes() ? alive : static_cast<std::ptrdiff_t>(detected));
  if (wanted <= 0) return;
  if (detected > 0) {
    if (!replenishes() && time - first_detection >= settle_for) return;
    if (time - last_detection < replenish_every) return;
  }
  last_detection = time;

  const auto &luma = context.frame.luma();
  cv::Mat forbidden(luma.size(), CV_8UC1, cv::Scalar(0));
  if (!context.forbidden.empty()) context.forbidden.copyTo(forbidden);
  if (!settings.region.empty()) {
    const auto a = context.frame.to_work(cv::Point2d(settings.region.tl()));
    const auto b = context.frame.to_work(cv::Point2d(settings.region.br()) - cv::Point2d(1, 1));
    const cv::Rect inside =
        cv::Rect(cv::Point(cvRound(a.x), cvRound(a.y)), cv::Point(cvRound(b.x) + 1, cvRound(b.y) + 1)) &
        cv::Rect({0, 0}, luma.size());
    cv::Mat outside(luma.size(), CV_8UC1, cv::Scalar(255));
    if (!inside.empty()) outside(inside).setTo(0);
    forbidden |= outside;
  }
  DetectOptions options;
  options.patch = patch_side(settings, context.frame);
  options.wanted = static_cast<std::size_t>(wanted);
  options.max_look_alike = algorithm->max_look_alike();
  std::vector<cv::Point2d> taken;
  for (const auto &life : lives)
    if (life.feature.state != FeatureState::ended)
      taken.push_back(context.frame.to_work({life.feature.x, life.feature.y}));
  for (const auto &start : false_starts) taken.push_back(context.frame.to_work(start.position));
  if (cv::countNonZero(forbidden) == forbidden.size().area()) return;
  // A picture of noise: the detectors need 40 ms to find nothing, and would in each frame.
  cv::Scalar mean, deviation;
  cv::meanStdDev(luma, mean, deviation, forbidden == 0);
  if (deviation[0] < min_contrast) return;

  cv::Mat specular, tools;
  if (algorithm->avoids_tools()) {
    find_tools(context.frame, tools);
    forbidden |= tools;
  }
  specular_mask(context.frame, {{0, 0}, luma.size()}, specular, settings.specular);
  for (const auto &position : detect(luma, specular, forbidden, options, taken)) {
    show(enter(requests.take_ids(), context.frame.to_picture(position), false, &context), context);
    if (detected++ == 0) first_detection = time;
  }
}

// A feature that was detected on the border or on burnt-in graphics before they were known tracks perfectly, because it
// never moves. So it is recognised by its start. One that has moved there later is tissue beside the graphics.
void Tracker::Impl::leave_graphics(const FrameContext &context) {
  if (settings.content_area == ContentArea::full || context.forbidden.empty()) return;
  const double still = patch_side(settings, context.frame) / 4.0 * context.frame.scale();
  for (auto &life : lives)
    if (!life.given && claims_position(life.feature.state) &&
        cv::norm(cv::Point2d(life.feature.x, life.feature.y) - life.start) < still &&
        content_area.contains(context.frame.to_work(life.start)))
      end(life);
}

// After tracking.
void Tracker::Impl::come_and_go(const FrameContext &context) {
  leave_graphics(context);
  drop_false_starts();
  forget_old();
  enter_given(&context);
  for (auto &life : lives) show(life, context);
  detect_more(context);
}

void Tracker::Impl::drop_false_starts() {
  if (!replenishes()) return;
  std::erase_if(false_starts, [this](const FalseStart &f) { return time - f.time >= shun_for; });
  for (auto &life : lives)
    if (life.started_falsely()) {
      false_starts.push_back({{life.feature.x, life.feature.y}, time});
      end(life);
    }
}

void Tracker::Impl::forget_old() {
  if (settings.forget_after <= 0) return;
  for (auto &life : lives) {
    const auto state = life.feature.state;
    if (!life.given && (state == FeatureState::lost || state == FeatureState::out) &&
        time - life.gone_since >= settings.forget_after)
      end(life);
  }
}

void Tracker::Impl::report(cv::Size size) {
  tracks.width = size.width;
  tracks.height = size.height;
  tracks.features.clear();
  tracks.features.reserve(lives.size());
  tracks.changed = false;
  Stats counted;
  std::vector<Requests::Known> alive;
  alive.reserve(lives.size());
  // Nothing throws from here on: what is marked as reported is reported.
  for (auto &life : lives) {
    tracks.features.push_back(life.feature);
    tracks.changed |= !life.reported || life.reported_as != life.feature.state;
    life.reported_as = life.feature.state;
    ++counted.features[static_cast<std::size_t>(life.feature.state)];
    counted.waited += !life.feature.fresh;
    if (!life.reported) ++counted.detected;
    life.reported = true;
    const auto &feature = life.feature;
    if (feature.state != FeatureState::ended)
      alive.push_back({feature.id, {feature.x, feature.y}, feature.state != FeatureState::out});
  }
  requests.report(std::move(alive));
  const std::lock_guard lock(stats_mutex);
  tracks.frame = stats.frames++;
  stats.features = counted.features;
  stats.detected += counted.detected;
  stats.waited += counted.waited;
}

const Tracks &Tracker::Impl::process(const FrameView *view, cv::Size size, std::int64_t pts, std::int64_t duration,
                                     bool discont) {
  const FrameBudget budget(settings.frame_budget, settings.clock);
  // Removes features that have been reported as ended, and detected ones whose begin() threw.
  std::erase_if(lives, [](const Life &l) {
    return (l.reported && l.reported_as == FeatureState::ended) || (!l.given && !l.begun);
  });
  if (view || !failed) clock.advance(pts, duration, discont);
  time = clock.time();
  failed = true;
  take_requests();
  if (view) frame.load(window.look(*view, time));
  // A switch between fields and frames changes the working image, though not the picture size.
  const auto work_size = view ? frame.size() : last_work_size;
  if (size != last_size || (work_size != last_work_size && !last_work_size.empty())) end_all();
  last_size = size;
  last_work_size = work_size;

  const int patch = view ? patch_side(settings, frame) : 0;
  tracks.too_small =
      view && std::min(frame.size().width, frame.size().height) < std::max(patch, static_cast<int>(Pyramid::smallest));
  if (!view || tracks.too_small) {
    for (auto &life : lives)
      if (life.feature.state != FeatureState::ended)
        life.apply({life.feature.id, Claim::Kind::lost, {life.feature.x, life.feature.y}, 0}, time);
    enter_given(nullptr);
  } else {
    if (settings.content_area == ContentArea::automatic) content_area.update(frame.luma(), time, patch);
    const FrameContext context{frame,
                               settings.content_area == ContentArea::automatic ? content_area.forbidden() : nowhere,
                               time, clock.jumped(), budget};
    follow(context);
    try {
      come_and_go(context);
    } catch (...) {
      // The positions are already this frame's, so the algorithm must keep this frame's picture too.
      try {
        algorithm->finish(context);
      } catch (...) {  // the first exception is the one to report
      }
      throw;
    }
    algorithm->finish(context);
  }
  report(size);
  failed = false;
  return tracks;
}

Tracker::Tracker(const Settings &settings, std::unique_ptr<Algorithm> algorithm)
    : impl_(std::make_unique<Impl>(settings, std::move(algorithm))) {}

Tracker::~Tracker() = default;

const Tracks &Tracker::process(const FrameView &view, std::int64_t pts, std::int64_t duration, bool discont) {
  return impl_->process(&view, {view.width, view.height}, pts, duration, discont);
}

const Tracks &Tracker::process_blind(int width, int height, std::int64_t pts, std::int64_t duration, bool discont) {
  return impl_->process(nullptr, {width, height}, pts, duration, discont);
}

void Tracker::offer_start(std::vector<StartPoint> points) {
  std::vector<char> taken(points.empty() ? 0 : max_points);
  std::erase_if(points, [&](const StartPoint &p) {
    return p.id >= max_points || !std::isfinite(p.position.x) || !std::isfinite(p.position.y) ||
           std::exchange(taken[p.id], 1) != 0;
  });
  impl_->offered = std::move(points);
}

FeatureId Tracker::add_point(double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y)) return no_feature;
  return impl_->requests.add({x, y});
}

bool Tracker::remove_point(FeatureId id) {
  return impl_->requests.remove(id);
}

FeatureId Tracker::remove_nearest(double x, double y) {
  return impl_->requests.remove_nearest({x, y});
}

void Tracker::reset() {
  impl_->requests.reset();
}

Stats Tracker::stats() const {
  Stats stats;
  {
    const std::lock_guard lock(impl_->stats_mutex);
    stats = impl_->stats;
  }
  impl_->algorithm->add_to(stats);
  return stats;
}

}  // namespace csd
