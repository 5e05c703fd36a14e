// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "programs/text_file.h"
#include "score/types.h"

namespace csd::programs {

/// The state of a labelling session, without any window: the user chooses points in frame 0, then labels each of them
/// in every n-th frame.
class LabelSession {
 public:
  enum class Sight : std::uint8_t { hidden = 0, visible = 1, uncertain = 2 };  ///< as in the CSV
  struct Label {
    std::uint64_t frame;
    FeatureId id;
    Sight sight;
    cv::Point2d position;  ///< pixels, centres at integers; only if visible
  };

  /// @param every n, at least 1
  explicit LabelSession(unsigned every) : every_(every) {}

  /// Resumes from a file written by csv(). Asks again for a torn last line. Throws score::InputError if these are not
  /// labels of such a session.
  static LabelSession resume(const TextFile &saved, unsigned every);

  bool choosing() const { return chosen_ == 0; }  ///< frame 0: each click adds a point
  std::uint64_t frame() const;                    ///< the current frame
  FeatureId point() const;                        ///< the point to label; while choosing, the next new one
  std::size_t points() const { return choosing() ? labels_.size() : chosen_; }

  void place(cv::Point2d position);
  /// Labels the point as hidden, outside or uncertain. Not while choosing.
  void skip(Sight sight);
  /// Ends choosing; returns false without a point.
  bool done_choosing();
  /// Undoes the last answer, even across frames and the end of choosing; returns false if there is none.
  bool undo();

  std::span<const Label> labels() const { return labels_; }
  /// The last position at which a point was visible; initially its label in frame 0.
  const Label &last_seen(FeatureId point) const;
  /// frame,id,x,y,visible: what csd-score reads.
  std::string csv() const;

 private:
  unsigned every_;
  std::size_t chosen_ = 0;  ///< points; 0 while they are being chosen
  std::vector<Label> labels_;
};

}  // namespace csd::programs
