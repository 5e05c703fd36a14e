// SPDX-License-Identifier: LGPL-2.1-or-later
// What the targets of the elements share: an element between two pads of ours, and what goes through it, decoded from
// an input's bytes. Without GstHarness, whose threads and clocks are more than is needed a hundred times a second.
#pragma once

#include <fuzzer/FuzzedDataProvider.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include <initializer_list>
#include <memory>
#include <string>

#include "fuzz.h"

namespace csd_fuzz {

using Numbers = FuzzedDataProvider;

/// 0 to `most`, which is below 256: one byte.
inline unsigned choose(Numbers &from, unsigned most) {
  return from.ConsumeIntegralInRange<unsigned>(0, most);
}
inline bool one_in(Numbers &from, unsigned n) {
  return choose(from, n - 1) == n - 1;
}

/// One of at most 256.
template <class T>
T pick(Numbers &from, std::initializer_list<T> values) {
  return values.begin()[choose(from, static_cast<unsigned>(values.size()) - 1)];
}

/// Text of at most `most` bytes without a zero: what a program can set. Not always UTF-8.
std::string text(Numbers &from, std::size_t most = 48);

/// Caps of raw video. `wild`: also such as no element should take; else a size of at most 80×64 and a rate.
GstCaps *video_caps(Numbers &from, bool wild);

/// A frame of these caps, of a moving texture. `wild`: its size, its memories, its GstVideoMeta and GstVideoCropMeta
/// may lie. Never more than 64 KiB of memory.
GstBuffer *frame(Numbers &from, const GstCaps *caps, unsigned index, bool wild);

/// Sets some property of the element's own or of its class's to a value that its GParamSpec allows.
void set_property(Numbers &from, GstElement *element);
/// Reads all of them.
void get_properties(GstElement *element);

/// An element, from NULL to NULL.
class Rig {
 public:
  /// `downstream`: what our pad behind it takes; null: anything. Takes it.
  explicit Rig(const char *factory, GstCaps *downstream = nullptr);
  ~Rig();
  Rig(const Rig &) = delete;
  Rig &operator=(const Rig &) = delete;

  GstElement *element() const { return element_; }
  void set_state(GstState state);
  /// Caps from here on, with what a stream needs before them.
  void set_caps(GstCaps *caps);  ///< takes it
  const GstCaps *caps() const { return caps_; }
  GstFlowReturn push(GstBuffer *buffer);  ///< takes it
  bool push(GstEvent *event);             ///< takes it
  bool push_upstream(GstEvent *event);    ///< takes it
  /// An event of any kind, either way; `index` frames have gone before.
  void some_event(Numbers &from, unsigned index);
  void some_query(Numbers &from);
  /// Until an EOS or an error, of an element with a thread of its own.
  void wait();
  /// What is told downstream of overlays that aren't drawn.
  bool renders_compositions = false;

 private:
  void begin();
  void read_messages();

  GstElement *element_;
  GstPad *src_ = nullptr, *sink_ = nullptr;  ///< ours
  GstCaps *caps_ = nullptr;
  GstBus *bus_;
};

}  // namespace csd_fuzz
