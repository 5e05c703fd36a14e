// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace csd {

/// Caches markers in the form that one overlay needs. `T` has a size: bytes().
///
/// Drops sprites unused for 60 frames, at the latest after 120: ids are not reused, so most belong to ended features.
/// The cache is bounded in bytes: a sprite to draw takes 17 kB at 480 lines and 230 kB at 2160. Sprites that don't fit
/// are made anew for each frame, and the next frame drops those that the last one did not show. So a frame with too
/// many markers costs time (250 µs a marker at 2160 lines), not memory.
template <class T>
class SpriteCache {
 public:
  static constexpr std::size_t max_bytes = 32 << 20;

  static constexpr std::uint64_t min_frames = 60;  ///< without a sprite before it is dropped

  /// Call before the first sprite of each frame.
  void next_frame() {
    if (std::exchange(full_, false))
      drop_unseen_for(1);
    else if (frame_ % min_frames == 0)
      drop_unseen_for(min_frames);
    ++frame_;
  }

  /// The sprite for `key`, made by make() if missing. Valid until the next call if the cache is full(), else until the
  /// next frame or clear().
  template <class Make>
  const T &get(std::uint64_t key, Make make) {
    if (const auto found = kept_.find(key); found != kept_.end()) {
      found->second.frame = frame_;
      return found->second.sprite;
    }
    homeless_ = make();
    if (bytes_ + homeless_.bytes() > max_bytes) {
      full_ = true;
      return homeless_;
    }
    const T &sprite = kept_.try_emplace(key, Kept{std::move(homeless_), frame_}).first->second.sprite;
    bytes_ += sprite.bytes();
    return sprite;
  }

  /// Whether a sprite of this frame didn't fit.
  bool full() const { return full_; }

  void clear() {
    kept_.clear();
    bytes_ = 0;
  }

 private:
  struct Kept {
    T sprite;
    std::uint64_t frame;  ///< the last one that showed it
  };
  void drop_unseen_for(std::uint64_t frames) {
    std::erase_if(kept_, [=, this](const auto &item) {
      const bool drop = item.second.frame + frames <= frame_;
      if (drop) bytes_ -= item.second.sprite.bytes();
      return drop;
    });
  }

  std::unordered_map<std::uint64_t, Kept> kept_;
  std::size_t bytes_ = 0;  ///< of kept_
  T homeless_;             ///< the last that didn't fit
  bool full_ = false;
  std::uint64_t frame_ = 0;
};

}  // namespace csd
