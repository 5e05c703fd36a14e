// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/markers.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace csd {

namespace {

/// Supersampling factor: drawn larger and averaged, which is sharper at few pixels than OpenCV's anti-aliasing.
constexpr int fine = 8;

struct Style {
  std::array<float, 3> rgb;  ///< 0…255
  float opacity;
};

/// Okabe and Ito's yellow, sky blue and orange; unobtrusive greys for features that claim no position.
Style style_of(FeatureState state) {
  switch (state) {
    case FeatureState::learning:
      return {{240, 228, 66}, 1};
    case FeatureState::tracked:
      return {{86, 180, 233}, 1};
    case FeatureState::occluded:
      return {{230, 159, 0}, 1};
    default:
      return {{200, 200, 200}, 0.65f};
  }
}

constexpr float halo_opacity = 0.8f;  // black: colour 0

void polygon(cv::Mat1b &mask, std::vector<cv::Point> points, int thickness) {
  cv::polylines(mask, std::vector<std::vector<cv::Point>>{std::move(points)}, true, 255, thickness);
}

/// Draws the shape of `state` around `c`; sizes in fine pixels.
void draw_shape(cv::Mat1b &mask, FeatureState state, cv::Point c, int radius, int thickness) {
  const int small = radius * 6 / 10;
  switch (state) {
    case FeatureState::learning: {
      const int r = radius * 12 / 10;
      return polygon(mask, {{c.x - r, c.y}, {c.x, c.y - r}, {c.x + r, c.y}, {c.x, c.y + r}}, thickness);
    }
    case FeatureState::tracked:
      cv::circle(mask, c, radius, 255, thickness);
      cv::circle(mask, c, thickness / 2, 255, cv::FILLED);
      return;
    case FeatureState::occluded: {
      const int r = radius * 9 / 10;
      return polygon(mask, {{c.x - r, c.y - r}, {c.x + r, c.y - r}, {c.x + r, c.y + r}, {c.x - r, c.y + r}}, thickness);
    }
    case FeatureState::lost:
      cv::line(mask, c - cv::Point(small, small), c + cv::Point(small, small), 255, thickness);
      cv::line(mask, c - cv::Point(small, -small), c + cv::Point(small, -small), 255, thickness);
      return;
    case FeatureState::out:
      return polygon(mask, {{c.x, c.y - small}, {c.x + small, c.y + small}, {c.x - small, c.y + small}}, thickness);
    case FeatureState::ended:
      return;
  }
}

void paste(const cv::Mat1f &from, cv::Mat1f &to, cv::Point at) {
  cv::Mat target = to(cv::Rect(at, from.size()));
  cv::max(static_cast<const cv::Mat &>(from), target, target);
}

}  // namespace

/// Coverage, 0…1, of a shape with and without its halo.
Markers::Glyph Markers::draw(cv::Size size, int stroke,
                             const std::function<void(cv::Mat1b &, int thickness)> &shape) const {
  const auto cover = [&](int thickness) {
    cv::Mat1b mask = cv::Mat1b::zeros(size * fine);
    shape(mask, thickness);
    cv::Mat1b small;
    cv::resize(mask, small, size, 0, 0, cv::INTER_AREA);
    cv::Mat1f out;
    small.convertTo(out, CV_32F, 1 / 255.0);
    return out;
  };
  return {cover(stroke), cover(stroke + 2 * halo_ * fine)};
}

Markers::Markers(int lines) : lines_(std::max(1, lines)) {
  const auto part = [this](double lines_per_pixel, int least_pixels) {
    return std::max(least_pixels, static_cast<int>(std::lround(lines_ / lines_per_pixel)));
  };
  radius_ = part(80, 4);
  halo_ = part(600, 1);
  text_height_ = part(54, 8);
  // Stroke width in fine pixels; with few lines it is a fraction of a pixel.
  stroke_ = std::max(fine * 5 / 4, static_cast<int>(std::lround(fine * lines_ / 400.0)));
  const int text_stroke = std::max(fine * 9 / 8, stroke_ * 8 / 10);

  const int margin = halo_ + stroke_ / fine + 1;
  int baseline = 0;
  const int font = cv::FONT_HERSHEY_SIMPLEX;
  const double scale = text_height_ * fine / static_cast<double>(cv::getTextSize("0", font, 1, 1, &baseline).height);
  const int digit_width = (cv::getTextSize("0", font, scale, 1, &baseline).width + fine - 1) / fine;
  digit_advance_ = digit_width + (text_stroke + fine - 1) / fine / 2;
  for (std::size_t d = 0; d < digits_.size(); ++d) {
    const std::string text(1, static_cast<char>('0' + d));
    digits_[d] =
        draw({digit_width + 2 * margin, text_height_ + 2 * margin}, text_stroke, [&](cv::Mat1b &mask, int thickness) {
          cv::putText(mask, text, cv::Point(margin, margin + text_height_) * fine, font, scale, 255, thickness);
        });
  }
  const int side = 2 * (radius_ * 12 / 10 + margin) + 1;
  for (std::size_t s = 0; s < feature_states; ++s)
    shapes_[s] = draw({side, side}, stroke_, [&](cv::Mat1b &mask, int thickness) {
      draw_shape(mask, static_cast<FeatureState>(s), cv::Point(side, side) * (fine / 2), radius_ * fine, thickness);
    });
}

std::uint64_t Markers::key(FeatureState state, FeatureId id, bool text_left) {
  return (static_cast<std::uint64_t>(id) * feature_states + static_cast<std::uint64_t>(state)) * 2 + text_left;
}

bool Markers::text_left(FeatureId id, double x, int width) const {
  const auto digits = static_cast<int>(std::to_string(id).size());
  const int side = shapes_[0].core.cols;
  const int reach = side / 2 - digit_advance_ / 4 + digits_[0].core.cols + digit_advance_ * (digits - 1);
  // Unless the left side is no better.
  return x + reach >= width && x - reach >= 0;
}

Sprite Markers::sprite(FeatureState state, FeatureId id, bool text_left) const {
  const Glyph &shape = shapes_[static_cast<std::size_t>(state)];
  const std::string text = std::to_string(id);
  const cv::Size digit = digits_[0].core.size();
  const int side = shape.core.rows;
  // The text is at the upper right of the shape, so that it hides as little of the feature as possible.
  const int text_x = side - digit_advance_ / 4, text_y = std::max(0, side / 2 - digit.height);
  const int above = std::max(0, digit.height - side / 2);
  Sprite out;
  const cv::Size size(text_x + digit.width + digit_advance_ * static_cast<int>(text.size() - 1),
                      std::max(above + side, above + text_y + digit.height));
  cv::Mat1f core = cv::Mat1f::zeros(size), halo = cv::Mat1f::zeros(size);
  const int shape_x = text_left ? size.width - side : 0, first_x = text_left ? 0 : text_x;
  paste(shape.core, core, {shape_x, above});
  paste(shape.halo, halo, {shape_x, above});
  for (std::size_t i = 0; i < text.size(); ++i) {
    const Glyph &glyph = digits_[static_cast<std::size_t>(text[i] - '0')];
    const cv::Point at(first_x + digit_advance_ * static_cast<int>(i), text_y);
    paste(glyph.core, core, at);
    paste(glyph.halo, halo, at);
  }
  const Style style = style_of(state);
  out.origin = {shape_x + side / 2, above + side / 2};
  out.rgba.create(size);
  out.covered.assign(static_cast<std::size_t>(size.height), cv::Range(0, 0));
  for (int y = 0; y < size.height; ++y) {
    cv::Range &covered = out.covered[static_cast<std::size_t>(y)];
    for (int x = 0; x < size.width; ++x) {
      const float c = core(y, x) * style.opacity;
      const float alpha = c + (1 - core(y, x)) * halo(y, x) * halo_opacity * style.opacity;
      cv::Vec4b &p = out.rgba(y, x);
      for (int k = 0; k < 3; ++k) p[k] = cv::saturate_cast<std::uint8_t>(c * style.rgb[static_cast<std::size_t>(k)]);
      p[3] = cv::saturate_cast<std::uint8_t>(255 * alpha);
      if (p[3] == 0) continue;
      if (covered.empty()) covered.start = x;
      covered.end = x + 1;
    }
  }
  return out;
}

}  // namespace csd
