// SPDX-License-Identifier: Zlib

// This header declares how a tick runs work on several threads: in blocks, with scratch memory for each, or
// as a team.

#pragma once

#include "solver/team.h"

#include <limber/parallel.h>

#include <algorithm>
#include <cfenv>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

/// Keeps a private type that is nested in an exported class out of what a shared library offers.
#if defined(__GNUC__) && !defined(_WIN32)
#define LIMBER_HIDDEN __attribute__((visibility("hidden")))
#else
#define LIMBER_HIDDEN
#endif

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Runs work in blocks on the threads of the user's function, or in order on the calling thread without one.
/// Work on one item must not depend on other items: then results are the same on any number of threads.
class Parallel {
 public:
  void use(ParallelFor run, std::size_t fromSprings) {
    run_ = run ? std::make_shared<const ParallelFor>(std::move(run)) : nullptr;
    fromSprings_ = fromSprings;
  }
  bool isOn() const { return run_ != nullptr && worthwhile_; }

  /// Number of springs from which on several threads gain something.
  std::size_t fromSprings() const { return fromSprings_; }
  /// Leaves the threads alone while there is so little to do that starting them would take longer.
  void setWorthwhile(bool worthwhile) { worthwhile_ = worthwhile; }

  /// Returns the number of ranges of inBlocks(); range i begins at i times their size.
  std::size_t blockCount(std::size_t count) const {
    return (count + blockSize(count) - 1) / blockSize(count);
  }
  std::size_t blockSize(std::size_t count) const {
    return std::max<std::size_t>(isOn() ? (count + kMaxBlocks - 1) / kMaxBlocks : count, 1);
  }

  /// Calls visit(begin, end) for ranges that cover [0, count), each range once.
  template <class Visit>
  void inBlocks(std::size_t count, Visit visit) const {
    if (count == 0) return;
    if (!isOn() || count == 1) return visit(std::size_t{0}, count);
    struct Blocks {
      std::size_t count, size;
      Visit& visit;
      std::fenv_t environment;
    } all{count, blockSize(count), visit, {}};
    std::fegetenv(&all.environment);
    // the user may replace the function while it runs
    const std::shared_ptr<const ParallelFor> run = run_;
    // a std::function that refers to one object needs no memory
    (*run)(blockCount(count), [&all](std::size_t block) {
      // rounding and denormal numbers as on the thread that steps the world
      std::fenv_t own;
      std::fegetenv(&own);
      std::fesetenv(&all.environment);
      all.visit(block * all.size, std::min(all.count, (block + 1) * all.size));
      std::fesetenv(&own);
    });
  }

  /// Calls visit(i) for i in [0, count).
  template <class Visit>
  void forEach(std::size_t count, Visit visit) const {
    inBlocks(count, [&visit](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) visit(i);
    });
  }

  /// Calls work(team) once, with a team of all threads that are free. It must be on.
  template <class Work>
  void together(Work work) const {
    Team team;
    inBlocks(kMaxBlocks, [&](std::size_t, std::size_t) { team.join([&] { work(team); }); });
  }

 private:
  /// Enough for an even load on tens of threads, and so few that starting them costs little.
  static constexpr std::size_t kMaxBlocks = 64;

  std::shared_ptr<const ParallelFor> run_;
  std::size_t fromSprings_ = 0;
  bool worthwhile_ = true;
};

/// Scratch memory for blocks that run at the same time. Its contents must not affect results.
template <class Scratch>
class ScratchPool {
 public:
  /// Calls use(scratch) with scratch memory that nobody else uses.
  template <class Use>
  void with(Use use) {
    std::unique_ptr<Scratch> scratch = take();
    use(*scratch);
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.push_back(std::move(scratch));
  }

 private:
  std::unique_ptr<Scratch> take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (free_.empty()) return std::make_unique<Scratch>();
    std::unique_ptr<Scratch> scratch = std::move(free_.back());
    free_.pop_back();
    return scratch;
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> free_;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
