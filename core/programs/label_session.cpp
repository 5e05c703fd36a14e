// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/label_session.h"

#include <algorithm>
#include <cassert>

#include "programs/decimal.h"
#include "programs/read_csv.h"

namespace csd::programs {

LabelSession LabelSession::resume(const TextFile &saved, unsigned every) {
  LabelSession session(every);
  std::vector<std::string> torn;
  for (const LabelRow &row : read_label_rows(saved, torn)) {
    if (session.choosing() && row.frame != 0) session.done_choosing();
    if (row.frame != session.frame() || row.id != session.point() || (session.choosing() && row.sight != '1'))
      throw score::InputError(saved.name, row.line,
                              "is not what labelling every " + std::to_string(every) + " frames wrote: feature " +
                                  std::to_string(session.point()) + " of frame " + std::to_string(session.frame()) +
                                  " comes here");
    if (row.sight == '1')
      session.place(row.position);
    else
      session.skip(row.sight == '0' ? Sight::hidden : Sight::uncertain);
  }
  return session;
}

std::uint64_t LabelSession::frame() const {
  return choosing() ? 0 : labels_.size() / chosen_ * every_;
}

FeatureId LabelSession::point() const {
  return static_cast<FeatureId>(choosing() ? labels_.size() : labels_.size() % chosen_);
}

void LabelSession::place(cv::Point2d position) {
  labels_.push_back({frame(), point(), Sight::visible, position});
}

void LabelSession::skip(Sight sight) {
  assert(!choosing());
  labels_.push_back({frame(), point(), sight, {}});
}

bool LabelSession::done_choosing() {
  if (!choosing() || labels_.empty()) return false;
  chosen_ = labels_.size();
  return true;
}

bool LabelSession::undo() {
  if (!choosing() && labels_.size() == chosen_) {
    chosen_ = 0;
    return true;
  }
  if (labels_.empty()) return false;
  labels_.pop_back();
  return true;
}

const LabelSession::Label &LabelSession::last_seen(FeatureId point) const {
  return *std::find_if(labels_.rbegin(), labels_.rend(),
                       [point](const Label &label) { return label.id == point && label.sight == Sight::visible; });
}

std::string LabelSession::csv() const {
  std::string text = "frame,id,x,y,visible\n";
  for (const Label &label : labels_) {
    const bool seen = label.sight == Sight::visible;
    text += std::to_string(label.frame) + "," + std::to_string(label.id) + "," +
            (seen ? decimal(label.position.x, 3, "") : "") + "," + (seen ? decimal(label.position.y, 3, "") : "") +
            "," + std::to_string(static_cast<int>(label.sight)) + "\n";
  }
  return text;
}

}  // namespace csd::programs
