// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/sensor.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"
#include "sim/light.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_noise = 800, stream_reservoir = 801;

// A row of noise starts at a random place in the reservoir; a row of a 4K picture takes 3 · 3840 numbers.
constexpr std::size_t reservoir = std::size_t{1} << 18;

// Luma's deviation at strength 1 matches the paper's and the project's clips, 2 grey levels in mid-grey; it grows with
// the signal like shot noise: σ² = 4·(0.4 + 0.6·luma/128).
constexpr float shared = 0.95F, own = 0.5F;  // noise common to R, G and B after demosaicing, and the rest
constexpr float sigma = 2.02F;

constexpr float kb = 0.114F, kr = 0.299F;  // any weights would do: luma is only separated and put back

constexpr double chroma_sigma = 1.4;  // pixels at 480 lines

/// Rounds a sensor sample to a byte.
std::uint8_t to_byte(float x) {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative, and a call of lround for each sample would be slow
  return static_cast<std::uint8_t>(static_cast<int>(std::clamp(x, 0.0F, 255.0F) + 0.5F));
}

}  // namespace

Sensor::Sensor(const Effects &effects, std::uint64_t seed)
    : vignette_(effects[Effect::vignette]),
      noise_(effects[Effect::noise]),
      chroma_(effects[Effect::chroma]),
      stop_(effects[Effect::field_stop]),
      seed_(seed) {
  if (noise_ <= 0) return;
  Random random(seed, stream_reservoir);
  normal_.resize(reservoir);
  for (float &x : normal_) x = static_cast<float>(random.normal());
}

void Sensor::add_noise(float *b, float *g, float *r, int width, std::uint64_t moment, int y) const {
  const auto n = static_cast<std::size_t>(width);
  const std::size_t room = reservoir - std::min(reservoir - 1, 4 * n);
  Random random(seed_ + moment * 0x9e3779b97f4a7c15u, (stream_noise << 32) + static_cast<std::uint64_t>(y));
  const auto somewhere = [&] { return normal_.data() + random.next() % room; };
  const float *common = somewhere(), *nb = somewhere(), *ng = somewhere(), *nr = somewhere();
  const float strength = sigma * static_cast<float>(noise_);
  for (std::size_t x = 0; x < n; ++x) {
    const float luma = std::min(kb * b[x] + (1 - kb - kr) * g[x] + kr * r[x], 255.0F);
    const float s = strength * std::sqrt(0.4F + (0.6F / 128) * std::max(luma, 0.0F));
    const float c = shared * common[x];
    b[x] += s * (c + own * nb[x]);
    g[x] += s * (c + own * ng[x]);
    r[x] += s * (c + own * nr[x]);
  }
}

float Sensor::stopped(cv::Point2d pixel, cv::Size size) const {
  if (stop_ <= 0) return 0;
  const double radius = size.height * std::max(0.78 - 0.2 * stop_, 0.2);
  const double dx = pixel.x - 0.5 * (size.width - 1), dy = pixel.y - 0.5 * (size.height - 1);
  const double soft = 1.5 * size.height / 480;
  return static_cast<float>(smoothstep(0.5 + (std::sqrt(dx * dx + dy * dy) - radius) / (2 * soft)));
}

void Sensor::expose(Canvas &canvas, const cv::Vec3d &gain, std::uint64_t moment, cv::Mat &picture,
                    std::vector<float> &scratch) const {
  const cv::Size size = canvas.size();
  const int width = size.width;
  std::vector<float> falls(static_cast<std::size_t>(width), 1.0F);
  for (int y = 0; y < size.height; ++y) {
    float *plane[3] = {canvas.row(0, y), canvas.row(1, y), canvas.row(2, y)};
    if (vignette_ > 0)
      for (int x = 0; x < width; ++x)
        falls[static_cast<std::size_t>(x)] = vignette(static_cast<float>(x), static_cast<float>(y), size, vignette_);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto k = static_cast<float>(gain[static_cast<int>(c)]);
      for (int x = 0; x < width; ++x) {
        const float value = plane[c][x] * (k * falls[static_cast<std::size_t>(x)]);
        plane[c][x] = std::min(value, 300.0F);  // a photosite saturates, so glare doesn't spread in the next steps
      }
    }
    if (noise_ > 0) add_noise(plane[0], plane[1], plane[2], width, moment, y);
    if (chroma_ > 0) {
      for (int x = 0; x < width; ++x) {
        const float luma = kb * plane[0][x] + (1 - kb - kr) * plane[1][x] + kr * plane[2][x];
        plane[0][x] -= luma;
        plane[2][x] -= luma;
        plane[1][x] = luma;
      }
    }
  }
  if (chroma_ > 0)
    for (const std::size_t c : {std::size_t{0}, std::size_t{2}}) {
      blur(canvas, c, chroma_sigma * std::sqrt(chroma_) * size.height / 480, scratch);
    }

  picture.create(size, CV_8UC3);
  for (int y = 0; y < size.height; ++y) {
    const float *b = canvas.row(0, y), *g = canvas.row(1, y), *r = canvas.row(2, y);
    std::uint8_t *out = picture.ptr(y);
    for (int x = 0; x < width; ++x) {
      float blue = b[x], green = g[x], red = r[x];
      if (chroma_ > 0) {
        blue += g[x];
        red += g[x];
        green = g[x] - (kb / (1 - kb - kr)) * b[x] - (kr / (1 - kb - kr)) * r[x];
      }
      if (stop_ > 0) {
        const float keep = 1 - stopped(cv::Point2d(x, y), size);
        blue *= keep;
        green *= keep;
        red *= keep;
      }
      out[3 * x] = to_byte(blue);
      out[3 * x + 1] = to_byte(green);
      out[3 * x + 2] = to_byte(red);
    }
  }
}

}  // namespace csd::sim
