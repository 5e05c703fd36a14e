// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learning_queue.h"

#include <chrono>
#include <list>
#include <utility>

namespace csd {

struct LearningQueue::Shared {
  explicit Shared(Executor &e) : executor(e) {}
  Executor &executor;
  std::mutex mutex;  // guards all below and the lanes' states
  std::condition_variable idle;
  std::size_t waiting = 0;
  std::size_t running = 0;
  std::int64_t spent = 0;
  std::exception_ptr failure;
};

struct LearningQueue::Lane::State {
  std::shared_ptr<Shared> shared;
  std::list<std::function<void()>> jobs;  // an empty list needs no memory, which may be short in ~Lane()
  bool scheduled = false;                 // a take_turn() is posted or running
};

LearningQueue::Lane::~Lane() {
  if (!state_) return;
  std::list<std::function<void()>> dropped;  // freed outside the lock
  const std::lock_guard lock(state_->shared->mutex);
  dropped.swap(state_->jobs);
  state_->shared->waiting -= dropped.size();
  state_->shared->idle.notify_all();
}

std::size_t LearningQueue::Lane::waiting() const {
  const std::lock_guard lock(state_->shared->mutex);
  return state_->jobs.size() + (state_->scheduled ? 1 : 0);
}

LearningQueue::LearningQueue(Executor &executor) : shared_(std::make_shared<Shared>(executor)) {}

LearningQueue::~LearningQueue() {
  std::unique_lock lock(shared_->mutex);
  shared_->idle.wait(lock, [this] { return shared_->running == 0; });
}

LearningQueue::Lane LearningQueue::make_lane() {
  auto state = std::make_shared<Lane::State>();
  state->shared = shared_;
  return Lane(std::move(state));
}

void LearningQueue::post(Lane &lane, std::function<void()> job) {
  {
    const std::lock_guard lock(shared_->mutex);
    lane.state_->jobs.push_back(std::move(job));
    ++shared_->waiting;
    if (lane.state_->scheduled) return;
    lane.state_->scheduled = true;
  }
  book(shared_, lane.state_);
}

// Schedules a turn for the lane. If the executor refuses it (no memory), the lane's jobs are dropped, so that nobody
// waits for them.
void LearningQueue::book(const std::shared_ptr<Shared> &shared, const std::shared_ptr<Lane::State> &lane) {
  try {
    shared->executor.post([shared, lane] { take_turn(shared, lane); });
  } catch (...) {
    const std::lock_guard lock(shared->mutex);
    if (!shared->failure) shared->failure = std::current_exception();
    shared->waiting -= lane->jobs.size();
    lane->jobs.clear();
    lane->scheduled = false;
  }
}

// Runs the jobs that waited when the turn began, then goes to the back of the executor's queue. One job at a time would
// be fairer, but all features of a picture would get their descriptors late, together.
void LearningQueue::take_turn(const std::shared_ptr<Shared> &shared, const std::shared_ptr<Lane::State> &lane) {
  std::unique_lock lock(shared->mutex);
  ++shared->running;
  for (std::size_t left = lane->jobs.size(); left > 0 && !lane->jobs.empty(); --left) {
    auto job = std::move(lane->jobs.front());
    lane->jobs.pop_front();
    lock.unlock();
    std::exception_ptr failure;
    const auto start = std::chrono::steady_clock::now();
    try {
      job();
    } catch (...) {
      failure = std::current_exception();
    }
    job = nullptr;
    const auto spent = std::chrono::steady_clock::now() - start;
    lock.lock();
    shared->spent += std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count();
    if (failure && !shared->failure) shared->failure = failure;
    --shared->waiting;
    shared->idle.notify_all();
  }
  lane->scheduled = !lane->jobs.empty();
  if (lane->scheduled) {
    lock.unlock();
    book(shared, lane);
    lock.lock();
  }
  --shared->running;
  // Notifies under the lock: once it is released, the owner and the executor may be gone.
  shared->idle.notify_all();
}

void LearningQueue::wait_idle() {
  std::unique_lock lock(shared_->mutex);
  shared_->idle.wait(lock, [this] { return shared_->waiting == 0; });
}

void LearningQueue::rethrow() {
  std::exception_ptr failure;
  {
    const std::lock_guard lock(shared_->mutex);
    failure = std::exchange(shared_->failure, nullptr);
  }
  if (failure) std::rethrow_exception(failure);
}

std::size_t LearningQueue::waiting() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->waiting;
}

std::int64_t LearningQueue::time_spent_ns() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->spent;
}

}  // namespace csd
