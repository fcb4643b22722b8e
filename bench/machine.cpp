// SPDX-License-Identifier: Zlib
#include "machine.h"

#include <sys/resource.h>

#include <LinearMath/btScalar.h>

#include <fstream>
#include <thread>

namespace limber::bench {
namespace {

/// The value of the first line that starts with "model name", as Linux has it.
std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string compilerName() {
#if defined(__clang__) || defined(__GNUC__)
  return __VERSION__;
#else
  return "unknown";
#endif
}

std::string buildKind() {
#ifdef NDEBUG
  return "optimised";
#else
  return "with assertions: no build to measure with";
#endif
}

}  // namespace

std::string describeMachine() {
  return processorName() + ", " + std::to_string(std::thread::hardware_concurrency()) +
         " threads; compiler " + compilerName() + ", " + buildKind() + "; Bullet " +
         std::to_string(BT_BULLET_VERSION) + " in " +
         (sizeof(btScalar) == sizeof(float) ? "single" : "double") + " precision";
}

double peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace limber::bench
