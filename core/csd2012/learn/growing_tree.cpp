// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/growing_tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "csd2012/learn/entropy.h"
#include "csd2012/learn/node_samples.h"
#include "csd2012/learn/pixel_pair.h"

namespace csd {

GrowingTree::GrowingTree(int patch_size, const ColourSpace &space, const GrowthOptions &options)
    : set_(patch_size), space_(space), options_(options), nodes_(1) {}

SampleId GrowingTree::add(const cv::Mat &patch, Label label) {
  const SampleId id = set_.add(patch, label);
  if (places_.size() < set_.slots()) {
    places_.resize(set_.slots());
    age_.resize(set_.slots());
  }
  age_[id] = added_++;
  put(id, drop(set_.patch(id)));
  return id;
}

void GrowingTree::replace(SampleId id, const cv::Mat &patch, Label label) {
  // Leaves its leaf only once nothing can fail.
  CV_Assert(set_.contains(id));
  set_.check(patch);
  take(id);
  set_.replace(id, patch, label);
  age_[id] = added_++;
  put(id, drop(set_.patch(id)));
}

void GrowingTree::remove(SampleId id) {
  CV_Assert(set_.contains(id));
  take(id);
  set_.remove(id);
}

bool GrowingTree::misclassified(SampleId id) const {
  CV_Assert(set_.contains(id));
  return leaf_says_feature(nodes_[static_cast<std::size_t>(places_[id].leaf)]) != (set_.label(id) == Label::feature);
}

Label GrowingTree::classify(const cv::Mat &patch) const {
  set_.check(patch);
  const cv::Mat whole = patch.isContinuous() ? patch : patch.clone();
  const Node &leaf = nodes_[static_cast<std::size_t>(drop(whole.data))];
  return leaf_says_feature(leaf) ? Label::feature : Label::not_feature;
}

void GrowingTree::build() {
  nodes_.assign(1, Node{});
  for (SampleId id = 0; id < set_.slots(); ++id)
    if (set_.contains(id)) put(id, 0);
  grow(0);
}

int GrowingTree::retrain(std::span<const SampleId> samples) {
  int replaced = 0;
  std::vector<std::int32_t> refused;  // by the stop rules: not tried again for each of their samples
  for (const SampleId id : samples) {
    if (!set_.contains(id)) continue;
    const std::int32_t at = places_[id].leaf;
    const Node &leaf = nodes_[static_cast<std::size_t>(at)];
    const bool errs = leaf.feature > 0 && leaf.feature < leaf.samples.size();
    if (!errs || std::find(refused.begin(), refused.end(), at) != refused.end()) continue;
    if (grow(at))
      ++replaced;
    else
      refused.push_back(at);
  }
  retrainings_ += static_cast<std::uint64_t>(replaced);
  if (nodes_.size() > std::max(options_.max_nodes, 4 * set_.slots())) {
    auto anew = *this;  // keeps the old tree intact if memory runs out
    anew.build();
    *this = std::move(anew);
  }
  return replaced;
}

std::int32_t GrowingTree::drop(const std::uint8_t *patch) const {
  std::int32_t at = 0;
  for (;;) {
    const Node &n = nodes_[static_cast<std::size_t>(at)];
    if (n.first_child < 0) return at;
    at = n.first_child + child_of(patch[n.test.p1], patch[n.test.p2]);
  }
}

void GrowingTree::put(SampleId id, std::int32_t leaf) {
  Node &n = nodes_[static_cast<std::size_t>(leaf)];
  places_[id] = {leaf, static_cast<std::uint32_t>(n.samples.size())};
  n.samples.push_back(id);
  n.own = nullptr;
  n.feature += set_.label(id) == Label::feature;
}

void GrowingTree::take(SampleId id) {
  const Place place = places_[id];
  Node &n = nodes_[static_cast<std::size_t>(place.leaf)];
  n.feature -= set_.label(id) == Label::feature;
  const SampleId last = n.samples.back();
  n.samples[place.index] = last;
  places_[last].index = place.index;
  n.samples.pop_back();
  n.own = nullptr;
}

// ID3 from one leaf down. False if the leaf was not divided.
bool GrowingTree::grow(std::int32_t leaf) {
  const std::size_t samples = nodes_[static_cast<std::size_t>(leaf)].samples.size();
  const Entropy entropy(samples);
  const LogTable log(samples);
  Random random(options_.seed ^ (++growths_ << 32), options_.stream);
  NodeSamples node_samples;
  PairFinder finder(options_.search);
  std::vector<SampleId> ids;

  std::vector<std::int32_t> open{leaf};  // breadth first
  for (std::size_t next = 0; next < open.size(); ++next) {
    const auto at = static_cast<std::size_t>(open[next]);
    const std::size_t features = nodes_[at].feature;
    const std::size_t others = nodes_[at].samples.size() - features;
    const int depth = nodes_[at].depth;
    if (features == 0 || others == 0 || features + others < options_.stop.min_samples ||
        depth >= options_.stop.max_depth)
      continue;

    ids = nodes_[at].samples;
    const auto middle =
        std::partition(ids.begin(), ids.end(), [&](SampleId i) { return set_.label(i) == Label::feature; });
    const auto split = static_cast<std::size_t>(middle - ids.begin());
    node_samples.gather(set_, std::span(ids).first(split), std::span(ids).subspan(split));
    const PairChoice choice = finder.find(node_samples, entropy, log, random);
    if (entropy.of(features, others) - choice.entropy < options_.stop.min_gain) continue;

    const auto first_child = static_cast<std::int32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 3);
    Node &n = nodes_[at];
    n.test = choice.pair;
    n.first_child = first_child;
    n.feature = 0;
    n.samples = {};
    n.own = nullptr;
    const SplitCounts &c = choice.counts;
    const std::array<std::size_t, 3> sizes{c.feature_greater + c.other_greater, c.feature_equal + c.other_equal,
                                           c.feature_less + c.other_less};
    for (std::size_t k = 0; k < 3; ++k) {
      Node &child = nodes_[static_cast<std::size_t>(first_child) + k];
      child.depth = depth + 1;
      child.samples.reserve(sizes[k]);
      open.push_back(first_child + static_cast<std::int32_t>(k));
    }
    for (const SampleId id : ids) {
      const std::uint8_t *patch = set_.patch(id);
      put(id, first_child + child_of(patch[choice.pair.p1], patch[choice.pair.p2]));
    }
  }
  return open.size() > 1;
}

std::shared_ptr<const LeafPatches> GrowingTree::own_patches(const Node &leaf) const {
  std::vector<SampleId> ids;
  for (const SampleId id : leaf.samples)
    if (set_.label(id) == Label::feature) ids.push_back(id);
  const auto newest = static_cast<std::ptrdiff_t>(std::min(options_.own_patches, ids.size()));
  std::partial_sort(ids.begin(), ids.begin() + newest, ids.end(),
                    [&](SampleId a, SampleId b) { return age_[a] > age_[b]; });
  auto own = std::make_shared<LeafPatches>(static_cast<std::size_t>(set_.pixels()));
  for (std::ptrdiff_t k = 0; k < newest; ++k) own->add(set_.patch(ids[static_cast<std::size_t>(k)]));
  return own;
}

std::shared_ptr<const Tree> GrowingTree::publish() const {
  std::vector<Tree::Node> table;
  Tree::LeavesPatches own;
  table.reserve(nodes_.size());
  std::vector<std::int32_t> order{0};  // breadth first: table index -> own index
  order.reserve(nodes_.size());
  int depth = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Node &n = nodes_[static_cast<std::size_t>(order[i])];
    Tree::Node out;
    if (n.first_child < 0) {
      out.first_child = static_cast<std::int32_t>(i) - 1;
      out.feature = n.feature;
      out.not_feature = static_cast<std::uint32_t>(n.samples.size()) - n.feature;
      depth = std::max(depth, n.depth);
    } else {
      out.p1 = n.test.p1;
      out.p2 = n.test.p2;
      out.first_child = static_cast<std::int32_t>(order.size());
      for (std::int32_t k = 0; k < 3; ++k) order.push_back(n.first_child + k);
    }
    table.push_back(out);
    if (options_.own_patches == 0) continue;
    // Few leaves change in a frame: the others share theirs with the trees published before.
    const bool shows = n.first_child < 0 && leaf_says_feature(n);
    if (shows && !n.own) n.own = own_patches(n);
    own.push_back(shows ? n.own : nullptr);
  }
  return std::make_shared<const Tree>(set_.patch_size(), space_, std::move(table), depth, std::move(own));
}

}  // namespace csd
