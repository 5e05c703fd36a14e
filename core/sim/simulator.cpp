// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/simulator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "content/specular.h"
#include "detect/detect.h"
#include "image/work_frame.h"
#include "sim/clock.h"
#include "sim/events.h"
#include "sim/lens.h"
#include "sim/sensor.h"
#include "sim/smoke_layer.h"
#include "sim/tissue.h"
#include "sim/tools.h"

namespace csd::sim {
namespace {

constexpr double picture_units = 1.25 * units_high;  // height of a user's texture
constexpr double hiding_smoke = 0.75;
constexpr double highlight_radius = 5;  // pixels at 480 lines
constexpr double last_moment = 1e9;     // seconds; the scene is still from then on: noise positions stay whole numbers
constexpr int widest = 16;              // maximum aspect ratio, wide or high: as for textures

void check_rate(double rate) {
  if (!(rate > 0) || !std::isfinite(rate)) throw std::invalid_argument("the simulator's rate must be above 0");
}

const SimSettings &checked(const SimSettings &s) {
  if (s.size.width < 16 || s.size.height < 16 || s.size.width > 8192 || s.size.height > 8192) {
    throw std::invalid_argument("the simulator's pictures are from 16×16 to 8192×8192");
  }
  if (s.size.width > widest * s.size.height || s.size.height > widest * s.size.width)
    throw std::invalid_argument("the simulator's pictures are at most 16 times as wide as high, or as high as wide");
  check_rate(s.rate);
  return s;
}

FrameView view_of(const cv::Mat &bgr) {
  FrameView v;
  v.width = bgr.cols;
  v.height = v.rows = bgr.rows;
  v.model = ColourModel::rgb;
  for (std::size_t i = 0; i < 3; ++i) {
    v.component[i] = {bgr.data + 2 - i, static_cast<std::ptrdiff_t>(bgr.step), 3, 1, 0, 0, 0};
  }
  return v;
}

/// The style of the scene after a cut: one of the first five, which look different from one another.
Style other_style(Style style) {
  const auto i = static_cast<std::size_t>(style);
  constexpr std::size_t unlike = static_cast<std::size_t>(Style::fat) + 1;
  return static_cast<Style>((i < unlike ? i + 2 : i + 1) % unlike);
}

/// Lines of the textures: 1.6 texels per pixel at 576 lines and below.
int texture_side(cv::Size size) {
#ifdef CSDTRACK_FUZZING
  if (size.height <= 32) return 256;  // else creating a scene takes seconds, and fuzzing creates a hundred thousand
#endif
  return size.height <= 576 ? 2048 : 4096;
}

}  // namespace

struct Simulator::Impl {
  explicit Impl(const SimSettings &s) : settings(checked(s)), sensor(s.effects, s.seed) {
    // The pattern loses three quarters of its contrast at strength 1.
    const double contrast = 1 / (1 + 3 * s.effects[Effect::low_texture]);
    const int side = texture_side(s.size);
    TextureMap map;
    if (s.texture.empty()) {
      map = tissue_texture(s.style, s.seed, side, contrast);
    } else {
      picture = texture_of_picture(s.texture, picture_units, side / 1280.0, gloss_of(s.style), contrast);
      map = std::move(picture.map);
    }
    tissue.emplace(s.effects, s.seed, std::move(map));
    if (s.effects[Effect::cut] > 0) {
      // The scene of a cut: another organ with its own motion.
      elsewhere.emplace(s.effects, s.seed + 1,
                        tissue_texture(other_style(s.style), s.seed + 1, std::max(side / 2, 256)));
    }
  }

  double time(std::uint64_t n) const {
    return std::min(begin + (static_cast<double>(n) - first) / settings.rate, last_moment);
  }
  double strength(Effect e) const { return settings.effects[e]; }
  bool dark(double t) const { return strength(Effect::black) > 0 && black_out(t, strength(Effect::black)).dark; }
  bool cut_away(double t) const { return elsewhere && is_cut(t); }

  Tools tools(double t) const {
    return Tools(t, strength(Effect::tools), settings.seed, settings.size, tissue->grip(t, settings.size));
  }

  void find(double t) {
    if (found_at == t) return;
    const double shutter = std::min(0.5 * strength(Effect::motion_blur), 1.0) / settings.rate;
    tissue->find(t, settings.size, shutter, fragments);
    found_at = t;
  }

  void expose(double t, std::uint64_t moment, cv::Mat &bgr);
  cv::Point2d surface_at(double t, cv::Point2d pixel) const;
  const Fragment *shown_at(cv::Point2d nearest) const;
  cv::Point2d newton(double t, cv::Point2d pixel, cv::Point2d uv, std::uint8_t sheet) const;
  bool hidden(double t, const Tools &tools, const SmokeLayer &smoke, const Lens &lens, cv::Point2d uv,
              cv::Point2d pixel) const;
  bool folded(double t, cv::Point2d uv, cv::Point2d pixel) const;
  bool behind_a_ring(double t, cv::Point2d uv, const Fragment &shown, cv::Point2d beside) const;
  bool blinded(const Camera &camera, cv::Point2d pixel) const;

  SimSettings settings;
  double first = 0, begin = 0;  // a frame's number and its time in seconds; the others follow at the rate
  Sensor sensor;
  std::optional<Tissue> tissue, elsewhere;
  PictureTexture picture;
  Fragments fragments;  // of the tissue, at found_at
  double found_at = std::numeric_limits<double>::quiet_NaN();
  Fragments other_fragments;
  Canvas canvas, copy;
  std::vector<float> scratch;
  cv::Mat second_field;
};

void Simulator::Impl::expose(double t, std::uint64_t moment, cv::Mat &bgr) {
  cv::Vec3d gain(0, 0, 0);
  if (dark(t)) {
    canvas.resize(settings.size);
    for (std::size_t c = 0; c < 3; ++c)
      for (int y = 0; y < settings.size.height; ++y) std::fill_n(canvas.row(c, y), settings.size.width, 0.0F);
  } else {
    const Camera camera = tissue->camera(t, settings.size);
    gain = Light(t, settings.effects, settings.seed, camera).gain();
    const double shutter = std::min(0.5 * strength(Effect::motion_blur), 1.0) / settings.rate;
    if (cut_away(t)) {
      elsewhere->find(t, settings.size, shutter, other_fragments);
      elsewhere->paint(t, other_fragments, canvas);
    } else {
      find(t);
      tissue->paint(t, fragments, canvas);
    }
    if (shutter > 0) blur_motion(cut_away(t) ? other_fragments : fragments, canvas, copy);
    if (!cut_away(t)) tools(t).draw(canvas);
    SmokeLayer(t, strength(Effect::smoke), settings.seed, settings.size).draw(canvas);
    Lens(t, settings.effects, settings.size).draw(canvas, scratch);
  }
  sensor.expose(canvas, gain, moment, bgr, scratch);
}

cv::Point2d Simulator::Impl::surface_at(double t, cv::Point2d pixel) const {
  const cv::Size size = settings.size;
  const auto off = [&](cv::Point2d uv) {  // error in pixels; infinite behind the camera
    const cv::Point3d at = tissue->project(t, size, uv);
    return at.z > 0 ? std::hypot(at.x - pixel.x, at.y - pixel.y) : std::numeric_limits<double>::infinity();
  };
  const cv::Point2d nearest(std::floor(pixel.x + 0.5), std::floor(pixel.y + 0.5));
  std::optional<cv::Point2d> found;
  if (const Fragment *f = shown_at(nearest)) {
    if ((*f)[Fragment::sheet] >= 0) {  // the bed in a wound has no surface points
      const cv::Point2d shown((*f)[Fragment::u], (*f)[Fragment::v]);
      const auto sheet = static_cast<std::uint8_t>((*f)[Fragment::sheet]);
      const cv::Point2d uv = newton(t, pixel, shown, sheet);
      // At the edge of a fold a pixel shows two places, and Newton's method may alternate between them.
      if (off(uv) < 1e-6) {
        found = uv;
      } else if (off(shown) < 1) {
        found = shown;
      }
    }
  } else {
    tissue->sheets().each([&](std::uint8_t sheet) {
      const cv::Point2d uv = newton(t, pixel, tissue->camera(t, size).to_plane(pixel), sheet);
      if (off(uv) < 1e-6 && (!found || tissue->project(t, size, uv).z < tissue->project(t, size, *found).z)) found = uv;
    });
  }
  if (found) return *found;
  std::ostringstream text;
  text.exceptions(std::ios::badbit);
  text << "the simulated surface has no point at the pixel " << pixel.x << "," << pixel.y;
  throw std::invalid_argument(text.str());
}

/// The fragment at a pixel; null outside the picture and in empty pixels.
const Fragment *Simulator::Impl::shown_at(cv::Point2d nearest) const {
  if (!nearest.inside(cv::Rect2d({}, cv::Size2d(settings.size)))) return nullptr;
  const Fragment &f = fragments.at(static_cast<int>(nearest.x), static_cast<int>(nearest.y));
  return f[Fragment::depth] < Fragments::nothing ? &f : nullptr;
}

/// Newton's method on the exact projection of a sheet.
cv::Point2d Simulator::Impl::newton(double t, cv::Point2d pixel, cv::Point2d uv, std::uint8_t sheet) const {
  const cv::Size size = settings.size;
  constexpr double step = 0.01;
  for (int i = 0; i < 30; ++i) {
    const cv::Point3d at = tissue->project(t, size, uv, sheet);
    const cv::Point2d error(pixel.x - at.x, pixel.y - at.y);
    if (error.dot(error) < 1e-22) break;
    const cv::Point3d du =
        tissue->project(t, size, {uv.x + step, uv.y}, sheet) - tissue->project(t, size, {uv.x - step, uv.y}, sheet);
    const cv::Point3d dv =
        tissue->project(t, size, {uv.x, uv.y + step}, sheet) - tissue->project(t, size, {uv.x, uv.y - step}, sheet);
    const double det = du.x * dv.y - dv.x * du.y;
    if (std::abs(det) < 1e-12) break;
    cv::Point2d move(2 * step * (dv.y * error.x - dv.x * error.y) / det,
                     2 * step * (du.x * error.y - du.y * error.x) / det);
    const double length = std::sqrt(move.dot(move));
    if (length > 20) move *= 20 / length;
    uv += move;
  }
  return uv;
}

/// Whether the fragment `beside` a point (pixels) shows another part of the surface. Parts hidden by rings are close to
/// the rings' edges in the picture, so only the surface's own slope tells them apart.
bool Simulator::Impl::behind_a_ring(double t, cv::Point2d uv, const Fragment &shown, cv::Point2d beside) const {
  constexpr double step = 0.01, max_distance = 1.5;  // pixels
  const auto at = [&](double u, double v) { return tissue->project(t, settings.size, {u, v}); };
  const cv::Point3d du = at(uv.x + step, uv.y) - at(uv.x - step, uv.y),
                    dv = at(uv.x, uv.y + step) - at(uv.x, uv.y - step);
  if (du.x * dv.y - dv.x * du.y <= 0) return true;  // seen from behind
  const double u = (shown[Fragment::u] - uv.x) / (2 * step), v = (shown[Fragment::v] - uv.y) / (2 * step);
  return std::hypot(u * du.x + v * dv.x - beside.x, u * du.y + v * dv.y - beside.y) > max_distance;
}

/// Whether the surrounding pixels show another part of the surface.
bool Simulator::Impl::folded(double t, cv::Point2d uv, cv::Point2d pixel) const {
  const cv::Size size = settings.size;
  const int x = static_cast<int>(std::floor(pixel.x + 0.5)), y = static_cast<int>(std::floor(pixel.y + 0.5));
  // At a cut, a pixel shows either sheet.
  const auto sheet = static_cast<float>(tissue->sheet_of(uv));
  const Fragment *shown = shown_at(cv::Point2d(x, y));
  if (tissue->sheets().any() && shown && (*shown)[Fragment::sheet] != sheet) return true;
  if (tissue->hollow() && shown) return behind_a_ring(t, uv, *shown, {x - pixel.x, y - pixel.y});
  float u0 = 1e9F, u1 = -1e9F, v0 = 1e9F, v1 = -1e9F;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, size.height - 1); ++j) {
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, size.width - 1); ++i) {
      const Fragment &f = fragments.at(i, j);
      if (f[Fragment::depth] >= Fragments::nothing || f[Fragment::sheet] != sheet) continue;
      u0 = std::min(u0, f[Fragment::u]);
      u1 = std::max(u1, f[Fragment::u]);
      v0 = std::min(v0, f[Fragment::v]);
      v1 = std::max(v1, f[Fragment::v]);
    }
  }
  const double slack = 1;  // unit
  return uv.x < u0 - slack || uv.x > u1 + slack || uv.y < v0 - slack || uv.y > v1 + slack;
}

bool Simulator::Impl::blinded(const Camera &camera, cv::Point2d pixel) const {
  if (strength(Effect::specular) <= 0) return false;
  const double radius = highlight_radius * settings.size.height / units_high;
  int blind = 0, seen = 0;
  for (int j = -2; j <= 2; ++j) {
    for (int i = -2; i <= 2; ++i) {
      if (i * i + j * j > 5) continue;
      const cv::Point at(static_cast<int>(std::floor(pixel.x + 0.5 * i * radius + 0.5)),
                         static_cast<int>(std::floor(pixel.y + 0.5 * j * radius + 0.5)));
      if (!at.inside({{}, settings.size})) continue;
      ++seen;
      if (tissue->blinded(camera, fragments, at) >= 0.5F) ++blind;
    }
  }
  return seen > 0 && 2 * blind >= seen;
}

bool Simulator::Impl::hidden(double t, const Tools &tools, const SmokeLayer &smoke, const Lens &lens, cv::Point2d uv,
                             cv::Point2d pixel) const {
  if (dark(t) || cut_away(t)) return true;
  if (strength(Effect::text) > 0 && cv::Rect2d(clock_box(settings.size)).contains(pixel + cv::Point2d(0.5, 0.5))) {
    return true;
  }
  if (sensor.stopped(pixel, settings.size) >= 0.5F || tools.cover(pixel) >= 0.5F || lens.lost(pixel) >= 0.5F)
    return true;
  if (smoke.density(pixel) >= hiding_smoke) return true;
  return tissue->drowned(t, uv) || folded(t, uv, pixel) || blinded(tissue->camera(t, settings.size), pixel);
}

Simulator::Simulator(const SimSettings &settings) : impl_(std::make_unique<Impl>(settings)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator &&) noexcept = default;
Simulator &Simulator::operator=(Simulator &&) noexcept = default;

const SimSettings &Simulator::settings() const {
  return impl_->settings;
}

void Simulator::retime(double rate, std::uint64_t first, double seconds) {
  check_rate(rate);
  impl_->settings.rate = rate;
  impl_->first = static_cast<double>(first);
  impl_->begin = seconds;
  impl_->found_at = std::numeric_limits<double>::quiet_NaN();  // the shutter's time depends on the rate
}

void Simulator::render(std::uint64_t n, cv::Mat &bgr) {
  const double t = impl_->time(n), interlaced = std::min(impl_->strength(Effect::interlacing), 1.0);
  if (interlaced > 0) impl_->expose(t + 0.5 * interlaced / impl_->settings.rate, 2 * n + 1, impl_->second_field);
  impl_->expose(t, 2 * n, bgr);
  if (interlaced > 0)
    for (int y = 1; y < bgr.rows; y += 2) impl_->second_field.row(y).copyTo(bgr.row(y));
  if (impl_->strength(Effect::text) > 0) draw_clock(t, bgr);
}

std::vector<cv::Point2d> Simulator::detect(std::size_t wanted) {
  cv::Mat picture;
  render(0, picture);
  WorkFrame frame;
  frame.load(view_of(picture));
  cv::Mat specular, forbidden(frame.size(), CV_8UC1, cv::Scalar(0));
  specular_mask(frame, {{}, frame.size()}, specular);
  const int patch = default_patch_size(frame.size().height), half = patch / 2;
  for (int y = 0; y < forbidden.rows; ++y) {
    for (int x = 0; x < forbidden.cols; ++x) {
      // Keeps patches away from the field stop and the text.
      for (const cv::Point corner : {cv::Point(-half, -half), {half, -half}, {-half, half}, {half, half}}) {
        const cv::Point2d at = frame.to_picture(cv::Point2d(x + corner.x, y + corner.y));
        const bool text = impl_->strength(Effect::text) > 0 && cv::Rect2d(clock_box(picture.size())).contains(at);
        if (text || impl_->sensor.stopped(at, picture.size()) > 0) forbidden.at<std::uint8_t>(y, x) = 255;
      }
    }
  }
  std::vector<cv::Point2d> pixels = csd::detect(frame.luma(), specular, forbidden, {patch, wanted});
  for (auto &p : pixels) p = frame.to_picture(p);
  return pixels;
}

std::vector<cv::Point2d> Simulator::on_surface(std::uint64_t n, std::span<const cv::Point2d> pixels) {
  const double t = impl_->time(n);
  impl_->find(t);
  std::vector<cv::Point2d> result;
  for (const auto &p : pixels) result.push_back(impl_->surface_at(t, p));
  return result;
}

cv::Point2d Simulator::of_texture(cv::Point2d pixel) const {
  if (impl_->settings.texture.empty()) throw std::logic_error("this simulation has no texture picture");
  return impl_->picture.on_surface(pixel);
}

std::vector<TruthPoint> Simulator::truth(std::uint64_t n, std::span<const cv::Point2d> surface) {
  const double t = impl_->time(n);
  const SimSettings &s = impl_->settings;
  const cv::Size size = s.size;
  if (!impl_->dark(t) && !impl_->cut_away(t)) impl_->find(t);
  const Tools tools = impl_->tools(t);
  const SmokeLayer smoke(t, s.effects[Effect::smoke], s.seed, size);
  const Lens lens(t, s.effects, size);
  std::vector<TruthPoint> result;
  for (const auto &uv : surface) {
    const cv::Point3d at = impl_->tissue->project(t, size, uv);
    TruthPoint p{static_cast<FeatureId>(result.size()), at.x, at.y, Visibility::visible};
    if (!(at.z > 0 && at.x >= -0.5 && at.x < size.width - 0.5 && at.y >= -0.5 && at.y < size.height - 0.5)) {
      p.visibility = Visibility::out;
    } else if (impl_->hidden(t, tools, smoke, lens, uv, {at.x, at.y})) {
      p.visibility = Visibility::hidden;
    }
    result.push_back(p);
  }
  return result;
}

}  // namespace csd::sim
