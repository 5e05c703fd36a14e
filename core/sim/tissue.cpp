// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tissue.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr float blood_colour[3] = {20, 14, 122};  // B, G, R
constexpr float water_tint[3] = {1.08F, 1.06F, 1.0F};
constexpr float stain[3] = {0.62F, 0.6F, 0.82F};      // what washed tissue keeps of its colour
constexpr float displaced_u = 173, displaced_v = 91;  // where its new pattern comes from, units
constexpr float blood_gloss = 1.3F, water_gloss = 1.5F;

}  // namespace

Tissue::Tissue(const Effects &effects, std::uint64_t seed, TextureMap texture)
    : effects_(effects),
      seed_(seed),
      surface_(effects, seed),
      texture_(std::move(texture)),
      fluids_(effects, seed),
      highlights_(effects[Effect::specular], seed) {}

cv::Point3d Tissue::project(double time, cv::Size size, cv::Point2d uv) const {
  return camera(time, size).project(surface_.at(time).at(surface_.place(uv.x, uv.y)));
}

void Tissue::find(double time, cv::Size size, double shutter, Fragments &fragments) {
  const Camera here = camera(time, size);
  const Surface::Moment moment = surface_.at(time);
  mesh_.build(surface_, moment, here, size);
  const Light light(time, effects_, seed_, here);

  const bool moving = shutter > 0;
  const Camera before = camera(time - shutter / 2, size), after = camera(time + shutter / 2, size);
  const Surface::Moment earlier = surface_.at(time - shutter / 2), later = surface_.at(time + shutter / 2);

  image_.clear();
  corners_.resize(mesh_.points.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Mesh::Point &p = mesh_.points[i];
    Fragment &c = corners_[i];
    image_.emplace_back(p.image.x, p.image.y);
    c[Fragment::depth] = static_cast<float>(p.image.z);
    c[Fragment::u] = static_cast<float>(p.place.u);
    c[Fragment::v] = static_cast<float>(p.place.v);
    c[Fragment::level] = static_cast<float>(p.units_log2);
    c[Fragment::gain] = static_cast<float>(light.on(p.place.normal, p.normal, p.position));
    c[Fragment::normal_x] = static_cast<float>(p.normal.dot(here.right));
    c[Fragment::normal_y] = static_cast<float>(p.normal.dot(here.down));
    if (fluids_.any()) fluids_.wet(time, p.place.u, p.place.v, c);
    if (moving) {
      const cv::Point3d a = before.project(earlier.at(p.place)), b = after.project(later.at(p.place));
      c[Fragment::motion_x] = static_cast<float>(b.x - a.x);
      c[Fragment::motion_y] = static_cast<float>(b.y - a.y);
    }
  }
  fragments.reset(size);
  const std::size_t used = moving ? Fragment::count : fluids_.any() ? Fragment::motion_x : Fragment::blood;
  fragments.draw_grid(mesh_.columns, mesh_.rows, image_, corners_, used);
}

bool Tissue::drowned(double time, cv::Point2d uv) const {
  if (!fluids_.any()) return false;
  Fragment f;
  fluids_.wet(time, uv.x, uv.y, f);
  return std::max(cover(f[Fragment::blood]), cover(f[Fragment::water])) >= 0.5F;
}

float Tissue::gloss_of(float texture_gloss, const Fragment &f, bool wet) {
  float gloss = texture_gloss * (1.0F / 255);
  if (wet) {
    gloss += (blood_gloss - gloss) * cover(f[Fragment::blood]);
    gloss += (water_gloss - gloss) * cover(f[Fragment::water]);
  }
  return gloss;
}

float Tissue::blinded(const Camera &camera, const Fragments &fragments, cv::Point pixel) const {
  const Fragment &f = fragments.at(pixel.x, pixel.y);
  if (f[Fragment::depth] >= Fragments::nothing) return 0;
  const auto texel = texture_.sample(f[Fragment::u], f[Fragment::v], f[Fragment::level]);
  const auto inverse = static_cast<float>(1 / camera.focal);
  const float sx = (static_cast<float>(pixel.x) - static_cast<float>(camera.principal.x)) * inverse;
  const float sy = (static_cast<float>(pixel.y) - static_cast<float>(camera.principal.y)) * inverse;
  return highlights_.at(f, sx, sy, gloss_of(texel[3], f, fluids_.any())).core;
}

template <bool Wet>
void Tissue::paint_row(double time, const Camera &camera, const Fragments &fragments, int y, Canvas &canvas) const {
  float *b = canvas.row(0, y), *g = canvas.row(1, y), *r = canvas.row(2, y);
  const Fragment *row = fragments.row(y);
  const auto inverse = static_cast<float>(1 / camera.focal);
  const float slope_y = (static_cast<float>(y) - static_cast<float>(camera.principal.y)) * inverse;
  const auto principal_x = static_cast<float>(camera.principal.x);
  // Water bends the light: where it runs, texels are looked up anew below.
  const auto width = static_cast<std::size_t>(canvas.size().width);
  std::vector<std::array<float, 4>> texels(width);
  texture_.sample_row(row, width, texels.data());
  const auto ripple_phase = static_cast<float>(time * 1.7 - floor_of(time * 1.7));
  for (int x = 0; x < canvas.size().width; ++x) {
    const Fragment &f = row[x];
    if (f[Fragment::depth] >= Fragments::nothing) {
      b[x] = g[x] = r[x] = 0;
      continue;
    }
    auto &texel = texels[static_cast<std::size_t>(x)];
    if constexpr (Wet) {
      float u = f[Fragment::u], v = f[Fragment::v];
      const float level = f[Fragment::level], water = cover(f[Fragment::water]);
      if (water > 0) {
        u += 4 * water * static_cast<float>(sin_turns(ripple_phase + 0.021F * v + 0.013F * u));
        v += 3 * water * static_cast<float>(sin_turns(2 * ripple_phase + 0.017F * u - 0.011F * v));
        texel = texture_.sample(u, v, level);
      }
      if (const float changed = cover(f[Fragment::changed]); changed > 0) {
        const auto other = texture_.sample(u + displaced_u, v + displaced_v, level);
        for (std::size_t c = 0; c < 3; ++c) {
          const float now = stain[c] * (0.35F * texel[c] + 0.75F * other[c]);
          texel[c] += changed * (now - texel[c]);
        }
      }
      if (const float blood = cover(f[Fragment::blood]); blood > 0) {
        // Thin at its edge, where tissue shines through.
        const float depth = blood * (0.8F + 0.15F * clamp01(f[Fragment::blood] * 0.5F));
        for (std::size_t c = 0; c < 3; ++c) texel[c] += depth * (blood_colour[c] - texel[c]);
      }
      if (water > 0)
        for (std::size_t c = 0; c < 3; ++c) texel[c] *= 1 + water * (water_tint[c] - 1);
    }
    const float gain = f[Fragment::gain];
    for (std::size_t c = 0; c < 3; ++c) texel[c] *= gain;
    const float slope_x = (static_cast<float>(x) - principal_x) * inverse;
    const auto light = highlights_.at(f, slope_x, slope_y, gloss_of(texel[3], f, Wet));
    if (light.glow > 0) {
      constexpr float glow[3] = {95, 70, 80}, core[3] = {330, 320, 320};  // a little violet, as sensors clip
      for (std::size_t c = 0; c < 3; ++c) {
        texel[c] += light.glow * glow[c];
        texel[c] += light.core * (core[c] - texel[c]);
      }
    }
    b[x] = texel[0];
    g[x] = texel[1];
    r[x] = texel[2];
  }
}

void Tissue::paint(double time, const Fragments &fragments, Canvas &canvas) const {
  canvas.resize(fragments.size());
  const Camera here = camera(time, fragments.size());
  for (int y = 0; y < fragments.size().height; ++y) {
    if (fluids_.any()) {
      paint_row<true>(time, here, fragments, y, canvas);
    } else {
      paint_row<false>(time, here, fragments, y, canvas);
    }
  }
}

void blur_motion(const Fragments &fragments, Canvas &canvas, Canvas &copy) {
  const cv::Size size = canvas.size();
  copy = canvas;
  for (int y = 0; y < size.height; ++y) {
    const Fragment *row = fragments.row(y);
    for (int x = 0; x < size.width; ++x) {
      const Fragment &f = row[x];
      if (f[Fragment::depth] >= Fragments::nothing) continue;
      const float mx = f[Fragment::motion_x], my = f[Fragment::motion_y];
      const float length = std::max(std::abs(mx), std::abs(my));
      // What is as near as the lens has no motion that can be told: it is huge, or no number.
      constexpr float most = 8192;
      if (!(length >= 0.5F && length <= most && std::abs(my) <= most)) continue;
      // As far to one side as to the other, so that nothing shifts.
      const int pairs = std::min(8, 1 + static_cast<int>(length / 2));
      float sum[3] = {copy.row(0, y)[x], copy.row(1, y)[x], copy.row(2, y)[x]};
      for (int k = 1; k <= pairs; ++k) {
        const float at = 0.5F * static_cast<float>(k) / (static_cast<float>(pairs) + 0.5F);
        const int dx = static_cast<int>(std::floor(mx * at + 0.5F)), dy = static_cast<int>(std::floor(my * at + 0.5F));
        const int xa = std::clamp(x + dx, 0, size.width - 1), xb = std::clamp(x - dx, 0, size.width - 1);
        const int ya = std::clamp(y + dy, 0, size.height - 1), yb = std::clamp(y - dy, 0, size.height - 1);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += copy.row(c, ya)[xa] + copy.row(c, yb)[xb];
      }
      const float weight = 1 / static_cast<float>(2 * pairs + 1);
      for (std::size_t c = 0; c < 3; ++c) canvas.row(c, y)[x] = weight * sum[c];
    }
  }
}

}  // namespace csd::sim
