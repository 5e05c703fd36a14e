// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <array>
#include <vector>

#include "image/frame_view.h"

namespace csd {

/// Lines of a component in its plane: row q of the component's grid is line first + q·step.
struct ComponentLines {
  int first = 0, step = 1;
  int sub_y = 0;  ///< log2 of the view's rows to a row of the grid
};

/// The bytes of a line of `plane` with `width` pixels, not for tiles. In formats without pixel strides it is
/// GStreamer's own stride, rounded up to a multiple of 4, which a plane's last line may lack. Throws std::runtime_error
/// if the format can't be that wide.
gint64 plane_line_bytes(const GstVideoFormatInfo &format, guint plane, gint64 width);

/// Whether the planes of a frame in tiles hold all tiles of its size.
bool holds_its_tiles(const GstVideoFrame &frame);

/// As many pixels, or the next number of them that the format's unpack and pack functions take without a mistake.
/// MappedLines has room for these.
int whole_groups(const GstVideoFormatInfo &format, int pixels);

/// Whether GstVideoFormatInfo's plane is a palette instead of samples.
inline bool is_palette(const GstVideoFormatInfo &format, guint plane) {
  return GST_VIDEO_FORMAT_INFO_HAS_PALETTE(&format) && plane == 1;
}
constexpr gint64 palette_bytes = 1024;

/// Lines of a mapped frame in a form that the format's own unpack and pack functions take, never with a byte outside
/// the mapped memory.
class MappedLines {
 public:
  /// For a frame that MappedFrame has found to hold its lines, and pixels up to column `width`. `frame` must outlive
  /// this object.
  MappedLines(const GstVideoFrame &frame, int width);

  /// What a line needs besides the frame: reused from line to line.
  struct Room {
    std::vector<guint8> planes[GST_VIDEO_MAX_PLANES];
  };
  /// Arguments of unpack_func and pack_func, for one line.
  struct Line {
    gpointer data[GST_VIDEO_MAX_PLANES] = {};
    gint stride[GST_VIDEO_MAX_PLANES] = {};
    gint y = 0;
  };

  bool tiled() const { return tiled_; }
  int planes() const { return planes_; }
  /// The planes' lines `lines`, in place. A plane's line is copied to `room`, with zeros behind it, if the functions
  /// might read past its memory, or if `copy` is set. In tiles `y` tells the line and `lines` isn't used.
  Line line(const std::array<int, GST_VIDEO_MAX_PLANES> &lines, int y, bool copy, Room &room) const;
  /// Copies a line's planes back from `room`. Not for tiles.
  void put(const std::array<int, GST_VIDEO_MAX_PLANES> &lines, const Room &room) const;
  /// The line in the frame's memory, and its bytes: plane_line_bytes().
  guint8 *place(int plane, int line) const;
  std::size_t bytes(int plane) const { return static_cast<std::size_t>(needed_[plane]); }

 private:
  const GstVideoFrame &frame_;
  bool tiled_;
  int planes_;
  gint64 needed_[GST_VIDEO_MAX_PLANES] = {};   ///< bytes of a line
  gint64 touched_[GST_VIDEO_MAX_PLANES] = {};  ///< bytes that the functions may touch, and more
};

/// Reads a frame by the unpack function of its format, line by line and in place.
class RowUnpacker : public PixelReader {
 public:
  /// Pixels [x, x + width) of the lines that `lines` names for each component. `frame` must outlive this object, and
  /// hold its lines.
  RowUnpacker(const GstVideoFrame &frame, int x, int width, int rows, bool fields,
              const std::array<ComponentLines, GST_VIDEO_MAX_COMPONENTS> &lines, const std::array<Component, 3> &grids);

  void read(int row, int first, int n, const std::array<std::uint8_t *, 3> &out) const override;

 private:
  void read_part(const MappedLines::Line &line, int begin, int n, int sub_x,
                 const std::array<std::uint8_t *, 3> &out) const;

  const GstVideoFormatInfo &format_;
  MappedLines frame_lines_;
  int x_, rows_, grain_;
  int grain_bytes_[GST_VIDEO_MAX_PLANES] = {};
  bool deep_;
  GstVideoPackFlags flags_;
  std::array<ComponentLines, GST_VIDEO_MAX_COMPONENTS> lines_;
  std::array<int, 3> sub_x_{};
};

/// Whether the format's unpacked pixels have 16 bits.
bool unpacks_deep(const GstVideoFormatInfo &format);

}  // namespace csd
