// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/peaks.h"

#include <algorithm>
#include <cmath>

#include "motion/significance.h"
#include "score/quantile.h"

namespace csd::motion {
namespace {

constexpr double correlated = 1.5 * oversampling;  // places: Hann's noise bandwidth
constexpr double own_share = 0.2;   // of its frequency, on both sides: a rhythm's own band, because rates vary
constexpr double near_share = 0.3;  // peaks this near are its modulation, not another rhythm
constexpr double own_width = 2;     // and at least this many 1/window: Hann's peak
constexpr double group_quantile = 0.75;
constexpr std::size_t max_peaks = 8;
constexpr double min_at_once = 0.1;      // of the greatest peak; smaller ones wait until that has been removed
constexpr double share_in_a_step = 0.1;  // of its rate: the most that a rhythm changes from one window to the next
constexpr double clear = 0.01;           // false-alarm probability of a rate in one window
constexpr double worth_a_look = 300;     // times the reported false-alarm probability, for candidates

/// The peak's position between grid frequencies, from a parabola through the logarithms: a Hann window's peak is nearly
/// a Gaussian. `at` is neither the first place nor the last.
double refined(const std::vector<double> &spectrum, std::size_t at) {
  const double l = spectrum[at - 1], m = spectrum[at], r = spectrum[at + 1];
  if (!(l > 0) || !(m > 0) || !(r > 0)) return static_cast<double>(at);
  const double below = std::log(l), top = std::log(m), above = std::log(r), bend = below - 2 * top + above;
  return static_cast<double>(at) + (bend < 0 ? std::clamp(0.5 * (below - above) / bend, -0.5, 0.5) : 0);
}

/// The positions of local maxima, the highest first.
std::vector<std::size_t> candidates(const std::vector<double> &mean) {
  std::vector<std::size_t> all;
  for (std::size_t i = 1; i + 1 < mean.size(); ++i)
    if (mean[i] > mean[i - 1] && mean[i] >= mean[i + 1]) all.push_back(i);
  std::sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) { return mean[a] > mean[b]; });
  return all;
}

}  // namespace

std::vector<double> PeakSearch::frequencies(std::size_t window) const {
  std::vector<double> all;
  for (const Peak &peak : peaks_) all.push_back(peak.by_window[window]);
  return all;
}

void PeakSearch::combine(std::size_t window, const Eigen::MatrixXf &periodogram, Eigen::Index row) {
  View &view = views_[window];
  view.spectrum.assign(view.members.empty() ? 0 : grid_.count, 0);
  std::vector<double> values(view.members.size()), shares;
  for (std::size_t m = 0; m < view.members.size(); ++m)
    shares.push_back(view.whole[m] > 0 ? view.remainder[m] / view.whole[m] : 0);
  for (std::size_t i = 0; i < view.spectrum.size(); ++i) {
    for (std::size_t m = 0; m < values.size(); ++m)
      values[m] = shares[m] * periodogram(row + static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(i));
    view.spectrum[i] = static_cast<float>(values.size() == 1 ? values[0] : score::quantile(values, group_quantile));
  }
}

void PeakSearch::search() {
  active_ = false;
  // Each window of a noise coordinate adds two degrees of freedom. Features move together, so they add none.
  dof_ = windows_ = 0;
  for (const View &view : views_) {
    if (view.spectrum.empty()) continue;
    dof_ += 2 * score::quantile(view.dimensions, 0.5);
    ++windows_;
  }
  if (dof_ == 0) return;
  const auto mean = mean_spectrum();
  judge(mean);
  propose(mean);
}

std::vector<double> PeakSearch::mean_spectrum() const {
  std::vector<double> mean(grid_.count, 0);
  std::size_t count = 0;
  for (const View &view : views_) {
    if (view.spectrum.empty()) continue;
    ++count;
    for (std::size_t i = 0; i < grid_.count; ++i) mean[i] += view.spectrum[i];
  }
  if (count == 0) return {};
  for (double &value : mean) value /= static_cast<double>(count);
  return mean;
}

/// Compares each peak, fitted jointly with all others, with what remains. Otherwise the sidelobes from gaps would look
/// like noise around the peak, and those of other peaks like a peak.
void PeakSearch::judge(const std::vector<double> &remaining) {
  for (std::size_t p = 0; p < peaks_.size(); ++p) {
    Peak &peak = peaks_[p];
    if (peak.confirmed) continue;
    const Background background = background_at(remaining, grid_.first, peak.at, own(peak.at), correlated, dof_);
    peak.false_alarm = motion::false_alarm(fitted_power(p), background, dof_, static_cast<double>(grid_.count));
    peak.confirmed = peak.false_alarm <= false_alarm_;
    if (peak.confirmed) continue;
    rejected_.push_back(peak.frequency);
    active_ = true;
  }
  std::erase_if(peaks_, [](const Peak &peak) { return !peak.confirmed; });
}

/// The power at the peak in mean_spectrum() if there were nothing else.
double PeakSearch::fitted_power(std::size_t peak) const {
  double sum = 0, count = 0;
  for (const View &view : views_) {
    if (view.spectrum.empty()) continue;
    std::vector<double> shares;
    for (std::size_t m = 0; m < view.members.size(); ++m)
      shares.push_back(view.whole[m] > 0 ? std::min(1.0, view.ellipses[peak][m].variance() / view.whole[m]) : 0);
    sum += score::quantile(std::move(shares), group_quantile);
    ++count;
  }
  return sum / count;
}

/// Upper bound of a peak's sidelobes from gaps: if the share m is missing, the greatest has m/(1 − m) of its amplitude.
/// Those of its mirror image at the negative frequency may add up with them.
double PeakSearch::sidelobes() const {
  double sum = 0, count = 0;
  for (const View &view : views_)
    for (const double missing : view.missing) {
      sum += missing;
      ++count;
    }
  const double missing = count > 0 ? sum / count : 0, side = missing / (1 - missing);
  return 2 * side * side;
}

void PeakSearch::propose(const std::vector<double> &mean) {
  const double at_once = std::max(min_at_once, sidelobes());
  double greatest = 0;
  for (const std::size_t at : candidates(mean)) {
    if (peaks_.size() + rejected_.size() >= max_peaks) return;
    if (mean[at] < at_once * greatest || taken(grid_.frequency(static_cast<double>(at)))) continue;
    const Background background = background_at(mean, grid_.first, at, own(at), correlated, dof_);
    if (!(motion::false_alarm(mean[at], background, dof_,
                              static_cast<double>(grid_.count) / (worth_a_look * false_alarm_)) < 1))
      continue;
    greatest = std::max(greatest, mean[at]);
    if (add(mean, at))
      active_ = true;
    else
      rejected_.push_back(grid_.frequency(static_cast<double>(at)));
  }
}

/// How many places on each side belong to a peak.
std::size_t PeakSearch::own(std::size_t at) const {
  return static_cast<std::size_t>(
      std::max(own_width * oversampling, own_share * static_cast<double>(grid_.first + at)));
}

bool PeakSearch::taken(double frequency) const {
  const double width = own_width * oversampling * grid_.step;
  const auto near = [&](double other, double reach) { return std::abs(frequency - other) <= reach; };
  return std::any_of(
             peaks_.begin(), peaks_.end(),
             [&](const Peak &peak) { return near(peak.frequency, std::max(width, near_share * peak.frequency)); }) ||
         std::any_of(rejected_.begin(), rejected_.end(), [&](double other) { return near(other, width); });
}

/// Returns false if the peak is already known.
bool PeakSearch::add(const std::vector<double> &mean, std::size_t at) {
  Peak peak;
  peak.frequency = grid_.frequency(refined(mean, at));
  peak.at = at;
  peak.by_window.assign(views_.size(), peak.frequency);
  peak.stands_out.assign(views_.size(), false);
  // Tracks the rate from the clearest window towards both ends, because it may change over an hour.
  std::size_t clearest = 0;
  double least = 1;
  for (std::size_t w = 0; w < views_.size(); ++w)
    if (const Seen seen = look_near(views_[w].spectrum, peak.frequency, own_share); seen.false_alarm < least) {
      least = seen.false_alarm;
      clearest = w;
    }
  follow(peak, clearest, 1);
  follow(peak, clearest, -1);
  std::vector<double> rates;
  for (std::size_t w = 0; w < views_.size(); ++w)
    if (peak.stands_out[w]) rates.push_back(peak.by_window[w]);
  if (rates.size() >= 3) peak.frequency = score::quantile(std::move(rates), 0.5);
  if (known_already(peak)) return false;
  peaks_.push_back(std::move(peak));
  return true;
}

/// A rate that varies a lot gives several peaks of the mean spectrum, which one path through the windows joins.
bool PeakSearch::known_already(const Peak &peak) const {
  return std::any_of(peaks_.begin(), peaks_.end(), [&](const Peak &other) {
    std::size_t same = 0, all = 0;
    for (std::size_t w = 0; w < views_.size(); ++w)
      if (peak.stands_out[w]) {
        ++all;
        same += std::abs(peak.by_window[w] - other.by_window[w]) <= grid_.step;
      }
    return 2 * same > all;
  });
}

/// The greatest power within `share` of a frequency.
PeakSearch::Seen PeakSearch::look_near(const std::vector<float> &spectrum, double frequency, double share) const {
  Seen seen;
  if (spectrum.empty()) return seen;
  const double reach = std::max(share * frequency, own_width * oversampling * grid_.step) / grid_.step,
               middle = frequency / grid_.step - static_cast<double>(grid_.first),
               last = static_cast<double>(grid_.count) - 2;
  const auto begin = static_cast<std::size_t>(std::clamp(middle - reach, 1.0, last)),
             end = static_cast<std::size_t>(std::clamp(middle + reach, 1.0, last)) + 1;
  const auto first = spectrum.begin();
  const auto best = static_cast<std::size_t>(
      std::max_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end)) - first);
  if (spectrum[best] < spectrum[best - 1] || spectrum[best] < spectrum[best + 1]) return seen;
  const std::vector<double> whole(spectrum.begin(), spectrum.end());
  const Background background = background_at(whole, grid_.first, best, own(best), correlated, dof_ / windows_);
  seen.false_alarm = motion::false_alarm(whole[best], background, dof_ / windows_, static_cast<double>(end - begin));
  seen.frequency = grid_.frequency(refined(whole, best));
  return seen;
}

void PeakSearch::follow(Peak &peak, std::size_t from, int step) const {
  double rate = peak.frequency;
  for (auto w = static_cast<std::ptrdiff_t>(from); w >= 0 && w < static_cast<std::ptrdiff_t>(views_.size());
       w += step) {
    const auto at = static_cast<std::size_t>(w);
    const double share = at == from ? own_share : share_in_a_step;
    const Seen seen = look_near(views_[at].spectrum, rate, share);
    if (seen.false_alarm < clear) {
      rate = seen.frequency;
      peak.stands_out[at] = true;
    }
    peak.by_window[at] = rate;
  }
}

}  // namespace csd::motion
