// SPDX-License-Identifier: LGPL-2.1-or-later
// csd-label: ground truth by hand. docs/metrics.md explains how.
#include <glib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <opencv2/highgui/highgui_c.h>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <opencv2/highgui.hpp>
#include <optional>
#include <system_error>

#include "programs/command_line.h"
#include "programs/label_session.h"
#include "programs/label_view.h"
#include "programs/video_frames.h"

namespace csd::programs {
namespace {

constexpr char window_name[] = "csd-label";
const cv::Size largest_picture(1500, 850);  ///< leaves room for the loupe on a full-HD screen
constexpr double zoom_factor = 4;

struct Options {
  std::string video, labels;
  unsigned every = 50;
};

Options parse(int argc, char **argv) {
  Options options;
  gchar **files = nullptr, *output = nullptr;
  gint every = static_cast<gint>(options.every);
  const GOptionEntry entries[] = {
      {"output", 'o', 0, G_OPTION_ARG_FILENAME, &output, "Where the labels go (VIDEO.labels.csv)", "FILE"},
      {"every", 0, 0, G_OPTION_ARG_INT, &every, "Label frame 0 and every N-th (50)", "N"},
      {G_OPTION_REMAINING, 0, 0, G_OPTION_ARG_FILENAME_ARRAY, &files, nullptr, nullptr},
      {nullptr, 0, 0, G_OPTION_ARG_NONE, nullptr, nullptr, nullptr}};
  parse_options(argc, argv, entries, "VIDEO  - label points by hand, for csd-score",
                "Click the points in frame 0, then Enter. In every N-th frame click where each is now, as asked.\n"
                "  h  it is hidden or outside     z  zoom in at the mouse, and out\n"
                "  ?  can't be told (not scored)  u  undo, as often as you like\n"
                "  q  end; the labels are saved after each answer, and the same command goes on from there");
  if (!files || !files[0] || files[1]) throw UsageError("takes one VIDEO; csd-label --help tells more");
  if (every < 1) throw UsageError("--every: at least 1");
  options.video = files[0];
  options.labels = output ? output : options.video + ".labels.csv";
  options.every = static_cast<unsigned>(every);
  g_strfreev(files);
  g_free(output);
  return options;
}

/// Atomic: the old file stays until the new one is complete.
void save(const LabelSession &session, const std::string &file) {
  const std::string text = session.csv();
  GError *error = nullptr;
  if (g_file_set_contents_full(file.c_str(), text.data(), static_cast<gssize>(text.size()),
                               G_FILE_SET_CONTENTS_CONSISTENT, 0666, &error))
    return;
  const std::string why = error->message;
  g_error_free(error);
  throw std::runtime_error(file + ": can't be written: " + why);
}

/// Throws if no window can be opened. Without a usable display (no $DISPLAY, no server, no permission) Qt ends the
/// process, so a child tries first. It keeps its connection until this object is destroyed, because an X server that
/// loses its last client resets and closes new connections.
class Display {
 public:
  /// Create it while the process has one thread: fork() copies only the calling thread.
  Display() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0 || (child_ = fork()) < 0)
      throw std::system_error(errno, std::generic_category(), "trying the display");
    if (child_ == 0) {
      close(ends[0]);
      hold(ends[1]);
    }
    close(ends[1]);
    socket_ = ends[0];
    char opened = 0;
    if (read(socket_, &opened, 1) == 1) return;
    release();
    const char *const x11 = g_getenv("DISPLAY");
    throw std::runtime_error("no window can be opened (DISPLAY is " + (x11 ? "'" + std::string(x11) + "'" : "not set") +
                             "): run it in a terminal of a desktop, or over ssh -X");
  }
  ~Display() { release(); }
  Display(const Display &) = delete;
  Display &operator=(const Display &) = delete;

 private:
  [[noreturn]] static void hold(int socket) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    if (!std::freopen("/dev/null", "w", stderr)) _exit(1);  // the error above is clearer than Qt's
    cvInitSystem(0, nullptr);
    char byte = 1;
    if (write(socket, &byte, 1) == 1) (void)!read(socket, &byte, 1);  // blocks until the other end is closed
    _exit(0);
  }

  void release() {
    close(socket_);
    waitpid(child_, nullptr, 0);
  }

  pid_t child_ = -1;
  int socket_ = -1;
};

class Window {
 public:
  Window(const Options &options, LabelSession session)
      : options_(options), session_(std::move(session)), frames_(options.video) {
    first_ = frames_.at(0).bgr;
    if (first_.empty()) throw std::runtime_error(options.video + ": has no frame");
    view_ = LabelView::whole(first_.size(), largest_picture);
    cv::namedWindow(window_name, cv::WINDOW_AUTOSIZE | cv::WINDOW_GUI_NORMAL);
    cv::setMouseCallback(window_name, on_mouse, this);
  }
  ~Window() { cv::destroyAllWindows(); }
  Window(const Window &) = delete;
  Window &operator=(const Window &) = delete;

  /// Runs until everything is labelled or the user quits.
  void run() {
    for (;;) {
      const cv::Mat frame = frames_.at(session_.frame()).bgr;
      if (frame.empty()) {
        std::printf("%s: all %zu points in all frames up to the end\n", options_.labels.c_str(), session_.points());
        return;
      }
      if (frame.size() != first_.size()) throw std::runtime_error(options_.video + ": the picture's size changes");
      if (!ask(frame)) return;
    }
  }

 private:
  /// Runs until the frame changes; returns false to quit.
  bool ask(const cv::Mat &frame) {
    cv::setWindowTitle(window_name, std::string(window_name) + ": frame " + std::to_string(session_.frame()));
    const std::uint64_t number = session_.frame();
    clicked_ = false;  // it was for the previous frame
    while (session_.frame() == number) {
      const bool was_choosing = session_.choosing();
      cv::imshow(window_name, draw_label_window(view_, frame, first_, session_, mouse_, message()));
      const int key = cv::waitKey(30) & 0xff;
      if (key == 'q' || key == 27 || cv::getWindowProperty(window_name, cv::WND_PROP_VISIBLE) < 1) return false;
      if (clicked_) {
        session_.place(view_.to_picture(click_));
        clicked_ = false;
        save(session_, options_.labels);
      }
      on_key(key);
      if (was_choosing != session_.choosing()) break;
    }
    return true;
  }

  void on_key(int key) {
    bool changed = false;
    if (key == '\r' || key == '\n') {
      session_.done_choosing();
    } else if ((key == 'h' || key == '?') && !session_.choosing()) {
      session_.skip(key == 'h' ? LabelSession::Sight::hidden : LabelSession::Sight::uncertain);
      changed = true;
    } else if (key == 'u') {
      changed = session_.undo();
    } else if (key == 'z') {
      if (zoomed_)
        view_ = LabelView::whole(first_.size(), largest_picture);
      else
        view_.zoom(mouse_, zoom_factor);
      zoomed_ = !zoomed_;
    }
    if (changed) save(session_, options_.labels);
  }

  std::string message() const {
    if (session_.choosing())
      return "frame 0: click the points (" + std::to_string(session_.points()) +
             " so far), then Enter; z zoom, u undo, q quit";
    return "frame " + std::to_string(session_.frame()) + ": where is point " + std::to_string(session_.point()) +
           " of " + std::to_string(session_.points()) + "?  h hidden, ? unsure, z zoom, u undo, q quit";
  }

  static void on_mouse(int event, int x, int y, int, void *self) {
    auto *const window = static_cast<Window *>(self);
    if (x < 0 || y < 0 || x >= window->view_.screen.width || y >= window->view_.screen.height) return;
    window->mouse_ = {x, y};
    if (event != cv::EVENT_LBUTTONDOWN) return;
    window->click_ = {x, y};
    window->clicked_ = true;
  }

  const Options &options_;
  LabelSession session_;
  VideoFrames frames_;
  cv::Mat first_;
  LabelView view_;
  bool zoomed_ = false, clicked_ = false;
  cv::Point mouse_, click_;
};

int main(int argc, char **argv) {
  return run_command("csd-label", [&](std::vector<std::string> &) {
    const Options options = parse(argc, argv);
    LabelSession session(options.every);
    if (std::filesystem::exists(options.labels))
      session = LabelSession::resume(read_text_file(options.labels), options.every);
    std::optional<Display> display(std::in_place);
    Window window(options, std::move(session));
    display.reset();
    window.run();
  });
}

}  // namespace
}  // namespace csd::programs

int main(int argc, char **argv) {
  return csd::programs::main(argc, argv);
}
