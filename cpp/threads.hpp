// Threads that share out numbered tasks.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sched.h>
#endif

namespace vbbench {

/// How many threads this process may run at the same time.
inline int available_threads() {
#ifdef __linux__
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(CPU_COUNT(&set), 1);
#endif
  return std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
}

/// The caller's thread and others, which wait between two runs and end with the team.
class Team {
 public:
  /// Of as many threads, or fewer where the system gives no more.
  explicit Team(int threads) {
    try {
      for (int n = 1; n < threads; ++n) others_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {
    }
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;
  ~Team() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    begin_.notify_all();
    for (std::thread& other : others_) other.join();
  }

  /// Calls task(n) once for each n from 0 to count − 1, in any order and at the same time; tasks do not throw.
  void run(int count, const std::function<void(int)>& task) {
    if (others_.empty() || count < 2) {
      for (int n = 0; n < count; ++n) task(n);
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      task_ = &task;
      count_ = count;
      next_ = 0;
      working_ = static_cast<int>(others_.size());
      ++round_;
    }
    begin_.notify_all();
    work();
    std::unique_lock lock(mutex_);
    end_.wait(lock, [this] { return working_ == 0; });
  }

 private:
  void work() {
    for (int n = next_++; n < count_; n = next_++) (*task_)(n);
  }

  void serve() {
    for (long seen = 0;; ++seen) {
      {
        std::unique_lock lock(mutex_);
        begin_.wait(lock, [&] { return ending_ || round_ > seen; });
        if (ending_) return;
      }
      work();
      const std::lock_guard lock(mutex_);
      if (--working_ == 0) end_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable begin_, end_;
  std::atomic<int> next_{0};
  const std::function<void(int)>* task_ = nullptr;
  int count_ = 0, working_ = 0;
  long round_ = 0;
  bool ending_ = false;
  std::vector<std::thread> others_;
};

}  // namespace vbbench
