// SPDX-License-Identifier: Zlib
#include "accuracy/accuracy_scene.h"
#include "bullet_soft/body_start.h"
#include "results.h"
#include "timing.h"

#include <algorithm>
#include <chrono>

namespace limber::bench {
namespace {

using Clock = std::chrono::steady_clock;  // a tick can take a microsecond, so the clock must be fast

constexpr double kUsualTick = 1.0 / 60;
constexpr double kMaxDistance = 1e4;  // m, larger than any scene

BodySetup shifted(BodySetup body, int copy) {
  const Eigen::Vector3d offset(0, 0, 20.0 * copy);
  body.settings.position += offset;
  if (body.positions.size()) body.positions.colwise() += offset;
  return body;
}

double manifoldImpulse(const btDiscreteDynamicsWorld& world) {
  const btDispatcher& dispatcher = *world.getDispatcher();
  double impulse = 0.0;
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold =
        *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(m);
    for (int p = 0; p < manifold.getNumContacts(); ++p)
      impulse += double(manifold.getContactPoint(p).getAppliedImpulse());
  }
  return impulse;
}

/// Plays one scene with one engine and measures the time of its ticks.
class Stage {
 public:
  /// Throws std::runtime_error if the engine does not support the scene.
  Stage(const Scene& scene, const EngineChoice& choice, double dt)
      : scene_(scene), dt_(dt), ticks_(static_cast<int>(std::lround(scene.seconds / dt))) {
    Scenario copies = scene;
    for (int copy = 1; copy < scene.copies; ++copy)
      for (const BodySetup& body : scene.bodies) copies.bodies.push_back(shifted(body, copy));
    engine_ = open(copies, choice, dt, rigid_);
    trace_.dt = dt;
    record();
  }

  bool over() const { return lost_ || tick_ >= ticks_; }
  void advance(int ticks) {
    for (; ticks > 0 && !over(); --ticks) {
      const auto start = Clock::now();
      engine_->tick(dt_);
      const double tick = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
      tickMicroseconds_.push_back(tick / scene_.copies);
      if (engine_->stepMicroseconds() >= 0.0)
        stepMicroseconds_.push_back(engine_->stepMicroseconds() / scene_.copies);
      ++tick_;
      record();
    }
  }

  const Trace& trace() const { return trace_; }
  bool lost() const { return lost_; }  ///< a point has flown to infinity
  /// Of the last frame, bit for bit.
  std::uint64_t hash() const {
    std::uint64_t hash = kHashStart;
    for (const auto& points : trace_.last().positions) addToHash(hash, points);
    for (const auto& speeds : trace_.last().velocities) addToHash(hash, speeds);
    return hash;
  }
  const std::vector<double>& tickMicroseconds() const { return tickMicroseconds_; }
  const std::vector<double>& stepMicroseconds() const { return stepMicroseconds_; }  ///< empty if unknown

 private:
  Frame currentFrame() const {
    Frame frame{statesOf(scene_, *engine_), {}, 0.0};
    for (const auto& body : rigid_.bodies)
      if (!body->isStaticObject()) frame.boxes.push_back(fromBullet(body->getWorldTransform().getOrigin()));
    frame.contactImpulse = manifoldImpulse(engine_->world()) + engine_->untoldImpulse();
    return frame;
  }
  void record() {
    Frame frame = currentFrame();
    lost_ = isLost(frame, kMaxDistance);
    const double remaining = (ticks_ - tick_ + 1) * dt_;  // s, from the previous frame to the scene's end
    if (remaining > scene_.keepSeconds + 0.5 * dt_) trace_.frames.clear();
    trace_.frames.push_back(std::move(frame));
  }

  const Scene& scene_;
  RigidBodies rigid_;  // declared before the engine, whose world refers to them
  std::unique_ptr<Engine> engine_;
  double dt_;
  int tick_ = 0, ticks_;
  bool lost_ = false;
  Trace trace_;
  std::vector<double> tickMicroseconds_, stepMicroseconds_;
};

// --- measurement ---

/// A run of one engine in a scene.
struct Run {
  EngineChoice choice;
  std::unique_ptr<Stage> stage;
};

/// Returns Limber with Verlet and `factor` times the substeps that the scene's first body needs.
EngineChoice withSubsteps(const Scene& scene, double dt, int factor) {
  const int count = factor * stableSubsteps(scene.bodies[0], dt);
  return limberChoice(format("Verlet, %d x substeps", factor), [count](SoftBodySettings& s) {
    s.stepping.stepper = Stepper::Verlet;
    s.stepping.minSubsteps = count;
  });
}

EngineChoice withTolerance(double periodTolerance) {
  return limberChoice(format("period tolerance %.0e", periodTolerance),
                      [=](SoftBodySettings& s) { s.stepping.periodTolerance = periodTolerance; });
}

/// In ordered scenes Limber is also run with 2, 4, 8 ... times the substeps that it needs to be stable.
std::vector<EngineChoice> enginesOf(const Scene& scene, double dt, const Options& options) {
  std::vector<EngineChoice> engines;
  for (EngineChoice& choice : allEngines())
    if (!scene.limberOnly || choice.isLimber()) engines.push_back(std::move(choice));
  if (scene.periodTolerance > 0.0) engines.push_back(withTolerance(scene.periodTolerance));
  const int finest = std::abs(dt - kUsualTick) < 1e-9 ? scene.finest : std::min(scene.finest, 8);
  for (int factor = 2; scene.ordered && factor <= finest; factor *= 2)
    engines.push_back(withSubsteps(scene, dt, factor));
  return wantedEngines(engines, options);
}

/// Engines that do not support the scene are left out.
std::vector<Run> openRuns(const Scene& scene, double dt, const Options& options) {
  std::vector<Run> runs;
  for (const EngineChoice& choice : enginesOf(scene, dt, options)) {
    try {
      runs.push_back({choice, std::make_unique<Stage>(scene, choice, dt)});
    } catch (const std::runtime_error& error) {
      std::fprintf(stderr, "no %s, %s in %s: %s\n", choice.engine.c_str(), choice.setting.c_str(),
                   scene.name.c_str(), error.what());
    }
  }
  return runs;
}

/// The engines take turns of a few ticks, so that the load of the machine is the same for all.
void playAll(std::vector<Run>& runs, const Scene& scene, double dt, Progress& progress) {
  constexpr int kTicksPerTurn = 8;
  bool playing = true;
  for (double done = 0; playing; done += kTicksPerTurn) {
    playing = false;
    for (Run& run : runs) {
      if (run.stage->over()) continue;
      run.stage->advance(kTicksPerTurn);
      playing = true;
    }
    progress.show(scene.name, std::min(1.0, done * dt / scene.seconds));
  }
}

const char* unitOf(const std::string& measure) {
  const bool isLength = measure == "height" || measure == "creep" || measure == "hop";
  return isLength ? "m" : "";
}

void addRows(const Run& run, const Scene& scene, double dt, Results& results) {
  const Stage& stage = *run.stage;
  const Subject subject{scene.kind == Kind::Free ? "free motion" : "with contacts", scene.name,
                        run.choice.engine, run.choice.setting, 1.0 / dt};
  for (const Measure& measure : scene.measures) {
    const double error = stage.lost() ? kLost : measure.error(stage.trace());
    if (!std::isnan(error)) results.add(subject, "error of " + measure.name, unitOf(measure.name), error);
    if (stage.lost()) break;  // one error is enough
  }
  results.add(subject, "tick", "us", stage.tickMicroseconds());
  if (run.choice.isLimber()) results.add(subject, "springs", "us", stage.stepMicroseconds());
  results.note(subject, "hash", hexText(stage.hash()));
}

std::vector<SceneMaker> wantedMakers(const Options& options) {
  std::vector<SceneMaker> all = freeScenes(options.quick);
  for (SceneMaker& maker : contactScenes(options.quick)) all.push_back(std::move(maker));
  return wantedScenes(std::move(all), options);
}

void runAccuracy(const Options& options, Results& results) {
  const std::vector<double> quick = {30, 60}, all = {30, 60, 120, 240};
  Progress progress;
  for (const SceneMaker& maker : wantedMakers(options)) {
    Scene scene = maker.make();
    scene.name = maker.name;
    if (!scene.remark.empty()) results.note({"remarks", scene.name, "", ""}, "remark", scene.remark);
    for (const double rate : options.numbers("ticks", options.quick ? quick : all)) {
      std::vector<Run> runs = openRuns(scene, 1.0 / rate, options);
      playAll(runs, scene, 1.0 / rate, progress);
      for (const Run& run : runs) addRows(run, scene, 1.0 / rate, results);
    }
    progress.finish(scene.name);
  }
}

}  // namespace

Bench accuracyBench() {
  return {"accuracy",
          "errors and times in scenes with a known outcome",
          "3 minutes",
          withEngineKeys({{"ticks", "ticks per second", 1, 10000, true}}),
          [](const Options& options) { return namesOf(wantedMakers(options)); },
          &runAccuracy};
}

}  // namespace limber::bench
