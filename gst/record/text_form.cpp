// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/text_form.h"

#include <optional>
#include <utility>

#include "record/klv.h"
#include "record/line_splitter.h"
#include "record/markup.h"
#include "text/read_line.h"

namespace csd {

namespace {

/// JSON lines, split anywhere. Only a buffer that is exactly one line says when it is.
class ByteLines : public TextForm {
 public:
  void read(const TextBuffer &buffer, const TakeLine &take, const LoseLine &) override {
    splitter_.add(buffer.text,
                  [&](std::string_view line, bool whole) { take(line, whole ? buffer.time : TextTime()); });
  }
  bool unfinished() const override { return splitter_.unfinished(); }
  void clear() override { splitter_.clear(); }

 private:
  LineSplitter splitter_;
};

/// A text track: a buffer is a line, or one of its text_pieces().
class TrackText : public TextForm {
 public:
  explicit TrackText(bool is_markup) : is_markup_(is_markup) {}
  void read(const TextBuffer &buffer, const TakeLine &take, const LoseLine &lose) override {
    if (is_markup_)
      pieces_.add(unescape_markup(buffer.text), buffer.time, buffer.discont, take, lose);
    else
      pieces_.add(buffer.text, buffer.time, buffer.discont, take, lose);
  }
  bool unfinished() const override { return pieces_.unfinished(); }
  void clear() override { pieces_.clear(); }

 private:
  const bool is_markup_;
  LinePieces pieces_;
};

/// Packets with such text, split anywhere, perhaps among others' packets.
class KlvText : public TextForm {
 public:
  void read(const TextBuffer &buffer, const TakeLine &take, const LoseLine &lose) override {
    if (buffer.discont && unfinished()) {
      lose("its rest is missing");
      clear();
    }
    bool begun_before = packets_.unfinished();
    const auto next = [&] {
      if (std::exchange(begun_before, false)) packet_time_ = buffer.time;
    };
    if (!begun_before) packet_time_ = buffer.time;
    packets_.add(
        buffer.text,
        [&](std::string_view text, bool follows) {
          take_packet(text, follows, take, lose);
          next();
        },
        [&] {
          lose("a packet was torn");
          pieces_.clear();
          next();
        });
    if (!ours_ && !packets_.unfinished() && buffer.text.size() >= klv_label.size()) ++others_;
  }
  bool unfinished() const override { return packets_.unfinished() || pieces_.unfinished(); }
  void clear() override {
    packets_.clear();
    pieces_.clear();
  }
  bool hopeless() const override { return hopeless_; }
  bool only_others() const override { return others_ >= 50; }

 private:
  void take_packet(std::string_view text, bool follows, const TakeLine &take, const LoseLine &lose) {
    ours_ = true;
    // Of several packets in a buffer only the first has its time.
    const TextTime time = std::exchange(packet_time_, {std::nullopt, packet_time_.untimed});
    // ffmpeg -c copy leaves packets without timestamps (seen with 5.1). Their own time is not that of the transport
    // stream.
    hopeless_ = time.untimed;
    if (hopeless_) {
      lose("it has no timestamp");
      pieces_.clear();
      return;
    }
    try {
      pieces_.add(text, time, !follows, take, lose);
    } catch (const LineError &error) {
      lose(error.what());
      pieces_.clear();
    }
  }

  KlvSplitter packets_;
  TextTime packet_time_;  ///< of the buffer in which the next packet begins, if it is the first one there
  LinePieces pieces_;
  unsigned others_ = 0;  ///< buffers large enough for one of our packets, but without one
  bool ours_ = false;    ///< a packet was found
  bool hopeless_ = false;
};

}  // namespace

std::unique_ptr<TextForm> make_text_form(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  if (gst_structure_has_name(structure, "application/x-ndjson")) return std::make_unique<ByteLines>();
  if (gst_structure_has_name(structure, "meta/x-klv")) return std::make_unique<KlvText>();
  return std::make_unique<TrackText>(g_strcmp0(gst_structure_get_string(structure, "format"), "pango-markup") == 0);
}

}  // namespace csd
