// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/rhythms.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "motion/peaks.h"
#include "score/quantile.h"

namespace csd::motion {
namespace {

constexpr double min_periods = 2.5;     // of the slowest rhythm in a window
constexpr double max_of_rate = 0.4;     // of the frame rate: the fastest rhythm
constexpr double min_coverage = 0.5;    // of a window, by weight, to include a feature in it
constexpr int min_moments = 24;         // and at least this many frames
constexpr double min_explained = 1e-4;  // of the variance: a hundredth of the amplitude
constexpr unsigned max_multiple = 4;
constexpr double rate_tolerance = 0.02;  // of a multiple; at least half of 1/window
constexpr double still = 1e-4;           // px: rounding errors

struct Window {
  std::size_t begin, end;  // frames
  double middle, length;   // s
};

std::vector<Window> windows_of(const Series &series, double length) {
  const double begin = series.times.front(), whole = series.times.back() - begin;
  length = std::min(length, whole);
  std::vector<Window> windows;
  if (!(length > 0)) return windows;
  const double steps = std::ceil((whole - length) / (length / 2) - 1e-9);
  for (double i = 0; i <= steps; ++i) {  // NOLINT(cert-flp30-c): whole numbers, exact
    const double from = begin + (steps > 0 ? (whole - length) * i / steps : 0);
    const auto first = std::lower_bound(series.times.begin(), series.times.end(), from),
               last = std::upper_bound(first, series.times.end(), from + length);
    if (last - first >= min_moments)
      windows.push_back({static_cast<std::size_t>(first - series.times.begin()),
                         static_cast<std::size_t>(last - series.times.begin()), from + length / 2, length});
    // Limits the number of windows to that of frames, however long a pause was.
    if (first == last && first != series.times.end())
      i = std::max(i, std::floor((*first - length - begin) / (whole - length) * steps) - 1);
  }
  return windows;
}

Grid grid_of(const Series &series, double window, const SearchOptions &options) {
  Grid grid;
  grid.step = 1 / (oversampling * window);
  const double lowest = std::max(options.lowest, min_periods / window),
               highest = std::min(options.highest, max_of_rate / series.interval);
  grid.first = static_cast<std::size_t>(std::ceil(lowest / grid.step - 1e-9));
  const auto last = static_cast<std::size_t>(std::floor(highest / grid.step + 1e-9));
  grid.count = last >= grid.first + 2 ? last - grid.first + 1 : 0;
  return grid;
}

/// Turns multiples of a slower rhythm into its harmonics. Harmonics decrease one after the other: one that is stronger
/// than the last, or follows a missing one, is a separate rhythm.
std::vector<Rhythm> with_harmonics(std::vector<Rhythm> all, double window) {
  std::sort(all.begin(), all.end(), [](const Rhythm &a, const Rhythm &b) { return a.frequency < b.frequency; });
  for (std::size_t i = 0; i < all.size(); ++i) {
    double before = 2 * all[i].amplitude;
    for (unsigned multiple = 1; multiple <= max_multiple; ++multiple) {
      // Several peaks at one multiple: those that the path through the windows missed.
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(i) + 1;
      const auto belongs = std::stable_partition(begin, all.end(), [&](const Rhythm &a) {
        return !(a.amplitude < before && same_rate(a, all[i], multiple, window));
      });
      if (belongs == all.end()) {
        if (multiple == 1) continue;
        break;
      }
      const auto strongest = std::max_element(
          belongs, all.end(), [](const Rhythm &a, const Rhythm &b) { return a.amplitude < b.amplitude; });
      if (multiple == 1) {
        if (strongest->amplitude > all[i].amplitude) std::swap(*strongest, all[i]);
        before = 2 * all[i].amplitude;
      } else {
        before = strongest->amplitude;
        all[i].harmonics.push_back({multiple, strongest->frequency, before});
      }
      for (auto rhythm = belongs; rhythm != all.end(); ++rhythm) all[i].explained += rhythm->explained;
      all.erase(belongs, all.end());
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Rhythm &a, const Rhythm &b) { return a.explained > b.explained; });
  return all;
}

/// Some features and the search for their common rhythms.
struct Group {
  std::vector<std::size_t> paths;
  std::size_t first, last;  // windows that contain them, from `first` to before `last`
  PeakSearch search;

  bool active(std::size_t window) const { return search.active() && window >= first && window < last; }
};

/// Sets amplitude, direction and share of the variance of peak p from the fits.
void measure(const Group &group, std::size_t p, Rhythm &rhythm) {
  std::vector<std::vector<double>> amplitudes(group.paths.size());
  double xx = 0, xy = 0, yy = 0, explained = 0, count = 0;
  for (const View &view : group.search.views())
    for (std::size_t m = 0; m < view.members.size(); ++m) {
      const Ellipse &e = view.ellipses[p][m];
      double all = view.remainder[m];
      for (const auto &other : view.ellipses) all += other[m].variance();
      if (!(all > 0)) continue;
      amplitudes[view.members[m]].push_back(e.semi_major());
      explained += e.variance() / all;
      ++count;
      if (!(e.variance() > 0)) continue;
      xx += (e.a * e.a + e.b * e.b) / e.variance();
      xy += (e.a * e.c + e.b * e.d) / e.variance();
      yy += (e.c * e.c + e.d * e.d) / e.variance();
    }
  std::vector<double> medians;
  for (auto &of_feature : amplitudes)
    if (!of_feature.empty()) medians.push_back(score::quantile(std::move(of_feature), 0.5));
  rhythm.amplitude = score::quantile(medians, 0.5);
  rhythm.amplitude_low = score::quantile(medians, 0.25);
  rhythm.amplitude_high = score::quantile(std::move(medians), 0.75);
  rhythm.direction = 90 / std::numbers::pi * std::atan2(2 * xy, xx - yy);
  rhythm.explained = count > 0 ? explained / count : 0;
}

Rhythms result_of(const Group &group, const std::vector<Window> &windows) {
  Rhythms found;
  for (const View &view : group.search.views()) found.windows += !view.members.empty();
  std::vector<Rhythm> all;
  for (std::size_t p = 0; p < group.search.peaks().size(); ++p) {
    const Peak &peak = group.search.peaks()[p];
    Rhythm rhythm;
    rhythm.frequency = peak.frequency;
    rhythm.false_alarm = peak.false_alarm;
    measure(group, p, rhythm);
    if (rhythm.explained < min_explained) continue;
    for (std::size_t w = 0; w < peak.by_window.size(); ++w)
      if (peak.stands_out[w]) rhythm.rates.push_back({windows[group.first + w].middle, peak.by_window[w]});
    all.push_back(std::move(rhythm));
  }
  if (!all.empty()) found.rhythms = with_harmonics(std::move(all), windows.front().length);
  return found;
}

class Search {
 public:
  Search(const Series &series, const std::vector<std::vector<std::size_t>> &groups, const SearchOptions &options)
      : series_(series), options_(options), windows_(windows_of(series, options.window)) {
    if (!windows_.empty()) grid_ = grid_of(series, windows_.front().length, options);
    for (const auto &paths : groups) {
      const auto [first, last] = windows_with(paths);
      groups_.push_back({paths, first, last, PeakSearch(last - first, grid_, options.false_alarm)});
    }
  }

  std::vector<Rhythms> run() {
    if (grid_.count > 0) {
      const auto active = [](const Group &group) { return group.search.active(); };
      for (unsigned round = 0; std::any_of(groups_.begin(), groups_.end(), active); ++round) {
        for (std::size_t w = 0; w < windows_.size(); ++w) {
          look(w);
          if (options_.progress)
            options_.progress(round, static_cast<double>(w + 1) / static_cast<double>(windows_.size()));
        }
        for (Group &group : groups_)
          if (group.search.active()) group.search.search();
      }
    }
    std::vector<Rhythms> all;
    for (const Group &group : groups_) all.push_back(result_of(group, windows_));
    return all;
  }

 private:
  /// The range of windows, end excluded, in which any of the paths has a frame.
  std::pair<std::size_t, std::size_t> windows_with(const std::vector<std::size_t> &paths) const {
    std::size_t begin = series_.times.size(), end = 0;
    for (const std::size_t path : paths) {
      begin = std::min(begin, series_.paths[path].frames.front());
      end = std::max(end, series_.paths[path].frames.back() + 1);
    }
    const auto first = std::find_if(windows_.begin(), windows_.end(), [&](const Window &w) { return w.end > begin; });
    const auto last = std::find_if(first, windows_.end(), [&](const Window &w) { return w.begin >= end; });
    return {static_cast<std::size_t>(first - windows_.begin()), static_cast<std::size_t>(last - windows_.begin())};
  }

  /// Fills in the views of window w.
  void look(std::size_t w) {
    const Window &window = windows_[w];
    const auto frames = static_cast<Eigen::Index>(window.end - window.begin);
    Samples samples;
    samples.length = window.length;
    samples.times.resize(frames);
    Eigen::VectorXd weights(frames);
    for (Eigen::Index i = 0; i < frames; ++i) {
      samples.times[i] = series_.times[window.begin + static_cast<std::size_t>(i)] - window.middle;
      weights[i] = taper(samples.times[i], window.length);
    }
    // Columns of all groups together: those of the same weights share what depends on these alone.
    std::vector<std::size_t> columns;
    for (Group &group : groups_) {
      if (!group.active(w)) continue;
      View &view = group.search.view(w - group.first);
      view.members.clear();
      view.missing.clear();
      for (std::size_t m = 0; m < group.paths.size(); ++m)
        if (const auto missing = missing_of(series_.paths[group.paths[m]], window, weights)) {
          view.members.push_back(m);
          view.missing.push_back(*missing);
          columns.push_back(group.paths[m]);
        }
    }
    if (columns.empty()) return;
    fill(samples, columns, window, weights);
    Eigen::Index column = 0;
    for (Group &group : groups_) {
      if (!group.active(w)) continue;
      View &view = group.search.view(w - group.first);
      const auto count = static_cast<Eigen::Index>(view.members.size());
      if (count > 0) take_out_of(view, samples, column, group.search.frequencies(w - group.first));
      column += count;
    }
    const Eigen::MatrixXf power = periodogram(samples, grid_);
    column = 0;
    for (Group &group : groups_) {
      if (!group.active(w)) continue;
      group.search.combine(w - group.first, power, column);
      column += static_cast<Eigen::Index>(group.search.view(w - group.first).members.size());
    }
  }

  /// From the covariance's eigenvalues, the square of the sum over the sum of the squares: 1 for motion along a line, 2
  /// for equal motion in all directions.
  static double dimensions_of(const Samples &samples, Eigen::Index c) {
    const Eigen::VectorXd x = samples.weights.col(c).cwiseProduct(samples.x.col(c));
    const double xx = x.dot(samples.x.col(c)), xy = x.dot(samples.y.col(c)),
                 yy = samples.weights.col(c).cwiseProduct(samples.y.col(c)).dot(samples.y.col(c)),
                 squares = xx * xx + yy * yy + 2 * xy * xy;
    return squares > 0 ? (xx + yy) * (xx + yy) / squares : 1;
  }

  /// `column` is the first one of the view.
  static void take_out_of(View &view, Samples &samples, Eigen::Index column, const std::vector<double> &frequencies) {
    const Eigen::Index end = column + static_cast<Eigen::Index>(view.members.size());
    view.ellipses = take_out(samples, column, end, frequencies);
    view.remainder.clear();
    view.dimensions.clear();
    for (Eigen::Index c = column; c < end; ++c) {
      view.dimensions.push_back(dimensions_of(samples, c));
      const double variance = sum_of_squares(samples, c) / samples.weights.col(c).sum();
      if (variance < still * still) {
        samples.x.col(c).setZero();
        samples.y.col(c).setZero();
      }
      view.remainder.push_back(variance < still * still ? 0 : variance);
    }
    if (view.whole.empty()) view.whole = view.remainder;  // the first round removes only drift
  }

  /// The range of a path's positions in a window.
  static std::pair<std::size_t, std::size_t> places(const Path &path, const Window &window) {
    const auto first = std::lower_bound(path.frames.begin(), path.frames.end(), window.begin),
               last = std::lower_bound(first, path.frames.end(), window.end);
    return {static_cast<std::size_t>(first - path.frames.begin()),
            static_cast<std::size_t>(last - path.frames.begin())};
  }

  /// The share of the window that is missing from a path; none if it is too large.
  std::optional<double> missing_of(const Path &path, const Window &window, const Eigen::VectorXd &weights) const {
    const auto [first, last] = places(path, window);
    double sum = 0;
    for (std::size_t i = first; i < last; ++i) sum += weights[static_cast<Eigen::Index>(path.frames[i] - window.begin)];
    const double coverage = std::min(1.0, sum * series_.interval / (window.length / 2));  // the taper's mean is ½
    if (last - first < std::size_t{min_moments} || coverage < min_coverage) return std::nullopt;
    return 1 - coverage;
  }

  void fill(Samples &samples, const std::vector<std::size_t> &columns, const Window &window,
            const Eigen::VectorXd &weights) const {
    const auto count = static_cast<Eigen::Index>(columns.size());
    samples.x.setZero(weights.size(), count);
    samples.y.setZero(weights.size(), count);
    samples.weights.setZero(weights.size(), count);
    for (Eigen::Index c = 0; c < count; ++c) {
      const Path &path = series_.paths[columns[static_cast<std::size_t>(c)]];
      const auto [first, last] = places(path, window);
      for (std::size_t i = first; i < last; ++i) {
        const auto row = static_cast<Eigen::Index>(path.frames[i] - window.begin);
        samples.x(row, c) = path.positions[i].x - path.start().x;
        samples.y(row, c) = path.positions[i].y - path.start().y;
        samples.weights(row, c) = weights[row];
      }
    }
  }

  const Series &series_;
  const SearchOptions &options_;
  std::vector<Window> windows_;
  Grid grid_;
  std::vector<Group> groups_;
};

}  // namespace

std::string_view usual_name(double frequency) {
  if (frequency >= 0.1 && frequency < 0.6) return "breath";
  if (frequency >= 0.6 && frequency <= 3.5) return "heart";
  return "";
}

bool same_rate(const Rhythm &a, const Rhythm &b, unsigned multiple, double window) {
  std::vector<double> off;
  auto other = b.rates.begin();
  for (const Rate &rate : a.rates) {
    while (other != b.rates.end() && other->time < rate.time) ++other;
    if (other != b.rates.end() && other->time == rate.time)
      off.push_back(std::abs(rate.frequency - multiple * other->frequency));
  }
  const double distance =
      off.empty() ? std::abs(a.frequency - multiple * b.frequency) : score::quantile(std::move(off), 0.5);
  return distance <= std::max(0.5 / window, rate_tolerance * a.frequency);
}

std::vector<Rhythms> find_rhythms(const Series &series, const std::vector<std::vector<std::size_t>> &groups,
                                  const SearchOptions &options) {
  return Search(series, groups, options).run();
}

}  // namespace csd::motion
