// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <vector>

namespace csd {

/// The raw formats that decoders and capture cards usually produce, as a caps list. A test iterates over it. They have
/// a structure of their own, which comes first: within a structure the source's order decides, and videotestsrc prefers
/// the deepest format.
#define CSD_USUAL_FORMATS                                                                                       \
  "I420, YV12, NV12, NV21, Y42B, Y444, YUY2, UYVY, GRAY8, RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, " \
  "ABGR, v210, I420_10LE, I422_10LE, Y444_10LE, P010_10LE"
/// The others that frame_view() describes in place: GBR is OBS's lossless recording, Y41B is NTSC DV.
#define CSD_OTHER_FORMATS                                                                                             \
  "NV16, VUYA, P012_LE, I420_12LE, RGBA64_LE, ARGB64, Y210, Y410, r210, BGR10A2_LE, GRAY10_LE32, GRAY16_LE, "         \
  "GRAY16_BE, Y41B, GBR, GBRA, RGBP, BGRP, GBR_10LE, GBR_10BE, GBR_12LE, GBR_12BE, GBRA_10LE, GBRA_10BE, GBRA_12LE, " \
  "GBRA_12BE"
/// The same of GStreamer 1.24 and later.
#define CSD_NEWER_FORMATS "GBR_16LE, GBR_16BE"
#define CSD_NATIVE_FORMATS "{ " CSD_USUAL_FORMATS ", " CSD_OTHER_FORMATS " }"

/// Whether frame_view() describes the format's samples in place. If not, GStreamer's unpacking reads them.
bool is_native(GstVideoFormat format);

/// Every raw format of the running GStreamer that has pixels to read: the usual ones, the other native ones, the rest.
std::vector<GstVideoFormat> pixel_formats();

/// Caps of both pad templates: every format, the usual ones first, plain and with the feature
/// meta:GstVideoOverlayComposition; progressive, interleaved and mixed, but neither fields nor alternate (a field alone
/// is no picture). The caller owns the result.
GstCaps *template_caps();

/// The same for elements that don't map: followed by every format in every memory, with every feature. The caller owns
/// the result.
GstCaps *any_memory_caps();

/// Whether frames of these caps can be mapped: they are among template_caps().
bool can_map(GstCaps *caps);

/// Parses caps. Caps that can't be mapped give only size and framerate: GstVideoInfo may not know their formats.
/// Returns false if even these are missing.
bool read_caps(GstCaps *caps, GstVideoInfo &info);

/// Adds interlace-mode=progressive to the structures of `caps` that lack the field, which is what the lack means.
/// Without it they are no subset of the template's caps and would be refused, so GstBaseTransformClass.accept_caps
/// checks these instead. The caller owns the result.
GstCaps *complete_caps(GstCaps *caps);

/// The caps of `formats`, as template_caps(). The caller owns the result.
GstCaps *caps_of(const std::vector<GstVideoFormat> &formats);

}  // namespace csd
