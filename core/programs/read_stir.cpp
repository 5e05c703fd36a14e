// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_stir.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace csd::programs {
namespace {

cv::Mat picture(const std::filesystem::path &file) {
  if (!std::filesystem::exists(file)) throw score::InputError(file, 0, "is not there: this is no folder of STIR");
  cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw score::InputError(file, 0, "is no picture that can be read");
  return image;
}

std::vector<cv::Point2d> centres(const cv::Mat &segmentation, const std::filesystem::path &file) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(segmentation, contours, cv::RETR_TREE, cv::CHAIN_APPROX_SIMPLE);
  if (contours.empty()) throw score::InputError(file, 0, "shows no point");
  std::vector<cv::Point2d> points;
  for (const auto &contour : contours) {
    const cv::Rect box = cv::boundingRect(contour);
    points.emplace_back(box.x + box.width / 2, box.y + box.height / 2);
  }
  return points;
}

}  // namespace

score::Truth read_stir(const std::string &folder) {
  std::filesystem::path base = folder;
  if (std::filesystem::is_directory(base / "segmentation")) base /= "segmentation";
  const std::filesystem::path start_file = base / "icgstartseg.png", end_file = base / "icgendseg.png";
  const cv::Mat start = picture(start_file), end = picture(end_file);
  if (start.size() != end.size())
    throw score::InputError(end_file, 0, "is not of the size of " + start_file.filename().string());
  score::Truth truth;
  truth.file = folder;
  truth.width = start.cols;
  truth.height = start.rows;
  truth.identified = false;
  truth.end_points = centres(end, end_file);
  score::TruthFrame first;
  for (const cv::Point2d &point : centres(start, start_file)) {
    truth.ids.push_back(static_cast<FeatureId>(first.points.size()));
    first.points.push_back({score::Presence::visible, point});
  }
  truth.frames.push_back(std::move(first));
  return truth;
}

}  // namespace csd::programs
