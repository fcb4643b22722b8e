// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "command_line.h"
#include "csv_table.h"
#include "render/measure_frames.h"
#include "render/render_summary.h"
#include "render/render_targets.h"

#include <cstdio>
#include <exception>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "render.csv";

struct Options {
  std::string out = "out/bench";
  bool quick = false;
  std::string part, context;  ///< empty: all
  int blocks = 0;             ///< 0: as many as the run's length asks for
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("--out", options.out, "folder of render*.csv and render.txt (default out/bench)");
  app.add_flag("--quick", options.quick, "few sizes and frames, under a minute: the times mean little");
  app.add_option("--part", options.part, "only frames, memory, png or skins")
      ->check(CLI::IsMember({"frames", "memory", "png", "skins"}));
  app.add_option("--context", options.context, "only osmesa or egl")->check(CLI::IsMember({"osmesa", "egl"}));
  app.add_option("--blocks", options.blocks, "turns of each path (default 5)")->check(CLI::PositiveNumber);
}

bool wants(const Options& options, const char* part) { return options.part.empty() || options.part == part; }

std::vector<DrawContext> contextsOf(const Options& options) {
  std::vector<DrawContext> chosen;
  for (const DrawContext& context : drawContexts())
    if (options.context.empty() || options.context == context.name) chosen.push_back(context);
  return chosen;
}

/// Those that this machine can make; the others are complained about.
std::vector<DrawContext> workingContexts(const Options& options) {
  std::vector<DrawContext> working;
  for (const DrawContext& context : contextsOf(options)) {
    try {
      render::ContextDesc desc;
      desc.backend = context.backend;
      render::createContext(desc);
      working.push_back(context);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "limber-bench: without %s: %s\n", context.name, error.what());
    }
  }
  return working;
}

std::vector<FrameScene> scenesOf(const Options& options) {
  std::vector<FrameScene> scenes;
  for (const std::size_t count :
       options.quick ? std::vector<std::size_t>{64, 1024} : std::vector<std::size_t>{64, 128, 1024, 4096})
    scenes.push_back(makeCubeScene(count));
  scenes.push_back(makeBallScene(options.quick));
  return scenes;
}

std::vector<FrameCase> casesOf(const std::vector<FrameScene>& scenes, const Options& options) {
  std::vector<FrameCase> cases;
  for (const FrameScene& scene : scenes) {
    for (const bool shadows : {false, true}) {
      cases.push_back({&scene, 1280, 720, shadows});
      if (!options.quick) cases.push_back({&scene, 1920, 1080, shadows});
    }
  }
  return cases;
}

std::vector<MemoryRow> memoryPart(const Options& options) {
  CsvTable csv(options.out + "/render_memory.csv", memoryColumns());
  std::vector<MemoryRow> rows = measurePathMemory(options.quick ? 256 : 4096, contextsOf(options));
  for (const MemoryRow& row : rows) csv.add(memoryCells(row));
  return rows;
}

std::vector<FrameRow> framesPart(const Options& options, RowProgress& progress) {
  CsvTable csv(options.out + "/" + kCsvName, frameColumns());
  FrameLimits limits;
  if (options.quick) limits = {2, 3};
  if (options.blocks > 0) limits.blocks = options.blocks;
  const std::vector<DrawContext> contexts = workingContexts(options);
  const std::vector<FrameScene> scenes = scenesOf(options);
  std::vector<FrameRow> all;
  for (const FrameCase& frameCase : casesOf(scenes, options)) {
    for (FrameRow& row : measureFrames(frameCase, contexts, limits, progress)) {
      csv.add(frameCells(row));
      all.push_back(std::move(row));
    }
    progress.finish(describe(frameCase));
  }
  return all;
}

std::vector<PngRow> pngPart(const Options& options, RowProgress& progress) {
  CsvTable csv(options.out + "/render_png.csv", pngColumns());
  PngLimits limits;
  if (options.quick) limits = {2, 3};
  if (options.blocks > 0) limits.pairs = options.blocks;
  std::vector<PngRow> rows = measurePngCost(options.out, limits, progress);
  for (const PngRow& row : rows) csv.add(pngCells(row));
  return rows;
}

std::vector<SkinCostRow> skinPart(const Options& options, RowProgress& progress) {
  CsvTable csv(options.out + "/render_skins.csv", skinColumns());
  const std::vector<DrawContext> contexts = workingContexts(options);
  if (contexts.empty()) return {};
  SkinLimits limits;
  if (options.quick) limits = {{{1, 51, 100}, {2, 21, 40}}, 2, 3};
  if (options.blocks > 0) limits.blocks = options.blocks;
  std::vector<SkinCostRow> rows = measureSkinCost(contexts[0], limits, progress);
  for (const SkinCostRow& row : rows) csv.add(skinCells(row));
  return rows;
}

}  // namespace

ExitCode runRender(int argc, char** argv) {
  CLI::App app("What does drawing many bodies cost?", "limber-bench render");
  Options options;
  addOptions(app, options);
  if (const auto end = parse(app, argc, argv)) return *end;
  if (!canWrite(options.out, kCsvName)) return kFailure;
  RowProgress progress;
  RenderResults results;
  // first, for it forks, and drivers start threads
  if (wants(options, "memory")) results.memory = memoryPart(options);
  if (wants(options, "frames")) results.frames = framesPart(options, progress);
  if (wants(options, "skins")) results.skins = skinPart(options, progress);
  if (wants(options, "png")) results.png = pngPart(options, progress);
  publish(summariseRender(results) + renderTargets(results), options.out + "/render.txt");
  return kSuccess;
}

}  // namespace limber::bench
