// SPDX-License-Identifier: Zlib
#pragma once

// The threads that step one island, or one large body, together.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

namespace limber {

/// Threads that share the loops of one computation. The first thread that joins leads: it runs the
/// computation, and the others take tasks of its loops until it ends. So the computation goes on with any
/// number of threads that join at any time, also with a single one that joins several times in a row. A loop
/// costs about a microsecond, far less than starting threads for it.
///
/// Each thread has its share of consecutive tasks, the same one in all loops with as many tasks, and then
/// takes what others have left. So the data of a task stays in the cache of one core.
///
/// The tasks of a loop must be independent; then results do not depend on the number of threads.
class Team {
 public:
  static constexpr std::uint32_t kMaxThreads = 64;

  Team() = default;
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// The first call runs lead(). The others help until it has returned. At most kMaxThreads threads may join
  /// at a time.
  template <class Lead>
  void join(Lead lead) {
    const std::uint32_t number = joined_.fetch_add(1, std::memory_order_relaxed);
    if (number > 0) return help(number);
    lead();
    ended_.store(true, std::memory_order_release);
  }

  /// Calls task(i) for i in [0, count), each once, and returns when all calls have returned. Only the leader
  /// may call it. Without a leader, or while nobody else has joined, it runs on the calling thread.
  template <class Task>
  void forEach(std::uint32_t count, Task task) {
    const std::uint32_t threads = std::min(joined_.load(std::memory_order_relaxed), kMaxThreads);
    if (count < 2 || threads < 2) {
      for (std::uint32_t i = 0; i < count; ++i) task(i);
      return;
    }
    done_.store(0, std::memory_order_relaxed);
    start({&task, [](void* context, std::uint32_t i) { (*static_cast<Task*>(context))(i); }, count, threads});
    takeOwnTasks(0);
    takeOtherTasks(0);
    for (unsigned turns = 0; done_.load(std::memory_order_acquire) != count; ++turns) wait(turns);
  }

 private:
  struct Loop {
    void* context;
    void (*call)(void* context, std::uint32_t task);
    std::uint32_t count, threads;

    std::uint32_t begin(std::uint32_t share) const { return share * count / threads; }
  };

  /// The number of the loop and, in the low half, how many tasks of a share nobody has taken.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left{0};
  };

  /// Waiting threads give up their processor now and then: the one they wait for may need it.
  static void wait(unsigned turns) {
    constexpr unsigned kBusyTurns = 256;
    if (turns % kBusyTurns == kBusyTurns - 1) return std::this_thread::yield();
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
    __builtin_ia32_pause();
#endif
  }

  void start(const Loop& loop) {
    context_.store(loop.context, std::memory_order_relaxed);
    call_.store(loop.call, std::memory_order_relaxed);
    count_.store(loop.count, std::memory_order_relaxed);
    threads_.store(loop.threads, std::memory_order_relaxed);
    const std::uint32_t number = number_.load(std::memory_order_relaxed) + 1;
    for (std::uint32_t i = 0; i < loop.threads; ++i)
      shares_[i].left.store(std::uint64_t{number} << 32 | (loop.begin(i + 1) - loop.begin(i)),
                            std::memory_order_release);
    number_.store(number, std::memory_order_release);
  }

  Loop present() const {
    return {context_.load(std::memory_order_relaxed), call_.load(std::memory_order_relaxed),
            count_.load(std::memory_order_relaxed), threads_.load(std::memory_order_relaxed)};
  }

  void takeOwnTasks(std::uint32_t thread) {
    while (takeTask(thread)) {
    }
  }

  /// Takes the tasks that others have left.
  void takeOtherTasks(std::uint32_t thread) {
    const std::uint32_t threads = threads_.load(std::memory_order_relaxed);
    for (std::uint32_t i = 1; i < threads; ++i) takeOwnTasks((thread + i) % threads);
  }

  /// Takes a task of a share and runs it. Returns false if none is left.
  ///
  /// The leader changes the loop only after all its tasks are done. So if `left` still has the same value
  /// when the task is taken, the loop that was read before is the one to which the task belongs.
  bool takeTask(std::uint32_t share) {
    std::uint64_t left = shares_[share].left.load(std::memory_order_acquire);
    for (;;) {
      const auto tasks = static_cast<std::uint32_t>(left);
      if (tasks == 0) return false;
      const Loop loop = present();
      if (!shares_[share].left.compare_exchange_weak(left, left - 1, std::memory_order_acq_rel)) continue;
      loop.call(loop.context, loop.begin(share + 1) - tasks);
      done_.fetch_add(1, std::memory_order_acq_rel);
      return true;
    }
  }

  /// Each thread first does its own share. To look for what others have left takes their cache lines from
  /// them, so that comes after some waiting: it is for threads that have lost their processor.
  void help(std::uint32_t thread) {
    constexpr unsigned kPatience = 64;
    std::uint32_t seen = 0;
    for (unsigned turns = 0; !ended_.load(std::memory_order_acquire); ++turns) {
      const std::uint32_t number = number_.load(std::memory_order_acquire);
      if (number != seen) {
        seen = number;
        turns = 0;
        takeOwnTasks(thread);
      } else {
        if (turns == kPatience) takeOtherTasks(thread);
        wait(turns);
      }
    }
  }

  alignas(64) std::atomic<std::uint32_t> joined_{0};
  // the present loop
  alignas(64) std::atomic<std::uint32_t> number_{0};
  std::atomic<bool> ended_{false};
  std::atomic<void*> context_{nullptr};
  std::atomic<void (*)(void*, std::uint32_t)> call_{nullptr};
  std::atomic<std::uint32_t> count_{0}, threads_{0};
  alignas(64) std::atomic<std::uint32_t> done_{0};
  std::array<Share, kMaxThreads> shares_;
};

}  // namespace limber
