// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/work_frame.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "image/samples.h"

namespace csd {
namespace {

/// Rows are converted in blocks of this many pixels, whose components then fit the first-level cache.
constexpr int block = 512;

/// Colour is scaled in bands of this many working lines: a window then scales few lines beyond it, and threads that
/// gather rarely wait for each other.
constexpr int band = 32;

// Whether a plane of bytes can be read in place.
bool is_plane(const FrameView &view, int k) {
  const Component &c = view.component[k];
  return !view.reader && view.packing == Packing::components && c.bytes == 1 && c.shift == 0 && c.pixel_stride == 1;
}

int sub_x(const FrameView &view, int k) {
  return view.packing == Packing::v210 ? k != 0 : view.component[k].sub_x;
}
int sub_y(const FrameView &view, int k) {
  return view.packing == Packing::v210 ? 0 : view.component[k].sub_y;
}

RowReader component_reader(const FrameView &view, int k) {
  if (is_plane(view, k))
    return [c = view.component[k]](int row, int first, int, std::uint8_t *) {
      return c.data + row * c.row_stride + first;
    };
  return [&view, k](int row, int first, int n, std::uint8_t *buffer) {
    read_samples(view, k, row, first, n, buffer);
    return static_cast<const std::uint8_t *>(buffer);
  };
}

RowReader rgb_luma_reader(const FrameView &view) {
  return [&view, c = LumaCoefficients::make(view.kr, view.kb)](int row, int first, int n, std::uint8_t *out) {
    std::uint8_t rgb[3][block];
    for (int x = 0; x < n; x += block) {
      const int part = std::min(block, n - x);
      read_samples(view, row, first + x, part, {rgb[0], rgb[1], rgb[2]});
      rgb_to_luma(c, rgb[0], rgb[1], rgb[2], part, out + x);
    }
    return static_cast<const std::uint8_t *>(out);
  };
}

}  // namespace

void WorkFrame::load(const FrameView &view, int most_lines) {
  if (!view.has_pixels() || view.row_step < 1) throw std::invalid_argument("WorkFrame: a view without pixels");
  view_ = source_ = view;
  yuv_ = YuvCoefficients::make(view.kr, view.kb, view.full_range);

  const int lines = std::min(most_lines, view.rows);
  scale_y_ = static_cast<double>(view.rows) / lines;
  const double picture_scale = scale_y_ * view.row_step;
  const int columns = std::max(1, static_cast<int>(std::lround(view.width / picture_scale)));
  scale_x_ = static_cast<double>(view.width) / columns;
  const cv::Size size(columns, lines);

  const bool direct = size == cv::Size(view.width, view.rows);
  const bool rgb = view.model == ColourModel::rgb;
  bands_.reset();
  if (direct && !rgb && is_plane(view, 0) && view.component[0].row_stride >= view.width) {
    // cv::Mat has no const version; nothing writes through it.
    luma_ = cv::Mat(size, CV_8UC1, const_cast<std::uint8_t *>(view.component[0].data),
                    static_cast<std::size_t>(view.component[0].row_stride));
    return;
  }
  own_luma_.create(size, CV_8UC1);
  luma_ = own_luma_;
  const RowReader read = rgb ? rgb_luma_reader(view_) : component_reader(view_, 0);
  if (direct) {
    for (int y = 0; y < size.height; ++y) {
      const std::uint8_t *row = read(y, 0, size.width, own_luma_.ptr(y));
      if (row != own_luma_.ptr(y)) std::memcpy(own_luma_.ptr(y), row, static_cast<std::size_t>(size.width));
    }
    return;
  }
  find_axes(size);
  scale_area(columns_[0], rows_[0], read, {0, size.height}, own_luma_);
  if (view.model != ColourModel::gray) prepare_colour(size);
}

/// Axes of luma and of chroma; recomputed only when the geometry changes.
void WorkFrame::find_axes(cv::Size size) {
  const int chroma_x = sub_x(view_, 1), chroma_y = sub_y(view_, 1);
  const std::array<int, 6> geometry{view_.width, view_.rows, size.width, size.height, chroma_x, chroma_y};
  if (geometry == geometry_) return;
  geometry_ = geometry;
  columns_[0] = AreaAxis(view_.width, 0, size.width);
  rows_[0] = AreaAxis(view_.rows, 0, size.height);
  columns_[1] = AreaAxis(view_.width, chroma_x, size.width);
  rows_[1] = AreaAxis(view_.rows, chroma_y, size.height);
}

/// Allocates the planes for scaled colour and makes gather() read them.
void WorkFrame::prepare_colour(cv::Size size) {
  source_ = {};
  source_.model = view_.model;
  source_.width = size.width;
  source_.height = source_.rows = size.height;
  for (int k = 0; k < 3; ++k) {
    cv::Mat &plane = colour_[k];
    plane.create(size, CV_8UC1);
    source_.component[k] = {.data = plane.data, .row_stride = static_cast<std::ptrdiff_t>(plane.step[0])};
  }
  bands_ = std::make_unique<Band[]>(static_cast<std::size_t>((size.height + band - 1) / band));
}

/// Scales the colour of working rows [begin, end), unless already done.
void WorkFrame::scale_colour(int begin, int end) const {
  for (int b = begin / band; b * band < end; ++b) {
    Band &one = bands_[static_cast<std::size_t>(b)];
    if (one.made.load(std::memory_order_acquire)) continue;
    const std::scoped_lock lock(one.making);
    if (one.made.load(std::memory_order_relaxed)) continue;
    const cv::Range range(b * band, std::min((b + 1) * band, luma_.rows));
    const int chroma = view_.model == ColourModel::yuv;
    for (int k = chroma; k < 3; ++k)
      scale_area(columns_[chroma], rows_[chroma], component_reader(view_, k), range, colour_[k]);
    one.made.store(true, std::memory_order_release);
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

/// `n` pixels of a component starting at (x, y), all inside the working image.
void WorkFrame::read_row_inside(int component, int y, int x, int n, std::uint8_t *out) const {
  if (source_.model != ColourModel::rgb && component == 0) {
    std::memcpy(out, luma_.ptr(y) + x, static_cast<std::size_t>(n));
    return;
  }
  const int sub = sub_x(source_, component), row = y >> sub_y(source_, component);
  if (sub == 0) return read_samples(source_, component, row, x, n, out);
  std::uint8_t coarse[block + 1];
  const int first = x >> sub;
  read_samples(source_, component, row, first, ((x + n - 1) >> sub) - first + 1, coarse);
  for (int i = 0; i < n; ++i) out[i] = coarse[((x + i) >> sub) - first];
}

/// `n` pixels of a component starting at (x, y); outside the working image its border is replicated.
void WorkFrame::read_row(int component, int y, int x, int n, std::uint8_t *out) const {
  y = std::clamp(y, 0, luma_.rows - 1);
  const int begin = std::clamp(x, 0, luma_.cols - 1);
  const int end = std::max(begin + 1, std::min(x + n, luma_.cols));
  // A block entirely outside repeats the nearest border pixel.
  const int left = std::clamp(begin - x, 0, n - 1), inside = std::min(end - begin, n - left);
  read_row_inside(component, y, begin, inside, out + left);
  std::fill(out, out + left, out[left]);
  std::fill(out + left + inside, out + n, out[left + inside - 1]);
}

/// Calls store(y, x, n, r, g, b) block by block for the whole rectangle; y and x are relative to it.
template <class Store>
void WorkFrame::gather_rows(const cv::Rect &rect, Store store) const {
  if (bands_ && !rect.empty()) {
    const int last = luma_.rows - 1;
    scale_colour(std::clamp(rect.y, 0, last), std::clamp(rect.y + rect.height - 1, 0, last) + 1);
  }
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

void WorkFrame::gather_least(cv::Mat &out) const {
  if (view_.model == ColourModel::gray) return luma_.copyTo(out);
  out.create(luma_.size(), CV_8UC1);
  const bool rgb = view_.model == ColourModel::rgb, scaled = bands_ != nullptr;
  const int right = sub_x(view_, 1), down = sub_y(view_, 1), samples = component_columns(view_, 1), n = luma_.cols;
  std::vector<std::size_t> nearest(static_cast<std::size_t>(scaled ? n : 0));
  for (std::size_t x = 0; x < nearest.size(); ++x)
    nearest[x] = static_cast<std::size_t>((static_cast<double>(x) + 0.5) * scale_x_) >> right;
  const auto luma_of = LumaCoefficients::make(view_.kr, view_.kb);
  const auto slots = static_cast<std::size_t>(samples);
  std::vector<std::uint8_t> first(slots), second(slots), third(slots), bright(slots), least_channel(slots);
  std::vector<std::int16_t> sampled(slots), chroma(slots << right);
  for (int y = 0, last = -1; y < luma_.rows; ++y) {
    const int row = static_cast<int>((y + 0.5) * scale_y_) >> down;
    if (row != last) {
      last = row;
      read_samples(view_, row, 0, samples, {rgb ? first.data() : nullptr, second.data(), third.data()});
      if (!rgb && !scaled) chroma_least(yuv_, second.data(), third.data(), samples, 1 << right, chroma.data());
      if (!rgb && scaled) {
        chroma_least(yuv_, second.data(), third.data(), samples, 1, sampled.data());
        for (std::size_t x = 0; x < nearest.size(); ++x) chroma[x] = sampled[nearest[x]];
      }
    }
    std::uint8_t *to = out.ptr(y);
    if (!rgb) {
      yuv_least(yuv_, luma_.ptr(y), chroma.data(), n, to);
    } else if (!scaled) {
      rgb_least(first.data(), second.data(), third.data(), n, to);
    } else {
      rgb_least(first.data(), second.data(), third.data(), samples, least_channel.data());
      rgb_to_luma(luma_of, first.data(), second.data(), third.data(), samples, bright.data());
      const std::uint8_t *luma = luma_.ptr(y);
      for (std::size_t x = 0; x < nearest.size(); ++x)
        to[x] = static_cast<std::uint8_t>(std::max(0, luma[x] + least_channel[nearest[x]] - bright[nearest[x]]));
    }
  }
}

int default_patch_size(int lines) {
  constexpr int full_size = 21, full_lines = 480, smallest = 9;
  if (lines >= full_lines) return full_size;
  const int half = static_cast<int>(std::lround((full_size * static_cast<double>(lines) / full_lines - 1) / 2));
  return std::max(smallest, 2 * half + 1);
}

}  // namespace csd
