// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learning_queue.h"

#include <gtest/gtest.h>

#include <future>
#include <new>
#include <stdexcept>
#include <thread>

#include "track/thread_pool.h"

namespace csd {
namespace {

/// Keeps jobs until run_one() is called, so that the test decides when a "thread" works. Can also refuse jobs, like a
/// pool without memory for them.
class ManualExecutor final : public Executor {
 public:
  void post(std::function<void()> job) override {
    if (refuses) throw std::bad_alloc();
    jobs.push_back(std::move(job));
  }
  void run_one() {
    auto job = std::move(jobs.front());
    jobs.pop_front();
    job();
  }
  std::deque<std::function<void()>> jobs;
  bool refuses = false;
};

TEST(LearningQueue, KeepsTheOrderWithinALaneAndAlternatesBetweenLanes) {
  ManualExecutor executor;
  LearningQueue queue(executor);
  auto a = queue.make_lane(), b = queue.make_lane();
  std::string order;
  // A job posted in a lane's turn waits for its next turn.
  queue.post(a, [&] { queue.post(a, [&order] { order += "a4"; }); });
  for (const char c : {'1', '2', '3'}) queue.post(a, [&order, c] { order += {'a', c}; });
  for (const char c : {'1', '2'}) queue.post(b, [&order, c] { order += {'b', c}; });
  EXPECT_EQ(queue.waiting(), 6u);
  while (!executor.jobs.empty()) executor.run_one();
  EXPECT_EQ(order, "a1a2a3b1b2a4");
  EXPECT_EQ(queue.waiting(), 0u);
}

TEST(LearningQueue, ADestroyedLaneDropsItsJobs) {
  ManualExecutor executor;
  LearningQueue queue(executor);
  int ran = 0;
  {
    auto lane = queue.make_lane();
    queue.post(lane, [&] {
      ++ran;
      queue.post(lane, [&ran] { ++ran; });
    });
    executor.run_one();
    EXPECT_EQ(lane.waiting(), 2u);  // one job, and the turn booked for it
  }
  EXPECT_EQ(queue.waiting(), 0u);
  while (!executor.jobs.empty()) executor.run_one();
  EXPECT_EQ(ran, 1);
}

TEST(LearningQueue, AnExceptionReachesTheOwnerOnceAndStopsNothing) {
  ThreadPool pool(1);
  LearningQueue queue(pool);
  auto lane = queue.make_lane();
  bool ran = false;
  queue.post(lane, [] { throw std::runtime_error("planted"); });
  queue.post(lane, [&ran] { ran = true; });
  queue.wait_idle();
  EXPECT_TRUE(ran);
  EXPECT_THROW(queue.rethrow(), std::runtime_error);
  EXPECT_NO_THROW(queue.rethrow());
}

TEST(LearningQueue, ARefusingExecutorDropsTheLanesJobsAndNobodyWaitsForThem) {
  ManualExecutor executor;
  LearningQueue queue(executor);
  auto lane = queue.make_lane();
  int ran = 0;
  const auto count = [&ran] { ++ran; };
  executor.refuses = true;
  queue.post(lane, count);
  EXPECT_EQ(queue.waiting(), 0u);
  queue.wait_idle();
  EXPECT_THROW(queue.rethrow(), std::bad_alloc);
  // Refused during a turn: the jobs posted meanwhile are dropped.
  executor.refuses = false;
  queue.post(lane, [&] {
    queue.post(lane, count);
    executor.refuses = true;
  });
  executor.run_one();
  EXPECT_EQ(queue.waiting(), 0u);
  queue.wait_idle();
  EXPECT_THROW(queue.rethrow(), std::bad_alloc);
  EXPECT_EQ(ran, 0);
  // The lane works as before.
  executor.refuses = false;
  queue.post(lane, count);
  executor.run_one();
  EXPECT_EQ(ran, 1);
  EXPECT_NO_THROW(queue.rethrow());
}

TEST(LearningQueue, ManyLanesWorkOnManyThreads) {
  ThreadPool pool(4);
  LearningQueue queue(pool);
  constexpr int lanes = 20, jobs = 200;
  std::vector<LearningQueue::Lane> lane;
  std::vector<int> count(lanes, 0);  // the lane's order allows one writer at a time: no lock; TSan watches
  for (int i = 0; i < lanes; ++i) lane.push_back(queue.make_lane());
  for (int j = 0; j < jobs; ++j)
    for (int i = 0; i < lanes; ++i)
      queue.post(lane[static_cast<std::size_t>(i)], [&count, i, j] {
        auto &c = count[static_cast<std::size_t>(i)];
        if (c == j) ++c;
      });
  queue.wait_idle();
  for (const int c : count) EXPECT_EQ(c, jobs);
  EXPECT_GT(queue.time_spent_ns(), 0);
}

}  // namespace
}  // namespace csd
