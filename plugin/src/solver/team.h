// SPDX-License-Identifier: Zlib
#pragma once

// The threads that step one island, or one large body, together.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
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
    start(
        &task, [](void* context, std::uint32_t i) { (*static_cast<Task*>(context))(i); }, count, threads);
    takeTasks(shares_[0]);
    for (std::uint32_t i = 1; i < threads; ++i) takeTasks(shares_[i]);
    for (unsigned turns = 0; done_.load(std::memory_order_acquire) != count; ++turns) wait(turns);
  }

 private:
  using Call = void (*)(void* context, std::uint32_t task);

  /// The tasks of a thread in the present loop, in a cache line of their own.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left{
        0};  ///< number of the loop, and in the low half tasks that nobody has taken
    std::atomic<void*> context{nullptr};
    std::atomic<Call> call{nullptr};
    std::atomic<std::uint32_t> end{0};  ///< 1 + the last task
  };

  /// Waiting threads give up their processor now and then: the one they wait for may need it.
  static void wait(unsigned turns) {
    constexpr unsigned kBusyTurns = 256;
    if (turns % kBusyTurns == kBusyTurns - 1) return std::this_thread::yield();
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
    __builtin_ia32_pause();
#endif
  }

  void start(void* context, Call call, std::uint32_t count, std::uint32_t threads) {
    ++loop_;
    for (std::uint32_t i = 0; i < threads; ++i) {
      const std::uint32_t begin = i * count / threads, end = (i + 1) * count / threads;
      Share& share = shares_[i];
      share.context.store(context, std::memory_order_relaxed);
      share.call.store(call, std::memory_order_relaxed);
      share.end.store(end, std::memory_order_relaxed);
      share.left.store(loop_ << 32 | (end - begin), std::memory_order_release);
    }
    shareCount_.store(threads, std::memory_order_relaxed);
  }

  /// Takes all tasks of a share, one by one, and runs them. Returns whether there were any.
  ///
  /// The leader changes a share only after all its tasks are done. So if `left` still has the same value when
  /// a task is taken, the members read before are those of its loop.
  bool takeTasks(Share& share) {
    bool any = false;
    for (std::uint64_t left = share.left.load(std::memory_order_acquire);
         static_cast<std::uint32_t>(left) > 0;) {
      void* const context = share.context.load(std::memory_order_relaxed);
      const Call call = share.call.load(std::memory_order_relaxed);
      const std::uint32_t task = share.end.load(std::memory_order_relaxed) - static_cast<std::uint32_t>(left);
      if (!share.left.compare_exchange_weak(left, left - 1, std::memory_order_acq_rel)) continue;
      call(context, task);
      done_.fetch_add(1, std::memory_order_acq_rel);
      any = true;
      left = share.left.load(std::memory_order_acquire);
    }
    return any;
  }

  /// Each thread first does its own share. To look for what others have left takes their cache lines from
  /// them, so that comes after some waiting: it is for threads that have lost their processor.
  ///
  /// Some 0.2 ms without work are a long computation of the leader alone. Then the processor is left to
  /// others.
  void help(std::uint32_t thread) {
    constexpr unsigned kPatience = 32, kLongWait = 4000;
    constexpr std::chrono::microseconds kNap(20);
    for (unsigned turns = 0; !ended_.load(std::memory_order_acquire); ++turns) {
      if (takeTasks(shares_[thread % kMaxThreads])) turns = 0;
      if (turns == kPatience)
        for (std::uint32_t i = 0; i < shareCount_.load(std::memory_order_relaxed); ++i) takeTasks(shares_[i]);
      if (turns < kLongWait)
        wait(turns);
      else
        std::this_thread::sleep_for(kNap);
    }
  }

  std::atomic<std::uint32_t> joined_{0};
  std::atomic<std::uint32_t> shareCount_{0};
  std::uint64_t loop_ = 0;  ///< number of loops, for the leader
  alignas(64) std::atomic<bool> ended_{false};
  alignas(64) std::atomic<std::uint32_t> done_{0};
  std::array<Share, kMaxThreads> shares_;
};

}  // namespace limber
