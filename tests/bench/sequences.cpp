// SPDX-License-Identifier: LGPL-2.1-or-later
#include "bench/sequences.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>

#include "content/dark_border.h"

namespace csd::bench {
namespace {

namespace fs = std::filesystem;
using S = sim::Scenario;
using T = sim::Style;
const Sequence sequences[] = {
    {"deformation-heart", S::deformation, "", T::heart},
    {"deformation-liver", S::deformation, "", T::liver},
    {"low-texture", S::low_texture, "", T::liver},
    {"tools-liver", S::occlusion, "", T::liver},
    {"tools-heart", S::occlusion, "", T::heart},
    {"irrigation", S::occlusion, "tools=0.7,heart-mild=0,liver=0.7,blood=1,irrigation=1", T::liver},
    {"zoom-heart", S::zoom, "", T::heart},
    {"zoom-peritoneum", S::zoom, "", T::peritoneum},
    {"rotation", S::rotation, "", T::peritoneum},
    {"smoke", S::smoke, "", T::bowel},
    {"specular-fat", S::specular, "", T::fat},
    {"specular-heart", S::specular, "", T::heart},
    {"mixed-heart", S::mixed, "", T::heart},
    {"mixed-bowel", S::mixed, "", T::bowel},
    {"cut", S::cut, "", T::bowel},
    {"wipe", S::deformation, "wipe=1", T::heart},
    {"black", S::rotation, "black=1,zoom=0.5", T::heart},
    {"picture-light", S::deformation, "heart-mild=0,heart-strong=1,light=1", T::heart, "heart.mkv"},
    {"picture-tools", S::occlusion, "specular=1,light=1,sway=1", T::heart, "abdomen.mkv"},
    {"picture-zoom", S::zoom, "specular=1", T::heart, "cutting.mp4"},
    {"picture-rotation", S::rotation, "smoke=1", T::heart, "cholecystectomy.mp4"},
};
// For each picture of real tissue.
const Sequence kinds[] = {
    {"beat", S::deformation, "heart-mild=0,heart-strong=1,light=1", T::heart},
    {"turn", S::rotation, "smoke=1", T::heart},
    {"zoom", S::zoom, "specular=1", T::heart},
    {"tools", S::occlusion, "specular=1,light=1,sway=1", T::heart},
    {"grasp", S::deformation, "grasp=1.5,heart-mild=0.5,liver=0.5,specular=0.6,motion-blur=0.5", T::heart},
    {"slide", S::deformation, "slide=1.3,heart-mild=0.7,sway=0.5,specular=0.6", T::heart},
    {"tear", S::deformation, "tear=1.3,heart-mild=0.7,liver=0.5,specular=0.6", T::heart},
    {"cavity", S::deformation, "cavity=1,liver=0.4,sway=0.5,specular=0.7,motion-blur=0.5", T::heart},
};

/// Crops the dark border: removes a row or column from the side with the most border until none is left.
cv::Mat without_border(const cv::Mat &picture) {
  cv::Mat luma;
  cv::cvtColor(picture, luma, cv::COLOR_BGR2GRAY);
  DarkBorder border;
  border.update(luma, 0);
  cv::Mat mask;
  cv::resize(border.mask(), mask, luma.size(), 0, 0, cv::INTER_NEAREST);
  cv::Rect inside({0, 0}, luma.size());
  const auto share = [&mask](const cv::Rect &line) {
    return static_cast<double>(cv::countNonZero(mask(line))) / line.area();
  };
  while (inside.area() > 0) {
    const auto &r = inside;
    const double sides[] = {share({r.x, r.y, r.width, 1}), share({r.x, r.y + r.height - 1, r.width, 1}),
                            share({r.x, r.y, 1, r.height}), share({r.x + r.width - 1, r.y, 1, r.height})};
    const auto worst = std::max_element(std::begin(sides), std::end(sides)) - std::begin(sides);
    if (sides[worst] == 0) break;
    if (worst < 2) --inside.height, inside.y += worst == 0;
    if (worst >= 2) --inside.width, inside.x += worst == 2;
  }
  return picture(inside).clone();
}

/// A picture's or video's first frame without its dark border.
cv::Mat first_frame(const std::string &video) {
  cv::Mat frame;
  cv::VideoCapture(video).read(frame);
  if (!frame.empty()) frame = without_border(frame);
  if (frame.empty()) throw std::runtime_error("no picture in " + video);
  return frame;
}

/// Passes the file's pictures through H.264.
void compress(const std::string &file) {
  const std::string raw = "-f rawvideo -pix_fmt yuv420p -s 640x480 -r 25 ", plain = file + ".plain";
  fs::rename(file, plain);
  const auto command = "ffmpeg -v error " + raw + "-i '" + plain +
                       "' -c:v libx264 -crf 23 -f h264 - | ffmpeg -v error -f h264 " + "-i - " + raw + "'" + file + "'";
  if (std::system(command.c_str()) != 0 || fs::file_size(file) != fs::file_size(plain))
    throw std::runtime_error("failed: " + command);
  fs::remove(plain);
}

}  // namespace

std::vector<Sequence> known_sequences(const std::string &clips) {
  std::vector<Sequence> out(std::begin(sequences), std::end(sequences));
  if (clips.empty()) std::erase_if(out, [](const Sequence &s) { return !s.clip.empty(); });
  for (auto &sequence : out)
    if (!sequence.clip.empty()) sequence.clip = (fs::path(clips) / sequence.clip).string();
  return out;
}

std::vector<Sequence> on_tissue(const std::vector<std::string> &folders) {
  std::vector<fs::path> pictures;
  for (const auto &folder : folders)
    for (const auto &entry : fs::directory_iterator(folder)) {
      const auto extension = entry.path().extension();
      for (const char *known : {".png", ".jpg", ".mkv", ".mp4"})
        if (extension == known) pictures.push_back(fs::absolute(entry.path()));
    }
  if (pictures.empty()) throw std::runtime_error("no picture in the folders of --tissue");
  std::sort(pictures.begin(), pictures.end(), [](const auto &a, const auto &b) { return a.stem() < b.stem(); });
  const auto same_stem = [&](const fs::path &picture) {
    return std::count_if(pictures.begin(), pictures.end(), [&](const auto &p) { return p.stem() == picture.stem(); });
  };
  std::vector<Sequence> out;
  for (const auto &kind : kinds)
    for (const auto &picture : pictures) {
      out.push_back(kind);
      out.back().name += '/' + (same_stem(picture) > 1 ? picture.filename() : picture.stem()).string();
      out.back().clip = picture.string();
    }
  return out;
}

Rendered render(const Sequence &sequence, std::uint64_t seed, std::uint64_t frames, std::size_t features,
                const std::string &folder) {
  Rendered out;
  auto file_name = sequence.name;
  std::replace(file_name.begin(), file_name.end(), '/', '-');
  const std::string stem = (fs::path(folder) / (file_name + '-' + std::to_string(seed) + '-' + std::to_string(frames) +
                                                '-' + std::to_string(features)))
                               .string();
  out.file = stem + ".i420";
  if (std::ifstream in(stem + ".truth", std::ios::binary); in) {
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < frames; ++i) {
      in.read(reinterpret_cast<char *>(&n), sizeof n);
      std::vector<sim::TruthPoint> points(n);
      in.read(reinterpret_cast<char *>(points.data()), static_cast<std::streamsize>(n * sizeof(sim::TruthPoint)));
      out.truth.push_back(std::move(points));
    }
    if (in) return out;
    out.truth.clear();
  }
  sim::SimSettings settings;
  settings.effects = sim::scenario_effects(sequence.scenario);
  settings.effects.set(sequence.effects);
  settings.seed = seed;
  settings.style = sequence.style;
  settings.size = picture_size;
  if (!sequence.clip.empty()) settings.texture = first_frame(sequence.clip);
  sim::Simulator simulator(settings);
  const auto surface = simulator.on_surface(0, simulator.detect(features));
  std::ofstream pictures(out.file, std::ios::binary), truth(stem + ".truth.part", std::ios::binary);
  cv::Mat bgr, i420;
  for (std::uint64_t i = 0; i < frames; ++i) {
    simulator.render(i, bgr);
    cv::cvtColor(bgr, i420, cv::COLOR_BGR2YUV_I420);
    pictures.write(reinterpret_cast<const char *>(i420.data), frame_bytes);
    out.truth.push_back(simulator.truth(i, surface));
    const std::uint64_t n = out.truth.back().size();
    truth.write(reinterpret_cast<const char *>(&n), sizeof n);
    truth.write(reinterpret_cast<const char *>(out.truth.back().data()),
                static_cast<std::streamsize>(n * sizeof(sim::TruthPoint)));
  }
  truth.close();
  pictures.close();
  if (!pictures || !truth) throw std::runtime_error("cannot write " + stem + ".*");
  if (!sequence.clip.empty()) compress(out.file);
  fs::rename(stem + ".truth.part", stem + ".truth");
  return out;
}

}  // namespace csd::bench
