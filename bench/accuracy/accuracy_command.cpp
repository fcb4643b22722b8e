// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "accuracy/accuracy_report.h"
#include "accuracy/accuracy_row.h"
#include "accuracy/bodies.h"
#include "accuracy/scene.h"
#include "accuracy/stage.h"
#include "command_line.h"
#include "csv_table.h"
#include "text_format.h"

#include <CLI/CLI.hpp>

#include <cstdio>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "accuracy.csv";

struct Options {
  std::string out = "out/bench";
  bool quick = false;
  std::string scene;  ///< part of the names of the scenes to play; empty: all
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("--out", options.out, "folder of accuracy.csv and accuracy.txt (default out/bench)");
  app.add_flag("--quick", options.quick, "fewer scenes, ticks of 1/30 and 1/60 s alone");
  app.add_option("--scene", options.scene, "only scenes whose name has this in it");
}

std::vector<double> ticksOf(const Options& options) {
  if (options.quick) return {1.0 / 30, 1.0 / 60};
  return {1.0 / 30, 1.0 / 60, 1.0 / 120, 1.0 / 240};
}

std::vector<Scene> allScenes(bool quick) {
  std::vector<Scene> scenes;
  addOscillators(scenes, quick);
  addChains(scenes, quick);
  addWaves(scenes, quick);
  addFreeShapes(scenes, quick);
  addImpacts(scenes, quick);
  addResting(scenes, quick);
  addRigidPartners(scenes, quick);
  return scenes;
}

std::vector<Scene> scenesOf(const Options& options) {
  std::vector<Scene> scenes;
  for (Scene& scene : allScenes(options.quick))
    if (scene.name.find(options.scene) != std::string::npos) scenes.push_back(std::move(scene));
  return scenes;
}

/// Returns one line about a played scene: the first error at the usual tick.
std::string describe(const Scene& scene, const Rows& rows) {
  const auto bestOf = [&](const std::string& engine) {
    const auto row = best(select(rows, [&](const AccuracyRow& r) {
      return isUsual(r) && r.measure == scene.measures[0] && r.engine == engine &&
             (engine != "limber" || r.setting == "auto");
    }));
    return row ? format("  %s %.1e", engine.c_str(), row->error) : std::string();
  };
  return format("%-29s %-12s", scene.name.c_str(), scene.measures[0].c_str()) + bestOf("limber") +
         bestOf("btSoftBody") + bestOf("btDeformable");
}

void measureAll(const Options& options, const std::vector<Scene>& scenes, std::vector<AccuracyRow>& rows) {
  CsvTable csv(options.out + "/" + kCsvName, accuracyColumns());
  RowProgress progress;
  for (const Scene& scene : scenes) {
    const std::vector<AccuracyRow> sceneRows = measureScene(scene, ticksOf(options), progress);
    for (const AccuracyRow& row : sceneRows) csv.add(accuracyCells(row));
    rows.insert(rows.end(), sceneRows.begin(), sceneRows.end());
    progress.finish(describe(scene, sceneRows));
  }
}

}  // namespace

ExitCode runAccuracy(int argc, char** argv) {
  CLI::App app("How far off are soft bodies, and what does a tick cost?", "limber-bench accuracy");
  Options options;
  addOptions(app, options);
  if (const auto end = parse(app, argc, argv)) return *end;
  if (!canWrite(options.out, kCsvName)) return kFailure;
  const std::vector<Scene> scenes = scenesOf(options);
  if (scenes.empty()) {
    std::fprintf(stderr, "limber-bench: no scene has \"%s\" in its name\n", options.scene.c_str());
    return kUsage;
  }
  std::vector<AccuracyRow> rows;
  measureAll(options, scenes, rows);
  const std::string summary = summariseAccuracy(scenes, rows);
  publish(summary, options.out + "/accuracy.txt");
  return kSuccess;
}

}  // namespace limber::bench
