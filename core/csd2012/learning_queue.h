// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>

#include "track/executor.h"

namespace csd {

/// Jobs of many features on one executor: those of one feature run one after the other in the order they were posted,
/// those of different features side by side and by turns. An exception in a job is kept for rethrow().
class LearningQueue {
 public:
  /// The jobs of one feature. Belongs to whoever made it; when it is destroyed, its jobs that have not begun are
  /// dropped (one that runs goes on to its end: it must own what it uses).
  class Lane {
   public:
    Lane() = default;
    ~Lane();
    Lane(Lane &&) noexcept = default;
    Lane &operator=(Lane &&) noexcept = default;
    std::size_t waiting() const;  ///< posted and not yet finished

   private:
    friend class LearningQueue;
    struct State;
    explicit Lane(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
  };

  explicit LearningQueue(Executor &executor);
  ~LearningQueue();  ///< waits for the job that runs on each lane; all lanes must be gone

  Lane make_lane();
  void post(Lane &lane, std::function<void()> job);
  void wait_idle();                    ///< until every job posted has run
  void rethrow();                      ///< throws the first exception of a job since the last call, if any
  std::size_t waiting() const;         ///< jobs posted and not finished, of all lanes
  std::int64_t time_spent_ns() const;  ///< inside jobs, all threads together

 private:
  struct Shared;
  static void book(const std::shared_ptr<Shared> &shared, const std::shared_ptr<Lane::State> &lane);
  static void take_turn(const std::shared_ptr<Shared> &shared, const std::shared_ptr<Lane::State> &lane);
  std::shared_ptr<Shared> shared_;
};

}  // namespace csd
