// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/motion_report.h"

#include <algorithm>
#include <array>

#include "programs/decimal.h"
#include "programs/json_writer.h"
#include "programs/table.h"
#include "score/quantile.h"

namespace csd::programs {
namespace {

using motion::Motion;
using motion::Path;
using motion::Rhythm;

constexpr std::size_t piece = 1 << 16;

/// A feature's motion over the whole recording.
struct Summary {
  double claimed = 0;                        // s
  cv::Point2d rest = motion::unknown_point;  // px
  double farthest = 0;                       // px from the start
  double speed = score::unknown;             // px/s, the median
};

Summary summary_of(const motion::Series &series, const Path &path) {
  Summary summary;
  std::vector<double> x, y, speeds;
  for (const cv::Point2d &p : path.positions) {
    x.push_back(p.x);
    y.push_back(p.y);
    summary.farthest = std::max(summary.farthest, std::hypot(p.x - path.start().x, p.y - path.start().y));
  }
  for (const cv::Point2d &v : motion::velocities(series, path))
    if (motion::known(v)) speeds.push_back(std::hypot(v.x, v.y));
  summary.claimed = static_cast<double>(x.size()) * series.interval;
  summary.rest = {score::quantile(std::move(x), 0.5), score::quantile(std::move(y), 0.5)};
  summary.speed = score::quantile(std::move(speeds), 0.5);
  return summary;
}

/// 3.2e-16, 0.004: few characters for any magnitude.
std::string probability(double p) {
  if (p == 0 || p >= 0.001) return decimal(p, p == 0 ? 0 : 3, "");
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, p, std::chars_format::scientific, 1).ptr};
}

std::string harmonics_of(const Rhythm &rhythm) {
  std::string text;
  for (const motion::Harmonic &harmonic : rhythm.harmonics)
    text += (text.empty() ? "" : ";") + std::to_string(harmonic.multiple) + ":" + decimal(harmonic.amplitude, 3, "");
  return text;
}

std::string or_dash(const std::string &text) {
  return text.empty() ? "—" : text;
}

std::vector<std::string> rate_cells(const Rhythm &rhythm) {
  return {or_dash(std::string(motion::usual_name(rhythm.frequency))), decimal(60 * rhythm.frequency, 2, ""),
          decimal(rhythm.frequency, 4, ""), decimal(rhythm.period(), 3, "")};
}

void add(JsonWriter &out, const Rhythm &rhythm) {
  out.key("usual_name").text(std::string(motion::usual_name(rhythm.frequency)));
  out.key("frequency").value(rhythm.frequency).key("per_minute").value(60 * rhythm.frequency);
  out.key("period").value(rhythm.period()).key("amplitude").value(rhythm.amplitude);
  out.key("amplitude_low").value(rhythm.amplitude_low).key("amplitude_high").value(rhythm.amplitude_high);
  out.key("direction").value(rhythm.direction).key("explained").value(rhythm.explained);
  out.key("false_alarm").value(rhythm.false_alarm).key("harmonics").begin_array();
  for (const motion::Harmonic &harmonic : rhythm.harmonics) {
    out.begin_object().key("multiple").whole(harmonic.multiple).key("frequency").value(harmonic.frequency);
    out.key("amplitude").value(harmonic.amplitude).end_object();
  }
  out.end_array().key("rates").begin_array();
  for (const motion::Rate &rate : rhythm.rates)
    out.begin_object().key("time").value(rate.time).key("frequency").value(rate.frequency).end_object();
  out.end_array();
}

/// Collects small pieces.
class Buffer {
 public:
  explicit Buffer(const Sink &write) : write_(write) { text_.reserve(2 * piece); }
  Buffer &operator<<(std::string_view text) {
    text_ += text;
    if (text_.size() >= piece) flush();
    return *this;
  }
  void flush() {
    write_(text_);
    text_.clear();
  }

 private:
  const Sink &write_;
  std::string text_;
};

template <typename Values, typename Text>
void add_array(Buffer &out, std::string_view key, const Values &values, Text text) {
  out << ",\"" << key << "\":[";
  for (std::size_t i = 0; i < values.size(); ++i) out << (i ? "," : "") << text(values[i]);
  out << "]";
}

/// Adds points as two arrays, x and y.
void add_points(Buffer &out, const char *x, const char *y, const std::vector<cv::Point2d> &points, cv::Point2d origin) {
  add_array(out, x, points, [&](const cv::Point2d &p) { return decimal(p.x - origin.x, 3, "null"); });
  add_array(out, y, points, [&](const cv::Point2d &p) { return decimal(p.y - origin.y, 3, "null"); });
}

void write_series_json(const Motion &motion, Buffer &out) {
  const auto count = [](std::uint64_t n) { return std::to_string(n); };
  out << "{\"scene\":{\"feature\":null";
  add_points(out, "dx", "dy", motion.scene.displacement, {0, 0});
  add_points(out, "vx", "vy", motion.scene.velocity, {0, 0});
  add_array(out, "features", motion.scene.features, count);
  out << "}";
  add_array(out, "times", motion.series.times, [](double time) { return decimal(time, 6, "null"); });
  add_array(out, "frames", motion.series.frames, count);
  out << ",\"features\":[";
  bool first = true;
  for (const Path &path : motion.series.paths) {
    // Dense, from its first frame to its last: null where it has no claim.
    const auto velocity = motion::velocities(motion.series, path);
    const std::size_t begin = path.frames.front(), end = path.frames.back() + 1;
    std::vector<cv::Point2d> positions(end - begin, motion::unknown_point), speeds = positions;
    for (std::size_t i = 0; i < path.frames.size(); ++i) {
      positions[path.frames[i] - begin] = path.positions[i];
      speeds[path.frames[i] - begin] = velocity[i];
    }
    out << (first ? "\n" : ",\n") << "{\"id\":" << std::to_string(path.id) << ",\"first\":" << count(begin);
    add_points(out, "dx", "dy", positions, path.start());
    add_points(out, "vx", "vy", speeds, {0, 0});
    out << "}";
    first = false;
  }
  out << "]}";
}

}  // namespace

std::string left_out(const motion::Series &series) {
  return std::to_string(series.left_out) + (series.left_out == 1 ? " frame is" : " frames are") +
         " left out, as the picture's size changes to " + std::to_string(series.other_width) + "x" +
         std::to_string(series.other_height);
}

std::string as_text(const MotionReport &report) {
  const Motion &motion = report.motion;
  const motion::Series &series = motion.series;
  std::string text = report.tracks + ": " + std::to_string(series.paths.size()) + " features, " +
                     std::to_string(series.times.size()) + " frames, " + decimal(series.times.front(), 3, "") + " to " +
                     decimal(series.times.back(), 3, "") + " s" + (series.left_out ? "; " + left_out(series) : "") +
                     "\n\n";
  Table scene{"Rhythms of the scene",
              {{"usually", "/min", "Hz", "period s", "amplitude px", "quartiles", "explained", "false alarm",
                "features", "harmonics"}}};
  for (const motion::SceneRhythm &one : motion.scene_rhythms) {
    auto row = rate_cells(one.rhythm);
    row.insert(row.end(),
               {decimal(one.rhythm.amplitude, 3, "—"),
                decimal(one.rhythm.amplitude_low, 3, "—") + "–" + decimal(one.rhythm.amplitude_high, 3, "—"),
                decimal(one.rhythm.explained, 3, "—"), probability(one.rhythm.false_alarm),
                std::to_string(one.agreeing) + " of " + std::to_string(one.judged), or_dash(harmonics_of(one.rhythm))});
    scene.rows.push_back(std::move(row));
  }
  text += motion.scene_rhythms.empty()
              ? "No rhythm of the scene stands out from noise: --false-alarm 1 lists what is highest all the same\n"
              : as_text(scene);
  Table features{"Features",
                 {{"feature", "usually", "/min", "Hz", "period s", "amplitude px", "direction °", "explained",
                   "false alarm", "harmonics", "claimed s", "farthest px", "speed px/s"}}};
  for (std::size_t i = 0; i < series.paths.size(); ++i) {
    const Summary summary = summary_of(series, series.paths[i]);
    const std::vector<std::string> whole = {decimal(summary.claimed, 1, "—"), decimal(summary.farthest, 2, "—"),
                                            decimal(summary.speed, 2, "—")};
    const auto add_row = [&](const std::vector<std::string> &cells) {
      features.rows.push_back({std::to_string(series.paths[i].id)});
      for (const auto *const part : {&cells, &whole})
        features.rows.back().insert(features.rows.back().end(), part->begin(), part->end());
    };
    for (const Rhythm &rhythm : motion.rhythms[i].rhythms) {
      auto row = rate_cells(rhythm);
      row.insert(row.end(),
                 {decimal(rhythm.amplitude, 3, "—"), decimal(rhythm.direction, 0, "—"),
                  decimal(rhythm.explained, 3, "—"), probability(rhythm.false_alarm), or_dash(harmonics_of(rhythm))});
      add_row(row);
    }
    if (motion.rhythms[i].rhythms.empty()) add_row(std::vector<std::string>(9, "—"));
  }
  return text + "\n" + as_text(features);
}

std::string as_csv(const MotionReport &report) {
  std::string text =
      "feature,usual_name,frequency_hz,per_minute,period_s,amplitude_px,amplitude_low_px,amplitude_high_px,"
      "direction_deg,explained,false_alarm,harmonics,agreeing,judged\n";
  const auto row = [&](const std::string &feature, const Rhythm &rhythm, const std::string &features) {
    text += feature + "," + std::string(motion::usual_name(rhythm.frequency)) + "," + decimal(rhythm.frequency, 6, "") +
            "," + decimal(60 * rhythm.frequency, 4, "") + "," + decimal(rhythm.period(), 6, "") + "," +
            decimal(rhythm.amplitude, 4, "") + "," + decimal(rhythm.amplitude_low, 4, "") + "," +
            decimal(rhythm.amplitude_high, 4, "") + "," + decimal(rhythm.direction, 2, "") + "," +
            decimal(rhythm.explained, 6, "") + "," + probability(rhythm.false_alarm) + "," + harmonics_of(rhythm) +
            "," + features + "\n";
  };
  for (const motion::SceneRhythm &one : report.motion.scene_rhythms)
    row("", one.rhythm, std::to_string(one.agreeing) + "," + std::to_string(one.judged));
  for (std::size_t i = 0; i < report.motion.series.paths.size(); ++i)
    for (const Rhythm &rhythm : report.motion.rhythms[i].rhythms)
      row(std::to_string(report.motion.series.paths[i].id), rhythm, ",");
  return text;
}

void write_series_csv(const MotionReport &report, const Sink &write) {
  const motion::Series &series = report.motion.series;
  const motion::SceneMotion &scene = report.motion.scene;
  std::vector<std::vector<cv::Point2d>> velocity;
  velocity.reserve(series.paths.size());
  for (const Path &path : series.paths) velocity.push_back(motion::velocities(series, path));
  const auto pair = [](const cv::Point2d &p) { return "," + decimal(p.x, 3, "") + "," + decimal(p.y, 3, ""); };
  const motion::ClaimsByFrame claims(series);
  Buffer out(write);
  out << "time_s,frame,feature,x_px,y_px,dx_px,dy_px,vx_px_s,vy_px_s,features\n";
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    const std::string moment = decimal(series.times[i], 6, "") + "," + std::to_string(series.frames[i]) + ",";
    out << moment << ",," << pair(scene.displacement[i]) << pair(scene.velocity[i]) << ","
        << std::to_string(scene.features[i]) << "\n";
    for (const motion::Claim &claim : claims.at(i)) {
      const Path &path = series.paths[claim.path];
      const cv::Point2d now = path.positions[claim.place];
      out << moment << std::to_string(path.id) << pair(now) << pair(now - path.start())
          << pair(velocity[claim.path][claim.place]) << ",\n";
    }
  }
  out.flush();
}

void write_json(const MotionReport &report, bool with_series, const Sink &write) {
  const Motion &motion = report.motion;
  const motion::Series &series = motion.series;
  JsonWriter out;
  out.begin_object().key("schema").whole(1).key("tracks").text(report.tracks);
  out.key("frames").whole(series.times.size()).key("from").value(series.times.front());
  out.key("to").value(series.times.back()).key("interval").value(series.interval).key("window").value(report.window);
  out.key("scene").begin_object().key("rhythms").begin_array();
  for (const motion::SceneRhythm &one : motion.scene_rhythms) {
    out.begin_object();
    add(out, one.rhythm);
    out.key("agreeing").whole(one.agreeing).key("judged").whole(one.judged).end_object();
  }
  out.end_array().end_object().key("features").begin_array();
  for (std::size_t i = 0; i < series.paths.size(); ++i) {
    const Path &path = series.paths[i];
    const Summary summary = summary_of(series, path);
    out.begin_object().key("id").whole(path.id);
    out.key("from").value(series.times[path.frames.front()]).key("to").value(series.times[path.frames.back()]);
    out.key("claimed").value(summary.claimed);
    out.key("start").values(std::array<double, 2>{path.start().x, path.start().y});
    out.key("rest").values(std::array<double, 2>{summary.rest.x, summary.rest.y});
    out.key("farthest").value(summary.farthest).key("speed").value(summary.speed);
    out.key("windows").whole(motion.rhythms[i].windows).key("rhythms").begin_array();
    for (const Rhythm &rhythm : motion.rhythms[i].rhythms) {
      out.begin_object();
      add(out, rhythm);
      out.end_object();
    }
    out.end_array().end_object();
  }
  out.end_array().key("notes").begin_array();
  for (const std::string &note : report.notes) out.text(note);
  out.end_array().end_object();
  std::string text = out.finish();
  if (!with_series) return write(text);
  // The series is as large as the recording is long, so it is written piece by piece, as the last member of the object.
  text.resize(text.rfind('}'));
  while (text.back() == '\n' || text.back() == ' ') text.pop_back();
  write(text + ",\n \"series\": ");
  Buffer rest(write);
  write_series_json(motion, rest);
  rest << "\n}\n";
  rest.flush();
}

}  // namespace csd::programs
