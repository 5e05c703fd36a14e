// SPDX-License-Identifier: LGPL-2.1-or-later
//
// csdtrackenc's files and recordings, read back by independent readers.
#include <glib/gstdio.h>
#include <signal.h>
#include <sys/wait.h>

#include <clocale>
#include <cmath>
#include <cstring>

#include "attach.h"
#include "read_text.h"

using csd_check::attach, csd_check::have, csd_check::Json, csd_check::lines_of;

namespace {

constexpr char video_caps[] = "video/x-raw,format=I420,width=64,height=48,framerate=25/1";
constexpr GstClockTime frame_time = 40 * GST_MSECOND;

std::string temporary(const char *name) {
  static std::string dir;
  if (dir.empty()) {
    g_autofree gchar *made = g_dir_make_tmp("csdtrackenc-XXXXXX", nullptr);
    dir = made;
  }
  return dir + "/" + name;
}

std::string read_file(const std::string &path) {
  gchar *data = nullptr;
  gsize size = 0;
  fail_unless(g_file_get_contents(path.c_str(), &data, &size, nullptr), "%s", path.c_str());
  std::string text(data, size);
  g_free(data);
  g_remove(path.c_str());
  return text;
}

/// Frames 0…n−1 into `tail`; `call` gets each of them.
GstElement *probed_pipeline(int n, const std::string &tail, csd_check::OnBuffer call) {
  GstElement *pipeline = csd_check::launch("videotestsrc num-buffers=" + std::to_string(n) + " ! " + video_caps +
                                           " ! identity name=in ! " + tail);
  csd_check::probe(pipeline, "in", "src", std::move(call));
  return pipeline;
}

/// Frames 0…n−1 into `tail`, all but the second with tracks.
GstElement *tracked_pipeline(int n, const std::string &tail) {
  return probed_pipeline(n, tail, [](GstBuffer *b, unsigned i) {
    if (i != 1) attach(b, "csdtrack0", i, 64, 48, 1.5 * i, 2);
  });
}

void play_to_end(GstElement *pipeline) {
  GError *error = csd_check::play(pipeline);
  fail_unless(error == nullptr, "%s", error ? error->message : "");
}

}  // namespace

GST_START_TEST(test_file_has_a_line_per_frame) {
  const std::string path = temporary("t.jsonl");
  play_to_end(
      tracked_pipeline(50, "tee name=t ! queue ! fakesink t. ! queue ! csdtrackenc ! filesink location=" + path));
  const std::vector<std::string> lines = lines_of(read_file(path));
  fail_unless_equals_int(lines.size(), 50);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json json(lines[i]);
    fail_unless_equals_uint64(std::int64_t(json["pts"]), i * frame_time);
    const auto features = json.features();
    fail_unless_equals_int(features.size(), i == 1 ? 0 : 2);
    if (i != 1) fail_unless(double(features.at(0)["x"]) == 1.5 * double(i));
  }
}
GST_END_TEST;

GST_START_TEST(test_csv_in_german_by_python) {
  const char *old = setlocale(LC_ALL, "de_DE.UTF-8");
  if (!old) {
    g_printerr("SKIP: the locale de_DE.UTF-8 is not installed; in C instead\n");
  } else {
    fail_unless_equals_string(localeconv()->decimal_point, ",");
  }
  const std::string path = temporary("t.csv");
  play_to_end(tracked_pipeline(4, "csdtrackenc ! text/csv ! filesink location=" + path));
  const std::string json_path = temporary("t.jsonl");
  play_to_end(tracked_pipeline(4, "csdtrackenc ! filesink location=" + json_path));
  const std::string line = read_file(json_path);
  setlocale(LC_ALL, "C");
  fail_unless(line.find("\"x\":4.500,") != std::string::npos, "%s", line.c_str());

  const std::string command =
      "/usr/bin/python3 " + std::string(g_getenv("CSDTRACK_CHECK_DIR")) + "/read_csv.py " + path;
  gchar *out = nullptr, *err = nullptr;
  gint status = 1;
  fail_unless(g_spawn_command_line_sync(command.c_str(), &out, &err, &status, nullptr) && status == 0, "%s", err);
  fail_unless_equals_string(out,
                            "0 0 0 0 0.0 2.0 tracked 0.931 true 9\n"
                            "0 0 0 7 0.0 0.0 lost 0.0 false 9\n"
                            "2 80000000 80000000 0 3.0 2.0 tracked 0.931 true 9\n"
                            "2 80000000 80000000 7 0.0 0.0 lost 0.0 false 9\n"
                            "3 120000000 120000000 0 4.5 2.0 tracked 0.931 true 9\n"
                            "3 120000000 120000000 7 0.0 0.0 lost 0.0 false 9\n");
  g_free(out);
  g_free(err);
  read_file(path);
}
GST_END_TEST;

/// The meta is a protocol: its states may be any words, and its numbers may be NaN.
GST_START_TEST(test_csv_of_other_programs_metadata) {
  const std::string path = temporary("t.csv");
  play_to_end(probed_pipeline(1, "csdtrackenc ! text/csv ! filesink location=" + path, [](GstBuffer *b, unsigned) {
    const GstCsdFeature feature{1, NAN, -INFINITY, "held, \"well\"", 0.5, TRUE};
    GstCsdHeader header{};
    header.source = header.algorithm = "hand";
    header.width = header.height = header.tracked_width = header.tracked_height = 64;
    header.n_features = 1;
    fail_unless(gst_buffer_add_csd_tracks(b, GST_CSD_TRACK_META_NAME, &header, &feature) != nullptr);
  }));
  const std::vector<std::string> lines = lines_of(read_file(path));
  fail_unless_equals_int(lines.size(), 2);
  fail_unless_equals_string(lines[1].c_str(), "0,0,0,1,,,\"held, \"\"well\"\"\",0.500,true");
}
GST_END_TEST;

GST_START_TEST(test_travels_through_matroska) {
  if (!have("matroskamux") || !have("x264enc") || !have("h264parse")) return;
  const std::string path = temporary("t.mkv");
  play_to_end(tracked_pipeline(
      60, "tee name=t matroskamux name=m ! filesink location=" + path +
              " t. ! queue ! x264enc ! h264parse ! m. t. ! queue max-size-time=5000000000 max-size-buffers=0 "
              "max-size-bytes=0 ! csdtrackenc ! m.subtitle_0"));
  std::vector<std::string> lines;
  std::vector<GstClockTime> times;
  GstElement *pipeline = csd_check::launch("filesrc location=" + path +
                                           " ! matroskademux name=d d.subtitle_0 ! queue ! fakesink name=out "
                                           "d.video_0 ! queue ! fakesink");
  csd_check::probe(pipeline, "out", "sink", [&](GstBuffer *buffer, unsigned) {
    GstMapInfo map;
    gst_buffer_map(buffer, &map, GST_MAP_READ);
    std::string text(reinterpret_cast<char *>(map.data), map.size);
    gst_buffer_unmap(buffer, &map);
    // matroskademux gives pango-markup; this undoes its escaping.
    for (const auto &[markup, plain] : {std::pair{"&quot;", "\""}, {"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}})
      for (std::size_t at; (at = text.find(markup)) != std::string::npos;) text.replace(at, strlen(markup), plain);
    lines.push_back(text.c_str());
    times.push_back(GST_BUFFER_PTS(buffer));
  });
  play_to_end(pipeline);
  g_remove(path.c_str());
  fail_unless_equals_int(lines.size(), 60);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json json(lines[i]);
    fail_unless_equals_uint64(std::int64_t(json["pts"]), i * frame_time);
    fail_unless_equals_uint64(times[i], i * frame_time);
    const auto features = json.features();
    fail_unless_equals_int(features.size(), i == 1 ? 0 : 2);
  }
}
GST_END_TEST;

GST_START_TEST(test_a_full_disk_is_an_error) {
  GError *error =
      csd_check::play(tracked_pipeline(100, "csdtrackenc ! filesink buffer-mode=unbuffered location=/dev/full"));
  fail_unless(g_error_matches(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NO_SPACE_LEFT));
  g_error_free(error);
}
GST_END_TEST;

GST_START_TEST(test_a_killed_process_leaves_whole_lines) {
  const std::string path = temporary("k.jsonl");
  const std::string location = "location=" + path;
  const char *argv[] = {"gst-launch-1.0", "-q",
                        "videotestsrc",   "!",
                        video_caps,       "!",
                        "csdtrackenc",    "!",
                        "filesink",       "buffer-mode=unbuffered",
                        location.c_str(), nullptr};
  GPid pid = 0;
  fail_unless(g_spawn_async(nullptr, const_cast<char **>(argv), nullptr,
                            static_cast<GSpawnFlags>(G_SPAWN_SEARCH_PATH | G_SPAWN_DO_NOT_REAP_CHILD), nullptr, nullptr,
                            &pid, nullptr));
  GStatBuf file = {};
  for (int i = 0; i < 1000 && file.st_size < 20000; ++i) {
    g_usleep(10000);
    if (g_stat(path.c_str(), &file) != 0) file.st_size = 0;
  }
  kill(pid, SIGKILL);
  int status = 0;
  waitpid(pid, &status, 0);
  fail_unless(WIFSIGNALED(status));
  std::vector<std::string> lines = lines_of(read_file(path));
  fail_unless(lines.size() > 50, "%u lines", unsigned(lines.size()));
  lines.pop_back();  // it may be torn
  for (std::size_t i = 0; i < lines.size(); ++i)
    fail_unless_equals_uint64(std::int64_t(Json(lines[i])["pts"]), i * frame_time);
}
GST_END_TEST;

static Suite *csdtrackenc_files_suite() {
  Suite *s = suite_create("csdtrackenc_files");
  TCase *tc = tcase_create("general");
  suite_add_tcase(s, tc);
  gst_object_unref(gst_plugin_load_by_name("csdtrack"));
  tcase_add_test(tc, test_file_has_a_line_per_frame);
  tcase_add_test(tc, test_csv_in_german_by_python);
  tcase_add_test(tc, test_csv_of_other_programs_metadata);
  tcase_add_test(tc, test_travels_through_matroska);
  tcase_add_test(tc, test_a_full_disk_is_an_error);
#ifndef CSDTRACK_SANITIZED
  // The system's gst-launch-1.0 can't load a sanitized plugin.
  tcase_add_test(tc, test_a_killed_process_leaves_whole_lines);
#else
  (void)test_a_killed_process_leaves_whole_lines;
#endif
  return s;
}

GST_CHECK_MAIN(csdtrackenc_files)
