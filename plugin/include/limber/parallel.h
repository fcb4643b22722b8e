// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>
#include <limber/export.h>
#include <limber/parallel_for.h>

#include <cstddef>
#include <functional>
#include <memory>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Threads that wait for tasks. The tasks of a tick throw nothing, need at most 128 KiB of stack, and take
/// over the floating-point environment of the thread that steps the world. More threads than free cores make
/// ticks slower. Thread rule: any thread may call run(), also in a task; a call while another one is going on
/// runs its tasks on the calling thread alone.
///
///     limber::ThreadPool pool;
///     soft.setParallelFor(pool.parallelFor());
class LIMBER_API ThreadPool {
 public:
  /// `threads`: number of threads that work, including the one that calls run(); 0: as many as the machine
  /// runs at the same time. At most 256.
  explicit ThreadPool(unsigned threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const;

  /// See ParallelFor. The calling thread works, too. Allocates nothing. A task that throws on another thread
  /// ends the program; what one throws on the calling thread comes out, and tasks that have not begun are
  /// left out.
  void run(std::size_t count, const std::function<void(std::size_t)>& task);

  /// Returns a function that calls run(). The pool must outlive the last call, in the last tick.
  ParallelFor parallelFor();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
