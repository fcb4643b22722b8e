// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <functional>

namespace limber {

/// Calls task(0), ..., task(count - 1), each once, in any order and on any threads, and returns when all
/// calls have returned. For NetworkSettings, AnalysisSettings and SoftBodySystem::setParallelFor(): a job
/// system that the program has already, a ThreadPool (parallel.h), or Bullet's task scheduler
/// (parallelForOf() in soft_body_system.h). Results do not depend on the number of threads. A task may wait
/// for what a task that has begun is doing, never for one that has not begun; so the tasks may also run one
/// after the other. Threads that share the step of a large body wait actively meanwhile.
using ParallelFor = std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

}  // namespace limber
