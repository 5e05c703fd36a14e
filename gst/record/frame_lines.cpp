// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/frame_lines.h"

#include <utility>

#include "caps/frame_mapping.h"

namespace csd {

namespace {

struct UnrefBuffer {
  void operator()(GstBuffer *buffer) const { gst_buffer_unref(buffer); }
};
using BufferPtr = std::unique_ptr<GstBuffer, UnrefBuffer>;

constexpr char relink_mark[] = "csdtrack-relinked";

}  // namespace

void FrameLines::warn_late_once(const Given &given, GstClockTime latency) {
  const GstClockTime limit = given.due ? latency : given.max_wait;
  if ((limit == 0 && !given.due) || std::exchange(warned_late_, true)) return;
  GST_ELEMENT_WARNING(
      element_, STREAM, FAILED,
      ("Frames pass without tracks: no text has come within %" G_GUINT64_FORMAT
       " ms%s. Put a queue before each pad of csdtrackdec, or set %s higher.",
       limit / GST_MSECOND, given.due ? ", the latency" : "", given.due ? "min-upstream-latency" : "max-wait"),
      ("what comes later is left out"));
}

void FrameLines::warn_back_once() {
  if (std::exchange(warned_back_, true)) return;
  GST_ELEMENT_WARNING(element_, STREAM, FAILED,
                      ("Frames pass without tracks: the text has begun again at an earlier time, and the video has not "
                       "yet. If it won't, flush the pad text, end its stream, or link it anew."),
                      (nullptr));
}

void FrameLines::warn_nothing_once() {
  if (std::exchange(warned_nothing_, true)) return;
  GST_ELEMENT_WARNING(
      element_, RESOURCE, SETTINGS,
      ("There are no tracks to put on the frames. Set location to a .jsonl file of csdtrackenc, or link "
       "a stream of its lines to the pad text."),
      (nullptr));
}

void FrameLines::start(std::unique_ptr<TrackFile> file) {
  file_ = std::move(file);
  from_file_ = file_ != nullptr;
  first_stream_.clear();
  another_stream_ = late_ = relinked_ = false;
  warned_late_ = warned_nothing_ = warned_unread_ = warned_another_ = warned_back_ = false;
  now_ = {};
  const std::lock_guard lock(mutex_);
  pad_ = {};
  matcher_ = {};
}

void FrameLines::frames_begin(const char *stream_id) {
  if (stream_id && first_stream_.empty()) first_stream_ = stream_id;
  if (stream_id) another_stream_ = first_stream_ != stream_id;
  const std::lock_guard lock(mutex_);
  matcher_.frames_begin();
}

void FrameLines::flush_frames() {
  const std::lock_guard lock(mutex_);
  matcher_.frames_begin_anew();
}

void FrameLines::frame(const FrameMoments &moments) {
  now_ = moments;
  const std::lock_guard lock(mutex_);
  matcher_.frame(moments);
}

bool FrameLines::need_not_wait() {
  if (file_ || late_ || !linked_) return true;
  const std::lock_guard lock(mutex_);
  return matcher_.decided() || pad_.over();
}

/// Calls change() under the lock, and then posts what there is to say: its handler may flush the pad.
template <class Change>
void FrameLines::change_pad(Change change) {
  PadLines::Notices notices;
  {
    const std::lock_guard lock(mutex_);
    change();
    notices = pad_.take_notices();
  }
  PadLines::post(element_, notices);
}

/// Reads what is on the pad, up to the current frame's line.
void FrameLines::read(GstAggregatorPad *text) {
  std::optional<Failure> failure;
  // Takes the buffer under the lock: a flush that empties the pad must not find us with an old line in hand.
  change_pad([&] {
    while (!matcher_.decided()) {
      const BufferPtr buffer(gst_aggregator_pad_pop_buffer(text));
      if (!buffer) break;
      if (is_empty_gap(buffer.get())) continue;
      if (auto its = guarded([&] { pad_.take(buffer.get(), matcher_); })) failure = std::move(its);
    }
  });
  if (failure) guard_.post(element_, *failure);
}

bool FrameLines::leave_text() {
  if (!from_file_) return false;
  if (!warned_unread_.exchange(true))
    GST_ELEMENT_WARNING(element_, RESOURCE, SETTINGS,
                        ("What is linked to the pad text is not read, for location is set. Use one of them."),
                        (nullptr));
  return true;
}

std::optional<TrackLine> FrameLines::find_in_file() {
  if (!another_stream_) return now_.stream ? file_->at(*now_.stream) : std::nullopt;
  if (!std::exchange(warned_another_, true))
    GST_ELEMENT_WARNING(element_, STREAM, FAILED,
                        ("Frames pass without tracks: another video follows the one that location is for. Play it in "
                         "a pipeline of its own, or link the text of both to the pad text."),
                        ("the first stream-id was '%s'", first_stream_.c_str()));
  return std::nullopt;
}

bool FrameLines::find_on_pad(GstAggregatorPad *text, const Given &given, std::optional<TrackLine> &line) {
  if (text) read(text);
  const bool more = text && linked_;
  bool known = false, back = false;
  {
    const std::lock_guard lock(mutex_);
    known = matcher_.decided() || pad_.over() || !more;
    if (!known && !given.due && !given.overdue && !late_) return false;
    line = matcher_.take();
    back = matcher_.lines_ahead();
  }
  if (back) warn_back_once();
  late_ = false;
  if (known) return true;
  const GstClockTime latency = gst_aggregator_get_latency(GST_AGGREGATOR(element_));
  // Live, each frame waits as long as the latency allows. Else one after the other would wait in vain.
  late_ = !GST_CLOCK_TIME_IS_VALID(latency);
  if (!line) warn_late_once(given, latency);
  return true;
}

bool FrameLines::find(GstAggregatorPad *text, const Given &given, std::optional<TrackLine> &line) {
  if (file_) {
    line = find_in_file();
    return true;
  }
  if (!linked_ && !relinked_) warn_nothing_once();
  return find_on_pad(text, given, line);
}

void FrameLines::skip(GstAggregatorPad *text, const FrameMoments &moments) {
  if (file_ || !text) return;
  frame(moments);
  read(text);
}

PadLines::Notices FrameLines::text_event(GstEvent *event) {
  const std::lock_guard lock(mutex_);
  if (GST_EVENT_TYPE(event) == GST_EVENT_CUSTOM_DOWNSTREAM && gst_event_has_name(event, relink_mark))
    pad_.relinked(matcher_);
  else
    pad_.handle(event, matcher_);
  return pad_.take_notices();
}

GstEvent *FrameLines::take_relinked() {
  if (!relinked_.exchange(false)) return nullptr;
  return gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty(relink_mark));
}

void FrameLines::flush_text() {
  const std::lock_guard lock(mutex_);
  pad_.flush(matcher_);
}

bool FrameLines::text_ended() {
  const std::lock_guard lock(mutex_);
  return pad_.ended();
}

void FrameLines::set_linked(bool linked) {
  linked_ = linked;
  if (!linked) relinked_ = true;
}

}  // namespace csd
