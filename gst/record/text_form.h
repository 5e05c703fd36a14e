// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <memory>
#include <string_view>

#include "record/line_pieces.h"

namespace csd {

/// A pad's buffer.
struct TextBuffer {
  std::string_view text;
  TextTime time;
  bool discont = false;  ///< data is missing before it
};

/// How lines come in a stream of buffers: one class for each form of csdtrackenc. Holds at most one unfinished line.
class TextForm {
 public:
  virtual ~TextForm() = default;
  /// Throws LineError for an invalid line. KLV comes over networks: there it is a lost line.
  virtual void read(const TextBuffer &buffer, const TakeLine &take, const LoseLine &lose) = 0;
  /// Whether a line has begun.
  virtual bool unfinished() const = 0;
  /// Forgets the line that has begun.
  virtual void clear() = 0;
  /// Whether the stream has timestamps, but this form can't be matched from here on: frames must not wait for it.
  virtual bool hopeless() const { return false; }
  /// Whether so much has come without any line of ours that none can be expected.
  virtual bool only_others() const { return false; }
};

/// The form of a stream of these caps.
std::unique_ptr<TextForm> make_text_form(const GstCaps *caps);

}  // namespace csd
