// SPDX-License-Identifier: LGPL-2.1-or-later
// Shared by the element targets: an element between two pads, and its data and events, decoded from an input's bytes.
// GstHarness is not used: its threads and clocks cost too much for hundreds of runs a second.
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

/// 0 to `most`, which must be below 256: takes one byte.
inline unsigned choose(Numbers &from, unsigned most) {
  return from.ConsumeIntegralInRange<unsigned>(0, most);
}
inline bool one_in(Numbers &from, unsigned n) {
  return choose(from, n - 1) == n - 1;
}

/// One of up to 256 values.
template <class T>
T pick(Numbers &from, std::initializer_list<T> values) {
  return values.begin()[choose(from, static_cast<unsigned>(values.size()) - 1)];
}

/// Text of up to `most` bytes without NUL, as a program can set it. Not always UTF-8.
std::string text(Numbers &from, std::size_t most = 48);

/// Caps of raw video, of up to 80×64 with a rate. `wild`: sometimes caps that no element should take.
GstCaps *video_caps(Numbers &from, bool wild);

/// A frame of these caps with a moving texture. `wild`: its size, memories, GstVideoMeta and GstVideoCropMeta may be
/// wrong. Uses at most 64 KiB of memory.
GstBuffer *frame(Numbers &from, const GstCaps *caps, unsigned index, bool wild);

/// Sets one of the element's properties, its own or inherited, to a value that its GParamSpec allows.
void set_property(Numbers &from, GstElement *element);
/// Reads all properties.
void get_properties(GstElement *element);

/// Runs an element from NULL to NULL.
class Rig {
 public:
  /// `downstream`: the caps that the pad downstream accepts; null: any. Takes ownership.
  explicit Rig(const char *factory, GstCaps *downstream = nullptr);
  ~Rig();
  Rig(const Rig &) = delete;
  Rig &operator=(const Rig &) = delete;

  GstElement *element() const { return element_; }
  void set_state(GstState state);
  /// Sets the caps from here on, after the events that a stream begins with.
  void set_caps(GstCaps *caps);  ///< takes ownership
  const GstCaps *caps() const { return caps_; }
  GstFlowReturn push(GstBuffer *buffer);  ///< takes ownership
  bool push(GstEvent *event);             ///< takes ownership
  bool push_upstream(GstEvent *event);    ///< takes ownership
  /// Sends any event up- or downstream, after `index` frames.
  void some_event(Numbers &from, unsigned index);
  void some_query(Numbers &from);
  /// Waits for an EOS or an error of an element with its own thread.
  void wait();
  /// Whether the pad downstream claims to render overlay compositions.
  bool renders_compositions = false;

 private:
  void begin();
  void read_messages();

  GstElement *element_;
  GstPad *src_ = nullptr, *sink_ = nullptr;  ///< the rig's own pads
  GstCaps *caps_ = nullptr;
  GstBus *bus_;
};

}  // namespace csd_fuzz
