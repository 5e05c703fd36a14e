// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tissue.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr float blood_colour[3] = {20, 14, 122};  // B, G, R
constexpr float water_tint[3] = {1.08F, 1.06F, 1.0F};
constexpr float stain[3] = {0.62F, 0.6F, 0.82F};      // colour that washed tissue keeps
constexpr float displaced_u = 173, displaced_v = 91;  // origin of its new pattern, units
constexpr double bed_u = 400, bed_v = 300;            // likewise for the tissue under a wound
constexpr float bed_tint[3] = {0.5F, 0.46F, 0.8F};
constexpr double nearest_seen = 20;  // units in front of the camera
constexpr float blood_gloss = 1.3F, water_gloss = 1.5F;

/// Blends the sheets in the pixels along their edges.
void soften_edges(const Fragments &fragments, Canvas &canvas) {
  struct Softened {
    int x, y;
    float colour[3];
  };
  std::vector<Softened> edge;
  const cv::Size size = canvas.size();
  for (int y = 1; y + 1 < size.height; ++y) {
    for (int x = 1; x + 1 < size.width; ++x) {
      const cv::Point beside[] = {{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}};
      const float sheet = fragments.at(x, y)[Fragment::sheet];
      if (std::all_of(std::begin(beside), std::end(beside),
                      [&](cv::Point p) { return fragments.at(p.x, p.y)[Fragment::sheet] == sheet; }))
        continue;
      Softened s{x, y, {}};
      for (std::size_t c = 0; c < 3; ++c) {
        s.colour[c] = 0.5F * canvas.row(c, y)[x];
        for (const cv::Point p : beside) s.colour[c] += 0.125F * canvas.row(c, p.y)[p.x];
      }
      edge.push_back(s);
    }
  }
  for (const Softened &s : edge)
    for (std::size_t c = 0; c < 3; ++c) canvas.row(c, s.y)[s.x] = s.colour[c];
}

}  // namespace

Tissue::Tissue(const Effects &effects, std::uint64_t seed, TextureMap texture)
    : effects_(effects),
      seed_(seed),
      surface_(effects, seed),
      texture_(std::move(texture)),
      fluids_(effects, seed),
      highlights_(effects[Effect::specular], seed) {}

/// A moment, and the motion during its exposure.
struct Tissue::View {
  View(const Tissue &tissue, double at, cv::Size size, double shutter)
      : time(at),
        moving(shutter > 0),
        camera(tissue.camera(at, size)),
        before(tissue.camera(at - shutter / 2, size)),
        after(tissue.camera(at + shutter / 2, size)),
        now(tissue.surface_.at(at)),
        earlier(tissue.surface_.at(at - shutter / 2)),
        later(tissue.surface_.at(at + shutter / 2)),
        light(at, tissue.effects_, tissue.seed_, camera) {}

  double time;
  bool moving;
  Camera camera, before, after;
  Surface::Moment now, earlier, later;
  Light light;
};

cv::Point3d Tissue::project(double time, cv::Size size, cv::Point2d uv) const {
  return camera(time, size).project(surface_.at(time).at(surface_.place(uv.x, uv.y)));
}

cv::Point3d Tissue::project(double time, cv::Size size, cv::Point2d uv, std::uint8_t sheet) const {
  return camera(time, size).project(surface_.at(time).at(surface_.place(uv.x, uv.y), sheet));
}

void Tissue::find(double time, cv::Size size, double shutter, Fragments &fragments) {
  const View view(*this, time, size, shutter);
  mesh_.build(surface_, view.now, view.camera, size);
  fragments.reset(size);
  if (!sheets().any() && !surface_.hollow()) {
    draw(view, 0, nullptr, fragments);
    return;
  }
  const auto owned_by = [this](auto owner_of) {
    owners_.clear();
    for (const Mesh::Point &p : mesh_.points) owners_.push_back(owner_of(p));
  };
  // In a cavity some walls are beside or behind the scope.
  owned_by([&](const Mesh::Point &p) { return p.image.z > nearest_seen ? p.place.sheet : Part::nobody; });
  sheets().each([&](std::uint8_t sheet) {
    mesh_.move_with(sheet, view.now, view.camera);
    const auto belongs = [&](float u, float v) { return sheet_of({u, v}) == sheet; };
    const Part part{owners_, sheet, belongs};
    draw(view, sheet, &part, fragments);
  });
  if (!sheets().any()) return;
  owned_by([&](const Mesh::Point &p) {
    // In a cavity sliding sheets gape where the walls bend.
    const bool bare = p.image.z > nearest_seen && (surface_.hollow() || Sheets::bared(view.now.cuts(), p.place.cuts));
    return static_cast<std::uint8_t>(bare ? 0 : Part::nobody);
  });
  if (std::all_of(owners_.begin(), owners_.end(), [](std::uint8_t o) { return o == Part::nobody; })) return;
  mesh_.lay_on_bed(view.now, view.camera);
  const Part part{owners_, 0};
  draw(view, Sheets::bed, &part, fragments);
}

void Tissue::draw(const View &view, int sheet, const Part *part, Fragments &fragments) {
  const bool bed = sheet == Sheets::bed;
  const auto where = [&](const Surface::Moment &moment, const Surface::Place &place) {
    if (!part) return moment.at(place);
    return bed ? moment.bed(place) : moment.at(place, static_cast<std::uint8_t>(sheet));
  };
  image_.clear();
  corners_.resize(mesh_.points.size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Mesh::Point &p = mesh_.points[i];
    Fragment &c = corners_[i];
    image_.emplace_back(p.image.x, p.image.y);
    if (part && !touches(*part, i)) continue;  // not in any cell of the part
    const double nearer = !bed && (sheet & Sheets::upper) != 0 ? Sheets::hides : 0;
    c[Fragment::depth] = static_cast<float>(p.image.z - nearer);
    c[Fragment::u] = static_cast<float>(p.place.u + (bed ? bed_u : 0));
    c[Fragment::v] = static_cast<float>(p.place.v + (bed ? bed_v : 0));
    c[Fragment::level] = static_cast<float>(p.units_log2);
    double gain = view.light.on(p.place.normal, p.normal, p.position);
    if (part) gain *= sheets().shade(view.now.cuts(), p.place.cuts, sheet);
    c[Fragment::gain] = static_cast<float>(gain);
    c[Fragment::normal_x] = static_cast<float>(p.normal.dot(view.camera.right));
    c[Fragment::normal_y] = static_cast<float>(p.normal.dot(view.camera.down));
    c[Fragment::sheet] = static_cast<float>(sheet);
    if (fluids_.any()) fluids_.wet(view.time, p.place.u, p.place.v, c);
    if (view.moving) {
      const cv::Point3d a = view.before.project(where(view.earlier, p.place)),
                        b = view.after.project(where(view.later, p.place));
      c[Fragment::motion_x] = static_cast<float>(b.x - a.x);
      c[Fragment::motion_y] = static_cast<float>(b.y - a.y);
    }
  }
  const std::size_t used = view.moving ? Fragment::count : fluids_.any() ? Fragment::motion_x : Fragment::blood;
  fragments.draw_grid(mesh_.columns, mesh_.rows, image_, corners_, used, part);
}

bool Tissue::touches(const Part &part, std::size_t corner) const {
  const int column = static_cast<int>(corner) % mesh_.columns, row = static_cast<int>(corner) / mesh_.columns;
  for (int j = std::max(row - 1, 0); j <= std::min(row + 1, mesh_.rows - 1); ++j)
    for (int i = std::max(column - 1, 0); i <= std::min(column + 1, mesh_.columns - 1); ++i)
      if (part.owners[static_cast<std::size_t>(j * mesh_.columns + i)] == part.owner) return true;
  return false;
}

std::optional<Tools::Grip> Tissue::grip(double time, cv::Size size) const {
  const Grasp g = grasp_at(time, effects_[Effect::grasp], seed_);
  if (g.in <= 0) return {};
  const cv::Point3d held = project(time, size, g.hold);
  const double w = size.width, h = size.height;
  if (!(held.z > 0 && held.x > -w && held.x < 2 * w && held.y > -h && held.y < 2 * h)) return {};
  const cv::Point2d tip(held.x, held.y), port(g.port.x * w, g.port.y * h);
  return Tools::Grip{tip + (port - tip) * (0.95 * (1 - g.in)), port, g.open, g.coloured};
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
  // Water refracts the light: looks up texels again below where it runs.
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
        // Thin at the edge, where tissue shines through.
        const float depth = blood * (0.8F + 0.15F * clamp01(f[Fragment::blood] * 0.5F));
        for (std::size_t c = 0; c < 3; ++c) texel[c] += depth * (blood_colour[c] - texel[c]);
      }
      if (water > 0)
        for (std::size_t c = 0; c < 3; ++c) texel[c] *= 1 + water * (water_tint[c] - 1);
    }
    if (f[Fragment::sheet] < 0)
      for (std::size_t c = 0; c < 3; ++c) texel[c] *= bed_tint[c];
    const float gain = f[Fragment::gain];
    for (std::size_t c = 0; c < 3; ++c) texel[c] *= gain;
    const float slope_x = (static_cast<float>(x) - principal_x) * inverse;
    const auto light = highlights_.at(f, slope_x, slope_y, gloss_of(texel[3], f, Wet));
    if (light.glow > 0) {
      constexpr float glow[3] = {95, 70, 80}, core[3] = {330, 320, 320};  // slightly violet, like a sensor's clipping
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
  if (sheets().any()) soften_edges(fragments, canvas);
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
      // Points as near as the lens have no usable motion: it is huge, or not a number.
      constexpr float max_motion = 8192;
      if (!(length >= 0.5F && length <= max_motion && std::abs(my) <= max_motion)) continue;
      // The same to both sides, so that nothing shifts.
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
