// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/sample_set.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

cv::Mat filled(int v) {
  return {3, 3, CV_8UC1, cv::Scalar(v)};
}

TEST(SampleSet, SlotsAreStableAndReused) {
  SampleSet set(3);
  EXPECT_EQ(set.row_bytes(), 16u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(set.add(filled(i), i % 2 ? Label::feature : Label::not_feature), SampleId(i));
  set.remove(7);
  EXPECT_FALSE(set.contains(7));
  EXPECT_EQ(set.size(), 49u);
  set.replace(9, filled(200), Label::not_feature);
  EXPECT_EQ(set.add(filled(100), Label::not_feature), 7u);
  EXPECT_EQ(set.slots(), 50u);
  for (SampleId i = 0; i < 50; ++i) {
    EXPECT_EQ(set.patch(i)[0], i == 7 ? 100 : i == 9 ? 200 : i);
    EXPECT_EQ(set.patch(i)[8], set.patch(i)[0]);
    EXPECT_EQ(set.patch(i)[9], 0);
    EXPECT_EQ(set.label(i), i % 2 && i != 7 && i != 9 ? Label::feature : Label::not_feature);
  }
}

TEST(SampleSet, AcceptsRowsOfALargerPicture) {
  cv::Mat picture(8, 8, CV_8UC1);
  for (int i = 0; i < 64; ++i) picture.data[i] = static_cast<std::uint8_t>(i);
  SampleSet set(3);
  const SampleId id = set.add(picture(cv::Rect(2, 4, 3, 3)), Label::feature);
  const int expected[9] = {34, 35, 36, 42, 43, 44, 50, 51, 52};
  for (int p = 0; p < 9; ++p) EXPECT_EQ(set.patch(id)[p], expected[p]);
}

}  // namespace
}  // namespace csd
