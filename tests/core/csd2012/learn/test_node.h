// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "base/random.h"
#include "csd2012/learn/node_samples.h"

namespace csd {

/// Patches of 5 × 5 pixels, gathered as one node.
struct TestNode {
  SampleSet set{5};
  std::vector<SampleId> features, others;
  NodeSamples node;

  void add(const cv::Mat &m, bool feature) {
    (feature ? features : others).push_back(set.add(m, feature ? Label::feature : Label::not_feature));
  }
  void random(int n, std::uint64_t seed, unsigned levels = 256) {
    Random r(seed);
    for (int i = 0; i < n; ++i) {
      cv::Mat m(5, 5, CV_8UC1);
      for (int p = 0; p < 25; ++p) m.data[p] = static_cast<std::uint8_t>(r.below(levels));
      add(m, i % 3 == 0);
    }
    node.gather(set, features, others);
  }
};

}  // namespace csd
