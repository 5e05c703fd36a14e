// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay_composition.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "overlay/markers.h"
#include "overlay/sprite_cache.h"

namespace csd {

namespace {

constexpr char feature_name[] = GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION;

bool has_feature(GstCaps *caps) {
  return !gst_caps_is_empty(caps) && !gst_caps_is_any(caps) &&
         gst_caps_features_contains(gst_caps_get_features(caps, 0), feature_name);
}

struct Unref {
  void operator()(GstBuffer *buffer) const { gst_buffer_unref(buffer); }
};
using Pixels = std::unique_ptr<GstBuffer, Unref>;

struct UnrefComposition {
  void operator()(GstVideoOverlayComposition *composition) const { gst_video_overlay_composition_unref(composition); }
};
using Composition = std::unique_ptr<GstVideoOverlayComposition, UnrefComposition>;

/// A sprite in the format of overlay rectangles: premultiplied, in the byte order of a native 32-bit ARGB word.
Pixels to_pixels(const Sprite &sprite) {
  const auto width = static_cast<guint>(sprite.rgba.cols), height = static_cast<guint>(sprite.rgba.rows);
  Pixels out(gst_buffer_new_allocate(nullptr, gsize{4} * width * height, nullptr));
  GstMapInfo map;
  gst_buffer_map(out.get(), &map, GST_MAP_WRITE);
  guint8 *p = map.data;
  for (const cv::Vec4b &c : sprite.rgba) {
    const guint32 argb = guint32{c[3]} << 24 | guint32{c[0]} << 16 | guint32{c[1]} << 8 | c[2];
    std::memcpy(p, &argb, sizeof argb);
    p += sizeof argb;
  }
  gst_buffer_unmap(out.get(), &map);
  gst_buffer_add_video_meta(out.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_OVERLAY_COMPOSITION_FORMAT_RGB, width,
                            height);
  return out;
}

}  // namespace

struct OverlayComposition::Impl {
  struct Entry {
    Pixels pixels;
    cv::Point origin;
    cv::Size size;

    std::size_t bytes() const { return std::size_t{4} * static_cast<std::size_t>(size.area()); }
  };
  std::optional<Markers> markers;
  SpriteCache<Entry> entries;

  const Entry &entry(const Feature &feature, int width) {
    const bool left = markers->text_left(feature.id, feature.x, width);
    return entries.get(Markers::key(feature.state, feature.id, left), [&] {
      const Sprite sprite = markers->sprite(feature.state, feature.id, left);
      return Entry{to_pixels(sprite), sprite.origin, sprite.rgba.size()};
    });
  }
};

OverlayComposition::OverlayComposition() : impl_(std::make_unique<Impl>()) {}
OverlayComposition::~OverlayComposition() = default;

void OverlayComposition::attach(GstBuffer *buffer, const Tracks &tracks, int left, int top, int height) {
  if (height < 1) return;
  if (!impl_->markers || impl_->markers->lines() != height) {
    impl_->entries.clear();
    impl_->markers.emplace(height);
  }
  impl_->entries.next_frame();
  GstVideoOverlayCompositionMeta *earlier = gst_buffer_get_video_overlay_composition_meta(buffer);
  Composition composition;
  for (const Feature &feature : tracks.features) {
    if (feature.state == FeatureState::ended || !(std::abs(feature.x) < 1e6) || !(std::abs(feature.y) < 1e6)) continue;
    const Impl::Entry &entry = impl_->entry(feature, tracks.width);
    const int x = static_cast<int>(std::lround(feature.x)) - entry.origin.x;
    const int y = static_cast<int>(std::lround(feature.y)) - entry.origin.y;
    // Skips sprites outside the picture; renderers clip the others.
    if (x >= tracks.width || y >= tracks.height || x + entry.size.width <= 0 || y + entry.size.height <= 0) continue;
    GstVideoOverlayRectangle *rectangle = gst_video_overlay_rectangle_new_raw(
        entry.pixels.get(), left + x, top + y, static_cast<guint>(entry.size.width),
        static_cast<guint>(entry.size.height), GST_VIDEO_OVERLAY_FORMAT_FLAG_PREMULTIPLIED_ALPHA);
    if (!composition && earlier) composition.reset(gst_video_overlay_composition_copy(earlier->overlay));
    if (composition)
      gst_video_overlay_composition_add_rectangle(composition.get(), rectangle);
    else
      composition.reset(gst_video_overlay_composition_new(rectangle));
    gst_video_overlay_rectangle_unref(rectangle);
  }
  if (!composition) return;
  if (earlier) {
    // Renderers only look at the first composition of a buffer.
    gst_video_overlay_composition_unref(earlier->overlay);
    earlier->overlay = composition.release();
  } else {
    gst_buffer_add_video_overlay_composition_meta(buffer, composition.get());
  }
}

GstCaps *OverlayNegotiation::transform_caps(GstPadDirection direction, GstCaps *caps) const {
  bool wanted, refused;
  {
    const std::lock_guard lock(mutex_);
    wanted = wanted_;
    refused = refused_;
  }
  if (!wanted) return gst_caps_ref(caps);
  GstCaps *with = gst_caps_new_empty(), *without = gst_caps_new_empty();
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    const GstStructure *structure = gst_caps_get_structure(caps, i);
    GstCapsFeatures *features = gst_caps_get_features(caps, i);
    const auto add = [structure](GstCaps *&to, GstCapsFeatures *as) {
      to = gst_caps_merge_structure_full(to, gst_structure_copy(structure), as);
    };
    if (gst_caps_features_is_any(features)) {
      add(without, gst_caps_features_copy(features));
    } else if (gst_caps_features_contains(features, feature_name)) {
      add(with, gst_caps_features_copy(features));
      // We can add the feature if upstream lacks it.
      if (direction == GST_PAD_SRC && !refused) {
        GstCapsFeatures *plain = gst_caps_features_copy(features);
        gst_caps_features_remove(plain, feature_name);
        add(without, plain);
      }
    } else {
      if (direction == GST_PAD_SINK && !refused) {
        GstCapsFeatures *more = gst_caps_features_copy(features);
        gst_caps_features_add(more, feature_name);
        // Elements use both spellings of system memory, which don't intersect: GL the first, some sinks the second.
        if (gst_caps_features_is_equal(features, GST_CAPS_FEATURES_MEMORY_SYSTEM_MEMORY)) {
          add(with, gst_caps_features_new(GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY, feature_name, nullptr));
          gst_caps_features_remove(more, GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY);
        }
        add(with, more);
      }
      add(without, gst_caps_features_copy(features));
    }
  }
  // Prefers the feature downstream and plain caps upstream, so that this element decides.
  return direction == GST_PAD_SINK ? gst_caps_merge(with, without) : gst_caps_merge(without, with);
}

GstCaps *OverlayNegotiation::prefer(GstCaps *caps) const noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (!wanted_) return caps;
  }
  GstCaps *with = gst_caps_new_empty(), *without = gst_caps_new_empty();
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    GstCapsFeatures *features = gst_caps_get_features(caps, i);
    gst_caps_append_structure_full(gst_caps_features_contains(features, feature_name) ? with : without,
                                   gst_structure_copy(gst_caps_get_structure(caps, i)),
                                   gst_caps_features_copy(features));
  }
  gst_caps_unref(caps);
  gst_caps_append(with, without);
  return with;
}

void OverlayNegotiation::set_caps(GstCaps *in, GstCaps *out) {
  const std::lock_guard lock(mutex_);
  upstream_has_ = has_feature(in);
  downstream_has_ = has_feature(out);
  may_attach_ = false;
  settled_ = false;
}

void OverlayNegotiation::set_wanted(bool wanted) {
  const std::lock_guard lock(mutex_);
  if (wanted_ == wanted) return;
  wanted_ = wanted;
  refused_ = told_ = settled_ = false;
  gst_pad_mark_reconfigure(src_);
}

void OverlayNegotiation::restart() {
  const std::lock_guard lock(mutex_);
  refused_ = settled_ = false;
  gst_pad_mark_reconfigure(src_);
}

void OverlayNegotiation::settle() {
  bool renders = upstream_has_;
  {
    const std::lock_guard lock(mutex_);
    if (!wanted_ || settled_ || gst_pad_needs_reconfigure(src_)) return;
  }
  if (!upstream_has_ && downstream_has_)
    if (GstCaps *caps = gst_pad_get_current_caps(src_)) {
      GstQuery *query = gst_query_new_allocation(caps, FALSE);
      renders = gst_pad_peer_query(src_, query) &&
                gst_query_find_allocation_meta(query, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
      gst_query_unref(query);
      gst_caps_unref(caps);
    }
  const std::lock_guard lock(mutex_);
  // The answer came from an old downstream: the next frame asks again.
  if (gst_pad_needs_reconfigure(src_)) return;
  settled_ = true;
  may_attach_ = renders;
  if (renders) told_ = false;
  if (renders || !downstream_has_) return;
  refused_ = true;
  gst_pad_mark_reconfigure(src_);
}

bool OverlayNegotiation::take_refusal() {
  const std::lock_guard lock(mutex_);
  return wanted_ && settled_ && !may_attach_ && !std::exchange(told_, true);
}

}  // namespace csd
