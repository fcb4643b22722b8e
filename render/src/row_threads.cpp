// SPDX-License-Identifier: Zlib
#include "row_threads.h"

#include <algorithm>

namespace limber::render {
namespace {

// About half a millisecond, which is several times what it costs to wake a thread.
constexpr std::size_t kOperationsPerThread = 2'000'000;

}  // namespace

RowThreads::~RowThreads() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  started_.notify_all();
  for (std::thread& thread : others_) {
    thread.join();
  }
}

unsigned RowThreads::partsFor(std::size_t rows, std::size_t operationsPerRow) const {
  const std::size_t worth = rows * operationsPerRow / kOperationsPerThread;
  return static_cast<unsigned>(std::min({worth + 1, std::max<std::size_t>(rows, 1), std::size_t{threads_}}));
}

void RowThreads::runPart(const Job& job, unsigned part) const {
  const RowRange range{job.rows * part / job.parts, job.rows * (part + 1) / job.parts};
  if (range.begin < range.end) {
    job.call(job.work, range, part);
  }
}

void RowThreads::runOnThreads(const Job& job) {
  if (job.parts == 1) {
    runPart(job, 0);
    return;
  }
  start();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    job_ = job;
    ++serial_;
    unfinished_ = static_cast<unsigned>(others_.size());
  }
  started_.notify_all();
  runPart(job, 0);
  std::unique_lock<std::mutex> lock(mutex_);
  finished_.wait(lock, [this] { return unfinished_ == 0; });
}

void RowThreads::start() {
  while (others_.size() + 1 < threads_) {
    const auto part = static_cast<unsigned>(others_.size() + 1);
    others_.emplace_back([this, part] { serve(part); });
  }
}

void RowThreads::serve(unsigned part) {
  std::uint64_t done = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    started_.wait(lock, [&] { return stopping_ || serial_ != done; });
    if (stopping_) {
      return;
    }
    done = serial_;
    const Job job = job_;
    lock.unlock();
    if (part < job.parts) {
      runPart(job, part);
    }
    lock.lock();
    if (--unfinished_ == 0) {
      finished_.notify_one();
    }
  }
}

}  // namespace limber::render
