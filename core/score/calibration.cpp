// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/calibration.h"

namespace csd::score {

void Reliability::add(const Clip &clip, double tau) {
  for (const Sample &sample : clip.samples) {
    if (!sample.labelled() || !sample.reported) continue;
    Bin &bin = bins[std::min(static_cast<std::size_t>(sample.confidence * confidence_bins), confidence_bins - 1)];
    ++bin.reports;
    bin.true_ones += sample.visible() && sample.distance() <= tau;
    bin.confidence_sum += sample.confidence;
  }
}

double Reliability::ece() const {
  std::uint64_t reports = 0;
  double error = 0;
  for (const Bin &bin : bins) {
    reports += bin.reports;
    error += std::abs(bin.confidence_sum - static_cast<double>(bin.true_ones));
  }
  return reports ? error / static_cast<double>(reports) : unknown;
}

}  // namespace csd::score
