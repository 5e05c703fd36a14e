// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <string_view>

#include "sim/texture_map.h"

namespace csd::sim {

/// What the tissue looks like.
enum class Style : std::uint8_t {
  heart,       ///< epicardium: muscle, yellow fat along branching vessels; glossy
  liver,       ///< dark, with a lattice of lobules that repeats; glossy
  peritoneum,  ///< pale, veined, fibrous; half dull
  bowel,       ///< pink serosa with fine vessel trees; glossy
  fat,         ///< omentum: yellow lobes; dull
  retina,      ///< a tree of strong vessels on smooth ground, little else; dull
  mucosa,      ///< pale pink, softly folded, a fine net of vessels; wet
  lobes,       ///< fat in large round lobes with dark seams
  charred,     ///< burnt: black crusts with pale rims, red patches
  speckle,     ///< white dots on dark grey, as for digital image correlation: as bright as highlights; dull
  pale,        ///< cartilage: near white, with a faint mottle; half dull
};
inline constexpr std::size_t style_count = static_cast<std::size_t>(Style::pale) + 1;

/// "heart", "liver", …
std::string_view style_name(Style style);
/// Throws std::invalid_argument that lists the names.
Style parse_style(std::string_view name);

/// The gloss of a style's tissue, 0…255, also for a user's textures.
std::uint8_t gloss_of(Style style);

/// A procedural texture that repeats every 1280 units, with `side` texels (a power of two, at least 256) per period.
/// `contrast` 1 is ordinary tissue; lower values fade the pattern but keep the large forms.
TextureMap tissue_texture(Style style, std::uint64_t seed, int side, double contrast = 1);

}  // namespace csd::sim
