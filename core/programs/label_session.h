// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "programs/text_file.h"
#include "score/types.h"

namespace csd::programs {

/// What somebody who labels a video has said so far, without any window: points are chosen in frame 0, then asked for,
/// one after the other, in every n-th frame.
class LabelSession {
 public:
  enum class Sight : std::uint8_t { hidden = 0, visible = 1, uncertain = 2 };  ///< the CSV's numbers
  struct Label {
    std::uint64_t frame;
    FeatureId id;
    Sight sight;
    cv::Point2d position;  ///< pixels, centres at integers; of the visible
  };

  /// @param every n, at least 1
  explicit LabelSession(unsigned every) : every_(every) {}

  /// Goes on where csv() was written. A torn last line is asked for again. Throws score::InputError if these are not
  /// labels of such a session.
  static LabelSession resume(const TextFile &saved, unsigned every);

  bool choosing() const { return chosen_ == 0; }  ///< in frame 0: each click is a new point
  std::uint64_t frame() const;                    ///< the frame that is asked about
  FeatureId point() const;                        ///< the point that is asked for; when choosing, the next to be chosen
  std::size_t points() const { return choosing() ? labels_.size() : chosen_; }

  void place(cv::Point2d position);
  /// The point asked for is hidden, outside, or can't be told. Not when choosing.
  void skip(Sight sight);
  /// Ends the choosing; false if there is no point yet.
  bool done_choosing();
  /// Takes the last answer back, also across frames and the end of the choosing; false if there is none.
  bool undo();

  std::span<const Label> labels() const { return labels_; }
  /// Where a point was seen last; the label of frame 0 to begin with.
  const Label &last_seen(FeatureId point) const;
  /// frame,id,x,y,visible: what csd-score reads.
  std::string csv() const;

 private:
  unsigned every_;
  std::size_t chosen_ = 0;  ///< points; 0 while they are being chosen
  std::vector<Label> labels_;
};

}  // namespace csd::programs
