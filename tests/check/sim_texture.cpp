// SPDX-License-Identifier: LGPL-2.1-or-later
//
// The picture of csdsimsrc's property `texture`: what is read, and what is refused before it is decoded.
#include "support/sim_texture.h"

#include <gdk-pixbuf/gdk-pixbuf.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

class SimTexture : public testing::Test {
 protected:
  SimTexture() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sim_texture-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~SimTexture() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string &content) {
    const std::string name = folder_ / "picture";
    std::ofstream(name, std::ios::binary) << content;
    return name;
  }

  /// What refusing it says.
  static std::string error_of(const std::string &file) {
    try {
      csd::load_picture(file);
    } catch (const std::invalid_argument &error) {
      return error.what();
    }
    return "it was read";
  }

  std::filesystem::path folder_;
};

#define EXPECT_SAYS(text, part) \
  EXPECT_PRED2([](auto &a, auto &b) { return a.find(b) != a.npos; }, text, std::string(part))

void number(std::string &bytes, std::size_t at, unsigned value) {
  for (unsigned i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> 8 * i);
}

/// The first 54 bytes of a BMP.
std::string bmp_head(unsigned width, unsigned height) {
  std::string bytes(54, '\0');
  bytes.replace(0, 2, "BM");
  number(bytes, 10, 54);
  number(bytes, 14, 40);
  number(bytes, 18, width);
  number(bytes, 22, height);
  bytes[26] = 1;
  bytes[28] = 24;
  return bytes;
}

TEST_F(SimTexture, ReadsPicturesAsBlueGreenRed) {
  for (const char *type : {"png", "tiff", "bmp"}) {
    for (const bool alpha : {false, true}) {
      GdkPixbuf *made = gdk_pixbuf_new(GDK_COLORSPACE_RGB, alpha, 8, 3, 5);
      gdk_pixbuf_fill(made, 0x102030ff);
      guchar *last = gdk_pixbuf_get_pixels(made) + 4 * gdk_pixbuf_get_rowstride(made) + 2 * (alpha ? 4 : 3);
      last[0] = 200;
      last[1] = 100;
      last[2] = 50;
      const std::string name = folder_ / "made";
      ASSERT_TRUE(gdk_pixbuf_save(made, name.c_str(), type, nullptr, nullptr)) << type;
      g_object_unref(made);
      const cv::Mat picture = csd::load_picture(name);
      ASSERT_EQ(picture.type(), CV_8UC3) << type;
      ASSERT_EQ(picture.size(), cv::Size(3, 5)) << type;
      EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(0x30, 0x20, 0x10)) << type;
      EXPECT_EQ(picture.at<cv::Vec3b>(4, 2), cv::Vec3b(50, 100, 200)) << type;
    }
  }
}

TEST_F(SimTexture, LeavesOutAlpha) {
  GdkPixbuf *made = gdk_pixbuf_new(GDK_COLORSPACE_RGB, TRUE, 8, 2, 2);
  gdk_pixbuf_fill(made, 0x10203000);  // transparent
  const std::string name = folder_ / "made";
  ASSERT_TRUE(gdk_pixbuf_save(made, name.c_str(), "png", nullptr, nullptr));
  g_object_unref(made);
  EXPECT_EQ(csd::load_picture(name).at<cv::Vec3b>(1, 1), cv::Vec3b(0x30, 0x20, 0x10));
}

TEST_F(SimTexture, RefusesTooLargePicturesBeforeItDecodesThem) {
  EXPECT_SAYS(error_of(file(bmp_head(40000, 30000))), "is of 40000 × 30000 pixels");
  EXPECT_SAYS(error_of(file(bmp_head(8193, 16))), "is of 8193 × 16 pixels");
  EXPECT_SAYS(error_of(file("P6 16 8193 255\n")), "is of 16 × 8193 pixels");
  EXPECT_SAYS(error_of(file("P6 16 8192 255\n")), "it ends too soon");  // it only has no pixels
}

TEST_F(SimTexture, RefusesFilesWithoutAnEnd) {
  const std::string sparse = file("P6 16 16 255\n");
  std::filesystem::resize_file(sparse, (std::uintmax_t{1} << 30) + 1);
  EXPECT_SAYS(error_of(sparse), "is longer than 1 GiB");
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string &name : {pipe, folder_.string(), std::string("/dev/zero")})
    EXPECT_SAYS(error_of(name), "is not a file");
}

TEST_F(SimTexture, SaysWhatIsWrong) {
  EXPECT_SAYS(error_of(folder_ / "none"), "doesn't exist");
  for (const std::string content : {"#EXTM3U\n#EXTINF:9,\nhttp://127.0.0.1:9/a.ts\n", "RIFF\x10\0\0\0WAVEfmt "})
    EXPECT_SAYS(error_of(file(content)), "is not a picture");
  EXPECT_SAYS(error_of(file("")), "is not a picture");
  // Half of the pixels.
  EXPECT_SAYS(error_of(file(bmp_head(16, 16) + std::string(8 * 48, 'x'))), "it ends too soon");
  EXPECT_SAYS(error_of(file("P6 16 16 255\n" + std::string(8 * 48, 'x'))), "it ends too soon");
}

}  // namespace
