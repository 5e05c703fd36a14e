// SPDX-License-Identifier: LGPL-2.1-or-later
// Combines every format, size, memory layout, algorithm and overlay with everything that can happen to a stream: each
// pair of values is in at least one case. Each frame must come out in order and unchanged, with plausible metadata.
//
// CSDTRACK_SIZES=small leaves out what is slow under valgrind; =all adds the largest frames.
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "caps/frame_mapping.h"
#include "scene.h"
// After all C++ headers: Check has a macro `fail`.
#include "csdtrack_harness.h"

namespace {

struct Size {
  int width, height;
};
constexpr Size sizes[] = {{1, 1},    {2, 2},     {1, 97},    {14, 11},     {31, 17},
                          {63, 129}, {322, 241}, {641, 361}, {1921, 1081}, {4096, 2304}};
constexpr std::size_t small_sizes = 6, usual_sizes = 8;

constexpr unsigned paddings[] = {0, 1, 5};
constexpr const char *algorithms[] = {"csd", "csd-2012", "csd-forest", "lk", "ms1", "ms2", "sift"};
constexpr const char *overlays[] = {"none", "meta", "draw"};
constexpr GstVideoInterlaceMode fields[] = {GST_VIDEO_INTERLACE_MODE_PROGRESSIVE, GST_VIDEO_INTERLACE_MODE_INTERLEAVED,
                                            GST_VIDEO_INTERLACE_MODE_MIXED};

/// Squares with edges that every tracker finds, reddish like tissue, in that format.
scene::Buffer draw(const GstVideoInfo &info, unsigned padding) {
  const GstVideoInfo rgb =
      scene::info_of(GST_VIDEO_FORMAT_xRGB, info.width, info.height, GST_VIDEO_INFO_INTERLACE_MODE(&info));
  scene::Buffer source = scene::allocate(rgb), out = scene::allocate(info, padding);
  {
    scene::Frame frame(rgb, source.get(), GST_MAP_WRITE);
    auto *line = static_cast<guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
    for (int y = 0; y < info.height; ++y, line += GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0))
      for (int x = 0; x < info.width; ++x) {
        line[4 * x + 1] = texture(x, y);
        line[4 * x + 2] = line[4 * x + 3] = texture(x, y) / 2;
      }
  }
  scene::convert(rgb, source.get(), info, out.get());
  return out;
}

/// A stream through one csdtrack. Checks every frame that comes out.
class Stream {
 public:
  Stream(const char *algorithm, const char *overlay) : drawn_(std::strcmp(overlay, "draw") == 0) {
    gchar *launch = g_strdup_printf("csdtrack algorithm=%s overlay=%s max-features=5 n-threads=1", algorithm, overlay);
    h_ = gst_harness_new_parse(launch);
    g_free(launch);
    gst_harness_add_propose_allocation_meta(h_, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    track_ = element(h_);
    bus_ = gst_bus_new();
    gst_element_set_bus(track_, bus_);
  }
  Stream(const Stream &) = delete;
  Stream &operator=(const Stream &) = delete;
  ~Stream() {
    GstMessage *error = gst_bus_pop_filtered(bus_, GST_MESSAGE_ERROR);
    fail_unless(error == nullptr, "an error was posted");
    gst_element_set_bus(track_, nullptr);
    gst_object_unref(bus_);
    gst_object_unref(track_);
    gst_harness_teardown(h_);
  }

  /// Sets the pictures' format from now on.
  void caps(const GstVideoInfo &info, unsigned padding) {
    picture_ = draw(info, padding);
    pixels_.resize(gst_buffer_get_size(picture_.get()));
    gst_buffer_extract(picture_.get(), 0, pixels_.data(), pixels_.size());
    GstCaps *caps = gst_video_info_to_caps(&info);
    info_ = info;
    seen_ = {info.width, info.height};
    if (!std::exchange(begun_, true)) {
      gst_harness_set_src_caps(h_, caps);
      return;
    }
    send(gst_event_new_caps(caps));
    gst_caps_unref(caps);
  }

  void send(GstEvent *event) { fail_unless(gst_harness_push_event(h_, event)); }

  void segment(double rate, GstClockTime start) {
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    segment.rate = rate;
    segment.start = segment.position = segment.time = start;
    send(gst_event_new_segment(&segment));
    time_ = start;
  }

  void flush() {
    send(gst_event_new_flush_start());
    send(gst_event_new_flush_stop(TRUE));
  }

  void again(const char *id) {
    send(gst_event_new_stream_start(id));
    GstCaps *caps = gst_video_info_to_caps(&info_);
    send(gst_event_new_caps(caps));
    gst_caps_unref(caps);
    segment(1, 0);
  }

  void state(GstState wanted) {
    fail_unless(gst_element_set_state(track_, wanted) == GST_STATE_CHANGE_SUCCESS);
    if (wanted < GST_STATE_PAUSED) frame_ = 0;
  }

  void frames(int n, std::function<void(GstBuffer *)> change = nullptr) {
    for (int i = 0; i < n; ++i) frame(i % 2 == 1, change);
  }

  void refused(GstFlowReturn why) { fail_unless_equals_int(gst_harness_push(h_, stamped(false)), why); }

  /// A frame of which only a rectangle is visible.
  void cropped(int x, int y, Size size) {
    const Size whole = std::exchange(seen_, size);
    frames(1, [=](GstBuffer *buffer) {
      auto *crop = gst_buffer_add_video_crop_meta(buffer);
      crop->x = static_cast<guint>(x);
      crop->y = static_cast<guint>(y);
      crop->width = static_cast<guint>(size.width);
      crop->height = static_cast<guint>(size.height);
    });
    seen_ = whole;
  }

  GstVideoInfo info() const { return info_; }
  GstHarness *harness() { return h_; }

 private:
  /// `shared`: something else holds the pixels, too.
  GstBuffer *stamped(bool shared) {
    GstBuffer *buffer = shared ? gst_buffer_copy(picture_.get()) : gst_buffer_copy_deep(picture_.get());
    GST_BUFFER_PTS(buffer) = time_;
    GST_BUFFER_DURATION(buffer) = 40 * GST_MSECOND;
    time_ += 40 * GST_MSECOND;
    if (shared && GST_VIDEO_INFO_INTERLACE_MODE(&info_) == GST_VIDEO_INTERLACE_MODE_MIXED)
      GST_BUFFER_FLAG_SET(buffer, GST_VIDEO_BUFFER_FLAG_INTERLACED);
    return buffer;
  }

  void frame(bool shared, const std::function<void(GstBuffer *)> &change) {
    GstBuffer *in = stamped(shared);
    if (change) change(in);
    const GstClockTime pts = GST_BUFFER_PTS(in);
    fail_unless_equals_int(gst_harness_push(h_, in), GST_FLOW_OK);
    GstBuffer *out = gst_harness_try_pull(h_);
    fail_unless(out != nullptr);
    fail_unless_equals_uint64(GST_BUFFER_PTS(out), pts);
    fail_unless_equals_uint64(frame_number(out), frame_++);
    fail_unless(same_pixels(out) || drawn_, "pixels have changed");
    fail_unless(same_pixels(picture_.get()), "shared pixels have changed");
    check(gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr));
    gst_buffer_unref(out);
  }

  bool same_pixels(GstBuffer *out) {
    return gst_buffer_get_size(out) == pixels_.size() && gst_buffer_memcmp(out, 0, pixels_.data(), pixels_.size()) == 0;
  }

  void check(const GstStructure *tracks) {
    static const std::set<std::string> known = {"learning", "tracked", "occluded", "lost", "out", "ended"};
    GstCsdHeader header;
    fail_unless(tracks != nullptr && gst_csd_structure_get_header(tracks, &header));
    fail_unless_equals_int(header.width, seen_.width);
    fail_unless_equals_int(header.height, seen_.height);
    fail_unless(header.n_features > 0 || seen_.width < 300, "nothing is tracked in a rich picture");
    std::set<guint> ids;
    for (guint i = 0; i < header.n_features; ++i) {
      GstCsdFeature f;
      fail_unless(gst_csd_structure_get_feature(tracks, i, &f));
      fail_unless(ids.insert(f.id).second, "id %u is duplicated", f.id);
      fail_unless(known.count(f.state) == 1, "state %s", f.state);
      fail_unless(std::isfinite(f.x) && std::isfinite(f.y) && f.confidence >= 0 && f.confidence <= 1);
      if (std::strcmp(f.state, "tracked") != 0 && std::strcmp(f.state, "learning") != 0) continue;
      fail_unless(f.x > -0.51 && f.y > -0.51 && f.x < seen_.width - 0.49 && f.y < seen_.height - 0.49,
                  "%s at %f,%f of %dx%d", f.state, f.x, f.y, seen_.width, seen_.height);
    }
  }

  bool drawn_, begun_ = false;
  GstHarness *h_ = nullptr;
  GstElement *track_ = nullptr;
  GstBus *bus_ = nullptr;
  scene::Buffer picture_;
  std::vector<guint8> pixels_;  ///< the picture's
  GstVideoInfo info_ = {};
  Size seen_ = {};  ///< the visible size
  GstClockTime time_ = 0;
  guint64 frame_ = 0;
};

/// What happens between two series of frames.
struct Event {
  const char *name;
  void (*happen)(Stream &);
};

const Event events[] = {
    {"nothing", [](Stream &) {}},
    {"flush",
     [](Stream &s) {
       s.flush();
       s.segment(1, 0);
     }},
    {"seek",
     [](Stream &s) {
       gst_harness_push_upstream_event(s.harness(),
                                       gst_event_new_seek(1, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, GST_SEEK_TYPE_SET,
                                                          static_cast<gint64>(9 * GST_SECOND), GST_SEEK_TYPE_NONE, -1));
       s.flush();
       s.segment(1, 9 * GST_SECOND);
     }},
    {"segment", [](Stream &s) { s.segment(2, 20 * GST_SECOND); }},
    {"larger",
     [](Stream &s) {
       const GstVideoInfo now = s.info();
       s.caps(scene::info_of(GST_VIDEO_INFO_FORMAT(&now), now.width + 3, now.height + 2,
                             GST_VIDEO_INFO_INTERLACE_MODE(&now)),
              3);
     }},
    {"another format",
     [](Stream &s) {
       const GstVideoInfo now = s.info();
       const bool gray = GST_VIDEO_INFO_FORMAT(&now) == GST_VIDEO_FORMAT_GRAY8;
       s.caps(scene::info_of(gray ? GST_VIDEO_FORMAT_BGRx : GST_VIDEO_FORMAT_GRAY8, now.width, now.height,
                             GST_VIDEO_INFO_INTERLACE_MODE(&now)),
              0);
     }},
    {"end and restart",
     [](Stream &s) {
       s.send(gst_event_new_eos());
       s.refused(GST_FLOW_EOS);
       s.flush();
       s.again("again");
     }},
    {"another stream", [](Stream &s) { s.again("other"); }},
    {"gap", [](Stream &s) { s.send(gst_event_new_gap(160 * GST_MSECOND, 80 * GST_MSECOND)); }},
    {"discontinuity",
     [](Stream &s) { s.frames(1, [](GstBuffer *b) { GST_BUFFER_FLAG_SET(b, GST_BUFFER_FLAG_DISCONT); }); }},
    {"no times",
     [](Stream &s) {
       s.frames(3, [](GstBuffer *b) { GST_BUFFER_PTS(b) = GST_BUFFER_DURATION(b) = GST_CLOCK_TIME_NONE; });
     }},
    {"backwards", [](Stream &s) { s.frames(3, [](GstBuffer *b) { GST_BUFFER_PTS(b) = 0; }); }},
    {"paused",
     [](Stream &s) {
       s.state(GST_STATE_PAUSED);
       s.frames(1);
       s.state(GST_STATE_PLAYING);
     }},
    {"ready",
     [](Stream &s) {
       s.state(GST_STATE_READY);
       s.refused(GST_FLOW_FLUSHING);
       s.state(GST_STATE_PLAYING);
       s.again("again");
     }},
    {"null",
     [](Stream &s) {
       s.state(GST_STATE_NULL);
       s.state(GST_STATE_PLAYING);
       s.again("again");
     }},
    {"crop",
     [](Stream &s) {
       if (s.info().width > 60 && s.info().height > 60) s.cropped(9, 4, {41, 37});
     }},
};

enum Factor { format, size, padding, algorithm, overlay, field, event, factors };
using Case = std::array<std::size_t, factors>;

/// Cases that cover each pair of values of any two factors. Greedy: each case begins with a pair not covered yet.
std::vector<Case> pairwise(const Case &counts) {
  std::set<std::array<std::size_t, 4>> missing;
  for (std::size_t a = 0; a < factors; ++a)
    for (std::size_t b = a + 1; b < factors; ++b)
      for (std::size_t i = 0; i < counts[a]; ++i)
        for (std::size_t j = 0; j < counts[b]; ++j) missing.insert({a, b, i, j});
  std::vector<Case> cases;
  while (!missing.empty()) {
    const auto [first, second, i, j] = *missing.begin();
    Case one = {};
    std::array<bool, factors> set = {};
    one[first] = i;
    one[second] = j;
    set[first] = set[second] = true;
    for (std::size_t f = 0; f < factors; ++f) {
      if (set[f]) continue;
      std::size_t best = 0, gain = 0;
      for (std::size_t n = 0; n < counts[f]; ++n) {
        const std::size_t value = (n + cases.size()) % counts[f];
        std::size_t news = 0;
        for (std::size_t g = 0; g < factors; ++g)
          if (set[g]) news += g < f ? missing.count({g, f, one[g], value}) : missing.count({f, g, value, one[g]});
        if (n == 0 || news > gain) best = value, gain = news;
      }
      one[f] = best;
      set[f] = true;
    }
    for (std::size_t a = 0; a < factors; ++a)
      for (std::size_t b = a + 1; b < factors; ++b) missing.erase({a, b, one[a], one[b]});
    cases.push_back(one);
  }
  return cases;
}

/// The usual formats, and of the others those that are read and drawn into in a way of their own.
constexpr char frame_formats[] = CSD_USUAL_FORMATS
    ", NV16, Y210, r210, GRAY10_LE32, GRAY16_LE, Y41B, GBR, GBRA_12BE, AYUV64, RGB15, UYVP, NV12_64Z32";

std::vector<Case> cases() {
  const char *wanted = g_getenv("CSDTRACK_SIZES");
  const std::size_t most = !wanted ? usual_sizes : std::strcmp(wanted, "all") == 0 ? std::size(sizes) : small_sizes;
  return pairwise({scene::formats(frame_formats).size(), most, std::size(paddings), std::size(algorithms),
                   std::size(overlays), std::size(fields), std::size(events)});
}

void run(const Case &c) {
  static const auto formats = scene::formats(frame_formats);
  const GstVideoInfo info =
      scene::info_of(formats[c[format]], sizes[c[size]].width, sizes[c[size]].height, fields[c[field]]);
  GST_INFO("%s %dx%d, %u padded, %s, %s, %s, %s", gst_video_format_to_string(formats[c[format]]), info.width,
           info.height, paddings[c[padding]], algorithms[c[algorithm]], overlays[c[overlay]],
           gst_video_interlace_mode_to_string(fields[c[field]]), events[c[event]].name);
  Stream stream(algorithms[c[algorithm]], overlays[c[overlay]]);
  stream.caps(info, paddings[c[padding]]);
  stream.frames(4);
  events[c[event]].happen(stream);
  stream.frames(4);
}

}  // namespace

GST_START_TEST(each_pair_is_covered) {
  const Case counts = {4, 3, 2, 2, 3, 2, 5};
  const auto all = pairwise(counts);
  for (std::size_t a = 0; a < factors; ++a)
    for (std::size_t b = a + 1; b < factors; ++b) {
      std::set<std::pair<std::size_t, std::size_t>> seen;
      for (const Case &c : all) seen.insert({c[a], c[b]});
      fail_unless_equals_int(static_cast<int>(seen.size()), static_cast<int>(counts[a] * counts[b]));
    }
}
GST_END_TEST

// Eight parts, so that a failure doesn't hide the other parts' results.
GST_START_TEST(every_frame_comes_out_in_every_case) {
  const auto all = cases();
  for (std::size_t i = static_cast<std::size_t>(__i__); i < all.size(); i += 8) run(all[i]);
}
GST_END_TEST

static Suite *csdtrack_states_suite() {
  Suite *suite = suite_create("csdtrack_states");
  TCase *tcase = tcase_create("states");
  tcase_set_timeout(tcase, 0);  // meson's applies
  suite_add_tcase(suite, tcase);
  tcase_add_test(tcase, each_pair_is_covered);
  tcase_add_loop_test(tcase, every_frame_comes_out_in_every_case, 0, 8);
  return suite;
}

GST_CHECK_MAIN(csdtrack_states)
