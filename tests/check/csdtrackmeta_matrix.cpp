// SPDX-License-Identifier: LGPL-2.1-or-later
//
// What becomes of the metadata downstream: it must be right or absent. Draws a white square where the metadata puts a
// feature, and looks for it in the output. Each is a row of docs/results/downstream.md, which must match the
// measurement; `ninja -C build meta-matrix` writes it.
#include <gst/video/video.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "attach.h"

// Last, since it defines a macro `fail`.
#include <gst/check/gstcheck.h>

namespace {

constexpr char begin_mark[] = "<!-- written by `ninja -C build meta-matrix` -->",
               end_mark[] = "<!-- end of meta-matrix -->";

struct Point {
  double x = 0, y = 0;
};

// The square covers the pixels 80…119 × 60…99 of 640 × 480.
constexpr int in_width = 640, in_height = 480, square_x = 80, square_y = 60, square_side = 40;
constexpr Point in_centre = {99.5, 79.5};
constexpr double no_brighter = 60;  // counts as black, since coded black is not quite black
// Pixels of the output. When it doubles the width, videoscale's bilinear filter itself shifts the picture by a third of
// a pixel. An element that forgets that centres are at integers would be off by a half.
constexpr double tracks_tolerance = 0.4;
constexpr double box_tolerance = 1;  // a box has whole pixels

/// A picture's size, and where its feature is.
struct At {
  int width, height;
  double x, y;
};
constexpr At unchanged = {in_width, in_height, in_centre.x, in_centre.y};
constexpr std::nullopt_t gone = std::nullopt;

struct Row {
  const char *elements;
  std::optional<At> at;  ///< of the tracks, by hand; none: no tracks arrive
  bool all = true;       ///< on all buffers that arrive, otherwise on some
};

// x' = (x + 1/2) s − 1/2: 100/2 − 1/2 and 80/2 − 1/2; 100·3/2 − 1/2 and 80·3/2 − 1/2; 100/4 − 1/2 and 80/4 − 1/2.
constexpr At half = {320, 240, 49.5, 39.5}, larger = {960, 720, 149.5, 119.5}, quarter = {160, 120, 24.5, 19.5};
constexpr auto rows = std::to_array<Row>({
    {"queue", unchanged},
    {"tee ! queue", unchanged},
    {"identity", unchanged},
    {"videorate ! video/x-raw,framerate=60/1", unchanged},
    {"videobalance saturation=0.5", unchanged},
    {"gamma gamma=1.2", unchanged},
    {"textoverlay text=A", unchanged},
    {"deinterlace mode=interlaced", gone},
    {"videoconvert ! video/x-raw,format=BGR", unchanged},
    {"videoconvert ! video/x-raw,format=NV12", unchanged},
    {"videoconvert ! video/x-raw,format=GRAY8", unchanged},
    {"videoscale ! video/x-raw,width=320,height=240", half},
    {"videoscale ! video/x-raw,width=960,height=720", larger},
    {"videoconvertscale ! video/x-raw,format=NV12,width=320,height=240", half},
    {"videoscale ! video/x-raw,width=320,height=240 ! videoscale ! video/x-raw,width=160,height=120", quarter},
    {"videoscale add-borders=true ! video/x-raw,width=640,height=640,pixel-aspect-ratio=1/1", gone},
    {"videoscale add-borders=false ! video/x-raw,width=640,height=640,pixel-aspect-ratio=1/1", gone},
    {"videocrop left=8", gone},
    {"aspectratiocrop aspect-ratio=1/1", gone},
    {"videobox left=-8", gone},
    {"videoflip video-direction=horiz", gone},
    {"compositor", gone},
    {"x264enc", unchanged},
    {"x264enc tune=zerolatency ! h264parse", unchanged},
    {"x264enc ! h264parse ! avdec_h264", unchanged},
    {"x264enc ! h264parse ! avdec_h264 ! videoconvertscale ! video/x-raw,format=BGR,width=320,height=240", half},
    {"openh264enc ! h264parse ! openh264dec", unchanged},
    {"x265enc ! h265parse ! avdec_h265", unchanged},
    {"jpegenc ! jpegparse ! jpegdec", unchanged},
    {"avenc_mpeg4 ! mpeg4videoparse ! avdec_mpeg4", unchanged},
    {"avenc_ffv1 ! avdec_ffv1", unchanged},
    {"vp8enc deadline=1 ! vp8dec", unchanged},
    {"vp9enc deadline=1 ! vp9parse ! vp9dec", unchanged},
    {"theoraenc ! theoradec", unchanged, false},
    {"y4menc", unchanged},
    {"x264enc ! mp4mux", unchanged, false},
    {"x264enc ! matroskamux", unchanged, false},
    {"x264enc ! h264parse ! mpegtsmux", gone},
    {"jpegenc ! multipartmux", unchanged, false},
    {"x264enc ! rtph264pay", gone},
    {"jpegenc ! rtpjpegpay", gone},
    {"rtpvrawpay", gone},
});

/// What arrives. Sums are over all buffers, the rest is from the last buffer.
struct Arrived {
  bool there = true;  ///< all these elements exist
  std::string error;
  unsigned buffers = 0, tracks = 0, truths = 0, boxes = 0, parameters = 0;
  GstCsdHeader header{};
  GstCsdFeature feature{}, second{};
  bool truth_agrees = true;            ///< with the tracks, whose copy it is
  Point box;                           ///< centre of the region of interest
  double tracks_off = 0, box_off = 0;  ///< their largest distance from the square
  int width = 0, height = 0;           ///< 0: the output is not raw
};

void put_in(GstBuffer *buffer, unsigned frame) {
  for (const char *name : {GST_CSD_TRACK_META_NAME, GST_CSD_TRUTH_META_NAME})
    csd_check::attach(buffer, "csdtrack0", frame, in_width, in_height, in_centre.x, in_centre.y, name);
  GstVideoRegionOfInterestMeta *roi =
      gst_buffer_add_video_region_of_interest_meta(buffer, "csdtrack", square_x, square_y, square_side, square_side);
  gst_video_region_of_interest_meta_add_param(roi, gst_structure_new("csdtrack", "id", G_TYPE_UINT, 0, nullptr));
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READWRITE)) g_error("a frame can't be mapped");
  for (int y = square_y; y < square_y + square_side; ++y)
    std::memset(map.data + y * in_width + square_x, 235, square_side);
  gst_buffer_unmap(buffer, &map);
}

/// The centre of the bright area. The square is alone in the picture.
Point look(const GstVideoInfo &info, GstBuffer *buffer) {
  GstVideoFrame frame;
  if (!gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ)) g_error("a frame can't be mapped");
  const int component = GST_VIDEO_INFO_IS_RGB(&info) ? 1 : 0;  // green, or luma
  const auto *data = static_cast<const guint8 *>(GST_VIDEO_FRAME_COMP_DATA(&frame, component));
  double weight = 0, x_sum = 0, y_sum = 0;
  // Only in the square's quarter: textoverlay writes into the others.
  for (int y = 0; y < info.height / 2; ++y)
    for (int x = 0; x < info.width / 2; ++x) {
      const guint8 value = data[y * GST_VIDEO_FRAME_COMP_STRIDE(&frame, component) +
                                x * GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, component)];
      const double w = std::max(0., value - no_brighter);
      weight += w;
      x_sum += w * x;
      y_sum += w * y;
    }
  gst_video_frame_unmap(&frame);
  return {x_sum / weight, y_sum / weight};
}

/// The distance of two points in x or in y, the larger; infinite if one is nowhere.
double apart(Point a, Point b) {
  const double far = std::max(std::abs(a.x - b.x), std::abs(a.y - b.y));
  return std::isnan(far) ? INFINITY : far;
}

void take_out(Arrived &arrived, GstBuffer *buffer, const GstCaps *caps) {
  ++arrived.buffers;
  Point truly = in_centre;  // since encoded video can't be inspected
  GstVideoInfo info;
  if (gst_structure_has_name(gst_caps_get_structure(caps, 0), "video/x-raw") && gst_video_info_from_caps(&info, caps)) {
    arrived.width = info.width;
    arrived.height = info.height;
    truly = look(info, buffer);
  }
  const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  const GstStructure *truth = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRUTH_META_NAME, nullptr);
  if (tracks && gst_csd_structure_get_header(tracks, &arrived.header) &&
      gst_csd_structure_get_feature(tracks, 0, &arrived.feature) &&
      gst_csd_structure_get_feature(tracks, 1, &arrived.second)) {
    ++arrived.tracks;
    arrived.tracks_off = std::max(arrived.tracks_off, apart({arrived.feature.x, arrived.feature.y}, truly));
  }
  if (truth) {
    ++arrived.truths;
    GstCsdFeature true_one;
    arrived.truth_agrees &= gst_csd_structure_get_feature(truth, 0, &true_one) && true_one.x == arrived.feature.x &&
                            true_one.y == arrived.feature.y;
  }
  if (const GstVideoRegionOfInterestMeta *roi = gst_buffer_get_video_region_of_interest_meta(buffer)) {
    ++arrived.boxes;
    arrived.box = {roi->x + (roi->w - 1) / 2.0, roi->y + (roi->h - 1) / 2.0};
    arrived.box_off = std::max(arrived.box_off, apart(arrived.box, truly));
    if (roi->params) ++arrived.parameters;
  }
}

void on_handoff(GstElement *, GstBuffer *buffer, GstPad *pad, gpointer arrived) {
  GstCaps *caps = gst_pad_get_current_caps(pad);
  take_out(*static_cast<Arrived *>(arrived), buffer, caps);
  gst_caps_unref(caps);
}

Arrived send_through(const std::string &elements, const std::string &par = "1/1") {
  Arrived arrived;
  GError *error = nullptr;
  GstElement *pipeline = gst_parse_launch(
      ("videotestsrc num-buffers=5 pattern=black ! video/x-raw,format=I420,framerate=30/1,width=640,height=480,"
       "pixel-aspect-ratio=" +
       par + " ! identity name=in ! " + elements + " ! fakesink name=out signal-handoffs=true")
          .c_str(),
      &error);
  if (error) {
    arrived.there = !g_error_matches(error, GST_PARSE_ERROR, GST_PARSE_ERROR_NO_SUCH_ELEMENT);
    arrived.error = error->message;
    g_clear_error(&error);
    gst_clear_object(&pipeline);
    return arrived;
  }
  csd_check::probe(pipeline, "in", "src", put_in);
  GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  g_signal_connect(out, "handoff", G_CALLBACK(on_handoff), &arrived);
  gst_object_unref(out);
  error = csd_check::play(pipeline);
  if (error) arrived.error = error->message;
  g_clear_error(&error);
  return arrived;
}

std::string fate(unsigned metas, unsigned buffers, Point position, double off, double tolerance) {
  if (metas == 0) return "gone";
  if (off > tolerance) return "WRONG";
  const std::string kept = apart(position, in_centre) < 1e-9 ? "kept" : "scaled";
  return metas == buffers ? kept : kept + " on some buffers";
}

/// The page's row.
std::string line_of(const char *elements, const Arrived &a) {
  return std::string("| `") + elements + "` | " +
         fate(a.tracks, a.buffers, {a.feature.x, a.feature.y}, a.tracks_off, tracks_tolerance) + " | " +
         fate(a.boxes, a.buffers, a.box, a.box_off, box_tolerance) + " | " + (a.parameters ? "kept" : "gone") + " |";
}

std::string page_path() {
  const char *here = g_getenv("CSDTRACK_CHECK_DIR");
  if (!here) g_error("CSDTRACK_CHECK_DIR isn't set");
  return std::string(here) + "/../../docs/results/downstream.md";
}

std::string read_page() {
  std::ifstream file(page_path(), std::ios::binary);
  if (!file) g_error("%s can't be read", page_path().c_str());
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The text between the marks.
std::string_view written(const std::string &page) {
  const auto begin = page.find(begin_mark), end = page.find(end_mark);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    g_error("%s has no lines \"%s\", \"%s\"", page_path().c_str(), begin_mark, end_mark);
  const auto inside = begin + sizeof begin_mark;
  return std::string_view(page).substr(inside, end - inside);
}

std::string heading() {
  guint major, minor, micro, nano;
  gst_version(&major, &minor, &micro, &nano);
  return "GStreamer " + std::to_string(major) + "." + std::to_string(minor) + ":\n\n" +
         "| through | GstCsdTrackMeta, GstCsdTruthMeta | box of `attach-roi` | its parameters |\n|---|---|---|---|\n";
}

/// The page's row for these elements, or "".
std::string row_on_page(std::string_view table, const char *elements) {
  std::istringstream lines{std::string(table)};
  const std::string begin = std::string("| `") + elements + "` |";
  for (std::string line; std::getline(lines, line);)
    if (line.compare(0, begin.size(), begin) == 0) return line;
  return "";
}

/// Measures all rows and writes them into the page. Rows that can't be measured here stay.
int write_page() {
  std::string page = read_page();
  const std::string_view old = written(page);
  std::string table = heading();
  for (const Row &row : rows) {
    const Arrived a = send_through(row.elements);
    const std::string line = a.there ? line_of(row.elements, a) : row_on_page(old, row.elements);
    g_print("%s\n", line.c_str());
    if (!a.there) g_printerr("SKIP: %s: the page's row stays\n", a.error.c_str());
    if (!line.empty()) table += line + "\n";
  }
  page.replace(static_cast<std::size_t>(old.data() - page.data()), old.size(), table);
  std::ofstream(page_path(), std::ios::binary) << page;
  return 0;
}

void assert_at(const char *elements, const Arrived &a, const std::optional<At> &at, bool all = true) {
  fail_unless(a.error.empty(), "%s: %s", elements, a.error.c_str());
  fail_unless(
      a.buffers > 0 && a.truths == a.tracks && (at ? (all ? a.tracks == a.buffers : a.tracks > 0) : a.tracks == 0),
      "%s: %u tracks, %u truths on %u buffers", elements, a.tracks, a.truths, a.buffers);
  if (!at) return;
  fail_unless(std::abs(a.feature.x - at->x) < 1e-9 && std::abs(a.feature.y - at->y) < 1e-9, "%s: %f,%f", elements,
              a.feature.x, a.feature.y);
  fail_unless(a.tracks_off < tracks_tolerance, "%s: %f off from what the picture shows", elements, a.tracks_off);
  fail_unless(a.truth_agrees, "%s", elements);
  fail_unless(a.header.width == at->width && a.header.height == at->height, "%s: %dx%d", elements, a.header.width,
              a.header.height);
  fail_unless(a.width == 0 || (a.width == at->width && a.height == at->height), "%s: %dx%d", elements, a.width,
              a.height);
  fail_unless(a.header.tracked_width == in_width && a.header.tracked_height == in_height);
  fail_unless(a.second.id == 7);
}

}  // namespace

GST_START_TEST(test_measured_row_matches_the_page) {
  const Row &row = rows[static_cast<std::size_t>(__i__)];
  const Arrived a = send_through(row.elements);
  if (!a.there) {
    g_printerr("SKIP: %s: %s\n", row.elements, a.error.c_str());
    return;
  }
  assert_at(row.elements, a, row.at, row.all);
  // The assertions up to here hold with every GStreamer. The page is about one version.
  const std::string page = read_page();
  if (written(page).find(heading()) != 0) {
    g_printerr("SKIP: the page is about another GStreamer\n");
    return;
  }
  const std::string said = row_on_page(written(page), row.elements), measured = line_of(row.elements, a);
  fail_unless_equals_string(said.c_str(), measured.c_str());
}
GST_END_TEST;

GST_START_TEST(test_page_has_exactly_these_rows) {
  const std::string page = read_page();
  std::istringstream lines{std::string(written(page))};
  std::string line;
  while (std::getline(lines, line) && line.compare(0, 4, "|---") != 0) {
  }
  for (const Row &row : rows) {
    fail_unless(static_cast<bool>(std::getline(lines, line)));
    fail_unless(line.find(std::string("| `") + row.elements + "` |") == 0, "%s: run meta-matrix", line.c_str());
  }
  fail_if(static_cast<bool>(std::getline(lines, line)), "%s: run meta-matrix", line.c_str());
}
GST_END_TEST;

GST_START_TEST(test_pixel_aspect_ratio) {
  // Other pixels with the same display aspect: 640·2 : 480 is 1280 : 480, without a border. 100·2 − 1/2.
  const char *elements = "videoscale ! video/x-raw,width=1280,height=480,pixel-aspect-ratio=1/1";
  assert_at(elements, send_through(elements, "2/1"), At{1280, 480, 199.5, 79.5});
  // 321 columns make 240.75 rows: an aspect that is off by less than a row leaves no border.
  elements = "videoscale ! video/x-raw,width=321,height=240,pixel-aspect-ratio=1/1";
  assert_at(elements, send_through(elements), At{321, 240, 100. * 321 / 640 - 0.5, 39.5});
}
GST_END_TEST;

GST_START_TEST(test_is_absent_where_it_would_be_wrong) {
  for (const char *borders : {"true", "false"}) {
    const std::string scale =
        std::string("videoscale add-borders=") + borders + " ! video/x-raw,pixel-aspect-ratio=1/1,";
    for (const auto &[size, par] : {std::pair{"width=640,height=640", "1/1"}, std::pair{"width=1280,height=480", "1/1"},
                                    std::pair{"width=640,height=482", "1/1"}, std::pair{"width=320,height=240", "2/1"}})
      assert_at(size, send_through(scale + size, par), gone);
  }
}
GST_END_TEST;

static Suite *csdtrackmeta_matrix_suite() {
  Suite *s = suite_create("csdtrackmeta_matrix");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  tcase_add_loop_test(tc, test_measured_row_matches_the_page, 0, static_cast<int>(rows.size()));
  tcase_add_test(tc, test_page_has_exactly_these_rows);
  tcase_add_test(tc, test_pixel_aspect_ratio);
  tcase_add_test(tc, test_is_absent_where_it_would_be_wrong);
  return s;
}

int main(int argc, char **argv) {
  const bool write = argc == 2 && std::strcmp(argv[1], "--write") == 0;
  if (write) argc = 1;
  gst_check_init(&argc, &argv);
  GstPlugin *plugin = gst_plugin_load_by_name("csdtrack");
  if (!plugin) g_error("no plugin: is GST_PLUGIN_PATH set?");
  gst_object_unref(plugin);
  if (write) {
    alarm(1200);  // neither check nor meson ends a pipeline that hangs here
    return write_page();
  }
  return gst_check_run_suite(csdtrackmeta_matrix_suite(), "csdtrackmeta_matrix", __FILE__);
}
