// SPDX-License-Identifier: Zlib
#include "run_demo.h"

#include "output_files.h"
#include "picture_output.h"
#include "progress.h"
#include "run_report.h"
#include "scene_renderer.h"
#include "scenes/end_checks.h"
#include "scenes/scene.h"
#include "scenes/scene_list.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

namespace limber::demo {

volatile std::sig_atomic_t stopSignal = 0;

namespace {

using Clock = std::chrono::steady_clock;

/// The renderer and the output of its pictures.
struct Pictures {
  Pictures(const scenes::Scene& scene, const DemoOptions& options, std::int64_t frameCount)
      : renderer(scene, options), output(options, frameCount) {}
  SceneRenderer renderer;
  PictureOutput output;
};

void advance(scenes::Scene& scene, std::int64_t ticks, RunFigures& figures) {
  for (std::int64_t i = 0; i < ticks; ++i) {
    if (stopSignal != 0) throw Stopped{};
    const scenes::TickTimes times = scenes::tick(scene);
    figures.tick.add(times.total);
    figures.soft += times.soft;
  }
}

void takePicture(Pictures& pictures, const Moment& moment, RunFigures& figures) {
  render::Image image = pictures.output.blank();
  const Clock::time_point start = Clock::now();
  pictures.renderer.draw(moment, image);
  figures.render.add(1000.0 * secondsSince(start));
  const Clock::time_point drawn = Clock::now();
  pictures.output.add(std::move(image));
  figures.output.add(1000.0 * secondsSince(drawn));
}

Moment momentOf(const scenes::Timeline& timeline, std::int64_t frame) {
  const std::int64_t last = std::max<std::int64_t>(timeline.frameCount() - 1, 1);
  return {timeline.tickFraction(frame), static_cast<double>(frame) / static_cast<double>(last)};
}

/// Simulation and drawing alternate on this thread; compression has a thread of its own.
void play(scenes::Scene& scene, const scenes::Timeline& timeline, Pictures* pictures, RunFigures& figures) {
  Progress progress(stderr, isTerminal(stderr));
  std::int64_t done = 0;
  const auto advanceTo = [&](std::int64_t tick) {
    advance(scene, tick - done, figures);
    done = tick;
    progress.show(done, timeline.ticks);
  };
  for (std::int64_t frame = 0; frame < timeline.frameCount(); ++frame) {
    advanceTo(timeline.ticksFor(frame));
    if (pictures) takePicture(*pictures, momentOf(timeline, frame), figures);
  }
  advanceTo(timeline.ticks);
}

ShapeFigures shapeFigures(const scenes::Scene& scene) {
  ShapeFigures figures;
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    if (body.network().kind != NetworkKind::Solid) continue;
    const scenes::ShapeError error = scenes::shapeError(body);
    ++figures.solids;
    figures.mean += error.relativeRms;
    figures.worst = std::max(figures.worst, error.relativeRms);
    figures.insideOut += error.mirrored;
  }
  if (figures.solids) figures.mean /= static_cast<double>(figures.solids);
  return figures;
}

void examine(const scenes::Scene& scene, const scenes::Timeline& timeline, RunFigures& figures) {
  figures.simulatedSeconds =
      static_cast<double>(timeline.ticks) / static_cast<double>(scenes::kTicksPerSecond);
  figures.bodies = scene.soft->bodyCount();
  figures.points = scenes::pointCount(scene);
  figures.springs = scenes::springCount(scene);
  figures.shape = shapeFigures(scene);
  figures.stateHash = scenes::stateHash(scene);
  figures.endProblem = scenes::checkEnd(scene);
}

RunFigures simulate(scenes::Scene& scene, const DemoOptions& options, std::unique_ptr<Pictures>& pictures) {
  const scenes::Timeline timeline = scenes::timelineOf(options.seconds, options.framesPerSecond);
  if (options.mode != PictureMode::None) {
    pictures = std::make_unique<Pictures>(scene, options, timeline.frameCount());
  }
  RunFigures figures;
  const Clock::time_point start = Clock::now();
  play(scene, timeline, pictures.get(), figures);
  if (pictures) pictures->output.finish();
  figures.wallSeconds = secondsSince(start);
  if (pictures) {
    figures.gpuBufferBytes = pictures->renderer.gpuBufferBytes();
    figures.bytesPerFrame = pictures->renderer.lastFrame().bytesStreamed;
    figures.ringWaits = pictures->renderer.ring().waits;
    figures.ringStalls = pictures->renderer.ring().stalls;
    figures.driver = pictures->renderer.driver();
  }
  examine(scene, timeline, figures);
  return figures;
}

/// Shows the progress of cooking.
scenes::SceneResult createScene(const DemoOptions& options) {
  constexpr double kPatience = 0.5;  // s
  StageProgress bars(stderr, isTerminal(stderr), kPatience);
  scenes::SceneOptions sceneOptions = options.sceneOptions;
  sceneOptions.cook.progress = [&bars](const char* what, double done) {
    bars.show(what, done);
    return stopSignal == 0;
  };
  scenes::SceneResult scene = scenes::findScene(options.scene)->create(sceneOptions);
  bars.finish();
  if (stopSignal != 0) throw Stopped{};
  return scene;
}

ExitCode fail(const std::string& reason) {
  std::fprintf(stderr, "limber-demo: %s\n", reason.c_str());
  return kFailure;
}

}  // namespace

ExitCode runDemo(const DemoOptions& options) {
  if (!options.statsFile.empty())
    if (const std::string reason = checkWritable(options.statsFile); !reason.empty()) return fail(reason);
  const scenes::SceneResult scene = createScene(options);
  if (!scene) return fail(scene.error());
  // after the creation of the scene: if that fails, no folder is made and no old picture removed
  if (options.mode != PictureMode::None)
    if (const std::string reason = prepareFolder(options.outFolder); !reason.empty()) return fail(reason);
  for (const std::string& note : (*scene)->notes) std::fprintf(stderr, "%s\n", note.c_str());

  std::unique_ptr<Pictures> pictures;
  const RunFigures figures = simulate(**scene, options, pictures);
  printTable(options, figures);
  if (pictures) std::printf("pictures    %s\n", pictures->output.describe().c_str());
  if (!options.statsFile.empty()) {
    if (const std::string reason = writeJson(options, figures); !reason.empty()) return fail(reason);
  }
  if (pictures && !pictures->output.videoProblem().empty()) return fail(pictures->output.videoProblem());
  return figures.endProblem.empty() ? kSuccess : kWrongEnd;
}

}  // namespace limber::demo
