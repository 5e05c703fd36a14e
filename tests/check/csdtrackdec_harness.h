// SPDX-License-Identifier: LGPL-2.1-or-later
// Lines, frames and harnesses for the tests of csdtrackdec.
#pragma once

#include <glib/gstdio.h>
#include <gst/check/gstharness.h>
#include <gst/video/video.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "attach.h"
#include "bus.h"
#include "read_text.h"

namespace csd_check {

inline constexpr char gray_64[] = "video/x-raw,format=GRAY8,width=64,height=48,framerate=25/1";
inline constexpr GstClockTime frame_time = 40 * GST_MSECOND;

/// A file in a folder that is removed with the process.
inline std::string temporary(const char *name) {
  static const struct Folder {
    gchar *path = g_dir_make_tmp("csdtrackdec-XXXXXX", nullptr);
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
      g_free(path);
    }
  } folder;
  return std::string(folder.path) + "/" + name;
}

inline std::string write_file(const char *name, const std::string &content) {
  const std::string path = temporary(name);
  fail_unless(g_file_set_contents(path.c_str(), content.data(), static_cast<gssize>(content.size()), nullptr));
  return path;
}

inline std::string read_file(const std::string &path) {
  gchar *data = nullptr;
  gsize size = 0;
  fail_unless(g_file_get_contents(path.c_str(), &data, &size, nullptr), "%s", path.c_str());
  std::string text(data, size);
  g_free(data);
  return text;
}

/// The samples of a recording's text track, one after the other, by an independent reader.
inline std::string extracted(const std::string &recording) {
  const std::string out = temporary("extracted");
  const std::string command = "ffmpeg -v error -y -i " + recording + " -map 0:s -c copy -f data " + out;
  gchar *err = nullptr;
  gint status = 1;
  fail_unless(g_spawn_command_line_sync(command.c_str(), nullptr, &err, &status, nullptr) && status == 0, "%s", err);
  g_free(err);
  return read_file(out);
}

/// What csdtrackenc writes for a tracked frame `n` of 64×48 pixels: one feature, at 10+n,20. Without newline.
inline std::string line(guint64 n, GstClockTime stream_time) {
  g_autofree gchar *text = g_strdup_printf(
      "{\"schema\":1,\"source\":\"csdtrack0\",\"role\":\"track\",\"algorithm\":\"csd\",\"frame\":%" G_GUINT64_FORMAT
      ",\"pts\":%" G_GUINT64_FORMAT ",\"duration\":40000000,\"running_time\":0,\"stream_time\":%" G_GUINT64_FORMAT
      ",\"reference\":null,\"width\":64,\"height\":48,\"features\":[{\"id\":3,\"x\":%" G_GUINT64_FORMAT
      ".250,\"y\":20.000,\"state\":\"tracked\",\"confidence\":0.931}]}",
      n, stream_time, stream_time, 10 + n);
  return text;
}
inline std::string line(guint64 n) {
  return line(n, n * frame_time);
}

inline std::string lines(guint64 from, guint64 to) {
  std::string text;
  for (guint64 n = from; n < to; ++n) text += line(n) + "\n";
  return text;
}

/// Adds a meta of `count` features, which differ in each frame.
inline void attach_many(GstBuffer *buffer, guint64 frame, guint count, const std::string &source = "csdtrack0") {
  std::vector<GstCsdFeature> features;
  for (guint i = 0; i < count; ++i)
    features.push_back({i, i % 64 + 0.125, static_cast<double>(frame % 48), GST_CSD_STATE_TRACKED, 0.931, TRUE});
  GstCsdHeader header{};
  header.source = source.c_str();
  header.algorithm = "csd";
  header.frame = frame;
  header.width = header.tracked_width = 64;
  header.height = header.tracked_height = 48;
  header.n_features = count;
  fail_unless(gst_buffer_add_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, &header, features.data()) != nullptr);
}

inline GstBuffer *frame_at(GstClockTime pts, GstClockTime duration = frame_time) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, 64 * 48, nullptr);
  gst_buffer_memset(buffer, 0, 100, 64 * 48);
  GST_BUFFER_PTS(buffer) = pts;
  GST_BUFFER_DURATION(buffer) = duration;
  return buffer;
}

/// The number of the frame whose tracks this buffer has, −1 if it has none.
inline int number_on(GstBuffer *buffer, const char *name = GST_CSD_TRACK_META_NAME) {
  GstCsdHeader header;
  const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, name, nullptr);
  if (!tracks) return -1;
  fail_unless(gst_csd_structure_get_header(tracks, &header));
  return static_cast<int>(header.frame);
}

/// The element asks at once whether its peers are live: what is set later comes too late.
inline GstHarness *new_side(GstElement *element, bool live, const char *sink, const char *src) {
  static GstStaticPadTemplate source = GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
  static GstStaticPadTemplate end = GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
  GstHarness *h = gst_harness_new_empty();
  gst_harness_set_live(h, live);
  gst_harness_add_element_full(h, element, &source, sink, &end, src);
  return h;
}

struct Harness {
  GstElement *element;
  GstHarness *h = nullptr;
  GstBus *bus = gst_bus_new();

  explicit Harness(const std::string &location = "", const char *caps = gray_64, const char *overlay = "none",
                   GstElement *given = nullptr, bool live = true)
      : element(given ? given : gst_element_factory_make("csdtrackdec", nullptr)) {
    if (!location.empty()) g_object_set(element, "location", location.c_str(), nullptr);
    gst_util_set_object_arg(G_OBJECT(element), "overlay", overlay);
    gst_element_set_bus(element, bus);
    h = new_side(element, live, "sink", "src");
    if (caps) gst_harness_set_src_caps_str(h, caps);
  }
  ~Harness() {
    gst_bus_set_flushing(bus, TRUE);
    gst_element_set_state(element, GST_STATE_NULL);  // its thread may still ask a pad that goes
    gst_harness_teardown(h);
    gst_element_set_bus(element, nullptr);
    gst_object_unref(element);
    gst_object_unref(bus);
  }
  Harness(const Harness &) = delete;
  Harness &operator=(const Harness &) = delete;

  /// Pushes a frame and returns the number of the tracks on it.
  int push(GstBuffer *frame) {
    GstBuffer *out = gst_harness_push_and_pull(h, frame);
    fail_unless(out != nullptr);
    const int number = number_on(out);
    gst_buffer_unref(out);
    return number;
  }
  int push(GstClockTime pts) { return push(frame_at(pts)); }

  std::string said(GstMessageType types) { return csd_check::said(bus, types); }
};

inline constexpr char ndjson[] = "application/x-ndjson", utf8[] = "text/x-raw,format=utf8",
                      markup[] = "text/x-raw,format=pango-markup";

/// A buffer from csdtrackenc.
struct Encoded {
  std::string text;
  GstClockTime pts, duration;
  bool discont;
};

/// csdtrackenc's output for a frame at 80 ms, flagged DISCONT, with `count` features.
inline std::vector<Encoded> encoded(guint count, const std::string &source = "csdtrack0",
                                    GstClockTime duration = frame_time, const char *out = utf8,
                                    const char *in = gray_64) {
  GstHarness *h = gst_harness_new("csdtrackenc");
  gst_harness_set_sink_caps_str(h, out);
  gst_harness_set_src_caps_str(h, in);
  GstBuffer *frame = frame_at(2 * frame_time, duration);
  attach_many(frame, 2, count, source);
  GST_BUFFER_FLAG_SET(frame, GST_BUFFER_FLAG_DISCONT);
  fail_unless_equals_int(gst_harness_push(h, frame), GST_FLOW_OK);
  std::vector<Encoded> buffers;
  while (GstBuffer *buffer = gst_harness_try_pull(h)) {
    buffers.push_back({text_in(buffer), GST_BUFFER_PTS(buffer), GST_BUFFER_DURATION(buffer),
                       GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DISCONT) != 0});
    gst_buffer_unref(buffer);
  }
  gst_harness_teardown(h);
  return buffers;
}

inline GstBuffer *bytes(const std::string &text, GstClockTime pts = GST_CLOCK_TIME_NONE) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, text.size(), nullptr);
  gst_buffer_fill(buffer, 0, text.data(), text.size());
  GST_BUFFER_PTS(buffer) = pts;
  return buffer;
}

/// Sends text to a pad in order, from a thread of its own. Not live, csdtrackdec's pad holds one buffer: the next one
/// blocks until frames have used it.
class TextThread {
 public:
  explicit TextThread(GstPad *pad) : pad_(pad), thread_([this] { run(); }) {}
  /// Deactivate the pad, or its peer, first: else this blocks too.
  ~TextThread() {
    {
      const std::lock_guard lock(mutex_);
      steps_.clear();
      over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  TextThread(const TextThread &) = delete;
  TextThread &operator=(const TextThread &) = delete;

  void push(GstBuffer *buffer) {
    const std::shared_ptr<GstBuffer> held(buffer, gst_buffer_unref);
    then([this, held] {
      ++begun_;
      flow_ = gst_pad_push(pad_, gst_buffer_ref(held.get()));
      ++taken_;
    });
  }
  void push(GstEvent *event) {
    const std::shared_ptr<GstEvent> held(event, gst_event_unref);
    then([this, held] { gst_pad_push_event(pad_, gst_event_ref(held.get())); });
  }
  void then(std::function<void()> step) {
    {
      const std::lock_guard lock(mutex_);
      steps_.push_back(std::move(step));
    }
    changed_.notify_all();
  }
  /// Until the element has taken everything, or has it in the pad's queue.
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return steps_.empty() && !busy_; });
  }
  /// Drops what the element has not taken, as a source does that is flushed.
  void drop() {
    {
      const std::lock_guard lock(mutex_);
      steps_.clear();
    }
    wait();
  }
  guint64 begun() const { return begun_; }
  guint64 taken() const { return taken_; }
  GstFlowReturn flow() const { return flow_; }  ///< of the last buffer

 private:
  void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return over_ || !steps_.empty(); });
      if (over_) return;
      busy_ = true;
      auto step = std::move(steps_.front());
      steps_.pop_front();
      lock.unlock();
      step();
      step = nullptr;
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  GstPad *const pad_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> steps_;
  bool busy_ = false, over_ = false;
  std::atomic<guint64> begun_ = 0, taken_ = 0;
  std::atomic<GstFlowReturn> flow_ = GST_FLOW_OK;
  std::thread thread_;
};

/// csdtrackdec with both sink pads, not live. By default it waits for its text as long as a test may last.
struct TextHarness : Harness {
  GstHarness *text;
  std::unique_ptr<TextThread> thread;

  explicit TextHarness(const char *caps = utf8, guint64 max_wait = 3600 * GST_SECOND, bool live = false)
      : Harness("", gray_64, "none", nullptr, live) {
    g_object_set(element, "max-wait", max_wait, nullptr);
    text = new_side(element, live, "text", nullptr);
    gst_harness_set_src_caps_str(text, caps);
    thread = std::make_unique<TextThread>(text->srcpad);
  }
  ~TextHarness() {
    gst_element_set_state(element, GST_STATE_NULL);
    thread.reset();
    gst_harness_teardown(text);
  }

  void push_text(const std::string &its, GstClockTime pts = GST_CLOCK_TIME_NONE) { thread->push(bytes(its, pts)); }
  void push_line(guint64 n) { push_line(line(n), n * frame_time); }
  void push_line(const std::string &its, GstClockTime pts) { push_text(its, pts); }
  void text_event(GstEvent *event) { thread->push(event); }
  void end() { text_event(gst_event_new_eos()); }
  /// Until the text so far is there; at most one buffer of it can be in the pad's queue.
  void wait_text() { thread->wait(); }
  /// Until so many buffers of text are there, or the last of them waits for room. What is linked or begun anew before
  /// them is then over: a frame that waits meanwhile may go on without tracks.
  void wait_begun(guint64 buffers) {
    while (thread->begun() < buffers) g_usleep(1000);
  }
  void flush_text() {
    gst_harness_push_event(text, gst_event_new_flush_start());
    thread->drop();
    gst_harness_push_event(text, gst_event_new_flush_stop(TRUE));
  }

  /// A frame that waits for its text. Tests check the result, not its time.
  void push_waiting(GstClockTime pts) {
    fail_unless_equals_int(gst_harness_push(h, frame_at(pts)), GST_FLOW_OK);
    // By now it has most probably begun to wait. If not, the test finds less than it could.
    g_usleep(20000);
    fail_unless(gst_harness_try_pull(h) == nullptr, "it didn't wait");
  }
  int pull_number() {
    GstBuffer *out = gst_harness_pull(h);
    fail_unless(out != nullptr);
    const int number = number_on(out);
    gst_buffer_unref(out);
    return number;
  }
};

/// A frame pushed by another thread, as the one before it is still in the pad's queue.
class Waiting {
 public:
  Waiting(Harness &harness, GstClockTime pts)
      : thread_([this, &harness, pts] { flow_ = gst_harness_push(harness.h, frame_at(pts)); }) {
    g_usleep(20000);  // see push_waiting()
  }
  GstFlowReturn join() {
    thread_.join();
    return flow_;
  }

 private:
  GstFlowReturn flow_ = GST_FLOW_CUSTOM_ERROR;
  std::thread thread_;
};

/// Acts once, within the call that logs `text`.
class When {
 public:
  When(const char *category, const char *text, std::function<void()> act)
      : category_(category), hook_(keep(text, std::move(act))) {
    gst_debug_set_threshold_for_name(category_, GST_LEVEL_LOG);
    (gst_debug_add_log_function)(logged, hook_, nullptr);  // the macro compares it with a void pointer
  }
  ~When() {
    gst_debug_remove_log_function_by_data(hook_);
    gst_debug_unset_threshold_for_name(category_);
    fail_unless(hook_->done, "'%s' was not logged", hook_->text.c_str());
  }
  When(const When &) = delete;
  When &operator=(const When &) = delete;

 private:
  struct Hook {
    std::string text;
    std::function<void()> act;
    std::atomic<bool> done = false;
    Hook(const char *its, std::function<void()> do_it) : text(its), act(std::move(do_it)) {}
  };

  /// As long as the process lives: another thread may still be in the call after the function is removed.
  static Hook *keep(const char *text, std::function<void()> act) {
    static auto *const hooks = new std::deque<Hook>;
    return &hooks->emplace_back(text, std::move(act));
  }
  static void logged(GstDebugCategory *, GstDebugLevel, const gchar *, const gchar *, gint, GObject *,
                     GstDebugMessage *message, gpointer data) {
    auto *hook = static_cast<Hook *>(data);
    if (g_str_has_prefix(gst_debug_message_get(message), hook->text.c_str()) && !hook->done.exchange(true)) hook->act();
  }

  const char *category_;
  Hook *hook_;
};

inline void flush(GstHarness *h) {
  gst_harness_push_event(h, gst_event_new_flush_start());
  gst_harness_push_event(h, gst_event_new_flush_stop(TRUE));
}

inline GstEvent *segment_event(GstClockTime start, GstClockTime base = 0, double rate = 1) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.rate = rate;
  segment.start = segment.time = segment.position = start;
  segment.base = base;
  if (rate < 0) segment.stop = 1000 * GST_SECOND;
  return gst_event_new_segment(&segment);
}

inline void new_segment(GstHarness *h, GstClockTime start, GstClockTime base = 0, double rate = 1) {
  fail_unless(gst_harness_push_event(h, segment_event(start, base, rate)));
}

/// Fails on any message that no test has asked for yet.
inline void assert_silent(Harness &harness) {
  const std::string text = harness.said(static_cast<GstMessageType>(GST_MESSAGE_WARNING | GST_MESSAGE_ERROR));
  fail_unless(text.empty(), "%s", text.c_str());
}

inline void assert_holds(const std::string &text, const char *part) {
  fail_unless(text.find(part) != std::string::npos, "'%s' is not in '%s'", part, text.c_str());
}

}  // namespace csd_check
