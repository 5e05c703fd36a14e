// SPDX-License-Identifier: LGPL-2.1-or-later
//
// Lines too long for a sample of a text track: csdtrackenc cuts them, csdtrackdec joins them, and files give them back.
#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

constexpr std::size_t most = 65535;  // the most bytes of a text in MP4, whose length has 16 bits

std::string joined(const std::vector<Encoded> &pieces) {
  std::string text;
  for (const Encoded &piece : pieces) text += piece.text;
  return text;
}

std::string escaped(const std::string &text) {
  std::string out;
  for (const char c : text) out += c == '"' ? std::string("&quot;") : std::string(1, c);
  return out;
}

/// The pieces of frame 2's line of 1500 features, for csdtrackdec.
struct Cut {
  std::vector<Encoded> pieces = encoded(1500);
  Cut() { fail_unless_equals_int(pieces.size(), 2); }
  void push(TextHarness &harness, std::size_t i, bool discont = false, bool markup = false) {
    GstBuffer *buffer = bytes(markup ? escaped(pieces[i].text) : pieces[i].text, pieces[i].pts);
    if (discont) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
    harness.thread->push(buffer);
  }
};

/// Expects tracks with these numbers on frames 0 to 4.
void assert_numbers(TextHarness &harness, std::vector<int> numbers) {
  for (std::size_t n = 0; n < numbers.size(); ++n) fail_unless_equals_int(harness.push(n * frame_time), numbers[n]);
}

void play_to_end(GstElement *pipeline) {
  GError *error = play(pipeline);
  fail_unless(error == nullptr, "%s", error ? error->message : "");
}

constexpr struct {
  const char *muxer, *demuxer;
} containers[] = {{"qtmux", "qtdemux"},
                  {"mp4mux", "qtdemux"},
                  {"mp4mux fragment-duration=300", "qtdemux"},
                  {"matroskamux", "matroskademux"}};
constexpr unsigned frames = 20;

bool can_record() {
  return have("x264enc") && have("avdec_h264") && have("qtmux") && have("matroskamux");
}

/// Records 20 frames, every other one with 1500 features, and returns their lines.
std::string record(const std::string &muxer, const std::string &recording) {
  const std::string file = temporary("first.jsonl"), wide = "queue max-size-time=0 max-size-buffers=0 max-size-bytes=0";
  GstElement *pipeline =
      launch("videotestsrc num-buffers=" + std::to_string(frames) +
             " ! video/x-raw,format=I420,width=64,height=48,framerate=25/1 ! identity name=in ! tee name=t " + muxer +
             " name=m ! filesink location=" + recording + " t. ! " + wide +
             " ! x264enc key-int-max=5 bframes=0 ! h264parse ! m. t. ! csdtrackenc ! " + wide +
             " ! m.subtitle_0 t. ! " + "csdtrackenc ! " + wide + " ! filesink location=" + file);
  probe(pipeline, "in", "src", [](GstBuffer *b, unsigned n) { attach_many(b, n, n % 2 == 0 ? 1500 : 2); });
  play_to_end(pipeline);
  return read_file(file);
}

/// The text of consecutive samples; in MP4 each follows its length of two bytes.
std::string in_samples(const std::string &bytes, bool mp4) {
  if (!mp4) return bytes;
  std::string text;
  for (std::size_t at = 0, size; at + 2 <= bytes.size(); at += 2 + size) {
    size = static_cast<guint8>(bytes[at]) * 256U + static_cast<guint8>(bytes[at + 1]);
    text += bytes.substr(at + 2, size);
  }
  return text;
}

std::string played(const std::string &recording, const std::string &demuxer, const std::string &tail) {
  return "filesrc location=" + recording + " ! " + demuxer + " name=d csdtrackdec name=r max-wait=3600000000000 ! " +
         tail + " d.video_0 ! queue ! decodebin ! r.sink d.subtitle_0 ! queue name=q ! r.text";
}

}  // namespace

GST_START_TEST(a_line_that_fits_is_one_buffer) {
  // Source names that make a line of 900 features exactly as long as allowed, and one byte longer.
  const std::size_t rest = most - joined(encoded(900, "")).size();
  fail_unless(rest < 10000);
  const auto fits = encoded(900, std::string(rest, 's')), over = encoded(900, std::string(rest + 1, 's'));
  fail_unless_equals_int(fits.size(), 1);
  fail_unless_equals_int(fits[0].text.size(), most);
  fail_unless_equals_uint64(fits[0].duration, frame_time);
  fail_unless_equals_int(over.size(), 2);
  fail_unless_equals_int(joined(over).size(), most + 1);
}
GST_END_TEST

GST_START_TEST(a_longer_line_is_cut_between_features_and_shares_the_time) {
  const auto pieces = encoded(5000);
  fail_unless_equals_int(pieces.size(), 6);
  fail_unless(joined(pieces) + "\n" == joined(encoded(5000, "csdtrack0", frame_time, ndjson)));
  GstClockTime time = 2 * frame_time;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Encoded &piece = pieces[i];
    fail_unless(piece.text.size() <= most && (i == 5 || piece.text.size() > most - 100));
    fail_unless(piece.text.starts_with("{\"id\":") == (i > 0));
    fail_unless(piece.text.ends_with(",") == (i < 5));
    fail_unless_equals_uint64(piece.pts, time);
    fail_unless(piece.duration >= frame_time / 6);
    fail_unless_equals_int(piece.discont, i == 0);
    time += piece.duration;
  }
  fail_unless_equals_uint64(time, 3 * frame_time);
}
GST_END_TEST

GST_START_TEST(a_longer_line_of_a_frame_without_duration) {
  const auto known = encoded(1500, "csdtrack0", GST_CLOCK_TIME_NONE);
  fail_unless_equals_int(known.size(), 2);
  fail_unless_equals_uint64(known[1].pts, 2 * frame_time + frame_time / 2);
  const auto unknown = encoded(1500, "csdtrack0", GST_CLOCK_TIME_NONE, utf8,
                               "video/x-raw,format=GRAY8,width=64,height=48,framerate=0/1");
  fail_unless_equals_int(unknown.size(), 2);
  for (const Encoded &piece : unknown) {
    fail_unless_equals_uint64(piece.pts, 2 * frame_time);
    fail_unless(piece.duration == GST_CLOCK_TIME_NONE);
  }
}
GST_END_TEST

GST_START_TEST(a_line_that_no_cut_can_shorten_stays_whole) {
  const std::string name(2 * most, 's');
  const auto pieces = encoded(3, name);
  fail_unless(joined(pieces) + "\n" == joined(encoded(3, name, frame_time, ndjson)));
  fail_unless_equals_int(pieces.size(), 2);
}
GST_END_TEST

GST_START_TEST(pieces_are_joined) {
  for (const bool escape : {false, true}) {
    TextHarness harness(escape ? markup : utf8);
    Cut cut;
    cut.push(harness, 0, false, escape);
    // A gap that a demuxer reports between the pieces does not concern the line in progress.
    harness.text_event(gst_event_new_gap(2 * frame_time, frame_time));
    harness.push_line("", 2 * frame_time);
    harness.push_waiting(2 * frame_time);
    cut.push(harness, 1, false, escape);
    GstBuffer *out = gst_harness_pull(harness.h);
    const GstStructure *tracks = gst_buffer_get_csd_tracks(out, GST_CSD_TRACK_META_NAME, nullptr);
    GstCsdHeader header;
    fail_unless(tracks && gst_csd_structure_get_header(tracks, &header));
    fail_unless_equals_int(header.n_features, 1500);
    for (guint i = 0; i < header.n_features; ++i) {
      GstCsdFeature feature;
      fail_unless(gst_csd_structure_get_feature(tracks, i, &feature));
      fail_unless(feature.id == i && feature.x == i % 64 + 0.125 && feature.y == 2);
    }
    gst_buffer_unref(out);
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(a_line_that_begins_before_a_seek_is_skipped) {
  TextHarness harness;
  Cut cut;
  cut.push(harness, 0);
  harness.flush_text();
  flush(harness.h);
  // Running time goes on: the text's part begins in the middle of frame 2.
  harness.text_event(segment_event(2 * frame_time + frame_time / 2, 2 * frame_time + frame_time / 2));
  new_segment(harness.h, 0);
  cut.push(harness, 1, true);
  harness.push_line(3);
  harness.end();
  assert_numbers(harness, {-1, -1, -1, 3, -1});
  assert_silent(harness);
}
GST_END_TEST

GST_START_TEST(a_torn_line_is_left_out) {
  const struct {
    const char *what;
    void (*come)(TextHarness &, Cut &);
  } cases[] = {
      {"the next line", [](TextHarness &, Cut &) {}},
      {"a gap", [](TextHarness &h, Cut &cut) { cut.push(h, 1, true); }},
      {"another stream",
       [](TextHarness &h, Cut &cut) {
         h.text_event(gst_event_new_stream_start("another"));
         h.text_event(segment_event(0));
         cut.push(h, 1);
       }},
  };
  for (const auto &c : cases) {
    TextHarness harness;
    Cut cut;
    for (guint64 n = 0; n < 2; ++n) harness.push_line(n);
    cut.push(harness, 0);
    c.come(harness, cut);
    harness.push_line(3);
    harness.push_line(4);
    assert_numbers(harness, {0, 1, -1, 3, 4});
    assert_holds(harness.said(GST_MESSAGE_WARNING), "broke off in line 3: its frame passes without tracks");
    // Once a stream, however often it happens.
    cut.pieces[0].pts += 10 * frame_time;
    cut.push(harness, 0);
    harness.end();
    fail_unless_equals_int(harness.push(5 * frame_time), -1);
    fail_unless(harness.said(GST_MESSAGE_WARNING).empty() == (c.what != std::string("another stream")), "%s", c.what);
  }
}
GST_END_TEST

GST_START_TEST(an_endless_line_is_refused) {
  TextHarness harness;
  const std::string feature = "{\"id\":1},";
  std::string piece;
  while (piece.size() < 1 << 20) piece += feature;
  harness.push_line(line(0).substr(0, line(0).find("{\"id\"")) + feature, 0);
  for (int i = 0; i < 10; ++i) harness.push_line(piece, 0);
  fail_unless_equals_int(harness.push(0 * frame_time), -1);
  assert_holds(harness.said(GST_MESSAGE_ERROR), "Line 1 of what came to the pad text: is longer than 8 MiB");
}
GST_END_TEST

GST_START_TEST(files_give_them_back) {
  if (!can_record()) return;
  for (const auto &c : containers) {
    const std::string recording = temporary("r"), second = temporary("second.jsonl");
    const std::string first = record(c.muxer, recording);
    std::string plain, text;
    for (const std::string &line : lines_of(first)) plain += line;
    GstElement *pipeline = launch(played(recording, c.demuxer, "csdtrackenc ! filesink location=" + second));
    probe(pipeline, "q", "src", [&](GstBuffer *buffer, unsigned) {
      std::string piece = text_in(buffer);
      for (std::size_t at; (at = piece.find("&quot;")) != std::string::npos;) piece.replace(at, 6, "\"");
      text += piece;
    });
    play_to_end(pipeline);
    fail_unless(in_samples(extracted(recording), c.demuxer == std::string("qtdemux")) == plain, "%s", c.muxer);
    fail_unless(text == plain, "%s: %u bytes of %u", c.muxer, unsigned(text.size()), unsigned(plain.size()));
    const auto before = lines_of(first), after = lines_of(read_file(second));
    fail_unless(after.size() == frames, "%s: %u", c.muxer, unsigned(after.size()));
    for (std::size_t i = 0; i < frames; ++i) {
      const auto tracks = [](const std::string &line) { return line.substr(line.find("\"reference\"")); };
      fail_unless(tracks(after[i]) == tracks(before[i]), "%s: frame %u", c.muxer, unsigned(i));
    }
  }
}
GST_END_TEST

GST_START_TEST(seeking_works_in_files) {
  if (!can_record()) return;
  for (const auto &c : containers) {
    if (std::string(c.muxer).find("fragment") != std::string::npos) continue;  // qtdemux 1.22 seeks there in video only
    const std::string recording = temporary("s");
    record(c.muxer, recording);
    for (const GstClockTime to : {6 * frame_time, 6 * frame_time + 25 * GST_MSECOND, 7 * frame_time + GST_MSECOND}) {
      GstElement *pipeline = launch(played(recording, c.demuxer, "fakesink name=s"));
      gst_element_set_state(pipeline, GST_STATE_PAUSED);
      gst_element_get_state(pipeline, nullptr, nullptr, GST_CLOCK_TIME_NONE);
      std::vector<int> numbers;
      probe(pipeline, "s", "sink", [&](GstBuffer *buffer, unsigned) { numbers.push_back(number_on(buffer)); });
      const auto flags = static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | GST_SEEK_FLAG_ACCURATE);
      fail_unless(gst_element_seek_simple(pipeline, GST_FORMAT_TIME, flags, static_cast<gint64>(to)));
      play_to_end(pipeline);
      const int first = static_cast<int>(to / frame_time);
      fail_unless(numbers.size() == frames - static_cast<unsigned>(first), "%s to %u: %u", c.muxer,
                  unsigned(to / GST_MSECOND), unsigned(numbers.size()));
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        // The line of the frame sought may have begun earlier.
        const bool there = numbers[i] == first + static_cast<int>(i);
        fail_unless(there || (i == 0 && to % frame_time != 0 && numbers[i] == -1), "%s to %u: %d on frame %u", c.muxer,
                    unsigned(to / GST_MSECOND), numbers[i], unsigned(i));
      }
    }
  }
}
GST_END_TEST

static Suite *text_pieces_suite() {
  Suite *s = suite_create("text_pieces");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, a_line_that_fits_is_one_buffer);
  tcase_add_test(tc, a_longer_line_is_cut_between_features_and_shares_the_time);
  tcase_add_test(tc, a_longer_line_of_a_frame_without_duration);
  tcase_add_test(tc, a_line_that_no_cut_can_shorten_stays_whole);
  tcase_add_test(tc, pieces_are_joined);
  tcase_add_test(tc, a_line_that_begins_before_a_seek_is_skipped);
  tcase_add_test(tc, a_torn_line_is_left_out);
  tcase_add_test(tc, an_endless_line_is_refused);
  tcase_add_test(tc, files_give_them_back);
  tcase_add_test(tc, seeking_works_in_files);
  return s;
}

GST_CHECK_MAIN(text_pieces)
