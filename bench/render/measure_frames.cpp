// SPDX-License-Identifier: Zlib
#include "render/measure_frames.h"

#include "sample_stats.h"
#include "text_format.h"

namespace limber::bench {
namespace {

struct Run {
  std::unique_ptr<FrameStage> stage;
  std::vector<FrameTimes> samples;
};

std::vector<Run> openAll(const FrameCase& frameCase, const std::vector<DrawContext>& contexts) {
  constexpr int kWarmUp = 4;  // shaders are compiled, each region of the ring touched
  std::vector<Run> runs;
  Eigen::Matrix3Xf points;
  for (const DrawContext& context : contexts) {
    for (const DrawPath& path : drawPaths()) {
      runs.push_back({std::make_unique<FrameStage>(frameCase, path, context), {}});
      runs.back().stage->addBodies(frameCase.scene->bodies());
      for (int frame = 0; frame < kWarmUp; ++frame) {
        pose(*frameCase.scene, frame, points);
        runs.back().stage->play(points);
      }
    }
  }
  return runs;
}

void playBlock(Run& run, const FrameScene& scene, int firstFrame, int frames) {
  Eigen::Matrix3Xf points;
  for (int i = 0; i < frames; ++i) {
    pose(scene, firstFrame + i, points);
    const FrameTimes times = run.stage->play(points);
    if (i > 0) run.samples.push_back(times);
  }
}

double medianOf(const Run& run, double FrameTimes::*part) {
  std::vector<double> values;
  for (const FrameTimes& times : run.samples) values.push_back(times.*part);
  return median(values);
}

FrameRow rowOf(const Run& run, const FrameCase& frameCase) {
  FrameRow row;
  row.scene = frameCase.scene->name;
  row.path = run.stage->path().name, row.context = run.stage->context().name;
  row.width = frameCase.width, row.height = frameCase.height, row.shadows = frameCase.shadows;
  row.bodies = frameCase.scene->bodies();
  row.points = frameCase.scene->points(), row.triangles = frameCase.scene->triangles();
  row.times = {medianOf(run, &FrameTimes::upload), medianOf(run, &FrameTimes::submit),
               medianOf(run, &FrameTimes::finish), medianOf(run, &FrameTimes::read),
               medianOf(run, &FrameTimes::frame),  medianOf(run, &FrameTimes::own),
               medianOf(run, &FrameTimes::process)};
  row.frames = run.samples.size();
  row.bytes = run.stage->lastFrame().bytesStreamed;
  row.drawCalls = run.stage->lastFrame().drawCalls;
  row.bufferBytes = run.stage->bufferBytes();
  row.driver = run.stage->driver();
  return row;
}

}  // namespace

std::vector<FrameRow> measureFrames(const FrameCase& frameCase, const std::vector<DrawContext>& contexts,
                                    const FrameLimits& limits, RowProgress& progress) {
  std::vector<Run> runs = openAll(frameCase, contexts);
  for (int block = 0; block < limits.blocks; ++block) {
    for (std::size_t i = 0; i < runs.size(); ++i)
      playBlock(runs[(i + static_cast<std::size_t>(block)) % runs.size()], *frameCase.scene,
                block * limits.framesPerBlock, limits.framesPerBlock);
    progress.show(describe(frameCase), double(block + 1) / limits.blocks);
  }
  std::vector<FrameRow> rows;
  for (const Run& run : runs) rows.push_back(rowOf(run, frameCase));
  return rows;
}

std::string describe(const FrameCase& frameCase) {
  const FrameScene& scene = *frameCase.scene;
  const std::string what = scene.bodies() > 1 ? format("%zu %s", scene.bodies(), scene.name.c_str())
                                              : format("%s of %zu triangles", scene.name.c_str(),
                                                       scene.shape.triangles.size() / 3);
  return format("%s, %dx%d, %s", what.c_str(), frameCase.width, frameCase.height,
                frameCase.shadows ? "shadows" : "no shadows");
}

}  // namespace limber::bench
