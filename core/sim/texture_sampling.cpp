// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/texture_sampling.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/texture_sampling.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace csd::sim {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // a machine with less than SSSE3: use the scalar version

void SampleRow(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
               std::size_t n, std::array<float, 4> *out) {
  sample_scalar(levels, level_count, bias, fragments, n, out);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// A texel is a vector: texels are scattered, but each is contiguous.
using Texel = hn::FixedTag<float, 4>;
using Vector = hn::Vec<Texel>;

HWY_INLINE Vector Load(const std::uint8_t *texel) {
  const Texel d;
  const hn::Rebind<std::int32_t, Texel> d32;
  const hn::Rebind<std::uint8_t, Texel> d8;
  return hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, texel)));
}

// Multiplies and adds separately, in the scalar version's order: fused operations would round differently.
HWY_INLINE Vector Bilinear(const TexelPlace &p) {
  const Texel d;
  const float w11 = p.fx * p.fy, w10 = p.fy - w11, w01 = p.fx - w11, w00 = 1 - p.fx - w10;
  const auto top = hn::Add(hn::Mul(hn::Set(d, w00), Load(p.upper)), hn::Mul(hn::Set(d, w01), Load(p.upper + 4)));
  const auto bottom = hn::Add(hn::Mul(hn::Set(d, w10), Load(p.lower)), hn::Mul(hn::Set(d, w11), Load(p.lower + 4)));
  return hn::Add(top, bottom);
}

void SampleRow(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
               std::size_t n, std::array<float, 4> *out) {
  const Texel d;
  for (std::size_t i = 0; i < n; ++i) {
    const Fragment &f = fragments[i];
    if (f[Fragment::depth] >= Fragments::nothing) continue;
    const LevelPlace at = level_place(f[Fragment::level] + bias, level_count);
    auto value = Bilinear(texel_place(levels[at.fine], f[Fragment::u], f[Fragment::v]));
    if (at.coarse != at.fine) {
      const auto coarse = Bilinear(texel_place(levels[at.coarse], f[Fragment::u], f[Fragment::v]));
      value = hn::Add(value, hn::Mul(hn::Set(d, at.f), hn::Sub(coarse, value)));
    }
    hn::StoreU(value, d, out[i].data());
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd::sim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd::sim {

HWY_EXPORT(SampleRow);

void sample_vectors(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
                    std::size_t n, std::array<float, 4> *out) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(levels, level_count, bias, fragments, n, out);
}

void sample_scalar(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
                   std::size_t n, std::array<float, 4> *out) {
  const auto bilinear = [](const TexelPlace &p) {
    const float w11 = p.fx * p.fy, w10 = p.fy - w11, w01 = p.fx - w11, w00 = 1 - p.fx - w10;
    std::array<float, 4> value;
    for (std::size_t c = 0; c < 4; ++c) {
      value[c] = (w00 * static_cast<float>(p.upper[c]) + w01 * static_cast<float>(p.upper[c + 4])) +
                 (w10 * static_cast<float>(p.lower[c]) + w11 * static_cast<float>(p.lower[c + 4]));
    }
    return value;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Fragment &f = fragments[i];
    if (f[Fragment::depth] >= Fragments::nothing) continue;
    const LevelPlace at = level_place(f[Fragment::level] + bias, level_count);
    out[i] = bilinear(texel_place(levels[at.fine], f[Fragment::u], f[Fragment::v]));
    if (at.coarse == at.fine) continue;
    const auto coarse = bilinear(texel_place(levels[at.coarse], f[Fragment::u], f[Fragment::v]));
    for (std::size_t c = 0; c < 4; ++c) out[i][c] += at.f * (coarse[c] - out[i][c]);
  }
}

}  // namespace csd::sim
#endif  // HWY_ONCE
