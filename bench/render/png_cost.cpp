// SPDX-License-Identifier: Zlib
#include "render/png_cost.h"

#include "clocks.h"
#include "csv_table.h"
#include "sample_stats.h"
#include "scene_renderer.h"
#include "scenes/scene_list.h"

#include <limber/render/png_writer_thread.h>

#include <array>
#include <cstdio>
#include <set>
#include <stdexcept>
#include <thread>

namespace limber::bench {
namespace {

demo::DemoOptions demoOptions() {
  demo::DemoOptions options;
  options.width = 1920;
  options.height = 1080;
  return options;
}

std::unique_ptr<scenes::Scene> makeDrop() {
  scenes::SceneResult scene = scenes::createCubes({});
  if (!scene) throw std::runtime_error(scene.error());
  return std::move(*scene);
}

/// Samples of one way.
struct Samples {
  std::vector<double> tickWall, tickOwn;    // a sample per tick
  std::vector<double> frameWall, frameOwn;  // a mean per block

  PngRow row(bool writes) const {
    return {writes, median(tickWall), median(tickOwn), median(frameWall), median(frameOwn), tickWall.size()};
  }
};

/// One drop, whose blocks of frames become files or not.
class Drop {
 public:
  explicit Drop(const std::string& folder)
      : folder_(folder), scene_(makeDrop()), renderer_(*scene_, demoOptions()) {
    renderer_.draw({}, image_);  // the first frame compiles shaders
  }
  ~Drop() {
    for (const std::string& file : files_) std::remove(file.c_str());
  }

  void play(int frames, bool writes) {
    Samples& samples = samples_[writes];
    const Stopwatch watch;
    for (int i = 0; i < frames; ++i) playFrame(i, writes, samples);
    if (writes) writer_.finish();
    const WorkTime block = watch.time();
    samples.frameWall.push_back(block.wallMs / frames);
    samples.frameOwn.push_back(block.cpuMs / frames);
  }

  std::vector<PngRow> rows() const { return {samples_[false].row(false), samples_[true].row(true)}; }

 private:
  void playFrame(int i, bool writes, Samples& samples) {
    const Stopwatch watch;
    scenes::tick(*scene_);
    const WorkTime tick = watch.time();
    samples.tickWall.push_back(tick.wallMs);
    samples.tickOwn.push_back(tick.cpuMs);
    if (writes) image_ = writer_.takeSpare();
    renderer_.draw({}, image_);
    if (!writes) return;
    const std::string file = folder_ + "/render_" + std::to_string(i) + ".png";
    files_.insert(file);
    writer_.submit(file, std::move(image_));
  }

  std::string folder_;
  std::set<std::string> files_;
  std::unique_ptr<scenes::Scene> scene_;
  demo::SceneRenderer renderer_;
  render::Image image_;
  std::array<Samples, 2> samples_;  // without and with files
  render::PngWriterThread writer_;
};

}  // namespace

std::vector<PngRow> measurePngCost(const std::string& folder, const PngLimits& limits,
                                   RowProgress& progress) {
  Drop drop(folder);
  for (int pair = 0; pair < limits.pairs; ++pair) {
    // first without, then with files, then the other way round: what the drop itself changes falls out
    for (const bool second : {false, true}) drop.play(limits.framesPerBlock, second != (pair % 2 == 1));
    progress.show("png", double(pair + 1) / limits.pairs);
  }
  progress.finish("frames as png");
  return drop.rows();
}

std::vector<std::string> pngColumns() {
  return {"writes_png", "tick_ms", "tick_own_ms", "frame_ms", "frame_own_ms", "frames", "cores"};
}

std::vector<std::string> pngCells(const PngRow& row) {
  return {row.writes ? "1" : "0",
          numberCell(row.tickWall),
          numberCell(row.tickOwn),
          numberCell(row.frameWall),
          numberCell(row.frameOwn),
          countCell(row.frames),
          countCell(std::thread::hardware_concurrency())};
}

}  // namespace limber::bench
