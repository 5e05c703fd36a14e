// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_stir.h"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "programs/file.h"
#include "programs/read_input.h"

namespace csd::programs {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAre;

void draw(const std::filesystem::path &file, const std::vector<cv::Rect> &tattoos, cv::Size size = {1280, 1024}) {
  cv::Mat image = cv::Mat::zeros(size, CV_8UC3);
  for (const cv::Rect &tattoo : tattoos) cv::rectangle(image, tattoo, cv::Scalar::all(255), cv::FILLED);
  std::filesystem::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file, image));
}

TEST(Stir, PointsAreTheMiddlesOfBoundingBoxes) {
  const TestFolder folder;
  draw(folder / "seq00/segmentation/icgstartseg.png", {{100, 200, 10, 5}, {600, 50, 7, 7}});
  draw(folder / "seq00/segmentation/icgendseg.png", {{110, 200, 10, 5}, {620, 50, 7, 7}, {900, 900, 1, 1}});
  for (const char *const given : {"seq00", "seq00/segmentation"}) {
    std::vector<std::string> notes;
    const auto truth = std::get<score::Truth>(read_input(folder / given, notes));
    EXPECT_FALSE(truth.identified);
    EXPECT_EQ(truth.width, 1280);
    EXPECT_EQ(truth.height, 1024);
    EXPECT_EQ(truth.ids.size(), 2u);
    ASSERT_EQ(truth.frames.size(), 1u);
    std::vector<cv::Point2d> starts;
    for (const auto &point : truth.frames[0].points) starts.push_back(point.position);
    EXPECT_THAT(starts, UnorderedElementsAre(cv::Point2d(105, 202), cv::Point2d(603, 53)));
    EXPECT_THAT(truth.end_points,
                UnorderedElementsAre(cv::Point2d(115, 202), cv::Point2d(623, 53), cv::Point2d(900, 900)));
  }
}

TEST(Stir, NamesEachDefect) {
  const TestFolder folder;
  const auto error = [&] { return input_error(folder / "", [&] { read_stir(folder / ""); }); };
  draw(folder / "icgstartseg.png", {{100, 200, 10, 5}});
  EXPECT_EQ(error(), "icgendseg.png: is not there: this is no folder of STIR");
  folder.write("icgendseg.png", "no picture");
  EXPECT_EQ(error(), "icgendseg.png: is no picture that can be read");
  draw(folder / "icgendseg.png", {});
  EXPECT_EQ(error(), "icgendseg.png: shows no point");
  draw(folder / "icgendseg.png", {{100, 200, 10, 5}}, {640, 512});
  EXPECT_EQ(error(), "icgendseg.png: is not of the size of icgstartseg.png");
}

}  // namespace
}  // namespace csd::programs
