// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/errors.h"

namespace csd::score {

std::vector<double> claimed_errors(const Clip &clip, std::size_t begin, std::size_t end) {
  std::vector<double> errors;
  for (std::size_t f = 0; f < clip.ids.size(); ++f)
    for (std::size_t t = begin; t < end; ++t) {
      const Sample &sample = clip.at(f, t);
      if (sample.visible() && sample.claimed) errors.push_back(sample.distance());
    }
  return errors;
}

std::vector<double> claimed_errors(const Clip &clip) {
  return claimed_errors(clip, 0, clip.moments.size());
}

DriftErrors drift_errors(const Clip &clip) {
  const std::size_t count = clip.moments.size(), fifth = (count + 4) / 5;
  return {claimed_errors(clip, 0, fifth), claimed_errors(clip, count - fifth, count)};
}

}  // namespace csd::score
