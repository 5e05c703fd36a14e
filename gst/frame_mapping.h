// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <string_view>

#include "image/frame_view.h"

namespace csd {

/// The raw formats that decoders and capture cards give, as a caps list. A test walks through it. The usual ones are a
/// structure of their own, the first: within one the order is the source's, and videotestsrc begins with the deepest.
#define CSD_USUAL_FORMATS                                                                                       \
  "I420, YV12, NV12, NV21, Y42B, Y444, YUY2, UYVY, GRAY8, RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, " \
  "ABGR, v210, I420_10LE, I422_10LE, Y444_10LE, P010_10LE"
#define CSD_OTHER_FORMATS \
  "NV16, VUYA, P012_LE, I420_12LE, RGBA64_LE, ARGB64, Y210, Y410, r210, BGR10A2_LE, GRAY10_LE32, GRAY16_LE"
#define CSD_VIDEO_FORMATS "{ " CSD_USUAL_FORMATS ", " CSD_OTHER_FORMATS " }"

/// Caps of both pad templates: every format, the usual ones first, plain and with the feature
/// meta:GstVideoOverlayComposition; progressive, interleaved and mixed, but neither fields nor alternate (a field alone
/// is no picture). The caller owns the result.
GstCaps *template_caps();

/// The same for who doesn't map: after them every format in every memory, with every feature. The caller owns the
/// result.
GstCaps *any_memory_caps();

/// Whether frames of these caps can be mapped: they are of template_caps().
bool can_map(GstCaps *caps);

/// What caps say, of those that can't be mapped size and framerate alone: their formats GstVideoInfo may not know.
/// False: not even these.
bool read_caps(GstCaps *caps, GstVideoInfo &info);

/// `caps` with interlace-mode=progressive where a structure lacks that field, which is what the lack means. Without it
/// such caps are no subset of the template's and would be refused: GstBaseTransformClass.accept_caps asks about these
/// instead. The caller owns the result.
GstCaps *complete_caps(GstCaps *caps);

/// A buffer's pixels, mapped for as long as this lives.
class MappedFrame {
 public:
  /// Throws std::runtime_error if the buffer can't be mapped, or is not what the caps say.
  MappedFrame(const GstVideoInfo &info, GstBuffer *buffer, GstMapFlags access);
  ~MappedFrame() { gst_video_frame_unmap(&frame_); }
  MappedFrame(const MappedFrame &) = delete;
  MappedFrame &operator=(const MappedFrame &) = delete;
  GstVideoFrame *operator->() { return &frame_; }
  GstVideoFrame &operator*() { return frame_; }

 private:
  GstVideoFrame frame_;
};

/// A buffer's bytes, mapped for reading for as long as this lives.
class MappedBytes {
 public:
  /// Throws std::runtime_error if the buffer can't be mapped.
  explicit MappedBytes(GstBuffer *buffer);
  ~MappedBytes() { gst_buffer_unmap(buffer_, &map_); }
  MappedBytes(const MappedBytes &) = delete;
  MappedBytes &operator=(const MappedBytes &) = delete;
  std::string_view bytes() const { return {reinterpret_cast<const char *>(map_.data), map_.size}; }

 private:
  GstBuffer *buffer_;
  GstMapInfo map_;
};

/// Left and right, or more views, come frame by frame in one stream, says its multiview-mode: frames that follow one
/// another aren't pictures of one view.
bool views_take_turns(const GstVideoInfo &caps);

/// Frames without pixels are legal where they are marked as a gap: there is nothing to see, and nothing wrong.
bool is_empty_gap(GstBuffer *buffer);

/// A rectangle of a frame, in its pixels.
struct PictureArea {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PictureArea &) const = default;
};

/// What of `frame` is the picture: the size that `caps` says (a GstVideoMeta's may be larger: padding), or with `crop`
/// (may be null) its rectangle, clamped to the frame. Width and height are 0 where nothing is left.
PictureArea picture_area(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop);

/// The same of a buffer that is not mapped: its GstVideoMeta and GstVideoCropMeta say.
PictureArea picture_area(GstBuffer *buffer, const GstVideoInfo &caps);

/// Whether a frame holds two fields, and which is first in time; the bottom one is the odd lines of the frame.
enum class Fields { progressive, top_first, bottom_first };
Fields frame_fields(const GstVideoFrame &frame);

/// A view of the picture in `frame`, or of the field that is first in time. `frame` must be mapped for reading (its
/// plane pointers and strides are then those of a GstVideoMeta, where there is one) and outlive the view; `caps`
/// is what it was mapped with, one of CSD_VIDEO_FORMATS. Nothing is copied. Coordinates are those of picture_area();
/// where that is empty, the view has width, height and rows 0.
///
/// A crop or a field that begins within a chroma sample rounds that sample's origin down: colour is then off by at
/// most one chroma sample, luma never.
FrameView frame_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop = nullptr);

/// Where the memory of plane `plane` ends: at the next plane, or with the memory it is mapped from.
const guint8 *plane_end(const GstVideoFrame &frame, guint plane);

/// Where the samples of a component lie in a line of their plane.
struct SamplePlace {
  int offset = 0;           ///< byte of the first
  int bytes = 1;            ///< of the word that holds one: 1, 2 or 4
  int shift = 0;            ///< its lowest bit in that word
  bool big_endian = false;  ///< that word
};

/// Of component `c` of a format that has no groups.
SamplePlace sample_place(const GstVideoFormatInfo &format, guint c);

/// Of formats that put several pixels into a group of bytes.
struct SampleGroups {
  Packing packing;
  int pixels, bytes;
};

/// Null of formats whose pixels lie at strides.
const SampleGroups *sample_groups(const GstVideoFormatInfo &format);

}  // namespace csd
