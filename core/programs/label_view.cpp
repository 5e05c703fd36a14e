// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/label_view.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace csd::programs {
namespace {

constexpr int loupe_side = 240, loupe_zoom = 8, look_zoom = 4;
constexpr int text_height = 28, text_width = 680;
const cv::Scalar black(0, 0, 0), white(255, 255, 255), yellow(0, 255, 255), green(0, 255, 0);

/// A part of a picture, magnified by `zoom`, with `centre` in the middle of the target.
void enlarge(const cv::Mat &picture, cv::Point2d centre, double zoom, cv::Mat target) {
  const int middle_x = target.cols / 2, middle_y = target.rows / 2;
  const cv::Matx23d back(1 / zoom, 0, centre.x - middle_x / zoom, 0, 1 / zoom, centre.y - middle_y / zoom);
  cv::warpAffine(picture, target, back, target.size(), cv::INTER_NEAREST | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
}

void draw_cross(cv::Mat &image, cv::Point at, const cv::Scalar &colour) {
  // A cross open in the middle, so that the labelled point stays visible. Dark edges, for bright tissue.
  for (const auto &[line_colour, width] : {std::pair(black, 3), std::pair(colour, 1)})
    for (const cv::Point direction : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)})
      cv::line(image, at + 3 * direction, at + 9 * direction, line_colour, width);
}

void write(cv::Mat &image, const std::string &text, cv::Point at, const cv::Scalar &colour = white) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, black, 3, cv::LINE_AA);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, colour, 1, cv::LINE_AA);
}

cv::Point rounded(cv::Point2d point) {
  return {cvRound(point.x), cvRound(point.y)};
}

}  // namespace

LabelView LabelView::whole(cv::Size picture, cv::Size largest) {
  const double scale = std::min(
      {1.0, largest.width / static_cast<double>(picture.width), largest.height / static_cast<double>(picture.height)});
  return {picture, cv::Size(cvRound(picture.width * scale), cvRound(picture.height * scale)), scale, {0, 0}};
}

void LabelView::zoom(cv::Point screen_pixel, double factor) {
  const cv::Point2d middle(screen_pixel.x + 0.5, screen_pixel.y + 0.5);
  corner += middle * (1 / scale - 1 / (scale * factor));
  scale *= factor;
}

cv::Point2d LabelView::to_picture(cv::Point screen_pixel) const {
  return {corner.x + (screen_pixel.x + 0.5) / scale - 0.5, corner.y + (screen_pixel.y + 0.5) / scale - 0.5};
}

cv::Point2d LabelView::to_screen(cv::Point2d picture_pixel) const {
  return {(picture_pixel.x + 0.5 - corner.x) * scale - 0.5, (picture_pixel.y + 0.5 - corner.y) * scale - 0.5};
}

cv::Mat draw_label_window(const LabelView &view, const cv::Mat &frame, const cv::Mat &first,
                          const LabelSession &session, cv::Point mouse, const std::string &message) {
  cv::Mat window(std::max(view.screen.height, 2 * loupe_side + 8) + text_height,
                 std::max(view.screen.width + 8 + loupe_side, text_width), CV_8UC3, cv::Scalar(48, 48, 48));
  cv::Mat shown = window(cv::Rect(cv::Point(), view.screen));
  const cv::Point middle(view.screen.width / 2, view.screen.height / 2);
  enlarge(frame, view.to_picture(middle), view.scale, shown);
  for (const LabelSession::Label &label : session.labels()) {
    if (label.frame != session.frame() || label.sight != LabelSession::Sight::visible) continue;
    const cv::Point at = rounded(view.to_screen(label.position));
    draw_cross(shown, at, green);
    write(shown, std::to_string(label.id), at + cv::Point(8, -6), green);
  }

  const cv::Rect upper(view.screen.width + 8, 0, loupe_side, loupe_side);
  const cv::Point loupe_middle(loupe_side / 2, loupe_side / 2);
  cv::Mat loupe = window(upper), look = window(upper + cv::Point(0, loupe_side + 8));
  enlarge(frame, view.to_picture(mouse), loupe_zoom, loupe);
  draw_cross(loupe, loupe_middle, yellow);
  if (!session.choosing()) {
    // Shows the surroundings of the last position, and the point's look in frame 0.
    const cv::Point2d last = session.last_seen(session.point()).position;
    cv::circle(shown, rounded(view.to_screen(last)), 24, yellow, 1, cv::LINE_AA);
    enlarge(first, session.labels()[session.point()].position, look_zoom, look);
    draw_cross(look, loupe_middle, green);
    write(look, "point " + std::to_string(session.point()) + " in frame 0", {6, 16}, green);
  }
  write(window, message, {6, window.rows - 9});
  return window;
}

}  // namespace csd::programs
