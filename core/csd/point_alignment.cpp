// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/point_alignment.h"

#include <algorithm>
#include <cmath>

#include "csd/memory.h"

namespace csd {
namespace {

/// The anchor's inner disc, for a tool or its shadow nearby, which covers the rest. `share`: the disc's share of the
/// patch.
AnchorLevel inner_disc(const AnchorLevel &anchor, double reach, double &share) {
  auto inner = anchor;
  int pixels = 0;
  for (int v = -PatchPlane::radius; v <= PatchPlane::radius; ++v)
    for (int u = -PatchPlane::radius; u <= PatchPlane::radius; ++u)
      if (u * u + v * v > reach * reach)
        inner.weight.at(u, v) = inner.shown.at(u, v) = 0;
      else
        ++pixels;
  share = pixels / static_cast<double>(PatchPlane::pixels);
  return inner;
}

AlignPrior prior_of(const CsdFrame &frame) {
  AlignPrior prior;
  prior.shape = frame.tuning.shape_deviation * std::sqrt(frame.steps);
  return prior;
}

}  // namespace

PointAlignment align_point(const CsdFrame &frame, const Memory &memory, const AlignmentPlan &plan) {
  const auto &tuning = frame.tuning;
  PointAlignment out;
  const int finest = memory.finest_level(plan.start.scale() / frame.patch, tuning);
  auto prior = prior_of(frame);
  prior.noise = memory.usual_noise();
  if (plan.position_sd > 0) prior.position = cv::Matx22d::eye() * (1 / (plan.position_sd * plan.position_sd));
  auto at = plan.start;
  bool coarse_seen = false;
  for (int level = std::min(finest + plan.levels, Anchor::coarsest); level >= finest; --level) {
    if (!memory.anchor().has(level)) continue;
    const auto &whole = memory.anchor().level(level);
    const bool last = level == finest, shears = last && !plan.inner && tuning.affine != 0;
    const auto model = shears ? AlignModel::affine : AlignModel::similarity;
    const auto align_with = [&](const AnchorLevel &anchor) {
      return align(frame.pyramid, frame.weights, anchor, level, at, prior, model,
                   last ? plan.precision : tuning.coarse_precision);
    };
    double share = 1;
    auto seen = plan.inner ? align_with(inner_disc(whole, tuning.inner_reach, share)) : align_with(whole);
    seen.unmasked /= share;
    if (last) {
      out.fine = seen;
      if (!coarse_seen) out.zncc_coarse = seen.zncc;
    } else if (seen.usable) {
      at = seen.state;
      prior.position += tuning.coarse_information * seen.information;
      out.zncc_coarse = seen.zncc;
      out.gain_coarse = seen.gain;
      coarse_seen = true;
    }
  }
  return out;
}

void align_coarser(const CsdFrame &frame, const Memory &memory, PointAlignment &alignment) {
  const int level = memory.finest_level(alignment.fine.state.scale() / frame.patch, frame.tuning) + 1;
  if (level > Anchor::coarsest || !memory.anchor().has(level)) return;
  const auto seen = align(frame.pyramid, frame.weights, memory.anchor().level(level), level, alignment.fine.state,
                          prior_of(frame), AlignModel::similarity, frame.tuning.coarse_precision);
  if (seen.usable) alignment.gain_coarse = seen.gain;
}

}  // namespace csd
