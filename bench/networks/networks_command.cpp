// SPDX-License-Identifier: Zlib
#include "command_list.h"

#include "command_line.h"
#include "csv_table.h"
#include "networks/networks_summary.h"
#include "networks/return_table.h"
#include "row_progress.h"
#include "text_format.h"

#include <CLI/CLI.hpp>

namespace limber::bench {
namespace {

constexpr const char* kCsvName = "networks.csv";

struct Options {
  std::string out = "out/bench";
  std::string mesh, rule;  ///< parts of what is to be measured; empty: all
  bool quick = false, models = false;
  std::uint32_t runs = 0;
  std::uint64_t seed = ReturnQuestion{}.seed;
};

bool has(const std::string& name, const std::string& part) { return name.find(part) != std::string::npos; }

/// Cooked and let go in fractions of a second.
bool isSmall(const std::string& mesh) {
  for (const char* name : {"cube8", "cube26", "ico42", "lshape90"})
    if (mesh == name) return true;
  return false;
}

std::vector<network_shapes::NamedShape> shapesOf(const Options& options) {
  std::vector<network_shapes::NamedShape> shapes;
  for (const network_shapes::NamedShape& shape : network_shapes::solids()) {
    const std::string name = shape.name;
    if (!has(name, options.mesh) || (options.quick && !isSmall(name))) continue;
    shapes.push_back(shape);
  }
  return shapes;
}

std::vector<NetworkRow> measureAll(const Options& options) {
  CsvTable csv(options.out + "/" + kCsvName, networkColumns());
  RowProgress progress;
  std::vector<NetworkRow> rows;
  const auto shapes = shapesOf(options);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    NetworkRow pipeline;
    for (const std::string& rule : braceRules()) {
      // random sets as many braces as the pipeline
      const bool needed = rule == "pipeline" && has("random", options.rule);
      if (!has(rule, options.rule) && !needed) continue;
      const std::string name = shapes[i].name + (" " + rule);
      progress.show(name, double(i) / double(shapes.size()));
      const std::uint32_t runs = options.runs > 0 ? options.runs : options.quick ? 20 : 100;
      rows.push_back(measureReturns({shapes[i], rule, runs, options.seed}, &pipeline));
      if (rule == "pipeline") pipeline = rows.back();
      csv.add(networkCells(rows.back()));
      progress.finish(name);
    }
  }
  return rows;
}

}  // namespace

ExitCode runNetworks(int argc, char** argv) {
  CLI::App app("Which springs keep which shape?", "limber-bench networks");
  Options options;
  app.add_option("--out", options.out, "folder of networks.csv and networks.txt (default out/bench)");
  app.add_option("--mesh", options.mesh, "only shapes whose name has this in it");
  app.add_option("--rule", options.rule, "only rules whose name has this in it");
  app.add_option("--runs", options.runs, "runs per shape and rule (default 100, quick 20)");
  app.add_option("--seed", options.seed, "of the deformations (default 1000)");
  app.add_flag("--models", options.models, "only the difficult meshes of meshes/, cooked by cook()");
  app.add_flag("--quick", options.quick, "four small shapes and 20 runs of each");
  if (const auto end = parse(app, argc, argv)) return *end;
  if (!canWrite(options.out, kCsvName)) return kFailure;
  NetworkResults results;
  const std::uint32_t modelRuns = options.runs > 0 ? options.runs : 100;
  if (options.models) {
    const std::vector<ModelRow> models = measureModels(options.mesh, modelRuns);
    publish(modelTable(models) + "\ntargets\n" + modelTargets(models), options.out + "/models.txt");
    return kSuccess;
  }
  results.counts = measureCounts();
  results.networks = measureAll(options);
  results.masses = measureMasses();
  results.skins = measureSkins(options.quick);
  results.materials = measureMaterials(options.quick);
  if (!options.quick && options.mesh.empty() && options.rule.empty()) {
    results.large = measureLarge();
    results.models = measureModels({}, modelRuns);
  }
  publish(summariseNetworks(results), options.out + "/networks.txt");
  return kSuccess;
}

}  // namespace limber::bench
