// SPDX-License-Identifier: Zlib

// This file is the thread pool, and the adapter of Bullet's task scheduler.

#include "bullet/parallel.h"

#include <LinearMath/btThreads.h>

#include <condition_variable>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- the pool ----------------------------------------------------------------------------------------------

namespace {

/// The time for which a thread looks for work before it goes to sleep. The parts of a tick follow one another
/// faster; waking a thread costs the caller up to 0.1 ms on a virtual machine.
constexpr std::chrono::microseconds kAwake(400);

void pause() {
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
  for (int i = 0; i < 32; ++i) __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Waits until done() or for kAwake. Then the thread may have lost its processor to the one that it waits
/// for.
template <class Done>
void lookFor(Done done) {
  const auto end = std::chrono::steady_clock::now() + kAwake;
  while (!done() && std::chrono::steady_clock::now() < end) pause();
}

}  // namespace

struct LIMBER_HIDDEN ThreadPool::Impl {
  explicit Impl(unsigned workers) {
    for (unsigned i = 0; i < workers; ++i) threads.emplace_back([this] { work(); });
  }

  ~Impl() {
    start(State::Ending);
    for (std::thread& thread : threads) thread.join();
  }

  enum class State : unsigned char { Idle, Running, Ending };

  /// Tells the threads about a new round.
  void start(State s) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      state = s;
      ++round;
    }
    begins.notify_all();
  }

  /// Waits for a round other than `seen`. Returns whether there are tasks; the thread then takes part.
  bool join(unsigned& seen) {
    lookFor([&] { return round != seen; });
    std::unique_lock<std::mutex> lock(mutex);
    begins.wait(lock, [&] { return round != seen; });
    seen = round;
    if (state != State::Running) return false;
    ++working;
    return true;
  }

  void work() {
    for (unsigned seen = 0;;) {
      if (join(seen)) {
        runTasks();
        --working;
      } else if (state == State::Ending) {
        return;
      }
    }
  }

  /// Runs tasks until none is left.
  void runTasks() {
    for (std::size_t i = next++; i < count; i = next++) (*task)(i);
  }

  void run(std::size_t n, const std::function<void(std::size_t)>& f) {
    if (busy.test_and_set(std::memory_order_acquire)) {
      for (std::size_t i = 0; i < n; ++i) f(i);
      return;
    }
    count = n;
    task = &f;
    next = 0;
    const End end{*this};
    start(State::Running);
    runTasks();
  }

  /// Ends a round, also if a task has thrown.
  struct End {
    Impl& impl;
    ~End() {
      impl.next = impl.count;
      {
        // threads that have not joined yet are not waited for
        const std::lock_guard<std::mutex> lock(impl.mutex);
        impl.state = State::Idle;
      }
      lookFor([&] { return impl.working == 0; });
      while (impl.working != 0) std::this_thread::yield();
      impl.busy.clear(std::memory_order_release);
    }
  };

  std::vector<std::thread> threads;
  std::mutex mutex;
  std::condition_variable begins;
  std::atomic<State> state{State::Idle};  // changes under the mutex, as the next two
  std::atomic<unsigned> round{0};
  std::atomic<unsigned> working{0};  // threads that take part; they leave without the mutex
  std::atomic_flag busy = ATOMIC_FLAG_INIT;
  std::atomic<std::size_t> next{0};
  std::size_t count = 0;
  const std::function<void(std::size_t)>* task = nullptr;
};

ThreadPool::ThreadPool(unsigned threads) {
  constexpr unsigned kMaxThreads = 256;
  const unsigned wanted = threads > 0 ? threads : std::thread::hardware_concurrency();
  impl_ = std::make_unique<Impl>(std::clamp(wanted, 1u, kMaxThreads) - 1);
}

ThreadPool::~ThreadPool() = default;

unsigned ThreadPool::threads() const { return static_cast<unsigned>(impl_->threads.size()) + 1; }

void ThreadPool::run(std::size_t count, const std::function<void(std::size_t)>& task) {
  impl_->run(count, task);
}

ParallelFor ThreadPool::parallelFor() {
  return [this](std::size_t count, const std::function<void(std::size_t)>& task) { run(count, task); };
}

// --- Bullet's scheduler ------------------------------------------------------------------------------------

ParallelFor parallelForOf(btITaskScheduler& scheduler) {
  return [&scheduler](std::size_t count, const std::function<void(std::size_t)>& task) {
    struct Body final : btIParallelForBody {
      const std::function<void(std::size_t)>* task;
      void forLoop(int begin, int end) const override {
        for (int i = begin; i < end; ++i) (*task)(static_cast<std::size_t>(i));
      }
    } body;
    body.task = &task;
    scheduler.parallelFor(0, static_cast<int>(count), 1, body);
  };
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
