// SPDX-License-Identifier: LGPL-2.1-or-later
// csdtrackdec with frames, and with lines in a file or on its pad `text`. The input: lines, a separator, and numbers
// that choose the actions. A frame waits for its text for at most a millisecond. Text waits for frames, so it comes
// from a thread of its own.
#include "elements.h"
#include "record/klv.h"

namespace {

using namespace csd_fuzz;

/// A source linked to the pad `text`.
class TextPad {
 public:
  TextPad(Rig &rig, std::string_view bytes)
      : rig_(rig), bytes_(bytes), pad_(gst_element_request_pad_simple(rig.element(), "text")) {
    if (!pad_) return;
    ours_ = gst_pad_new("text", GST_PAD_SRC);
    gst_object_ref_sink(ours_);
    gst_pad_set_active(ours_, TRUE);
    gst_pad_link(ours_, pad_);
    thread_ = g_thread_pool_new(send, ours_, 1, TRUE, nullptr);
    send(gst_event_new_stream_start("t"));
  }
  ~TextPad() {
    if (!pad_) return;
    gst_pad_push_event(ours_, gst_event_new_flush_start());  // ends a wait; the rest is refused
    g_thread_pool_free(thread_, FALSE, TRUE);
    gst_pad_set_active(ours_, FALSE);
    gst_pad_unlink(ours_, pad_);
    gst_object_unref(ours_);
    gst_element_release_request_pad(rig_.element(), pad_);
    gst_object_unref(pad_);
  }
  TextPad(const TextPad &) = delete;
  TextPad &operator=(const TextPad &) = delete;

  void set_caps(Numbers &from) {
    static const char *const kinds[] = {"application/x-ndjson", "text/x-raw,format=utf8",
                                        "text/x-raw,format=pango-markup", "text/x-raw", "meta/x-klv"};
    const unsigned kind = choose(from, 4);
    klv_ = kind == 4;
    GstCaps *caps = gst_caps_from_string(kinds[kind]);
    send(gst_event_new_caps(caps));
    gst_caps_unref(caps);
  }
  void begin(GstFormat format) {
    GstSegment segment;
    gst_segment_init(&segment, format);
    send(gst_event_new_segment(&segment));
  }
  /// A line, or some bytes. In KLV most are in a packet, which may be one of several and may be cut.
  void push(Numbers &from) {
    const std::size_t end = bytes_.find('\n');
    std::size_t size = end == std::string_view::npos ? bytes_.size() : end + 1;
    if (one_in(from, 4)) size = std::min<std::size_t>(bytes_.size(), choose(from, 255));
    const std::size_t there = size > planted_bytes() ? size - planted_bytes() : size;
    std::string data(bytes_.substr(0, there));
    bytes_.remove_prefix(size);
    if (klv_ && !one_in(from, 4)) {
      const std::size_t count = one_in(from, 2) ? 1 : 1 + choose(from, 3);
      data = csd::klv_packet(data, choose(from, 255), count - 1 - choose(from, count - 1), count);
      if (one_in(from, 4)) data.resize(choose(from, data.size()));
      size = data.size() + planted_bytes();
    }
    auto *copy = static_cast<guint8 *>(g_malloc(std::max<std::size_t>(data.size(), 1)));
    std::copy_n(data.begin(), data.size(), copy);
    GstBuffer *buffer = gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, copy, size, 0, size, copy, g_free);
    if (klv_ && one_in(from, 8)) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
    if (one_in(from, 2)) GST_BUFFER_PTS(buffer) = one_in(from, 8) ? from.ConsumeIntegral<guint64>() : line_ * 40000000;
    ++line_;
    send(buffer);
  }
  void event(Numbers &from) {
    switch (choose(from, 5)) {
      case 0:
        gst_pad_push_event(ours_, gst_event_new_flush_start());
        gst_pad_push_event(ours_, gst_event_new_flush_stop(TRUE));
        break;
      case 1:
        send(gst_event_new_gap(from.ConsumeIntegralInRange<guint64>(0, G_MAXUINT64 - 1),
                               one_in(from, 2) ? from.ConsumeIntegral<guint64>() : 1));
        break;
      case 2:
        send(gst_event_new_eos());
        break;
      case 3:
        set_caps(from);
        break;
      case 4:
        send(gst_event_new_stream_start("t"));
        break;
      default:
        begin(one_in(from, 3) ? GST_FORMAT_BYTES : GST_FORMAT_TIME);
    }
  }

 private:
  void send(gpointer buffer_or_event) { g_thread_pool_push(thread_, buffer_or_event, nullptr); }
  static void send(gpointer buffer_or_event, gpointer ours) {
    if (GST_IS_EVENT(buffer_or_event))
      gst_pad_push_event(GST_PAD(ours), GST_EVENT(buffer_or_event));
    else
      gst_pad_push(GST_PAD(ours), GST_BUFFER(buffer_or_event));
  }

  Rig &rig_;
  std::string_view bytes_;
  GstPad *pad_, *ours_ = nullptr;
  GThreadPool *thread_ = nullptr;
  guint64 line_ = 0;
  bool klv_ = false;
};

void step(Numbers &from, Rig &rig, TextPad *text, unsigned &index) {
  switch (choose(from, 11)) {
    case 0:
      set_property(from, rig.element());
      break;
    case 1:
      rig.some_event(from, index);
      break;
    case 2:
      rig.some_query(from);
      break;
    case 3:
      rig.set_caps(video_caps(from, one_in(from, 8)));
      break;
    case 4:
      rig.set_state(static_cast<GstState>(GST_STATE_NULL + choose(from, GST_STATE_PLAYING - GST_STATE_NULL)));
      break;
    case 5:
      get_properties(rig.element());
      rig.renders_compositions = !rig.renders_compositions;
      break;
    case 6:
      if (text) text->event(from);
      break;
    case 7:
    case 8:
      if (text) text->push(from);
      break;
    default:
      rig.push(frame(from, rig.caps(), index++, one_in(from, 4)));
  }
}

}  // namespace

void csd_fuzz::run(std::string_view bytes) {
  const auto parts = split(bytes, 2);
  Numbers from(reinterpret_cast<const std::uint8_t *>(parts.back().data()), parts.back().size());
  Rig rig("csdtrackdec");
  const MemoryFile file(parts[0].substr(0, parts[0].size() - (parts.size() == 1 ? planted_bytes() : 0)));
  const bool by_file = from.ConsumeBool();
  static const char *const overlays[] = {"none", "draw", "meta"};
  gst_util_set_object_arg(G_OBJECT(rig.element()), "overlay", overlays[choose(from, 2)]);
  g_object_set(rig.element(), "max-wait", guint64{1000 * choose(from, 1)}, nullptr);
  if (by_file) g_object_set(rig.element(), "location", file.path().c_str(), nullptr);
  std::unique_ptr<TextPad> text;
  if (!by_file || one_in(from, 8)) text = std::make_unique<TextPad>(rig, parts[0]);
  rig.set_state(GST_STATE_PLAYING);
  rig.set_caps(video_caps(from, false));
  if (text) {
    text->set_caps(from);
    text->begin(GST_FORMAT_TIME);
  }
  unsigned index = 0;
  for (int steps = 0; steps < 24 && from.remaining_bytes() > 0; ++steps) step(from, rig, text.get(), index);
}
