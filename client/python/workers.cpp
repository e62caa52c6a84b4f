#include "client/python/workers.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <unistd.h>

namespace palpate {

struct Workers::Shared {
  /// Makes calls until there are no more.
  void Help(std::size_t thread) {
    while (!failed.load(std::memory_order_relaxed)) {
      const std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
      if (index >= count) return;
      try {
        (*work)(index, thread);
      } catch (...) {
        Fail();
      }
    }
  }
  void Fail() {
    const std::lock_guard lock(mutex);
    if (!error) error = std::current_exception();
    failed.store(true, std::memory_order_relaxed);
  }
  void Live(std::size_t thread) {
    std::unique_lock lock(mutex);
    for (std::uint64_t seen = 0;;) {
      begun.wait(lock, [&] { return is_over || loop != seen; });
      if (is_over) return;
      seen = loop;
      lock.unlock();
      Help(thread);
      lock.lock();
      if (--busy == 0) done.notify_one();
    }
  }

  const pid_t process = getpid();
  std::mutex mutex;
  std::condition_variable begun, done;
  std::uint64_t loop = 0;
  std::size_t busy = 0;  // number of other threads that have not finished this loop
  bool is_over = false;
  std::exception_ptr error;
  // Set before a loop begins:
  const Work* work = nullptr;
  std::size_t count = 0;

  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::vector<std::thread> others;
};

Workers::Workers(int threads) : threads_(std::max(threads, 1)) {}

Workers::~Workers() {
  End();
}

void Workers::End() {
  if (!shared_) return;
  if (shared_->process != getpid()) {
    // Its threads are not here, and may have held what they share.  It can only be left behind.
    (void)shared_.release();
    return;
  }
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->is_over = true;
  }
  shared_->begun.notify_all();
  for (std::thread& other : shared_->others) other.join();
  shared_.reset();
}

bool Workers::has_failed() const {
  return shared_->failed.load(std::memory_order_relaxed);
}

void Workers::Run(std::size_t count, const Work& work, const std::function<void()>& wait) {
  using namespace std::chrono_literals;
  if (shared_ && shared_->process != getpid()) End();
  if (!shared_) shared_ = std::make_unique<Shared>();
  Shared& shared = *shared_;
  const std::size_t wanted = std::min(static_cast<std::size_t>(threads_), count);
  std::unique_lock lock(shared.mutex);
  for (std::size_t thread = shared.others.size() + 1; thread < wanted; ++thread) {
    shared.others.emplace_back([&shared, thread] { shared.Live(thread); });
  }
  shared.work = &work;
  shared.count = count;
  shared.next = 0;
  shared.failed = false;
  shared.error = nullptr;
  shared.busy = shared.others.size();
  ++shared.loop;
  lock.unlock();
  shared.begun.notify_all();
  shared.Help(0);
  lock.lock();
  while (!shared.done.wait_for(lock, 10ms, [&] { return shared.busy == 0; })) {
    if (shared.error) continue;
    lock.unlock();
    try {
      wait();
    } catch (...) {
      shared.Fail();
    }
    lock.lock();
  }
  if (shared.error) std::rethrow_exception(std::exchange(shared.error, nullptr));
}

}  // namespace palpate
