// SPDX-License-Identifier: Zlib
#include "render/frames.h"

#include <sys/wait.h>
#include <unistd.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <cstdio>
#include <exception>
#include <fstream>
#include <optional>

namespace limber::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr int kFrames = 8;

/// What a child process tells its parent.
struct Finding {
  double buffers = 0.0, grown = 0.0;  ///< bytes
};

/// The second number of /proc/self/statm counts pages. 0 where there is no such file.
double residentBytes() {
#if defined(__GLIBC__)
  malloc_trim(0);  // what compiling shaders has left over would hide what comes after
#endif
  std::ifstream file("/proc/self/statm");
  double all = 0.0, resident = 0.0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void playFrames(FrameStage& stage, const Eigen::Matrix3Xf& points) {
  for (int frame = 0; frame < kFrames; ++frame) stage.play(points);
}

Finding drawAndMeasure(std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  const FrameScene scene = makeCubeScene(bodies);
  Eigen::Matrix3Xf points;
  pose(scene, 0, points);
  FrameStage stage({&scene, kWidth, kHeight, true}, path, context);
  stage.addBodies(1);
  playFrames(stage, points);
  const double before = residentBytes();
  stage.addBodies(bodies - 1);
  playFrames(stage, points);
  return {static_cast<double>(stage.bufferBytes()), before > 0.0 ? residentBytes() - before : 0.0};
}

[[noreturn]] void runChild(int pipe, std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  try {
    const Finding finding = drawAndMeasure(bodies, path, context);
    const bool told = write(pipe, &finding, sizeof finding) == sizeof finding;
    _exit(told ? 0 : 1);
  } catch (const std::exception&) {
    _exit(1);
  }
}

/// In a process of its own; empty if that fails.
std::optional<Finding> measureInChild(std::size_t bodies, const DrawPath& path, const DrawContext& context) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  std::fflush(nullptr);  // or the child would write it once more
  const pid_t child = fork();
  if (child == 0) runChild(ends[1], bodies, path, context);
  close(ends[1]);
  Finding finding;
  const bool told = child > 0 && read(ends[0], &finding, sizeof finding) == sizeof finding;
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  return told ? std::optional<Finding>(finding) : std::nullopt;
}

}  // namespace

void measureMemory(std::size_t bodies, const std::vector<DrawContext>& contexts, const Options& options,
                   Results& results) {
  for (const DrawContext& context : contexts)
    for (const DrawPath& path : drawPaths()) {
      if (!options.wantsEngine(path.name, context.name)) continue;
      const std::optional<Finding> finding = measureInChild(bodies, path, context);
      if (!finding) continue;
      const Subject subject{"memory", format("%zu cubes", bodies), path.name, context.name};
      results.add(subject, "buffers per cube", "B", finding->buffers / double(bodies));
      // what a process that has drawn one cube grows by: staging, and with a software driver all of its
      // memory
      if (finding->grown > 0.0)
        results.add(subject, "process per cube", "B", finding->grown / double(bodies));
    }
}

}  // namespace limber::bench
