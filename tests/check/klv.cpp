// SPDX-License-Identifier: LGPL-2.1-or-later
//
// Lines in packets of SMPTE 336: their bytes, and how csdtrackdec reads packets that are cut, torn, lost or foreign.
#include "record/klv.h"

#include <random>
#include <set>

#include "csdtrackdec_harness.h"

using namespace csd_check;

namespace {

constexpr char klv[] = "meta/x-klv,parsed=true";

/// As in docs/metadata.md. `key` ends in the line's number and the number of pieces still to come.
std::string key(unsigned line = 0, unsigned rest = 0) {
  return std::string("\x06\x0e\x2b\x34\x01\x01\x01\x01\x0f\x63\x73\x64\x74\x72", 14) + static_cast<char>(line) +
         static_cast<char>(rest);
}

/// With a length field of that many bytes after the first.
std::string packet(const std::string &key, const std::string &value, unsigned bytes = 3) {
  std::string out = key + static_cast<char>(0x80 | bytes);
  for (unsigned i = bytes; i-- > 0;) out += static_cast<char>(value.size() >> 8 * i);
  return out + value;
}
std::string packet(guint64 n) {
  return packet(key(), line(n));
}

/// From a drone's camera (MISB ST 0601), with half of our label and some brackets in its value.
const std::string foreign = packet({"\x06\x0e\x2b\x34\x02\x0b\x01\x01\x0e\x01\x03\x01\x01\x00\x00\x00", 16},
                                   "\x02\x08" + key().substr(0, 9) + "{}" + key().substr(0, 13), 1);

/// The header of a packet in a synchronous metadata stream: service, sequence, flags, length.
std::string access_unit(const std::string &value) {
  return std::string{'\xfc', '\x07', '\xdf', static_cast<char>(value.size() >> 8), static_cast<char>(value.size())} +
         value;
}

struct Klv : TextHarness {
  /// BYTES is as from a file, where lines have their own times; TIME is as from a demuxer.
  explicit Klv(GstFormat format = GST_FORMAT_BYTES) : TextHarness(klv) {
    GstSegment segment;
    gst_segment_init(&segment, format);
    gst_harness_push_event(text, gst_event_new_segment(&segment));
  }
  void push_bytes(const std::string &data, GstClockTime pts = GST_CLOCK_TIME_NONE, bool discont = false) {
    GstBuffer *buffer = bytes(data, pts);
    if (discont) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
    thread->push(buffer);
  }
  /// Which of the frames 0 to `count` get their own line. None may get another's.
  std::set<int> right(int count) {
    std::set<int> numbers;
    for (int n = 0; n < count; ++n) {
      const int number = TextHarness::push(n * frame_time);
      fail_unless(number == -1 || number == n, "frame %d has tracks of %d", n, number);
      if (number == n) numbers.insert(n);
    }
    return numbers;
  }
};

void fail_unless_numbers(const std::set<int> &got, std::set<int> expected) {
  std::string text;
  for (const int n : got) text += std::to_string(n) + " ";
  fail_unless(got == expected, "%s", text.c_str());
}

/// The pieces of frame `n`'s line, which has two features: `count` of them, each with one more.
std::vector<std::string> pieces(guint64 n, unsigned number, unsigned count) {
  std::vector<std::string> packets;
  std::string text = line(n);
  text.resize(text.size() - 2);
  for (unsigned i = 0; i < count; ++i) {
    if (i > 0)
      text = "{\"id\":" + std::to_string(i + 3) + ",\"x\":1.000,\"y\":2.000,\"state\":\"lost\",\"confidence\":0.000}";
    packets.push_back(packet(key(number, count - 1 - i), text + (i + 1 < count ? "," : "]}")));
  }
  return packets;
}

}  // namespace

GST_START_TEST(a_length_uses_as_few_bytes_as_possible) {
  const struct {
    std::size_t size;
    std::string length;
  } cases[] = {{0, {"\0", 1}},          {1, "\x01"},
               {127, "\x7f"},           {128, "\x81\x80"},
               {255, "\x81\xff"},       {256, {"\x82\x01\x00", 3}},
               {65535, "\x82\xff\xff"}, {65536, {"\x83\x01\x00\x00", 4}}};
  for (const auto &c : cases) {
    const std::string value(c.size, 'x');
    fail_unless(csd::klv_packet(value, 5, 0, 1) == key() + c.length + value, "%u", unsigned(c.size));
  }
}
GST_END_TEST

GST_START_TEST(a_line_is_one_packet) {
  const auto packets = encoded(2, "csdtrack0", frame_time, klv), lines = encoded(2, "csdtrack0", frame_time, ndjson);
  fail_unless_equals_int(packets.size(), 1);
  std::string text = lines[0].text;
  text.pop_back();
  fail_unless(text.size() > 255 && packets[0].text == packet(key(), text, 2));
  fail_unless_equals_uint64(packets[0].pts, 2 * frame_time);
  fail_unless_equals_uint64(packets[0].duration, frame_time);
  fail_unless(packets[0].discont);
}
GST_END_TEST

GST_START_TEST(a_longer_line_is_several_packets) {
  const auto packets = encoded(2500, "csdtrack0", frame_time, klv);
  fail_unless_equals_int(packets.size(), 3);
  std::string text;
  GstClockTime time = 2 * frame_time;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const Encoded &p = packets[i];
    // The longest that mpegtsmux 1.22 can encode.
    fail_unless(p.text.size() <= 65527 && (i == 2 || p.text.size() > 64000));
    const auto number = static_cast<unsigned char>(p.text[14]);
    fail_unless(number > 0 && number < 128);
    const std::string value = p.text.substr(16 + 3);
    fail_unless(p.text == packet(key(number, 2 - static_cast<unsigned>(i)), value, 2));
    fail_unless_equals_uint64(p.pts, time);
    fail_unless_equals_int(p.discont, i == 0);
    text += value;
    time += p.duration;
  }
  fail_unless(text + "\n" == encoded(2500, "csdtrack0", frame_time, ndjson)[0].text);
  fail_unless_equals_uint64(time, 3 * frame_time);
}
GST_END_TEST

GST_START_TEST(packets_are_found_at_any_cut) {
  const auto cut = pieces(2, 7, 3);
  std::string all = foreign + packet(0) + access_unit(packet(1)) + foreign;
  for (const std::string &piece : cut) all += piece + foreign;
  all += packet(3) + packet(key(), line(4), 8);
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 60; ++size) {
    Klv harness;
    // First in cuts of one size, in the last rounds of random sizes.
    for (std::size_t at = 0, step; at < all.size(); at += step) {
      step = size == 0 ? all.size() : size < 40 ? size : 1 + random() % 300;
      harness.push_bytes(all.substr(at, step));
    }
    harness.end();
    fail_unless_numbers(harness.right(6), {0, 1, 2, 3, 4});
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(a_torn_packet_costs_its_line) {
  const std::string whole = packet(1);
  for (std::size_t left = 14; left < whole.size(); ++left) {
    // In the middle, away from the boundaries of key, length and the next packet, a few places are enough.
    if (left > 40 && left + 10 < whole.size() && left % 9 != 0) continue;
    for (const std::string &next : {std::string(), foreign, access_unit("")}) {
      Klv harness;
      harness.push_bytes(packet(0));
      harness.push_bytes(whole.substr(0, left));
      harness.push_bytes(next + packet(2));
      harness.push_bytes(packet(3));
      harness.end();
      fail_unless_numbers(harness.right(5), {0, 2, 3});
      assert_holds(harness.said(GST_MESSAGE_WARNING), "broke off in line 2: its frame passes without tracks");
      assert_silent(harness);
    }
    // Only its end arrives.
    Klv harness;
    harness.push_bytes(packet(0) + whole.substr(whole.size() - left) + packet(2));
    harness.end();
    fail_unless_numbers(harness.right(4), {0, 2});
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(packets_a_demuxer_reports_lost_are_not_waited_for) {
  Klv harness;
  // The start of one and the end of the next would make a whole line.
  harness.push_bytes(packet(1).substr(0, 250));
  harness.push_bytes(packet(2).substr(250) + packet(3), GST_CLOCK_TIME_NONE, true);
  harness.end();
  fail_unless_numbers(harness.right(5), {3});
  assert_holds(harness.said(GST_MESSAGE_WARNING), "broke off in line 1");
}
GST_END_TEST

GST_START_TEST(a_damaged_packet_costs_its_line) {
  const std::string spoilt[] = {
      packet(key(), "{\"schema\":1"),
      packet(key(), line(1).replace(10, 1, "2")),
      packet(key(), line(0, 0)),  // earlier than the previous one
      key() + '\x80' + line(1),   // of an unspecified length
      key() + "\x84\x7f\xff\xff\xff" + line(1),
      key() + "\xff" + line(1),
  };
  for (const std::string &bad : spoilt) {
    Klv harness;
    harness.push_bytes(packet(key(), line(0, frame_time / 4)));
    harness.push_bytes(bad);
    harness.push_bytes(packet(2));
    harness.end();
    fail_unless_numbers(harness.right(4), {0, 2});
    assert_holds(harness.said(GST_MESSAGE_WARNING), "broke off in line 2");
    fail_unless_equals_int(harness.thread->flow(), GST_FLOW_OK);
    fail_unless(harness.said(GST_MESSAGE_ERROR).empty());
  }
}
GST_END_TEST

GST_START_TEST(a_line_with_a_lost_piece_is_not_joined) {
  const auto a = pieces(1, 5, 3), b = pieces(2, 6, 3);
  const struct {
    std::string bytes;
    std::set<int> right;
  } cases[] = {
      {a[0] + a[1] + a[2] + b[0] + b[1] + b[2], {0, 1, 2, 3}},
      {a[0] + a[2] + b[0] + b[1] + b[2], {0, 2, 3}},
      {a[1] + a[2] + b[0] + b[1] + b[2], {0, 2, 3}},
      {a[0] + b[1] + b[2], {0, 3}},
      {a[0] + a[1] + b[2], {0, 3}},
      {a[0] + a[1], {0, 3}},
      {a[0] + a[1].substr(0, 80) + a[2] + b[0] + b[1] + b[2], {0, 2, 3}},
  };
  for (const auto &c : cases) {
    Klv harness;
    harness.push_bytes(packet(0) + c.bytes + packet(3));
    harness.end();
    fail_unless_numbers(harness.right(5), c.right);
    fail_unless(harness.said(GST_MESSAGE_ERROR).empty());
  }
}
GST_END_TEST

GST_START_TEST(the_buffers_time_takes_precedence_over_the_lines) {
  {  // A transport stream starts at other times than the tracked one.
    Klv harness(GST_FORMAT_TIME);
    for (guint64 n = 0; n < 4; ++n)
      harness.push_bytes(foreign + packet(key(), line(n, 100 * GST_SECOND)), n * frame_time);
    fail_unless_numbers(harness.right(4), {0, 1, 2, 3});
    assert_silent(harness);
  }
  {  // Two packets in a buffer: the second keeps its distance from the first. So does one that ends in the next buffer.
    Klv harness(GST_FORMAT_TIME);
    std::string all;
    for (guint64 n = 0; n < 5; ++n) all += packet(key(), line(n, 100 * GST_SECOND + n * frame_time));
    const std::size_t size = packet(key(), line(0, 100 * GST_SECOND)).size();
    harness.push_bytes(all.substr(0, 2 * size + 50), 0);
    harness.push_bytes(all.substr(2 * size + 50), 3 * frame_time);
    harness.end();
    fail_unless_numbers(harness.right(5), {0, 1, 2, 3, 4});
    assert_silent(harness);
  }
  {  // A packet has the time of the buffer in which it begins, even if it ends in the next.
    Klv harness(GST_FORMAT_TIME);
    const std::string one = packet(key(), line(1, 100 * GST_SECOND));
    harness.push_bytes(one.substr(0, 50), frame_time);
    harness.push_bytes(one.substr(50), 2 * frame_time);
    harness.end();
    fail_unless_numbers(harness.right(3), {1});
  }
  {  // A torn packet doesn't pass its time on to the next.
    Klv harness(GST_FORMAT_TIME);
    const auto other = [](guint64 n) { return packet(key(), line(n, 100 * GST_SECOND + n * frame_time)); };
    harness.push_bytes(other(0), 0);
    harness.push_bytes(other(1).substr(0, 200), frame_time);
    harness.push_bytes(other(2), 2 * frame_time);
    harness.push_bytes(other(3) + other(4).substr(0, 200) + other(5), 3 * frame_time);
    harness.end();
    fail_unless_numbers(harness.right(7), {0, 2, 3, 5});
  }
  {  // In a transport stream that has lost its times, no packet's time is known.
    Klv harness(GST_FORMAT_TIME);
    for (guint64 n = 0; n < 3; ++n) harness.push_bytes(packet(n));
    fail_unless_numbers(harness.right(3), {});
    assert_holds(harness.said(GST_MESSAGE_WARNING), "line 1");
  }
}
GST_END_TEST

GST_START_TEST(no_input_is_an_error) {
  std::mt19937 random(2);
  for (int round = 0; round < 200; ++round) {
    Klv harness;
    std::string all;
    for (guint64 n = 0; n < 6; ++n) {
      const auto parts = pieces(n, static_cast<unsigned>(n) + 1, 1 + random() % 3);
      for (const std::string &part : parts) all += random() % 4 == 0 ? foreign + part : part;
    }
    for (unsigned wounds = random() % 6; wounds > 0; --wounds) {
      const std::size_t at = random() % all.size(), size = random() % 400;
      switch (random() % 3) {
        case 0:
          all.erase(at, size);
          break;
        case 1:
          all.insert(at, all.substr(random() % all.size(), size));
          break;
        default:
          all[at] = static_cast<char>(random());
      }
      if (all.empty()) break;
    }
    for (std::size_t at = 0, step; at < all.size(); at += step) {
      step = 1 + random() % 500;
      harness.push_bytes(all.substr(at, step), GST_CLOCK_TIME_NONE, random() % 16 == 0);
    }
    // A whole packet is read, whatever came before it.
    const std::string end = packet(key(), line(20, 20 * frame_time));
    harness.push_bytes(end);
    harness.end();
    fail_unless_equals_int(harness.push(20 * frame_time), 20);
    fail_unless(harness.said(GST_MESSAGE_ERROR).empty());
  }
}
GST_END_TEST

GST_START_TEST(foreign_packets_alone_are_reported_once) {
  {
    Klv harness;
    harness.push_waiting(0);
    for (int i = 0; i < 49; ++i) harness.push_bytes(foreign);
    harness.wait_text();
    assert_silent(harness);
    for (int i = 0; i < 60; ++i) harness.push_bytes(foreign);
    harness.push_bytes(packet(0));
    harness.end();
    fail_unless_equals_int(harness.pull_number(), 0);
    fail_unless_equals_int(harness.push(frame_time), -1);
    assert_holds(harness.said(GST_MESSAGE_WARNING), "none of it is csdtrackenc's");
    fail_unless(harness.said(GST_MESSAGE_WARNING).empty());
  }
  {  // A long line comes in many buffers, and foreign packets may come among ours.
    Klv harness;
    const std::string one = packet(0);
    for (std::size_t at = 0; at < one.size(); at += 2) harness.push_bytes(one.substr(at, 2));
    for (int i = 0; i < 100; ++i) harness.push_bytes(foreign);
    harness.end();
    fail_unless_numbers(harness.right(2), {0});
    assert_silent(harness);
  }
}
GST_END_TEST

GST_START_TEST(a_transport_stream_takes_the_longest_lines) {
  if (!have("mpegtsmux") || !have("tsdemux")) return;
  const std::string file = temporary("long.ts");
  const auto collect = [](GstElement *pipeline, const char *name) {
    std::vector<std::pair<std::string, GstClockTime>> packets;
    probe(pipeline, name, "src", [&](GstBuffer *b, unsigned) { packets.emplace_back(text_in(b), GST_BUFFER_PTS(b)); });
    GError *error = play(pipeline);
    fail_unless(error == nullptr, "%s", error ? error->message : "");
    return packets;
  };
  GstElement *pipeline = launch(
      "videotestsrc num-buffers=10 ! video/x-raw,format=GRAY8,width=64,height=48,framerate=25/1 ! identity name=in "
      "! csdtrackenc ! identity name=out ! mpegtsmux ! filesink location=" +
      file);
  probe(pipeline, "in", "src", [](GstBuffer *b, unsigned n) { attach_many(b, n, n % 2 == 0 ? 5000 : 2); });
  const auto sent = collect(pipeline, "out");
  fail_unless_equals_int(sent.size(), 5 * 6 + 5);
  const auto got = collect(launch("filesrc location=" + file + " ! tsdemux ! queue name=out ! fakesink"), "out");
  fail_unless_equals_int(got.size(), sent.size());
  const GstClockTimeDiff shift = GST_CLOCK_DIFF(sent[0].second, got[0].second);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    fail_unless(got[i].first == sent[i].first, "%u", unsigned(i));
    // Times have a resolution of 90 kHz.
    const GstClockTimeDiff off = GST_CLOCK_DIFF(sent[i].second, got[i].second) - shift;
    fail_unless(ABS(off) < 20 * GST_USECOND, "%u: %" GST_STIME_FORMAT, unsigned(i), GST_STIME_ARGS(off));
  }
}
GST_END_TEST

static Suite *klv_suite() {
  Suite *s = suite_create("klv");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, foreign_packets_alone_are_reported_once);
  tcase_add_test(tc, a_length_uses_as_few_bytes_as_possible);
  tcase_add_test(tc, a_line_is_one_packet);
  tcase_add_test(tc, a_longer_line_is_several_packets);
  tcase_add_test(tc, packets_are_found_at_any_cut);
  tcase_add_test(tc, a_torn_packet_costs_its_line);
  tcase_add_test(tc, packets_a_demuxer_reports_lost_are_not_waited_for);
  tcase_add_test(tc, a_damaged_packet_costs_its_line);
  tcase_add_test(tc, a_line_with_a_lost_piece_is_not_joined);
  tcase_add_test(tc, the_buffers_time_takes_precedence_over_the_lines);
  tcase_add_test(tc, no_input_is_an_error);
  tcase_add_test(tc, a_transport_stream_takes_the_longest_lines);
  return s;
}

GST_CHECK_MAIN(klv)
