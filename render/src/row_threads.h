// SPDX-License-Identifier: Zlib
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace limber::render {

/// A range of rows: begin <= row < end.
struct RowRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Splits work on independent rows among a few threads. Each row is computed by one thread, so that results
/// do not depend on the number of threads. The threads start with the first work that is worth it.
class RowThreads {
 public:
  /// `threads` counts the calling thread and is at least 1.
  explicit RowThreads(unsigned threads) : threads_(threads) {}
  ~RowThreads();
  RowThreads(const RowThreads&) = delete;
  RowThreads& operator=(const RowThreads&) = delete;

  /// Calls work(RowRange, part) for consecutive ranges, part = 0, 1, ... below threads(), that cover all
  /// rows, and returns when all calls have returned. `operationsPerRow` decides how many threads are worth
  /// it. The work must not throw.
  template <typename Work>
  void run(std::size_t rows, std::size_t operationsPerRow, const Work& work) {
    const auto call = [](const void* object, RowRange range, unsigned part) {
      (*static_cast<const Work*>(object))(range, part);
    };
    runOnThreads({&work, call, rows, partsFor(rows, operationsPerRow)});
  }

  unsigned threads() const { return threads_; }

 private:
  struct Job {
    const void* work = nullptr;
    void (*call)(const void* work, RowRange range, unsigned part) = nullptr;
    std::size_t rows = 0;
    unsigned parts = 0;
  };

  unsigned partsFor(std::size_t rows, std::size_t operationsPerRow) const;
  void runOnThreads(const Job& job);
  void runPart(const Job& job, unsigned part) const;
  void start();
  void serve(unsigned part);

  unsigned threads_;
  std::vector<std::thread> others_;
  std::mutex mutex_;
  std::condition_variable started_, finished_;
  Job job_;
  std::uint64_t serial_ = 0;  // Of the job.
  unsigned unfinished_ = 0;   // Other threads that have not finished it.
  bool stopping_ = false;
};

}  // namespace limber::render
