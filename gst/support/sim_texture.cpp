// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/sim_texture.h"

#include <gdk-pixbuf/gdk-pixbuf.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "record/file_name.h"

namespace csd {
namespace {

constexpr int longest_side = 8192;
/// More than the longest picture without compression, of 16-bit R G B A, has.
constexpr std::uintmax_t longest_file = std::uintmax_t{1} << 30;

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
using Loader = std::unique_ptr<GdkPixbufLoader, Unref>;

[[noreturn]] void fail(const std::string &file, const std::string &why) {
  throw std::invalid_argument(
      "texture: " + quoted(file) + " " + why +
      ". Name a picture that gdk-pixbuf can read (PNG, JPEG, TIFF, BMP, …), of at most 8192 × 8192 pixels.");
}

/// Also frees the error.
std::string text_of(GError *error) {
  if (!error) return "it is damaged";
  const std::unique_ptr<GError, decltype(&g_error_free)> freed(error, g_error_free);
  return error->message;
}

/// Opens a file that is worth reading: a device or a pipe may have no end.
std::ifstream open(const std::string &file) {
  std::error_code none;
  const auto status = std::filesystem::status(file, none);
  if (!std::filesystem::exists(status)) fail(file, "doesn't exist");
  if (!std::filesystem::is_regular_file(status)) fail(file, "is not a file");
  if (std::filesystem::file_size(file, none) > longest_file) fail(file, "is longer than 1 GiB");
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(file, "can't be opened");
  return in;
}

/// What the loader has said so far.
struct Progress {
  int width = 0, height = 0;            ///< in the picture's head
  int first = longest_side, last = -1;  ///< the rows that are read
  bool too_large() const { return width > longest_side || height > longest_side; }
  /// Some loaders take a file that ends too soon, and leave the rest of the picture as the memory was.
  bool cut_off() const { return last - first + 1 < height; }
};

/// Called before the loader allocates the picture: a file of a few bytes may claim to be one of gigabytes. A size of 0
/// makes it stop.
void on_size(GdkPixbufLoader *loader, int width, int height, Progress *progress) {
  progress->width = width;
  progress->height = height;
  if (progress->too_large()) gdk_pixbuf_loader_set_size(loader, 0, 0);
}

void on_rows(GdkPixbufLoader *, int, int y, int, int height, Progress *progress) {
  progress->first = std::min(progress->first, y);
  progress->last = std::max(progress->last, y + height - 1);
}

/// Feeds the file to the loader. Ends it in any case: that frees what it holds.
void read(const std::string &file, GdkPixbufLoader *loader, const Progress &progress) {
  std::ifstream in = open(file);
  GError *error = nullptr;
  bool going = true;
  for (std::array<char, 65536> part; going && !progress.too_large();) {
    in.read(part.data(), part.size());
    if (in.gcount() == 0) break;
    going = gdk_pixbuf_loader_write(loader, reinterpret_cast<const guchar *>(part.data()),
                                    static_cast<gsize>(in.gcount()), &error);
  }
  if (!gdk_pixbuf_loader_close(loader, going ? &error : nullptr)) going = false;
  if (progress.too_large()) {
    g_clear_error(&error);
    fail(file, "is of " + std::to_string(progress.width) + " × " + std::to_string(progress.height) + " pixels");
  }
  if (going && progress.cut_off()) fail(file, "can't be decoded: it ends too soon");
  if (going) return;
  const bool unknown = g_error_matches(error, GDK_PIXBUF_ERROR, GDK_PIXBUF_ERROR_UNKNOWN_TYPE);
  fail(file, (unknown ? "is not a picture: " : "can't be decoded: ") + text_of(error));
}

}  // namespace

cv::Mat load_picture(const std::string &file) {
  Progress progress;
  const Loader loader(gdk_pixbuf_loader_new());
  g_signal_connect(loader.get(), "size-prepared", G_CALLBACK(on_size), &progress);
  g_signal_connect(loader.get(), "area-updated", G_CALLBACK(on_rows), &progress);
  try {
    read(file, loader.get(), progress);
  } catch (...) {
    gdk_pixbuf_loader_close(loader.get(), nullptr);  // does nothing if it is closed; unclosed it would warn
    throw;
  }
  const GdkPixbuf *pixbuf = gdk_pixbuf_loader_get_pixbuf(loader.get());  // of an animation, its first picture
  if (!pixbuf) fail(file, "holds no picture");
  const int channels = gdk_pixbuf_get_n_channels(pixbuf);
  // gdk-pixbuf's pictures are of 8-bit R G B or R G B A. OpenCV doesn't write to them.
  const cv::Mat rgb(gdk_pixbuf_get_height(pixbuf), gdk_pixbuf_get_width(pixbuf), CV_8UC(channels),
                    const_cast<guint8 *>(gdk_pixbuf_read_pixels(pixbuf)),
                    static_cast<std::size_t>(gdk_pixbuf_get_rowstride(pixbuf)));
  cv::Mat picture;
  cv::cvtColor(rgb, picture, channels == 4 ? cv::COLOR_RGBA2BGR : cv::COLOR_RGB2BGR);
  return picture;
}

}  // namespace csd
