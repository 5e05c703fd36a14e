// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <string_view>

#include "caps/formats.h"
#include "image/frame_view.h"

namespace csd {

/// Maps a buffer's pixels for its lifetime.
class MappedFrame {
 public:
  /// Throws std::runtime_error if the buffer can't be mapped or doesn't match the caps.
  MappedFrame(const GstVideoInfo &info, GstBuffer *buffer, GstMapFlags access);
  ~MappedFrame() { gst_video_frame_unmap(&frame_); }
  MappedFrame(const MappedFrame &) = delete;
  MappedFrame &operator=(const MappedFrame &) = delete;
  GstVideoFrame *operator->() { return &frame_; }
  GstVideoFrame &operator*() { return frame_; }

 private:
  GstVideoFrame frame_;
};

/// Maps a buffer's bytes for reading, for its lifetime.
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

/// Whether multiview-mode says that the views (left and right, or more) alternate frame by frame: consecutive frames
/// then show different views.
bool views_take_turns(const GstVideoInfo &caps);

/// A frame without pixels is legal if flagged as a gap: nothing to see, but no error.
bool is_empty_gap(GstBuffer *buffer);

/// A rectangle in pixels of a frame.
struct PictureArea {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PictureArea &) const = default;
};

/// The part of `frame` that is the picture: the caps' size (a GstVideoMeta's may be larger: padding), or the rectangle
/// of `crop` (may be null), clamped to the frame. Width and height are 0 if nothing is left.
PictureArea picture_area(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop);

/// The same for an unmapped buffer, from its GstVideoMeta and GstVideoCropMeta.
PictureArea picture_area(GstBuffer *buffer, const GstVideoInfo &caps);

/// Whether a frame holds two fields, and which comes first in time. The bottom field is the frame's odd lines.
enum class Fields { progressive, top_first, bottom_first };
Fields frame_fields(const GstVideoFrame &frame);

/// A view of the picture in `frame`, or of the field that comes first in time. `frame` must be mapped for reading (its
/// plane pointers and strides then follow its GstVideoMeta, if any) and outlive the view; `caps` is what it was mapped
/// with. Copies no frame: in formats that are not is_native() the view has a reader that unpacks rows. Coordinates are
/// those of picture_area(); if that is empty, the view has width, height and rows 0.
///
/// If a crop or a field starts within a chroma sample, that sample's origin is rounded down: colour is then off by at
/// most one chroma sample, luma never.
FrameView frame_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop = nullptr);

/// The same with a reader in every format, to measure and to test. A reader shows the same samples.
FrameView unpacked_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop = nullptr);

/// Whether a frame that MappedFrame has mapped, not in tiles, has line `line` of component `c`. It has those of its
/// height. Two fields of 4n+2 lines have a chroma line more, which GStreamer's default layout has room for; a
/// GstVideoMeta's may have another plane there, or nothing.
bool has_line(const GstVideoFrame &frame, guint c, int line);

/// Where the samples of a component lie in a line of their plane.
struct SamplePlace {
  int offset = 0;           ///< byte of the first sample
  int bytes = 1;            ///< of the word that holds a sample: 1, 2 or 4
  int shift = 0;            ///< the sample's lowest bit in the word
  bool big_endian = false;  ///< the word's byte order
};

/// For component `c` of an ungrouped format.
SamplePlace sample_place(const GstVideoFormatInfo &format, guint c);

/// For formats that pack several pixels into a group of bytes.
struct SampleGroups {
  Packing packing;
  int pixels, bytes;
};

/// Null for ungrouped formats.
const SampleGroups *sample_groups(const GstVideoFormatInfo &format);

}  // namespace csd
