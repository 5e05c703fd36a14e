// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace csd {

/// One colour component (Y, U, V, R, G or B) of a picture in memory; not owned.
struct Component {
  const std::uint8_t *data = nullptr;  ///< the first sample of the first row
  std::ptrdiff_t row_stride = 0;       ///< bytes from a row to the next
  std::ptrdiff_t pixel_stride = 1;     ///< bytes from a sample to the next in its row
  std::uint8_t bytes = 1;              ///< 1, or 2 for a 16-bit word, unaligned
  std::uint8_t shift = 0;              ///< right shift that leaves the upper 8 bits of the sample
  std::uint8_t sub_x = 0;              ///< log2 of the horizontal subsampling
  std::uint8_t sub_y = 0;              ///< log2 of the vertical subsampling
  std::uint8_t left = 0;    ///< of a word: left shift, before `shift`, that removes the bits above the sample
  bool big_endian = false;  ///< of a word
  std::uint16_t black = 0;  ///< with a `gain`: the word that maps to 0
  std::uint16_t gain = 0;   ///< if not 0, a word maps to (word − black)·gain / 2^16, without shifts
};

enum class ColourModel : std::uint8_t { gray, yuv, rgb };

/// v210 packs 6 pixels of 4:2:2 10 bit into 16 bytes; gray10 packs 3 pixels into a 32-bit word, low bits first. All
/// other formats are components with strides.
enum class Packing : std::uint8_t { components, v210, gray10 };

/// Reads the samples of a picture that no Component describes.
class PixelReader {
 public:
  virtual ~PixelReader() = default;
  /// Reads `n` ≥ 1 samples from column `first` of row `row` as 8 bit: component k into out[k], unless that is null. Row
  /// and column are in the grid of these components, which must have the same. May be called by several threads.
  virtual void read(int row, int first, int n, const std::array<std::uint8_t *, 3> &out) const = 0;
};

/// A view of a picture or one of its fields; copies no pixel and owns none.
///
/// Coordinates of features are the *picture's* (pixel centres at integers, top left 0,0): row r of the view is the
/// picture's line `row_step * r + row_offset`. A progressive picture has rows == height, row_step 1, row_offset 0.
struct FrameView {
  int width = 0;   ///< of the picture, pixels
  int height = 0;  ///< of the picture, pixels
  int rows = 0;    ///< rows in the view: height, or the field's
  int row_step = 1;
  int row_offset = 0;
  ColourModel model = ColourModel::gray;
  Packing packing = Packing::components;
  /// With Packing::v210 or gray10: the view's first column is this pixel of the row, 0…5 or 0…2 (a crop may begin
  /// inside a group).
  int x_offset = 0;
  /// Y · Y,U,V · R,G,B. With Packing::v210 or gray10 only component[0].data and .row_stride are used.
  std::array<Component, 3> component{};
  /// Not null: it reads all samples. Of the components only sub_x and sub_y are then used, and no Packing.
  std::shared_ptr<const PixelReader> reader{};
  double kr = 0.2126;       ///< Y'CbCr matrix (BT.709 unless the stream says otherwise)
  double kb = 0.0722;       ///< Y'CbCr matrix
  bool full_range = false;  ///< Y'CbCr in 0…255 instead of 16…235/240
  /// 16-bit gray that may use any part of its range: GrayWindow finds that part and sets black and gain.
  bool open_range = false;

  bool has_pixels() const { return width > 0 && rows > 0 && (reader || component[0].data); }
};

}  // namespace csd
