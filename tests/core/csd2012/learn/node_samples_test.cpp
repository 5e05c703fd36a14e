// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/node_samples.h"

#include <gtest/gtest.h>

#include <array>
#include <span>

#include "core/simd_targets.h"
#include "test_node.h"

namespace csd {
namespace {

void expect_turned(const TestNode &f, std::span<const SampleId> features, std::span<const SampleId> others) {
  ASSERT_EQ(f.node.pixels(), 25u);
  ASSERT_EQ(f.node.features(), features.size());
  ASSERT_EQ(f.node.others(), others.size());
  EXPECT_EQ(f.node.size(), features.size() + others.size());
  for (std::size_t p = 0; p < 25; ++p) {
    for (std::size_t i = 0; i < f.node.feature_bytes(); ++i)
      EXPECT_EQ(f.node.feature_row(p)[i], i < features.size() ? f.set.patch(features[i])[p] : 0);
    for (std::size_t i = 0; i < f.node.other_bytes(); ++i)
      EXPECT_EQ(f.node.other_row(p)[i], i < others.size() ? f.set.patch(others[i])[p] : 0);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(f.node.feature_row(p)) % 64, 0u);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(f.node.other_row(p)) % 64, 0u);
  }
}

TEST(NodeSamples, TransposesThePatchesFeaturesFirst) {
  TestNode f;
  f.random(103, 1);
  EXPECT_EQ(f.node.feature_bytes(), 64u);  // 35 of them
  EXPECT_EQ(f.node.other_bytes(), 128u);   // 68
  expect_turned(f, f.features, f.others);
}

// 150 and 300 samples are rows of 192 and 320 bytes, 512 together. The next, smaller set reuses their memory.
TEST(NodeSamples, FewerSamplesAfterMoreLeaveNothingBehind) {
  TestNode f;
  f.random(450, 2);
  expect_turned(f, f.features, f.others);
  const std::span features(f.features), others(f.others);
  f.node.gather(f.set, features.subspan(140, 2), others.first(17));
  expect_turned(f, features.subspan(140, 2), others.first(17));
  f.node.gather(f.set, {}, others.first(1));
  EXPECT_EQ(f.node.feature_bytes(), 0u);
  expect_turned(f, {}, others.first(1));
}

void transposes_as_the_plain_twin() {
  Random random(3);
  std::array<std::array<std::uint8_t, 48>, 16> rows;
  std::array<const std::uint8_t *, 16> pointers;
  for (std::size_t i = 0; i < 16; ++i) {
    for (auto &x : rows[i]) x = static_cast<std::uint8_t>(random.below(256));
    pointers[i] = rows[i].data();
  }
  for (std::size_t count = 0; count <= 16; ++count) {
    alignas(16) std::array<std::uint8_t, 48 * 32> simd{}, plain{};
    transpose16(pointers.data(), count, 48, simd.data(), 32);
    transpose16_scalar(pointers.data(), count, 48, plain.data(), 32);
    EXPECT_EQ(simd, plain) << count;
    for (std::size_t p = 0; p < 48; ++p)
      for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(plain[p * 32 + i], i < count ? rows[i][p] : 0);
  }
}

TEST(NodeSamples, TransposesAsItsPlainTwin) {
  test::on_all_targets(transposes_as_the_plain_twin);
}

}  // namespace
}  // namespace csd
