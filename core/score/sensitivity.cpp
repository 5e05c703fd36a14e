// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/sensitivity.h"

#include "score/quantile.h"

namespace csd::score {
namespace {

double ratio(std::uint64_t part, std::uint64_t whole) {
  return whole ? static_cast<double>(part) / static_cast<double>(whole) : unknown;
}

}  // namespace

Counts &Counts::operator+=(const Counts &other) {
  correct += other.correct;
  wrong += other.wrong;
  missed += other.missed;
  on_hidden += other.on_hidden;
  quiet += other.quiet;
  return *this;
}

double Counts::sensitivity() const {
  return ratio(correct, correct + wrong + missed);
}
double Counts::k() const {
  return ratio(wrong + on_hidden, correct + wrong + on_hidden);
}
double Counts::k_visible() const {
  return ratio(wrong, correct + wrong);
}
double Counts::hidden_claimed() const {
  return ratio(on_hidden, on_hidden + quiet);
}

Outcomes::Outcomes(const Clip &clip, double tau) : features(clip.ids.size()), moments(clip.moments.size()) {
  for (const Sample &sample : clip.samples) {
    const bool claim = sample.labelled() && sample.claimed;
    labelled.push_back(sample.labelled());
    visible.push_back(sample.visible());
    claimed.push_back(claim);
    correct.push_back(claim && sample.visible() && sample.distance() <= tau);
  }
}

std::vector<Counts> count_frames(const Outcomes &outcomes) {
  std::vector<Counts> frames(outcomes.moments);
  for (std::size_t i = 0; i < outcomes.labelled.size(); ++i) {
    if (!outcomes.labelled[i]) continue;
    Counts &frame = frames[i % outcomes.moments];
    if (outcomes.visible[i])
      ++(outcomes.correct[i] ? frame.correct : outcomes.claimed[i] ? frame.wrong : frame.missed);
    else
      ++(outcomes.claimed[i] ? frame.on_hidden : frame.quiet);
  }
  return frames;
}

PaperScore paper_score(std::span<const Counts> frames) {
  std::vector<double> sensitivity, k, k_visible;
  for (const Counts &frame : frames) {
    sensitivity.push_back(frame.sensitivity());
    k.push_back(frame.k());
    k_visible.push_back(frame.k_visible());
  }
  return {mean_of_known(sensitivity), mean_of_known(k), mean_of_known(k_visible)};
}

PaperScore paper_score(const Outcomes &outcomes, std::span<const std::uint32_t> weights) {
  const std::size_t n = outcomes.moments;
  std::vector<std::uint32_t> visible(n), claimed(n), correct(n);
  const auto add = [n](std::vector<std::uint32_t> &sums, const std::uint8_t *row, std::uint32_t weight) {
    std::uint32_t *const sum = sums.data();
    for (std::size_t t = 0; t < n; ++t) sum[t] += weight * row[t];
  };
  for (std::size_t f = 0; f < outcomes.features; ++f) {
    if (!weights[f]) continue;
    add(visible, &outcomes.visible[f * n], weights[f]);
    add(claimed, &outcomes.claimed[f * n], weights[f]);
    add(correct, &outcomes.correct[f * n], weights[f]);
  }
  double sensitivity = 0, k = 0;
  std::size_t with_visible = 0, with_claims = 0;
  for (std::size_t t = 0; t < n; ++t) {
    if (visible[t]) {
      sensitivity += static_cast<double>(correct[t]) / visible[t];
      ++with_visible;
    }
    if (claimed[t]) {
      k += static_cast<double>(claimed[t] - correct[t]) / claimed[t];
      ++with_claims;
    }
  }
  return {with_visible ? sensitivity / static_cast<double>(with_visible) : unknown,
          with_claims ? k / static_cast<double>(with_claims) : unknown, unknown};
}

}  // namespace csd::score
