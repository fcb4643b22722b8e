// SPDX-License-Identifier: Zlib
#include "accuracy/stage.h"

#include "accuracy/accuracy_row.h"
#include "engines/limber_engine.h"
#include "sample_stats.h"
#include "text_format.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace limber::bench {
namespace {

constexpr int kTicksPerTurn = 8;  // ticks that each engine plays in turn

struct Run {
  EngineChoice choice;
  int substeps = 1;
  std::unique_ptr<Stage> stage;  // nullptr: this engine does not support the scene
};

/// Returns Limber with Verlet and `factor` times the substeps that the scene's first body needs.
EngineChoice withSubsteps(const Scene& scene, double dt, int factor) {
  const int count = factor * stableSubsteps(scene.bodies[0], dt);
  const auto tune = [count](SoftBodySettings& s) {
    s.stepping.stepper = Stepper::Verlet;
    s.stepping.minSubsteps = count;
  };
  return {"limber", "verlet x" + std::to_string(factor), [tune](double) { return makeLimberEngine(tune); }};
}

EngineChoice withTolerance(double periodTolerance) {
  const auto tune = [periodTolerance](SoftBodySettings& s) { s.stepping.periodTolerance = periodTolerance; };
  return {"limber", format("auto %.0e", periodTolerance), [tune](double) { return makeLimberEngine(tune); }};
}

std::vector<Run> runsOf(const Scene& scene, double dt) {
  std::vector<Run> runs;
  for (EngineChoice& choice : allEngines())
    if (!scene.limberOnly || choice.engine == "limber") runs.push_back({choice, 1, nullptr});
  if (scene.periodTolerance > 0.0) runs.push_back({withTolerance(scene.periodTolerance), 1, nullptr});
  const int finest = std::abs(dt - kUsualTick) < 1e-9 ? scene.finest : std::min(scene.finest, 8);
  for (int factor = 2; scene.ordered && factor <= finest; factor *= 2)
    runs.push_back({withSubsteps(scene, dt, factor), factor, nullptr});
  return runs;
}

void makeStage(Run& run, const Scene& scene, double dt) {
  try {
    run.stage = std::make_unique<Stage>(scene, run.choice, dt);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "no %s %s in %s: %s\n", run.choice.engine.c_str(), run.choice.setting.c_str(),
                 scene.name.c_str(), error.what());
  }
}

void playAll(std::vector<Run>& runs, const Scene& scene, double dt, RowProgress& progress) {
  const double ticks = scene.seconds / dt;
  bool playing = true;
  for (double done = 0; playing; done += kTicksPerTurn) {
    playing = false;
    for (Run& run : runs) {
      if (!run.stage || run.stage->over()) continue;
      run.stage->advance(kTicksPerTurn);
      playing = true;
    }
    progress.show(scene.name, std::min(1.0, done / ticks));
  }
}

/// Returns the distance from the median below which half of the samples lie.
double spread(std::vector<double> samples) {
  const double middle = median(samples);
  for (double& sample : samples) sample = std::abs(sample - middle);
  return median(samples);
}

std::vector<AccuracyRow> rowsOf(const Run& run, const Scene& scene, double dt) {
  const Stage& stage = *run.stage;
  AccuracyRow row;
  row.scene = scene.name, row.kind = scene.kind, row.dt = dt;
  row.engine = run.choice.engine, row.setting = run.choice.setting, row.substeps = run.substeps;
  row.ordered = scene.ordered;
  row.tickMicroseconds = median(stage.tickMicroseconds());
  row.noise = spread(stage.tickMicroseconds());
  row.stepMicroseconds =
      stage.stepMicroseconds().empty() ? row.tickMicroseconds : median(stage.stepMicroseconds());
  row.hash = stage.hash();
  std::vector<double> errors(scene.measures.size(), kLost);
  if (stage.lost())
    errors.resize(1);  // one row is enough: all measures are lost
  else
    errors = scene.judge(stage.trace());
  std::vector<AccuracyRow> rows;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (std::isnan(errors[i])) continue;  // this engine has no such measure
    row.measure = scene.measures[i];
    row.error = errors[i];
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

std::vector<AccuracyRow> measureScene(const Scene& scene, const std::vector<double>& ticks,
                                      RowProgress& progress) {
  std::vector<AccuracyRow> rows;
  for (const double dt : ticks) {
    std::vector<Run> runs = runsOf(scene, dt);
    for (Run& run : runs) makeStage(run, scene, dt);
    playAll(runs, scene, dt, progress);
    for (const Run& run : runs)
      if (run.stage)
        for (AccuracyRow& row : rowsOf(run, scene, dt)) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace limber::bench
