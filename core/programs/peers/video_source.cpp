// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/video_source.h"

#include <array>
#include <charconv>
#include <iostream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "base/types.h"
#include "image/colour_rows.h"

namespace csd::peers {

namespace {

constexpr int max_pixels_a_side = 32768;
constexpr std::size_t longest_line = 4096;

std::runtime_error bad(const std::string &text) {
  return std::runtime_error("YUV4MPEG2: " + text);
}

int whole(std::string_view text, std::string_view what) {
  int value = 0;
  const auto [stop, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || stop != text.data() + text.size() || value < 1)
    throw bad("\"" + std::string(text) + "\" is no " + std::string(what));
  return value;
}

/// A line of the header, or before a frame; nothing at the end. Stops after `longest_line` if the line doesn't start
/// with `begin`. Avoids allocations, because a stream treats a failed one as its end.
std::optional<std::string> line_of(std::istream &in, std::string_view begin) {
  std::array<char, longest_line + 1> text;
  in.getline(text.data(), text.size());
  const auto count = static_cast<std::size_t>(in.gcount());
  if (in.fail() && count < longest_line) return {};
  std::string line(text.data(), count - (in.eof() || in.fail() ? 0 : 1));
  if (in.fail() && line.starts_with(begin))
    throw bad("a line is longer than " + std::to_string(longest_line) + " bytes");
  return line;
}

class Y4m final : public VideoSource {
 public:
  explicit Y4m(std::istream &in) : in_(in) {
    constexpr std::string_view magic = "YUV4MPEG2 ";
    const std::string header = line_of(in, magic).value_or("");
    if (!header.starts_with(magic)) throw bad("the input does not begin with \"YUV4MPEG2 \"");
    for (std::size_t at = magic.size(); at < header.size();) {
      const auto end = std::min(header.find(' ', at), header.size());
      parameter(std::string_view(header).substr(at, end - at));
      at = end + 1;
    }
    if (width_ == 0 || height_ == 0) throw bad("no width (W) or height (H) in the header");
    if (width_ > max_pixels_a_side || height_ > max_pixels_a_side) throw bad("the picture is too large");
    const bool sd = height_ <= 576;
    yuv_ = YuvCoefficients::make(sd ? 0.299 : 0.2126, sd ? 0.114 : 0.0722, full_range_);
    chroma_width_ = gray_ ? 0 : (width_ + (1 << sub_x_) - 1) >> sub_x_;
    chroma_height_ = gray_ ? 0 : (height_ + (1 << sub_y_) - 1) >> sub_y_;
    planes_.resize(size_of(width_, height_) + 2 * size_of(chroma_width_, chroma_height_));
  }

  bool next(Picture &picture) override {
    constexpr std::string_view magic = "FRAME";
    const auto line = line_of(in_, magic);
    if (!line) return false;
    if (!line->starts_with(magic)) throw bad("frame " + std::to_string(frame_) + ": no FRAME where it must be");
    in_.read(planes_.data(), static_cast<std::streamsize>(planes_.size()));
    if (static_cast<std::size_t>(in_.gcount()) != planes_.size())
      throw bad("frame " + std::to_string(frame_) + " breaks off after " + std::to_string(in_.gcount()) + " of " +
                std::to_string(planes_.size()) + " bytes");
    convert(picture.bgr);
    picture.pts = picture.running_time = picture.stream_time = time(frame_);
    picture.duration = time(frame_ + 1) - picture.pts;
    ++frame_;
    return true;
  }

  void drain() override { in_.ignore(std::numeric_limits<std::streamsize>::max()); }

 private:
  static std::size_t size_of(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }

  void parameter(std::string_view p) {
    if (p.empty()) return;
    const auto value = p.substr(1);
    if (p[0] == 'W') width_ = whole(value, "width");
    if (p[0] == 'H') height_ = whole(value, "height");
    if (p[0] == 'F') {
      const auto colon = value.find(':');
      if (colon == value.npos) throw bad("\"" + std::string(p) + "\" is no frame rate");
      rate_ = whole(value.substr(0, colon), "frame rate");
      per_ = whole(value.substr(colon + 1), "frame rate");
    }
    if (p[0] == 'C') {
      if (value == "420" || value == "420jpeg" || value == "420mpeg2" || value == "420paldv")
        sub_x_ = sub_y_ = 1;
      else if (value == "422")
        sub_x_ = 1, sub_y_ = 0;
      else if (value == "444")
        sub_x_ = sub_y_ = 0;
      else if (value == "411")
        sub_x_ = 2, sub_y_ = 0;
      else if (value == "mono")
        gray_ = true;
      else
        throw bad("the format \"" + std::string(p) + "\" can't be read; C420, C422, C444, C411 and Cmono can");
    }
    if (p == "XCOLORRANGE=FULL") full_range_ = true;
  }

  /// The time of the n-th frame, rounded down like GStreamer.
  std::int64_t time(std::int64_t n) const {
    const auto whole_seconds = n * per_ / rate_, rest = n * per_ % rate_;
    return whole_seconds * second + rest * second / rate_;
  }

  void convert(cv::Mat &bgr) {
    bgr.create(height_, width_, CV_8UC3);
    const auto w = static_cast<std::size_t>(width_);
    const auto *y_plane = reinterpret_cast<const std::uint8_t *>(planes_.data());
    const auto *u_plane = y_plane + size_of(width_, height_);
    const auto *v_plane = u_plane + size_of(chroma_width_, chroma_height_);
    std::vector<std::uint8_t> u(w, 128), v(w, 128), r(w), g(w), b(w);
    for (int y = 0; y < height_; ++y) {
      if (!gray_) {
        const auto row = size_of(chroma_width_, y >> sub_y_);
        for (std::size_t x = 0; x < w; ++x) {
          u[x] = u_plane[row + (x >> sub_x_)];
          v[x] = v_plane[row + (x >> sub_x_)];
        }
      }
      yuv_to_rgb(yuv_, y_plane + size_of(width_, y), u.data(), v.data(), width_, r.data(), g.data(), b.data());
      interleave(b.data(), g.data(), r.data(), width_, bgr.ptr(y));
    }
  }

  std::istream &in_;
  int width_ = 0, height_ = 0;
  std::int64_t rate_ = 25, per_ = 1, frame_ = 0;
  int sub_x_ = 1, sub_y_ = 1;
  bool gray_ = false, full_range_ = false;
  int chroma_width_ = 0, chroma_height_ = 0;
  YuvCoefficients yuv_;
  std::vector<char> planes_;
};

class VideoFile final : public VideoSource {
 public:
  explicit VideoFile(const std::string &name) : frames_(name) {}

  bool next(Picture &picture) override {
    picture = frames_.at(frame_);
    if (picture.bgr.empty()) return false;
    ++frame_;
    return true;
  }

 private:
  programs::VideoFrames frames_;
  std::uint64_t frame_ = 0;
};

}  // namespace

std::unique_ptr<VideoSource> read_y4m(std::istream &in) {
  return std::make_unique<Y4m>(in);
}

std::unique_ptr<VideoSource> open_video(const std::string &name) {
  if (name == "-") return read_y4m(std::cin);
  return std::make_unique<VideoFile>(name);
}

}  // namespace csd::peers
