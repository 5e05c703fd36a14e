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

/// Jobs of many features on one executor. Those of one feature run in the order they were posted; those of different
/// features run in parallel and take turns. An exception of a job is kept for rethrow().
class LearningQueue {
 public:
  /// The jobs of one feature, owned by the caller of make_lane(). Its destructor drops the jobs that have not begun. A
  /// running job finishes, so it must own what it uses.
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
  ~LearningQueue();  ///< waits for the running jobs; all lanes must have been destroyed

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
