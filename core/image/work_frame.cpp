// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/work_frame.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "image/samples.h"

namespace csd {
namespace {

/// Rows are converted in blocks of so many pixels, whose components then fit the first-level cache.
constexpr int block = 512;

constexpr int interpolation = cv::INTER_AREA;

/// Component `k` as a matrix on the memory of the view, if it can be one.
bool is_plane(const FrameView &view, int k) {
  const Component &c = view.component[k];
  return view.packing == Packing::components && c.bytes == 1 && c.shift == 0 && c.pixel_stride == 1 &&
         c.row_stride >= component_columns(view, k);
}

// OpenCV has no matrix of const; nothing writes through it.
cv::Mat plane(const FrameView &view, int type, const std::uint8_t *data, std::ptrdiff_t stride) {
  return cv::Mat(view.rows, view.width, type, const_cast<std::uint8_t *>(data), static_cast<std::size_t>(stride));
}

}  // namespace

void WorkFrame::load(const FrameView &view) {
  if (view.width < 1 || view.rows < 1 || view.row_step < 1 || !view.component[0].data)
    throw std::invalid_argument("WorkFrame: a view without pixels");
  view_ = source_ = view;
  yuv_ = YuvCoefficients::make(view.kr, view.kb, view.full_range);

  const int lines = std::min(max_lines, view.rows);
  scale_y_ = static_cast<double>(view.rows) / lines;
  const double picture_scale = scale_y_ * view.row_step;
  const int columns = std::max(1, static_cast<int>(std::lround(view.width / picture_scale)));
  scale_x_ = static_cast<double>(view.width) / columns;
  const cv::Size size(columns, lines);

  direct_ = size == cv::Size(view.width, view.rows);
  luma_ = cv::Mat();
  if (view.model == ColourModel::rgb)
    load_rgb(size);
  else
    load_luma(size);
}

void WorkFrame::load_luma(cv::Size size) {
  cv::Mat full;
  if (is_plane(view_, 0)) {
    full = plane(view_, CV_8UC1, view_.component[0].data, view_.component[0].row_stride);
  } else {
    gathered_.create(view_.rows, view_.width, CV_8UC1);
    for (int y = 0; y < view_.rows; ++y) read_samples(view_, 0, y, 0, view_.width, gathered_.ptr(y));
    full = gathered_;
  }
  if (direct_) {
    luma_ = full;
    return;
  }
  cv::resize(full, scaled_, size, 0, 0, interpolation);
  luma_ = scaled_;
  if (view_.model == ColourModel::yuv) {
    find_footprints(component_columns(view_, 1), size.width, columns_);
    find_footprints(component_rows(view_, 1), size.height, rows_);
  }
}

void WorkFrame::load_rgb(cv::Size size) {
  const auto rgb_of = [](const FrameView &from, int y, int x, int n, std::uint8_t *r, std::uint8_t *g,
                         std::uint8_t *b) {
    read_samples(from, 0, y, x, n, r);
    read_samples(from, 1, y, x, n, g);
    read_samples(from, 2, y, x, n, b);
  };
  std::uint8_t r[block], g[block], b[block];
  if (!direct_) {
    // R, G and B are scaled together, so that luma and colour see the same picture; luma is then made of few pixels.
    gathered_.create(view_.rows, view_.width, CV_8UC3);
    for (int y = 0; y < view_.rows; ++y)
      for (int x = 0; x < view_.width; x += block) {
        const int n = std::min(block, view_.width - x);
        rgb_of(view_, y, x, n, r, g, b);
        interleave(b, g, r, n, gathered_.ptr(y) + 3 * x);
      }
    cv::resize(gathered_, rgb_scaled_, size, 0, 0, interpolation);
    source_.width = size.width;
    source_.height = source_.rows = size.height;
    for (int k = 0; k < 3; ++k)
      source_.component[k] = {.data = rgb_scaled_.data + (2 - k),
                              .row_stride = static_cast<std::ptrdiff_t>(rgb_scaled_.step[0]),
                              .pixel_stride = 3};
    direct_ = true;
  }
  const LumaCoefficients coefficients = LumaCoefficients::make(view_.kr, view_.kb);
  scaled_.create(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; x += block) {
      const int n = std::min(block, size.width - x);
      rgb_of(source_, y, x, n, r, g, b);
      rgb_to_luma(coefficients, r, g, b, n, scaled_.ptr(y) + x);
    }
  luma_ = scaled_;
}

/// Shares `samples` out among `pixels`: each pixel gets those that begin nearest to its interval; one that would get
/// none gets the one over its centre.
void WorkFrame::find_footprints(int samples, int pixels, std::vector<Footprint> &out) {
  out.resize(static_cast<std::size_t>(pixels));
  const double step = static_cast<double>(samples) / pixels;
  for (int i = 0; i < pixels; ++i) {
    Footprint f{static_cast<int>(std::lround(i * step)), static_cast<int>(std::lround((i + 1) * step))};
    if (f.end <= f.begin) {
      f.begin = std::min(static_cast<int>((i + 0.5) * step), samples - 1);
      f.end = f.begin + 1;
    }
    out[static_cast<std::size_t>(i)] = f;
  }
}

cv::Point2d WorkFrame::to_work(cv::Point2d picture) const {
  const double row = (picture.y - view_.row_offset) / view_.row_step;
  return {(picture.x + 0.5) / scale_x_ - 0.5, (row + 0.5) / scale_y_ - 0.5};
}

cv::Point2d WorkFrame::to_picture(cv::Point2d work) const {
  const double row = (work.y + 0.5) * scale_y_ - 0.5;
  return {(work.x + 0.5) * scale_x_ - 0.5, view_.row_step * row + view_.row_offset};
}

/// `n` pixels of a component from (x, y) on, all inside the working image.
void WorkFrame::read_row_inside(int component, int y, int x, int n, std::uint8_t *out) const {
  if (source_.model != ColourModel::rgb && component == 0) {
    std::memcpy(out, luma_.ptr(y) + x, static_cast<std::size_t>(n));
    return;
  }
  if (direct_) {
    const bool v210 = source_.packing == Packing::v210;
    const int sub_x = v210 ? 1 : source_.component[component].sub_x;
    const int row = v210 ? y : y >> source_.component[component].sub_y;
    if (sub_x == 0) return read_samples(source_, component, row, x, n, out);
    std::uint8_t coarse[block + 1];
    const int first = x >> sub_x;
    read_samples(source_, component, row, first, ((x + n - 1) >> sub_x) - first + 1, coarse);
    for (int i = 0; i < n; ++i) out[i] = coarse[((x + i) >> sub_x) - first];
    return;
  }
  const Footprint *columns = columns_.data() + x;
  const Footprint rows = rows_[static_cast<std::size_t>(y)];
  const int first = columns[0].begin, count = columns[n - 1].end - first;
  cv::AutoBuffer<std::uint8_t, 4 * block> samples(static_cast<std::size_t>(count));
  std::uint32_t sum[block] = {};
  for (int row = rows.begin; row < rows.end; ++row) {
    read_samples(source_, component, row, first, count, samples.data());
    for (int i = 0; i < n; ++i)
      for (int s = columns[i].begin; s < columns[i].end; ++s) sum[i] += samples[static_cast<std::size_t>(s - first)];
  }
  for (int i = 0; i < n; ++i) {
    const auto area = static_cast<std::uint32_t>((columns[i].end - columns[i].begin) * (rows.end - rows.begin));
    out[i] = static_cast<std::uint8_t>((sum[i] + area / 2) / area);
  }
}

/// `n` pixels of a component from (x, y) on; outside the working image its border goes on.
void WorkFrame::read_row(int component, int y, int x, int n, std::uint8_t *out) const {
  y = std::clamp(y, 0, luma_.rows - 1);
  const int begin = std::clamp(x, 0, luma_.cols - 1);
  const int end = std::max(begin + 1, std::min(x + n, luma_.cols));
  // A block that lies outside altogether is made of the border pixel next to it.
  const int left = std::clamp(begin - x, 0, n - 1), inside = std::min(end - begin, n - left);
  read_row_inside(component, y, begin, inside, out + left);
  std::fill(out, out + left, out[left]);
  std::fill(out + left + inside, out + n, out[left + inside - 1]);
}

/// Calls store(y, x, n, r, g, b), y and x relative to the rectangle, for all of it in blocks.
template <class Store>
void WorkFrame::gather_rows(const cv::Rect &rect, Store store) const {
  std::uint8_t c[3][block], r[block], g[block], b[block];
  for (int y = 0; y < rect.height; ++y)
    for (int x = 0; x < rect.width; x += block) {
      const int n = std::min(block, rect.width - x);
      const int components = source_.model == ColourModel::gray ? 1 : 3;
      for (int k = 0; k < components; ++k) read_row(k, rect.y + y, rect.x + x, n, c[k]);
      switch (source_.model) {
        case ColourModel::gray:
          store(y, x, n, c[0], c[0], c[0]);
          break;
        case ColourModel::rgb:
          store(y, x, n, c[0], c[1], c[2]);
          break;
        case ColourModel::yuv:
          yuv_to_rgb(yuv_, c[0], c[1], c[2], n, r, g, b);
          store(y, x, n, r, g, b);
          break;
      }
    }
}

void WorkFrame::gather_bgr(const cv::Rect &rect, cv::Mat &out) const {
  out.create(rect.size(), CV_8UC3);
  gather_rows(rect, [&](int y, int x, int n, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b) {
    interleave(b, g, r, n, out.ptr(y) + 3 * x);
  });
}

void WorkFrame::gather(const cv::Rect &rect, const ColourSpace &space, cv::Mat &out) const {
  out.create(rect.size(), CV_8UC1);
  gather_rows(rect, [&](int y, int x, int n, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b) {
    rgb_to_space(space, r, g, b, n, out.ptr(y) + x);
  });
}

int default_patch_size(int lines) {
  constexpr int full_size = 21, full_lines = 480, smallest = 9;
  if (lines >= full_lines) return full_size;
  const int half = static_cast<int>(std::lround((full_size * static_cast<double>(lines) / full_lines - 1) / 2));
  return std::max(smallest, 2 * half + 1);
}

}  // namespace csd
