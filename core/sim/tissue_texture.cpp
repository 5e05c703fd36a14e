// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tissue_texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/ieee_math.h"
#include "sim/noise_field.h"
#include "sim/vessels.h"

namespace csd::sim {
namespace {

constexpr double period = 1280;  // units
constexpr std::uint64_t stream_texture = 900;

// Luma deviation in a patch of 21 units, exceeded by a fifth of the texture: features are detected there. In the
// pictures it is less, because of the light's gain and the pyramid's smoothing.
constexpr double pattern_deviation = 17.8;
constexpr double pattern_share = 0.8;
constexpr int patch_units = 21;
constexpr double form_units = 30;  // larger forms don't count as pattern

constexpr std::array<std::string_view, style_count> names = {
    "heart", "liver", "peritoneum", "bowel", "fat", "retina", "mucosa", "lobes", "charred", "speckle", "pale"};
constexpr std::array<std::uint8_t, style_count> glosses = {235, 245, 150, 215, 190, 110, 255, 200, 215, 60, 120};

struct Colour {
  float b, g, r;
};

Colour operator*(float k, Colour c) {
  return {k * c.b, k * c.g, k * c.r};
}
Colour mix(Colour a, Colour b, float f) {
  return {a.b + f * (b.b - a.b), a.g + f * (b.g - a.g), a.r + f * (b.r - a.r)};
}

/// 0…1 around `middle`, for a field of deviation 1.
float above(float x, float middle, float width) {
  return smoothstep((x - middle) / width + 0.5F);
}

/// Creates the fields of one texture; lengths in units.
class Loom {
 public:
  Loom(std::uint64_t seed, int side) : seed_(seed), side_(side), per_unit_(side / period) {}

  int side() const { return side_; }

  NoiseField noise(std::vector<Octave> octaves) {
    for (Octave &o : octaves) o.size *= per_unit_;
    return fractal_noise(side_, octaves, seed_, stream_++);
  }
  /// Cells with irregular borders: displaced by noise of up to about `warp`.
  Cells cells_of(double size, double jitter, double warp) {
    const Cells straight = cells(side_, size * per_unit_, jitter, seed_, stream_++);
    const NoiseField dx = noise({{0.8 * size, 1}, {0.3 * size, 0.5}}), dy = noise({{0.8 * size, 1}, {0.3 * size, 0.5}});
    const auto scale = static_cast<float>(0.5 * warp * per_unit_);
    Cells out{NoiseField(side_), NoiseField(side_)};
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const int xx = (x + static_cast<int>(scale * dx.row(y)[x]) + 2 * side_) % side_;
        const int yy = (y + static_cast<int>(scale * dy.row(y)[x]) + 2 * side_) % side_;
        out.edge.row(y)[x] = straight.edge.row(yy)[xx];
        out.value.row(y)[x] = straight.value.row(yy)[xx];
      }
    }
    return out;
  }
  NoiseField vessels(std::vector<VesselOptions> sets) {
    NoiseField field(side_);
    for (VesselOptions &o : sets) {
      o.width *= per_unit_;
      o.least *= per_unit_;
      o.length *= per_unit_;
      o.wind /= per_unit_;
      draw_vessels(field, o, seed_, stream_++);
    }
    return field;
  }
  /// A fibrous field: noise stretched to `along` times its width (a power of two) and bent by a warp.
  NoiseField fibres(double width, int along, double warp) {
    const NoiseField source = noise({{width * along, 1}, {width * along / 2, 0.6}}),
                     bend = noise({{420, 1}, {140, 0.2}, {30, 0.03}});
    NoiseField out(side_);
    const auto shift = static_cast<float>(warp * per_unit_);
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const int yy = along * y + along * static_cast<int>(std::floor(shift * bend.row(y)[x]));
        out.row(y)[x] = source.row(((yy % side_) + side_) % side_)[x];
      }
    }
    return out;
  }

 private:
  std::uint64_t seed_;
  int side_;
  double per_unit_;
  std::uint64_t stream_ = stream_texture;
};

template <class Shade>
cv::Mat weave(int side, std::uint8_t gloss, Shade shade) {
  cv::Mat texture(side, side, CV_8UC4);
  for (int y = 0; y < side; ++y) {
    std::uint8_t *out = texture.ptr(y);
    for (int x = 0; x < side; ++x, out += 4) {
      const Colour c = shade(x, y);
      const float value[3] = {c.b, c.g, c.r};
      // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative, and a call of lround for each texel would be slow
      for (int i = 0; i < 3; ++i) out[i] = static_cast<std::uint8_t>(std::clamp(value[i], 0.0F, 255.0F) + 0.5F);
      out[3] = gloss;
    }
  }
  return texture;
}

cv::Mat heart(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{260, 1}, {110, 0.6}, {45, 0.35}}),
                   fine = loom.noise({{12, 1}, {5, 0.7}, {2.5, 0.5}});
  const NoiseField fat_form = loom.noise({{190, 1}, {75, 0.6}, {28, 0.4}, {10, 0.25}, {5, 0.1}});
  const NoiseField fibre = loom.fibres(3.5, 8, 60);
  const Cells lobules = loom.cells_of(17, 0.95, 7);
  const NoiseField arteries = loom.vessels({{4, 6.5, 1.6, 640, 0.09, 4}, {7, 3.2, 0.9, 300, 0.12, 4}});
  const NoiseField veins = loom.vessels({{4, 8.5, 2.4, 560, 0.06, 3}}),
                   hairs = loom.vessels({{46, 1.7, 0.7, 130, 0.15, 4}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float f = form.row(y)[x], n = fine.row(y)[x];
    Colour c = mix({52, 40, 146}, {128, 124, 214}, clamp01(0.5F + 0.3F * f));
    c = (1 + 0.045F * fibre.row(y)[x] + 0.04F * n) * c;
    const float fat = above(fat_form.row(y)[x] + 0.1F * n, 0.85F, 0.75F);
    if (fat > 0) {
      const float lobe = smoothstep(1.7F * lobules.edge.row(y)[x]), own = lobules.value.row(y)[x];
      Colour yellow = mix({72, 132, 208}, {118, 184, 232}, 0.75F * lobe + 0.3F * own - 0.1F);
      c = mix(c, (1 + 0.025F * n) * yellow, 0.85F * fat);
    }
    // Spots of blood under the surface.
    c = mix(c, {36, 22, 112}, 0.65F * above(n - 0.3F * f, 2.0F, 1.0F));
    c = mix(c, {104, 58, 112}, 0.55F * veins.row(y)[x]);
    c = mix(c, {56, 42, 158}, 0.5F * hairs.row(y)[x]);
    return mix(c, {40, 30, 142}, 0.7F * arteries.row(y)[x]);
  });
}

cv::Mat liver(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{300, 1}, {120, 0.5}}), fine = loom.noise({{6, 1}, {3, 0.9}});
  const NoiseField blotch = loom.noise({{50, 1}, {22, 0.7}, {10, 0.3}});
  const Cells lobules = loom.cells_of(8.5, 0.5, 3);
  const NoiseField threads = loom.vessels({{24, 1.8, 0.8, 300, 0.12, 4}}),
                   veins = loom.vessels({{4, 5, 2, 420, 0.07, 3}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x], patchy = blotch.row(y)[x];
    Colour c = mix({40, 32, 104}, {70, 60, 148}, clamp01(0.5F + 0.25F * form.row(y)[x] + 0.14F * patchy));
    // Each lobule is dark in its middle and pale at its border, unevenly across the texture.
    const float lobe = smoothstep(1.6F * lobules.edge.row(y)[x]), net = clamp01(0.65F + 0.3F * patchy);
    c = (1.12F - 0.3F * net * lobe + 0.16F * (lobules.value.row(y)[x] - 0.5F) + 0.06F * n) * c;
    c = mix(c, {60, 36, 84}, 0.5F * veins.row(y)[x]);
    // Vessels of the capsule, and its thicker parts.
    c = mix(c, {104, 100, 186}, 0.5F * threads.row(y)[x]);
    return mix(c, {150, 150, 200}, 0.35F * above(patchy + 0.5F * n, 2.4F, 1.4F));
  });
}

cv::Mat peritoneum(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{280, 1}, {120, 0.6}, {50, 0.3}}),
                   fine = loom.noise({{9, 1}, {4, 0.7}, {2.5, 0.4}});
  const NoiseField fibre = loom.fibres(4.5, 8, 60), sheet = loom.noise({{170, 1}, {70, 0.6}, {25, 0.3}});
  const NoiseField small = loom.vessels({{16, 2.8, 0.8, 330, 0.12, 5}, {40, 1.6, 0.7, 130, 0.16, 4}});
  const NoiseField veins = loom.vessels({{7, 9, 2.2, 620, 0.06, 3}}), blots = loom.noise({{26, 1}, {12, 0.5}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x];
    Colour c = mix({58, 98, 184}, {140, 148, 222}, clamp01(0.5F + 0.32F * form.row(y)[x]));
    c = (1 + 0.03F * n + 0.02F * blots.row(y)[x]) * c;
    // Fascia: whitish strands in sheets.
    const float strands = clamp01(0.45F + 0.35F * fibre.row(y)[x]) * above(sheet.row(y)[x], 0.7F, 1.6F);
    c = mix(c, {196, 200, 230}, 0.42F * strands);
    c = mix(c, {132, 92, 138}, 0.5F * veins.row(y)[x]);
    return mix(c, {58, 46, 168}, 0.65F * small.row(y)[x]);
  });
}

cv::Mat bowel(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{240, 1}, {100, 0.6}, {40, 0.3}}),
                   fine = loom.noise({{12, 1}, {6, 0.8}, {3, 0.5}});
  const NoiseField stripes = loom.fibres(6, 8, 90), blots = loom.noise({{30, 1}, {14, 0.6}});
  const NoiseField trees = loom.vessels({{7, 4.5, 0.8, 360, 0.1, 6}, {26, 2.2, 0.7, 170, 0.14, 5}});
  const NoiseField blue = loom.vessels({{6, 5, 1.5, 420, 0.07, 3}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x];
    Colour c = mix({108, 104, 198}, {182, 180, 234}, clamp01(0.5F + 0.3F * form.row(y)[x]));
    c = (1 + 0.025F * n + 0.02F * stripes.row(y)[x] + 0.025F * blots.row(y)[x]) * c;
    c = mix(c, {150, 104, 150}, 0.5F * blue.row(y)[x]);
    return mix(c, {66, 52, 176}, 0.65F * trees.row(y)[x]);
  });
}

cv::Mat fat(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{260, 1}, {100, 0.6}, {40, 0.3}}), fine = loom.noise({{8, 1}, {3.5, 0.7}});
  const Cells lobes = loom.cells_of(58, 1, 34), middle = loom.cells_of(24, 1, 14), grains = loom.cells_of(10, 0.95, 4);
  const NoiseField small = loom.vessels({{16, 3, 0.8, 320, 0.12, 6}, {30, 1.6, 0.7, 120, 0.16, 3}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x];
    Colour c = mix({48, 146, 232}, {112, 198, 246},
                   clamp01(0.5F + 0.3F * form.row(y)[x] + 0.2F * (middle.value.row(y)[x] - 0.5F)));
    const float lobe = smoothstep(3 * lobes.edge.row(y)[x]), part = smoothstep(2 * middle.edge.row(y)[x]);
    const float grain = smoothstep(2 * grains.edge.row(y)[x]);
    // Deep and red between the lobes, shallow between their parts.
    c = mix({34, 82, 178}, c, 0.3F + 0.5F * lobe + 0.2F * part);
    c = (0.87F + 0.07F * part + 0.06F * grain + 0.1F * (grains.value.row(y)[x] - 0.5F) + 0.025F * n) * c;
    return mix(c, {46, 46, 176}, 0.65F * small.row(y)[x]);
  });
}

cv::Mat retina(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{330, 1}, {150, 0.5}}), fine = loom.noise({{14, 1}, {5, 0.7}});
  const NoiseField under = loom.vessels({{26, 9, 5, 300, 0.12, 3}});
  const NoiseField veins = loom.vessels({{7, 10, 1.6, 860, 0.028, 5}, {9, 4, 1.2, 330, 0.06, 4}});
  const NoiseField arteries = loom.vessels({{6, 6.5, 1.4, 800, 0.04, 5}, {30, 2.4, 0.9, 200, 0.1, 4}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x];
    Colour c = mix({40, 74, 184}, {66, 112, 214}, clamp01(0.5F + 0.3F * form.row(y)[x]));
    c = (1 + 0.02F * n) * c;
    // The choroid's vessels shine through.
    c = mix(c, {62, 104, 222}, 0.25F * under.row(y)[x]);
    c = mix(c, {26, 22, 96}, 0.9F * veins.row(y)[x]);
    return mix(c, {32, 34, 138}, 0.85F * arteries.row(y)[x]);
  });
}

cv::Mat mucosa(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{260, 1}, {110, 0.6}}), fine = loom.noise({{9, 1}, {4, 0.8}});
  const NoiseField folds = loom.fibres(46, 4, 90);
  const Cells net = loom.cells_of(30, 1, 22), pits = loom.cells_of(7, 0.8, 2);
  const NoiseField small = loom.vessels({{22, 2.6, 0.8, 240, 0.16, 6}, {60, 1.4, 0.6, 110, 0.2, 4}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x];
    Colour c = mix({142, 134, 216}, {194, 190, 240}, clamp01(0.5F + 0.3F * form.row(y)[x]));
    // Folds: long soft swellings with creases between them.
    const float fold = folds.row(y)[x];
    c = (1 + 0.07F * std::clamp(fold, -2.0F, 2.0F)) * c;
    c = mix(c, {98, 84, 178}, 0.5F * smoothstep(1 - 1.1F * std::abs(fold + 0.9F)));
    c = (0.97F + 0.05F * smoothstep(2 * pits.edge.row(y)[x]) + 0.025F * n) * c;
    c = mix(c, {104, 82, 188},
            0.45F * (1 - smoothstep(7 * net.edge.row(y)[x])) * clamp01(0.5F + 0.4F * form.row(y)[x]));
    return mix(c, {76, 56, 170}, 0.65F * small.row(y)[x]);
  });
}

cv::Mat lobes(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{280, 1}, {120, 0.6}}), fine = loom.noise({{7, 1}, {3.5, 0.8}});
  const Cells large = loom.cells_of(92, 0.9, 26), parts = loom.cells_of(34, 1, 12);
  const NoiseField small = loom.vessels({{26, 2.6, 0.8, 220, 0.16, 6}, {40, 1.4, 0.7, 100, 0.2, 4}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x], own = large.value.row(y)[x], part = parts.value.row(y)[x];
    Colour c = mix({56, 158, 226}, {126, 206, 248}, clamp01(0.5F + 0.25F * form.row(y)[x] + 0.5F * (own - 0.5F)));
    // Round: bright on top, darker towards the seam.
    const float up = clamp01(1.5F * large.edge.row(y)[x]), round = std::sqrt(up * (2 - up));
    const float inner = clamp01(1.8F * parts.edge.row(y)[x]), swell = std::sqrt(inner * (2 - inner));
    c = (0.66F + 0.24F * round + 0.13F * swell + 0.08F * (part - 0.5F) + 0.025F * n) * c;
    c = mix({30, 52, 132}, c, 0.35F + 0.65F * smoothstep(6 * large.edge.row(y)[x]));
    return mix(c, {44, 44, 176}, 0.65F * small.row(y)[x]);
  });
}

cv::Mat charred(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{240, 1}, {90, 0.6}}), fine = loom.noise({{8, 1}, {3.5, 1}});
  const NoiseField burnt = loom.noise({{150, 1}, {60, 0.7}, {24, 0.4}, {10, 0.2}});
  const NoiseField bleeding = loom.noise({{110, 1}, {45, 0.6}, {18, 0.25}});
  const Cells flakes = loom.cells_of(17, 1, 11);
  const NoiseField trees = loom.vessels({{12, 3.2, 0.8, 260, 0.14, 5}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const float n = fine.row(y)[x], b = burnt.row(y)[x] + 0.08F * n, wet = bleeding.row(y)[x] + 0.05F * n;
    Colour c = mix({66, 66, 158}, {104, 112, 196}, clamp01(0.5F + 0.3F * form.row(y)[x]));
    c = mix((1 + 0.05F * n) * c, {44, 36, 146}, 0.55F * trees.row(y)[x]);
    // Towards the crust tissue is pale from heat, then brown, then black and cracked.
    c = mix(c, (1 + 0.04F * n) * Colour{140, 166, 208}, 0.8F * above(b, 0.15F, 0.5F));
    c = mix(c, (1 + 0.1F * n) * Colour{44, 66, 112}, above(b, 0.62F, 0.35F));
    const float flake = smoothstep(3.5F * flakes.edge.row(y)[x]);
    const Colour crust = mix({22, 30, 74}, mix({20, 22, 32}, {46, 54, 78}, flakes.value.row(y)[x]), flake);
    c = mix(c, (1 + 0.12F * n) * crust, above(b, 1.0F, 0.4F));
    // Blood: dark and smooth, thinner at its edge.
    return mix(c, mix({34, 26, 158}, {20, 14, 104}, above(wet, 1.5F, 1.0F)), 0.9F * above(wet, 1.0F, 0.3F));
  });
}

cv::Mat speckle(Loom &loom, std::uint8_t gloss) {
  const Cells dots = loom.cells_of(9, 0.7, 0);
  return weave(loom.side(), gloss, [&](int x, int y) {
    return mix({20, 20, 20}, {250, 250, 250}, above(dots.edge.row(y)[x], 0.4F, 0.3F));
  });
}

cv::Mat pale(Loom &loom, std::uint8_t gloss) {
  const NoiseField form = loom.noise({{240, 1}, {100, 0.5}}), fine = loom.noise({{16, 1}, {8, 0.8}, {4, 0.6}});
  return weave(loom.side(), gloss, [&](int x, int y) {
    const Colour c = mix({168, 184, 200}, {196, 206, 216}, clamp01(0.5F + 0.3F * form.row(y)[x]));
    return (1 + 0.05F * fine.row(y)[x]) * c;
  });
}

double deviation_of(Style style) {
  // The retina's patches contain little more than a thin vessel each.
  if (style == Style::retina) return 1.14 * pattern_deviation;
  // Else it would be no speckle.
  return style == Style::speckle ? 5 * pattern_deviation : pattern_deviation;
}

/// The value exceeded by a fifth of all patches: the deviation of luma within a patch of 21 units.
double strong_deviation(const cv::Mat &texture) {
  const double per_unit = texture.cols / period;
  const int step = std::max(1, static_cast<int>(floor_of(per_unit + 0.5)));  // about every unit
  std::vector<double> all;
  const int side = static_cast<int>(patch_units * per_unit);
  for (int y = 0; y + side < texture.rows; y += 2 * side) {
    for (int x = 0; x + side < texture.cols; x += 2 * side) {
      double sum = 0, squares = 0, n = 0;
      for (int j = 0; j < side; j += step) {
        for (int i = 0; i < side; i += step) {
          const std::uint8_t *p = texture.ptr(y + j) + 4 * (x + i);
          const double luma = 0.114 * p[0] + 0.587 * p[1] + 0.299 * p[2];
          sum += luma;
          squares += luma * luma;
          n += 1;
        }
      }
      all.push_back(std::max(squares / n - sum * sum / (n * n), 0.0));
    }
  }
  const auto at = static_cast<std::size_t>(pattern_share * static_cast<double>(all.size()));
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(at), all.end());
  return std::sqrt(all[at]);
}

}  // namespace

std::string_view style_name(Style style) {
  return names.at(static_cast<std::size_t>(style));
}

Style parse_style(std::string_view name) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<Style>(i);
  std::string all;
  for (const auto n : names) all += (all.empty() ? "" : ", ") + std::string(n);
  throw std::invalid_argument("no style \"" + std::string(name) + "\"; there are " + all);
}

std::uint8_t gloss_of(Style style) {
  return glosses.at(static_cast<std::size_t>(style));
}

TextureMap tissue_texture(Style style, std::uint64_t seed, int side, double contrast) {
  if (side < 256 || (side & (side - 1)) != 0) throw std::invalid_argument("a texture's side is a power of two");
  Loom loom(seed + 7919 * static_cast<std::uint64_t>(style), side);
  const std::uint8_t gloss = gloss_of(style);
  cv::Mat texture;
  switch (style) {
    case Style::heart:
      texture = heart(loom, gloss);
      break;
    case Style::liver:
      texture = liver(loom, gloss);
      break;
    case Style::peritoneum:
      texture = peritoneum(loom, gloss);
      break;
    case Style::bowel:
      texture = bowel(loom, gloss);
      break;
    case Style::fat:
      texture = fat(loom, gloss);
      break;
    case Style::retina:
      texture = retina(loom, gloss);
      break;
    case Style::mucosa:
      texture = mucosa(loom, gloss);
      break;
    case Style::lobes:
      texture = lobes(loom, gloss);
      break;
    case Style::charred:
      texture = charred(loom, gloss);
      break;
    case Style::speckle:
      texture = speckle(loom, gloss);
      break;
    case Style::pale:
      texture = pale(loom, gloss);
      break;
  }
  const double per_unit = side / period;
  scale_pattern(texture, form_units * per_unit,
                contrast * deviation_of(style) / std::max(strong_deviation(texture), 0.5));
  return TextureMap(texture, per_unit);
}

}  // namespace csd::sim
