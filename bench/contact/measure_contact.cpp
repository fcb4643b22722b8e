// SPDX-License-Identifier: Zlib
#include "contact/measure_contact.h"

#include "contact/contact_stage.h"
#include "sample_stats.h"

#include <stdexcept>

namespace limber::bench {
namespace {

/// The results of one repeat of one engine.
struct Sample {
  double median = 0.0, worst = 0.0, wall = 0.0, penetration = 0.0, speed = 0.0, asleep = 0.0, stretch = 0.0;
};

struct Run {
  const ContactEngine* engine = nullptr;
  std::unique_ptr<ContactStage> stage;  // of the current repeat
  std::vector<Sample> samples;          // #repeats; fewer if it was given up
  std::string error;
};

bool takesPart(const ContactScene& scene, const ContactEngine& engine) {
  return (scene.withOthers || !engine.isOther) && (scene.withBudgets || !engine.isBudget);
}

std::vector<Run> runsOf(const ContactScene& scene, const std::vector<ContactEngine>& engines) {
  std::vector<Run> runs;
  for (const ContactEngine& engine : engines) {
    if (!takesPart(scene, engine)) continue;
    Run& run = runs.emplace_back();
    run.engine = &engine;
    if (scene.sleeps() && !engine.sleeps) run.error = "never sleeps";
  }
  return runs;
}

void open(Run& run, const ContactScene& scene) {
  run.stage.reset();
  if (!run.error.empty()) return;
  try {
    run.stage = std::make_unique<ContactStage>(scene, *run.engine);
  } catch (const std::runtime_error& error) {
    run.error = error.what();
  }
}

void runAll(std::vector<Run>& runs, const ContactScene& scene, const ContactLimits& limits, int repeat,
            RowProgress& progress) {
  const int turns = (scene.settleTicks + scene.measuredTicks + scene.turn - 1) / scene.turn;
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      Run& run = runs[(i + static_cast<std::size_t>(turn + repeat)) % runs.size()];
      if (run.stage && !run.stage->over()) run.stage->advance(scene.turn, limits.timeLimit);
    }
    progress.show(scene.name, (repeat + double(turn + 1) / turns) / limits.repeats);
  }
}

void storeSample(Run& run) {
  if (!run.stage) return;
  const ContactStage& stage = *run.stage;
  run.error = stage.error();
  if (run.error.empty())
    run.samples.push_back({median(stage.ticks()), largest(stage.ticks()), median(stage.wallTicks()),
                           stage.deepestPenetration(), stage.residualSpeed(), stage.asleep(),
                           stage.stretch()});
  run.stage.reset();
}

double medianOf(const Run& run, double Sample::*value) {
  std::vector<double> all;
  for (const Sample& sample : run.samples) all.push_back(sample.*value);
  return median(all);
}

/// Returns the ratio of medians in the same repeats; empty if the other engine did not run.
std::optional<double> ratioOf(const Run& run, const std::vector<Run>& runs, bool ContactEngine::*mark) {
  for (const Run& reference : runs) {
    if (!(reference.engine->*mark) || !reference.error.empty() || !run.error.empty()) continue;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < run.samples.size(); ++i)
      ratios.push_back(run.samples[i].median / reference.samples[i].median);
    return median(ratios);
  }
  return std::nullopt;
}

std::size_t pointsOf(const ContactScene& scene) {
  std::size_t points = 0;
  for (const BodySetup& body : scene.bodies) points += body.network->restPoints.size();
  return points;
}

ContactRow rowOf(const Run& run, const std::vector<Run>& runs, const ContactScene& scene) {
  ContactRow row;
  row.scene = scene.name, row.engine = run.engine->name;
  row.role = scene.role, row.crowd = scene.crowd;
  row.bodies = scene.bodies.size(), row.points = pointsOf(scene);
  row.repeats = static_cast<int>(run.samples.size());
  row.tickMedian = medianOf(run, &Sample::median);
  row.tickWorst = medianOf(run, &Sample::worst);
  row.wallMedian = medianOf(run, &Sample::wall);
  row.penetration = medianOf(run, &Sample::penetration) / scene.size;
  row.residualSpeed = medianOf(run, &Sample::speed);
  row.asleep = medianOf(run, &Sample::asleep);
  row.stretch = medianOf(run, &Sample::stretch);
  row.hasSprings = !run.engine->isSpheres;
  row.toSoftBody = ratioOf(run, runs, &ContactEngine::isReference);
  row.toSpheres = ratioOf(run, runs, &ContactEngine::isSpheres);
  row.error = run.error;
  return row;
}

}  // namespace

std::vector<ContactRow> measureContact(const ContactScene& scene, const std::vector<ContactEngine>& engines,
                                       const ContactLimits& limits, RowProgress& progress) {
  std::vector<Run> runs = runsOf(scene, engines);
  for (int repeat = 0; repeat < limits.repeats; ++repeat) {
    for (Run& run : runs) open(run, scene);
    runAll(runs, scene, limits, repeat, progress);
    for (Run& run : runs) storeSample(run);
  }
  std::vector<ContactRow> rows;
  for (const Run& run : runs) rows.push_back(rowOf(run, runs, scene));
  return rows;
}

}  // namespace limber::bench
