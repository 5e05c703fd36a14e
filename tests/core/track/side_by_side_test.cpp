// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/side_by_side.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <vector>

#include "track/thread_pool.h"

namespace csd {
namespace {

TEST(SideBySide, DoesEachJobOnceWithAnyNumberOfThreads) {
  for (const unsigned threads : {0U, 1U, 2U, 5U}) {
    ThreadPool pool(std::max(1U, threads));
    const auto workers = threads > 0 ? SideBySide(pool) : SideBySide();
    for (const std::size_t n : {0, 1, 3, 4, 5, 100, 1001}) {
      std::vector<std::atomic<int>> done(n);
      workers.each(n, [&](std::size_t i) { ++done[i]; });
      for (const auto &times : done) ASSERT_EQ(times, 1) << threads << " of " << n;
    }
  }
}

TEST(SideBySide, DoesNotWaitForABusyExecutor) {
  std::promise<void> begun, go_on;  // before the pool, whose thread may use them until it ends
  ThreadPool pool(1);
  pool.post([&] {
    begun.set_value();
    go_on.get_future().wait();
  });
  begun.get_future().wait();
  std::atomic<int> done = 0;
  {
    // The jobs are gone before the helper starts: it must not touch them.
    const std::function<void(std::size_t)> job = [&](std::size_t) { ++done; };
    SideBySide(pool).each(50, job);
  }
  EXPECT_EQ(done, 50) << "although the only other thread never started";
  go_on.set_value();
}

TEST(SideBySide, WorksInOtherThreadsToo) {
  // Two jobs that wait for each other: one thread alone would never finish.
  std::promise<void> first, second;
  ThreadPool pool(1);
  const auto other = [](std::promise<void> &mine, std::promise<void> &theirs) {
    mine.set_value();
    return theirs.get_future().wait_for(std::chrono::minutes(1)) == std::future_status::ready;
  };
  std::atomic<int> met = 0;
  SideBySide(pool).each(8, [&](std::size_t i) {
    if (i == 0) met += other(first, second);
    if (i == 4) met += other(second, first);
  });
  EXPECT_EQ(met, 2);
}

TEST(SideBySide, RethrowsAJobsExceptionOnceAllHaveEnded) {
  for (const bool helped : {false, true}) {
    ThreadPool pool(2);
    const auto workers = helped ? SideBySide(pool) : SideBySide();
    std::atomic<int> done = 0;
    EXPECT_THROW(workers.each(100,
                              [&](std::size_t i) {
                                if (i == 7) throw std::runtime_error("seven");
                                ++done;
                              }),
                 std::runtime_error);
    EXPECT_EQ(done, helped ? 99 : 7);
  }
}

/// An executor that takes two jobs and then runs out of memory.
class Poor final : public Executor {
 public:
  void post(std::function<void()> job) override {
    if (jobs.size() == 2) throw std::bad_alloc();
    jobs.push_back(std::move(job));
  }
  unsigned width() const override { return 4; }
  std::vector<std::function<void()>> jobs;
};

TEST(SideBySide, DoesAllJobsItselfWhereTheExecutorFails) {
  Poor poor;
  std::atomic<int> done = 0;
  EXPECT_NO_THROW(SideBySide(poor).each(100, [&](std::size_t) { ++done; }));
  EXPECT_EQ(done, 100);
  for (const auto &late : poor.jobs) late();
  EXPECT_EQ(done, 100);
}

}  // namespace
}  // namespace csd
