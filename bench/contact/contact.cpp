// SPDX-License-Identifier: Zlib
#include "contact/contact.h"
#include "results.h"
#include "scenes/overlap.h"
#include "timing.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace limber::bench {

// --- a scene in an engine ---

namespace {

constexpr double kFar = 1e3;  // m, from the origin

/// s of the thread per tick after the first, which initialises. Engines a hundred times too slow are stopped.
constexpr double kTooSlow = 2.0;

std::vector<Eigen::Matrix3Xd> allPositions(const Engine& engine, std::size_t count) {
  std::vector<Eigen::Matrix3Xd> all;
  for (std::size_t b = 0; b < count; ++b) all.push_back(engine.positions(b));
  return all;
}

}  // namespace

ContactStage::ContactStage(const ContactScene& scene, const EngineChoice& choice)
    : scene_(scene), solids_(choice.engine != kLooseSpheres) {
  engine_ = open(scene, choice, {kContactTick, scene.role == Role::Pile}, rigid_);
  for (const BodySetup& body : scene.bodies) points_ += body.network->restPoints.size();
}

void ContactStage::tick() {
  if (done_ + 1 == scene_.settleTicks + scene_.measuredTicks)
    before_ = allPositions(*engine_, scene_.bodies.size());
  const Stopwatch watch;
  engine_->tick(kContactTick);
  const WorkTime time = watch.time();
  seconds_ += 1e-3 * time.cpuMs;
  if (done_ > 0) laterSeconds_ += 1e-3 * time.cpuMs;
  if (done_++ < scene_.settleTicks) return;
  ticks_.push_back(time.cpuMs);
  wallTicks_.push_back(time.wallMs);
}

/// Fails a scene whose bodies have left it: their times are meaningless.
void ContactStage::checkPlaces() {
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Eigen::Matrix3Xd x = engine_->positions(b);
    if (!x.allFinite() || x.cwiseAbs().maxCoeff() > kFar) error_ = "flies apart";
    for (Eigen::Index i = 0; error_.empty() && i < x.cols(); ++i)
      if (scene_.distance(x.col(i)) < -scene_.size) error_ = "goes through what it should lie on";
  }
}

void ContactStage::advance(int ticks, double timeLimit) {
  for (int i = 0; i < ticks && !over(); ++i) {
    tick();
    const bool tooSlow = laterSeconds_ > kTooSlow * std::max(1, done_ - 1);
    if ((tooSlow || seconds_ > timeLimit) && !over())
      error_ = format("given up after %d ticks: %.0f ms each", done_, 1e3 * seconds_ / done_);
  }
  if (error_.empty()) checkPlaces();
}

double ContactStage::deepestPenetration() const {
  double deepest = 0.0;
  std::vector<scenes::PosedSurface> surfaces;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const BodySetup& body = scene_.bodies[b];
    const Eigen::Matrix3Xd x = engine_->positions(b);
    const double radius = pointRadius(*body.network, body.settings);
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      deepest = std::max(deepest, radius - scene_.distance(x.col(i)));
    if (solids_ && scene_.role == Role::Pile) surfaces.push_back(scenes::posed(x, body.network->surface));
  }
  return std::max(deepest, scenes::deepestOverlap(surfaces).depth);
}

double ContactStage::stretch() const {
  double sum = 0.0, count = 0.0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const SpringNetwork& network = *scene_.bodies[b].network;
    const Eigen::Vector3d& scale = scene_.bodies[b].settings.scale;
    const Eigen::Matrix3Xd x = engine_->positions(b);
    for (const NetworkSpring& spring : network.springs) {
      if (spring.kind != SpringKind::Structural) continue;
      const Eigen::Vector3d rest = network.restPoints[spring.b] - network.restPoints[spring.a];
      const double strain =
          (x.col(spring.b) - x.col(spring.a)).norm() / rest.cwiseProduct(scale).norm() - 1.0;
      sum += strain * strain, ++count;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

double ContactStage::residualSpeed() const {
  double sum = 0.0;
  for (std::size_t b = 0; b < before_.size(); ++b) sum += (engine_->positions(b) - before_[b]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(points_)) / kContactTick;
}

// --- engines ---

namespace {

/// Returns btSoftBody with links as stiff as the springs. It does not sleep in btSoftRigidDynamicsWorld.
EngineChoice softBody(const std::string& setting, int iterations, std::optional<SoftContacts> contacts = {},
                      double hardness = kHardContacts) {
  return {"btSoftBody", setting, [=](const EngineUse& use) {
            const SoftContacts cheapest =
                use.bodiesTouch ? SoftContacts::PointsAndFaces : SoftContacts::Points;
            return makeSoftBodyEngine(use.dt, iterations, LinkStiffness::Calibrated,
                                      contacts.value_or(cheapest), hardness);
          }};
}

EngineChoice looseSpheres() {
  return {kLooseSpheres, "", [](const EngineUse&) { return makeBareEngine(); }};
}

/// Returns btSoftBody with 4 iterations and each kind of contacts.
std::vector<EngineChoice> contactFlags() {
  return {softBody("SDF_RS", 4, SoftContacts::Points),
          softBody("SDF_RS | VF_SS", 4, SoftContacts::PointsAndFaces),
          softBody("VF_SS with kKHR 0.1", 4, SoftContacts::PointsAndFaces, kBulletsHardness),
          softBody("SDF_RS | CL_SS", 4, SoftContacts::PointsAndClusters),
          softBody("CL_RS | CL_SS", 4, SoftContacts::Clusters),
          looseSpheres()};
}

/// Times are also given relative to this engine's.
bool isReference(const EngineChoice& choice) {
  return choice.engine == "btSoftBody" &&
         (choice.setting == iterationsText(4) || choice.setting == "SDF_RS | VF_SS");
}

bool isBudget(const EngineChoice& choice) { return choice.setting.rfind("at most", 0) == 0; }

}  // namespace

EngineChoice usersLimber(const std::string& setting, const TuneSettings& tune,
                         const ParallelFor& parallelFor) {
  const auto tuned = [tune](SoftBodySettings& settings) {
    settings.volumeModulus = SoftBodySettings().volumeModulus;
    if (tune) tune(settings);
  };
  return limberChoice(setting, tuned, parallelFor);
}

std::vector<EngineChoice> contactEngines() {
  std::vector<EngineChoice> engines = {
      usersLimber("default"),
      usersLimber("Stepping::fast()", [](SoftBodySettings& s) { s.stepping = Stepping::fast(); }),
      usersLimber("Collision::Points", [](SoftBodySettings& s) { s.collision = Collision::Points; })};
  for (const int substeps : {5, 10, 20, 40})
    engines.push_back(usersLimber("at most " + std::to_string(substeps) + " substeps",
                                  [substeps](SoftBodySettings& s) { s.stepping.maxSubsteps = substeps; }));
  for (const int iterations : {1, 4, 10}) engines.push_back(softBody(iterationsText(iterations), iterations));
  engines.push_back(
      {"btDeformable", "implicit", [](const EngineUse&) { return makeDeformableEngine(true); }});
  engines.push_back(looseSpheres());
  return engines;
}

// --- memory ---

namespace {

/// Returns the bytes of heap that the program uses.
std::optional<double> heapBytes() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
#else
  return std::nullopt;
#endif
}

constexpr double kLatticeSpacing = 1.0;                   // m: the broadphase sees no pairs
constexpr double kBondReach = 1.1, kDiagonalReach = 1.5;  // spacings: 6 or 18 neighbours

/// Returns the bytes of each of `count` bodies of a network.
double bytesOfBody(const SharedNetwork& network, int count) {
  const auto engine = makeLimberEngine();
  BodySetup body = bodyOf(network, 1.0, 100.0, 1.0);
  engine->addBody(body);
  for (int i = 0; i < 4; ++i) engine->tick(kContactTick);
  const double before = *heapBytes();
  for (int i = 0; i < count; ++i) {
    body.settings.position.x() += 10.0 * kLatticeSpacing;
    engine->addBody(body);
  }
  for (int i = 0; i < 4; ++i) engine->tick(kContactTick);
  return (*heapBytes() - before) / count;
}

}  // namespace

std::optional<MemoryUse> measureMemory(bool quick) {
  if (!heapBytes()) return std::nullopt;
  const int count = quick ? 4 : 32;
  Eigen::Matrix3d counts;  // points, springs and 1 of three bodies
  Eigen::Vector3d bytes;
  const SharedNetwork networks[] = {latticeNetwork(4, 4, 4, kLatticeSpacing, kBondReach),
                                    latticeNetwork(4, 4, 4, kLatticeSpacing, kDiagonalReach),
                                    latticeNetwork(7, 7, 7, kLatticeSpacing, kBondReach)};
  for (int i = 0; i < 3; ++i) {
    counts.row(i) << double(networks[i]->restPoints.size()), double(networks[i]->springs.size()), 1.0;
    bytes[i] = bytesOfBody(networks[i], count);
  }
  const Eigen::Vector3d use = counts.inverse() * bytes;
  return MemoryUse{use[0], use[1], use[2], double(sizeof(NetworkSpring))};
}

// --- measurement ---

namespace {

/// The results of the repeats of one engine; fewer if it was given up.
struct Run {
  EngineChoice choice;
  std::unique_ptr<ContactStage> stage;  // of the current repeat
  std::vector<double> tick, worst, wall, depth, speed, asleep, strain;
  std::string error;

  bool isSpheres() const { return choice.engine == kLooseSpheres; }
};

bool takesPart(const ContactScene& scene, const EngineChoice& choice) {
  const bool isOther = !choice.isLimber() && choice.engine != kLooseSpheres;
  return (scene.withOthers || !isOther) && (scene.withBudgets || !isBudget(choice));
}

std::vector<Run> runsOf(const ContactScene& scene, const std::vector<EngineChoice>& engines) {
  std::vector<Run> runs;
  for (const EngineChoice& choice : engines) {
    if (!takesPart(scene, choice)) continue;
    runs.emplace_back().choice = choice;
    if (scene.sleeps() && choice.engine == "btSoftBody") runs.back().error = "never sleeps";
  }
  return runs;
}

void open(Run& run, const ContactScene& scene) {
  run.stage.reset();
  if (!run.error.empty()) return;
  try {
    run.stage = std::make_unique<ContactStage>(scene, run.choice);
  } catch (const std::runtime_error& error) {
    run.error = error.what();
  }
}

/// Runs all engines in turns of some ticks. The order rotates with each turn and each repeat.
void playRepeat(std::vector<Run>& runs, const ContactScene& scene, double timeLimit, int repeat) {
  const int turns = (scene.settleTicks + scene.measuredTicks + scene.turn - 1) / scene.turn;
  for (int turn = 0; turn < turns; ++turn)
    for (std::size_t i = 0; i < runs.size(); ++i) {
      Run& run = runs[(i + static_cast<std::size_t>(turn + repeat)) % runs.size()];
      if (run.stage && !run.stage->over()) run.stage->advance(scene.turn, timeLimit);
    }
}

void storeRepeat(Run& run, const ContactScene& scene) {
  if (!run.stage) return;
  const ContactStage& stage = *run.stage;
  run.error = stage.error();
  if (run.error.empty()) {
    run.tick.push_back(median(stage.ticks()));
    run.worst.push_back(largest(stage.ticks()));
    run.wall.push_back(median(stage.wallTicks()));
    run.depth.push_back(100.0 * stage.deepestPenetration() / scene.size);
    run.speed.push_back(stage.residualSpeed());
    run.asleep.push_back(100.0 * stage.asleep());
    run.strain.push_back(100.0 * stage.stretch());
  }
  run.stage.reset();
}

/// Returns the ratios of the ticks in the same repeats; empty if the other engine did not run.
std::vector<double> ratios(const Run& run, const std::vector<Run>& runs, bool toSpheres) {
  std::vector<double> all;
  for (const Run& other : runs)
    if (other.error.empty() && (toSpheres ? other.isSpheres() : isReference(other.choice)))
      for (std::size_t i = 0; i < run.tick.size(); ++i) all.push_back(run.tick[i] / other.tick[i]);
  return all;
}

void addRows(const Run& run, const std::vector<Run>& runs, const ContactScene& scene, Results& results) {
  const Subject subject{nameOf(scene.role), scene.name, run.choice.engine, run.choice.setting,
                        1.0 / kContactTick};
  if (!run.error.empty()) return results.note(subject, "no result", run.error);
  double points = 0.0;
  for (const BodySetup& body : scene.bodies) points += static_cast<double>(body.network->restPoints.size());
  results.add(subject, "bodies", "", static_cast<double>(scene.bodies.size()));
  results.add(subject, "points", "", points);
  results.add(subject, "tick", "ms", run.tick);
  results.add(subject, "worst tick", "ms", run.worst);
  results.add(subject, "tick, wall time", "ms", run.wall);
  results.add(subject, "tick per point", "us", 1e3 * median(run.tick) / points);
  if (const auto all = ratios(run, runs, false); !all.empty())
    results.add(subject, "tick over btSoftBody's", "", all);
  if (const auto all = ratios(run, runs, true); !all.empty())
    results.add(subject, "tick over loose spheres'", "", all);
  results.add(subject, "deepest penetration", "% of size", run.depth);
  if (scene.rests()) results.add(subject, "residual speed", "m/s", run.speed);
  if (!run.isSpheres()) results.add(subject, "strain", "%", run.strain);
  results.add(subject, "asleep", "%", run.asleep);
}

void addMemory(const std::optional<MemoryUse>& use, Results& results) {
  const Subject subject{"memory", "", "Limber", "default"};
  if (!use) return results.note(subject, "no result", "the C library does not report it");
  results.add(subject, "point", "B", use->perPoint);
  results.add(subject, "Bullet's rigid body of a point, once it is requested", "B",
              double(sizeof(btRigidBody)));
  results.add(subject, "spring", "B", use->perSpring);
  results.add(subject, "body", "B", use->perBody);
  results.add(subject, "spring of the network that bodies share", "B", use->networkPerSpring);
}

/// Changes the bodies of the scenes: no reference depends on them.
void changeBodies(std::vector<ContactScene>& scenes, const Options& options) {
  for (ContactScene& scene : scenes)
    for (BodySetup& body : scene.bodies) {
      SoftBodySettings& s = body.settings;
      s.extensionStiffness = options.number("stiffness", s.extensionStiffness);
      s.compressionStiffness = options.number("stiffness", s.compressionStiffness);
      s.damping = options.number("damping", s.damping);
      s.friction = options.number("friction", s.friction);
    }
}

std::vector<ContactScene> wantedContactScenes(const Options& options) {
  return wantedScenes(allContactScenes(options.quick), options);
}

void runContact(const Options& options, Results& results) {
  std::vector<ContactScene> scenes = wantedContactScenes(options);
  changeBodies(scenes, options);
  const bool flags = options.word("flags") == "yes";
  const std::vector<EngineChoice> engines = wantedEngines(flags ? contactFlags() : contactEngines(), options);
  const int repeats = static_cast<int>(options.number("repeats", 3));
  Progress progress;
  for (const ContactScene& scene : scenes) {
    std::vector<Run> runs = runsOf(scene, engines);
    for (int repeat = 0; repeat < repeats; ++repeat) {
      progress.show(scene.name, double(repeat) / repeats);
      for (Run& run : runs) open(run, scene);
      playRepeat(runs, scene, options.number("patience", 120), repeat);
      for (Run& run : runs) storeRepeat(run, scene);
    }
    for (const Run& run : runs) addRows(run, runs, scene, results);
    progress.finish(scene.name);
  }
  if (!flags && options.scene.empty() && options.wantsEngine("Limber"))
    addMemory(measureMemory(options.quick), results);
}

}  // namespace

Bench contactBench() {
  return {"contact",
          "time of bodies that fly, land, rest, sleep, drape and pile up",
          "30 minutes",
          withEngineKeys({{"repeats", "repeats of each scene", 1, 100},
                          {"patience", "seconds of an engine for a repeat of a scene", 0.001, 1e6},
                          {"stiffness", "N/m, of all springs", 0, 1e12},
                          {"damping", "N s/m, of all springs", 0, 1e12},
                          {"friction", "of all bodies", 0, 1e6},
                          {"flags", "compare kinds of collision of btSoftBody instead", {"yes", "no"}}}),
          [](const Options& options) { return namesOf(wantedContactScenes(options)); },
          &runContact};
}

}  // namespace limber::bench
