// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pixel_ranking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace csd {

namespace {

constexpr std::size_t max_bins = std::size_t{1} << histogram_sizes[0].bits;
using Histogram = std::array<std::uint32_t, max_bins>;

/// Four tables in turn: incrementing the same bin twice in a row would wait for the first store.
void histogram(const std::uint8_t *values, std::size_t n, int shift, Histogram &h) {
  if (n < 256) {  // below, summing four tables costs more than it saves
    h.fill(0);
    for (std::size_t i = 0; i < n; ++i) ++h[static_cast<std::size_t>(values[i] >> shift)];
    return;
  }
  std::array<Histogram, 4> part{};
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    ++part[0][static_cast<std::size_t>(values[i] >> shift)];
    ++part[1][static_cast<std::size_t>(values[i + 1] >> shift)];
    ++part[2][static_cast<std::size_t>(values[i + 2] >> shift)];
    ++part[3][static_cast<std::size_t>(values[i + 3] >> shift)];
  }
  for (; i < n; ++i) ++part[0][static_cast<std::size_t>(values[i] >> shift)];
  for (std::size_t b = 0; b < max_bins; ++b) h[b] = part[0][b] + part[1][b] + part[2][b] + part[3][b];
}

}  // namespace

LogTable::LogTable(std::size_t max_count) : log_(max_count + 1), floor_(std::log(likelihood_floor)) {
  log_[0] = -1e30;
  for (std::size_t k = 2; k <= max_count; ++k) log_[k] = std::log(static_cast<double>(k));
}

int histogram_bits(std::size_t n) {
  return std::find_if(histogram_sizes.begin(), histogram_sizes.end(),
                      [n](const HistogramSize &size) { return n >= size.min_samples; })
      ->bits;
}

double variance_ratio(std::span<const std::uint32_t> t, std::uint32_t features, std::span<const std::uint32_t> f,
                      std::uint32_t others, const LogTable &log) {
  if (features == 0 || others == 0) return 0;
  const double floor = log.floor();
  const double log_features = log[features], log_others = log[others];
  // Σ a·L² and Σ a·L for a = t and a = f, in counts; those for (t+f)/2 are their means.
  double t2 = 0, t1 = 0, f2 = 0, f1 = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    // No branch on empty bins: in a small node they are unpredictable.
    const double lt = std::max(log[t[i]] - log_features, floor);
    const double lf = std::max(log[f[i]] - log_others, floor);
    const double l = lt - lf;  // Eq. 4
    const double nt = t[i], nf = f[i];
    t1 += nt * l;
    t2 += nt * l * l;
    f1 += nf * l;
    f2 += nf * l * l;
  }
  t1 /= features;
  t2 /= features;
  f1 /= others;
  f2 /= others;
  const double mean = (t1 + f1) / 2;
  const double within = (t2 - t1 * t1) + (f2 - f1 * f1);  // Eq. 6
  return ((t2 + f2) / 2 - mean * mean) / (std::max(within, 0.0) + variance_epsilon);
}

void variance_ratios(const NodeSamples &node, const LogTable &log, std::vector<double> &v) {
  v.resize(node.pixels());
  const int bits = histogram_bits(node.size());
  const std::size_t bins = std::size_t{1} << bits;
  Histogram t, f;
  for (std::size_t p = 0; p < node.pixels(); ++p) {
    histogram(node.feature_row(p), node.features(), 8 - bits, t);
    histogram(node.other_row(p), node.others(), 8 - bits, f);
    v[p] = variance_ratio({t.data(), bins}, static_cast<std::uint32_t>(node.features()), {f.data(), bins},
                          static_cast<std::uint32_t>(node.others()), log);
  }
}

void rank_pixels(std::span<const double> v, std::size_t count, std::vector<std::uint16_t> &ranked) {
  ranked.resize(v.size());
  std::iota(ranked.begin(), ranked.end(), std::uint16_t{0});
  count = std::min(count, v.size());
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count), ranked.end(),
                    [&](std::uint16_t a, std::uint16_t b) { return v[a] != v[b] ? v[a] > v[b] : a < b; });
  ranked.resize(count);
}

}  // namespace csd
