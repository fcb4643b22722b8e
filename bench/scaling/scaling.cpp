// SPDX-License-Identifier: Zlib
// Repeats Tables 1 and 2 of C. Hart's paper: cubes fall onto a floor, 1, 2, 4 ... of them until 50 ticks a
// second are too many, then bisecting; with loose spheres beside them.
#include "results.h"
#include "scaling/count_search.h"
#include "scene/scene.h"
#include "scene_renderer.h"
#include "scenes/scene_list.h"
#include "timing.h"

#include <limber/contacts.h>

#include <algorithm>
#include <cmath>

namespace limber::bench {
namespace {

// --- what is measured ---

constexpr int kTicksPerSecond = 50;

enum class Mode {
  Bare,  ///< as many loose Bullet spheres as the cubes have points: no springs, no plugin, no pictures
  None,  ///< soft cubes without a renderer
  Shaded,
  Wireframe
};
inline bool isDrawn(Mode mode) { return mode == Mode::Shaded || mode == Mode::Wireframe; }

struct ScalingOptions {
  double seconds = 10.0;  ///< simulated, per run
  std::uint32_t maxBodies = 65536;
  int width = 1280, height = 720;  ///< pixels of a frame
  int repeats = 3;                 ///< runs per row, where a run is short
  double minutes = 12.0;           ///< wall time after which no more rows are begun
  bool sleep = false;              ///< bodies at rest may fall asleep
};

/// What is measured: soft cubes, drawn or not, or loose spheres.
struct Cubes {
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;
  std::unique_ptr<scenes::Scene> scene;           ///< the cubes, or nullptr
  RigidBodies rigid;                              ///< the floor of the spheres, which outlives their world
  std::unique_ptr<Engine> spheres;                ///< or nullptr
  std::unique_ptr<demo::SceneRenderer> renderer;  ///< nullptr: no pictures
  render::Image image;
};

/// Adds a sphere of the same radius, mass and friction for each point mass, over the same floor. Nothing
/// supports the upper ones, so all of them come to lie on the floor.
void addSpheres(const scenes::Scene& scene, Cubes& cubes) {
  const btRigidBody& floor = *scene.world->statics.front();
  const auto& box = static_cast<const btBoxShape&>(*floor.getCollisionShape());
  cubes.spheres = makeBareEngine();
  cubes.spheres->world().setGravity(scene.world->dynamics.getGravity());
  cubes.rigid.world = &cubes.spheres->world();
  addBox(cubes.rigid, fromBullet(box.getHalfExtentsWithMargin()), 0,
         fromBullet(floor.getWorldTransform().getOrigin()), double(floor.getFriction()));
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    BodySetup setup;
    setup.network = body.sharedNetwork();
    setup.settings = body.settings();
    setup.maySleep = true;  // see keepAwake()
    cubes.spheres->addBody(setup);
  }
}

btDiscreteDynamicsWorld& worldOf(const Cubes& cubes) {
  return cubes.scene ? cubes.scene->world->dynamics : cubes.spheres->world();
}

/// A body asleep costs next to nothing: what is to be measured must stay awake.
void keepAwake(btDiscreteDynamicsWorld& world) {
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    if (!objects[i]->isStaticObject()) objects[i]->forceActivationState(DISABLE_DEACTIVATION);
  }
}

std::unique_ptr<scenes::Scene> makeScene(std::uint32_t count) {
  scenes::SceneOptions options;
  options.count = count;
  return valueOf(scenes::createCubes(options));
}

/// Draws a frame. Returns milliseconds from reading positions until the GPU is done (glFinish), without
/// copying the picture to main memory, which a window does not need.
double draw(Cubes& cubes) {
  const Stopwatch watch;
  cubes.renderer->draw({}, cubes.image);
  return watch.time().wallMs - cubes.renderer->lastFrame().readMs;
}

void addRenderer(Cubes& cubes, const ScalingOptions& options, Mode mode) {
  demo::DemoOptions look;
  look.width = options.width;
  look.height = options.height;
  look.mode = mode == Mode::Wireframe ? demo::PictureMode::Wireframe : demo::PictureMode::Shaded;
  cubes.renderer = std::make_unique<demo::SceneRenderer>(*cubes.scene, look);
  draw(cubes);  // the first frame compiles shaders
}

/// Throws std::runtime_error with the reason, as when there is no OpenGL.
Cubes makeCubes(const ScalingOptions& options, Mode mode, std::uint32_t count) {
  Cubes cubes;
  cubes.scene = makeScene(count);
  cubes.bodies = count;
  cubes.points = scenes::pointCount(*cubes.scene);
  if (mode == Mode::Bare) {
    addSpheres(*cubes.scene, cubes);
    cubes.scene.reset();
  } else {
    cubes.springs = scenes::springCount(*cubes.scene);
  }
  if (!options.sleep) keepAwake(worldOf(cubes));
  if (isDrawn(mode)) addRenderer(cubes, options, mode);
  return cubes;
}

/// Steps the world by 1/50 s.
WorkTime tick(Cubes& cubes) {
  constexpr btScalar kTick = btScalar(1) / btScalar(kTicksPerSecond);
  btDiscreteDynamicsWorld& world = worldOf(cubes);
  const Stopwatch watch;
  world.stepSimulation(kTick, 0, kTick);
  return watch.time();
}

/// The plugin's part of the last tick; zeros for spheres.
TickProfile ownPart(const Cubes& cubes) { return cubes.scene ? cubes.scene->soft->profile() : TickProfile(); }

std::size_t contactCount(const Cubes& cubes) {
  btDispatcher& dispatcher = *worldOf(cubes).getDispatcher();
  std::size_t count = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    if (dispatcher.getManifoldByIndexInternal(i)->getNumContacts() > 0) ++count;
  }
  for (std::size_t i = 0; cubes.scene && i < cubes.scene->soft->bodyCount(); ++i)
    if (cubes.scene->soft->body(i)->surfaceObject()) count += cubes.scene->soft->body(i)->contacts().size();
  return count;
}

std::uint64_t stateHash(const Cubes& cubes) {
  if (cubes.scene) return scenes::stateHash(*cubes.scene);
  std::uint64_t hash = kHashStart;
  for (std::size_t body = 0; body < cubes.bodies; ++body) {
    addToHash(hash, cubes.spheres->positions(body));
    addToHash(hash, cubes.spheres->velocities(body));
  }
  return hash;
}

// --- a run ---

/// When a run is given up.
struct RowLimits {
  bool mayGiveUp = false;      ///< as soon as it is clear that real time is lost
  double wallSeconds = 600.0;  ///< in any case after so long
};

// a sample each 100 ms, as in the paper
constexpr int kTicksPerSample = kTicksPerSecond / 10;

// runs longer than this are not repeated: they hold enough samples, and the bench has to end
constexpr double kShortRunSeconds = 4.0;

/// What a run of one count in one mode leaves behind. Samples are taken every tenth of a simulated second.
struct Recording {
  Mode mode = Mode::None;
  std::uint32_t bodies = 0;
  std::size_t points = 0, springs = 0;
  std::vector<double> allTicks;                 ///< #ticks, ms
  std::vector<double> ticks, ticksCpu, frames;  ///< #samples, ms; no frames without a renderer
  std::vector<double> contacts, asleep;         ///< #samples, touching pairs and shares
  TickProfile own;                              ///< the plugin's part, summed over the samples
  std::size_t gpuBytes = 0;                     ///< of buffers, without textures and render targets
  std::string driver;                           ///< of OpenGL; empty without a renderer
  std::uint64_t hash = 0;                       ///< of the last state
  bool complete = false;                        ///< false: given up early, because too slow
  int repeats = 1;                              ///< runs measured, of which this is the middle one
  bool repeatable = true;                       ///< all runs ended in the same state, bit for bit
};

double simulatedSeconds(const Recording& r) {
  return static_cast<double>(r.allTicks.size()) / kTicksPerSecond;
}

/// Seconds the run would have taken with a frame after each tick: frames are only drawn when sampled, which
/// saves four fifths of them.
double runSeconds(const Recording& r) {
  return 1e-3 * (sum(r.allTicks) + mean(r.frames) * static_cast<double>(r.allTicks.size()));
}

/// Simulated seconds per second.
double realTime(const Recording& r) { return simulatedSeconds(r) / std::max(runSeconds(r), 1e-9); }

/// Falling is cheaper than lying on the floor, so a run that is far too slow while falling is lost.
bool isHopeless(const Recording& r, double seconds) {
  constexpr double kFallingSeconds = 0.5, kFarTooSlow = 3.0, kLost = 1.5;
  const double simulated = simulatedSeconds(r), run = runSeconds(r);
  return run > kLost * seconds || (simulated >= kFallingSeconds && run > kFarTooSlow * simulated);
}

void takeSample(Cubes& cubes, const WorkTime& time, Recording& r) {
  r.ticks.push_back(time.wallMs);
  r.ticksCpu.push_back(time.cpuMs);
  r.own += ownPart(cubes);
  r.contacts.push_back(static_cast<double>(contactCount(cubes)));
  r.asleep.push_back(asleepShare(worldOf(cubes)));
  if (cubes.renderer) r.frames.push_back(draw(cubes));
}

void describe(const Cubes& cubes, Recording& r) {
  r.bodies = cubes.bodies;
  r.points = cubes.points;
  r.springs = cubes.springs;
  if (cubes.renderer) {
    r.gpuBytes = cubes.renderer->gpuBufferBytes();
    r.driver = cubes.renderer->driver();
  }
  r.hash = stateHash(cubes);
}

std::string settingOf(Mode mode) {
  const char* const names[] = {"", "not drawn", "shaded", "wireframe"};
  return names[static_cast<int>(mode)];
}

std::string engineOf(Mode mode) { return mode == Mode::Bare ? "loose spheres" : "Limber"; }

Recording measureOnce(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                      Progress& progress) {
  Cubes cubes = makeCubes(options, mode, count);
  const std::string name = engineOf(mode) + " " + settingOf(mode) + ", " + std::to_string(count) + " cubes";
  const auto ticks = static_cast<std::size_t>(std::lround(options.seconds * kTicksPerSecond));
  const Stopwatch watch;
  Recording r;
  while (r.allTicks.size() < ticks) {
    const WorkTime time = tick(cubes);
    r.allTicks.push_back(time.wallMs);
    if (r.allTicks.size() % kTicksPerSample == 0) takeSample(cubes, time, r);
    if (watch.seconds() > limits.wallSeconds || (limits.mayGiveUp && isHopeless(r, options.seconds))) break;
    progress.show(name, static_cast<double>(r.allTicks.size()) / static_cast<double>(ticks));
  }
  if (r.ticks.empty()) takeSample(cubes, tick(cubes), r);
  r.mode = mode;
  describe(cubes, r);
  r.complete = simulatedSeconds(r) > options.seconds - 0.5 / kTicksPerSecond;
  return r;
}

/// The middle one by speed; of an even number the slower one.
Recording middleOf(std::vector<Recording> runs) {
  const auto sameEnd = [&](const Recording& run) { return run.hash == runs[0].hash; };
  const bool repeatable = std::all_of(runs.begin(), runs.end(), sameEnd);
  std::sort(runs.begin(), runs.end(),
            [](const Recording& a, const Recording& b) { return realTime(a) < realTime(b); });
  Recording row = runs[(runs.size() - 1) / 2];
  row.repeats = static_cast<int>(runs.size());
  row.repeatable = repeatable;
  return row;
}

/// Returns a new scene of `count` cubes, run for the time asked for; the middle one of several runs where
/// they are short.
Recording measureRow(const ScalingOptions& options, Mode mode, std::uint32_t count, const RowLimits& limits,
                     Progress& progress) {
  const Stopwatch watch;
  std::vector<Recording> runs = {measureOnce(options, mode, count, limits, progress)};
  const bool isShort = runs[0].complete && watch.seconds() < kShortRunSeconds;
  for (int i = 1; isShort && i < options.repeats; ++i) {
    const Recording again = measureOnce(options, mode, count, limits, progress);
    if (again.complete) runs.push_back(again);
  }
  return middleOf(runs);
}

void addTimes(const Subject& subject, const Recording& r, Results& results) {
  const auto samples = static_cast<double>(r.ticks.size());
  results.add(subject, "tick", "ms", median(r.ticks));
  results.add(subject, "tick, mean", "ms", mean(r.ticks));
  results.add(subject, "tick, largest sample", "ms", largest(r.ticks));
  results.add(subject, "worst tick", "ms", std::max(largest(r.allTicks), largest(r.ticks)));
  results.add(subject, "tick, own time", "ms", mean(r.ticksCpu));
  if (r.points) results.add(subject, "tick per point", "us", 1e3 * mean(r.ticks) / double(r.points));
  if (r.mode != Mode::Bare) {
    results.add(subject, "Limber's part", "ms", r.own.totalMs() / samples);
    results.add(subject, "before the springs", "ms", r.own.beforeStepMs() / samples);
    results.add(subject, "springs", "ms", r.own.stepMs / samples);
    results.add(subject, "writing to Bullet", "ms", r.own.writeMs / samples);
    results.add(subject, "reading from Bullet", "ms", r.own.readBackMs / samples);
  }
  if (isDrawn(r.mode)) {
    results.add(subject, "frame", "ms", mean(r.frames));
    results.add(subject, "frame, largest", "ms", largest(r.frames));
    results.add(subject, "buffers", "MB", 1e-6 * double(r.gpuBytes));
    results.note(subject, "driver", r.driver);
  }
}

void addRow(const Recording& r, Results& results) {
  const std::string scene = std::to_string(r.bodies) + (r.bodies == 1 ? " cube" : " cubes");
  const Subject subject{"cubes", scene, engineOf(r.mode), settingOf(r.mode), kTicksPerSecond};
  results.add(subject, "bodies", "", r.bodies);
  results.add(subject, "points", "", double(r.points));
  results.add(subject, "springs per cube", "", double(r.springs) / r.bodies);
  addTimes(subject, r, results);
  results.add(subject, "simulated over real time", "", realTime(r));
  results.add(subject, "touching pairs", "", mean(r.contacts));
  results.add(subject, "asleep", "%", 100.0 * mean(r.asleep));
  results.add(subject, "simulated", "s", simulatedSeconds(r));
  results.add(subject, "complete", "", r.complete);
  results.add(subject, "runs", "", r.repeats);
  results.add(subject, "runs end alike", "", r.repeatable);
  results.note(subject, "hash", hexText(r.hash));
}

// --- the search ---

// the counts of the paper's tables: measured to the end, real time or not
constexpr std::uint32_t kPaperCount = 64;

struct ModeSearch {
  Mode mode;
  CountSearch search;

  bool isOver() const { return !search.next(); }
};

struct Run {
  const ScalingOptions& options;
  Results& results;
  Progress progress;
  Stopwatch watch;

  double secondsLeft() const { return 60.0 * options.minutes - watch.seconds(); }
};

Recording measureAndKeep(Mode mode, std::uint32_t count, const RowLimits& limits, Run& run) {
  Recording row = measureRow(run.options, mode, count, limits, run.progress);
  addRow(row, run.results);
  run.progress.finish(format("%-9s %5u cubes: tick %.3f ms, %.2f x real time%s", settingOf(mode).c_str(),
                             row.bodies, mean(row.ticks), realTime(row), row.complete ? "" : " (given up)"));
  return row;
}

std::ptrdiff_t countUnfinished(const std::vector<ModeSearch>& searches) {
  return std::count_if(searches.begin(), searches.end(), [](const ModeSearch& s) { return !s.isOver(); });
}

/// No row may take more than its mode's share of the time that is left.
void searchAll(std::vector<ModeSearch>& searches, Run& run) {
  while (countUnfinished(searches) > 0 && run.secondsLeft() > 0.0) {
    for (ModeSearch& search : searches) {
      if (search.isOver()) continue;
      const double share = run.secondsLeft() / static_cast<double>(countUnfinished(searches));
      if (share <= 0.0) return;
      const std::uint32_t count = *search.search.next();
      const Recording row = measureAndKeep(search.mode, count, {count > kPaperCount, share}, run);
      search.search.report(realTime(row) >= 1.0);
    }
  }
}

void addEnd(const ModeSearch& s, Results& results) {
  const bool timeUp = s.search.next().has_value();
  const Subject subject{"largest number in real time", "cubes", engineOf(s.mode), settingOf(s.mode),
                        kTicksPerSecond};
  results.add(subject, "cubes in real time", "", s.search.largest());
  if (timeUp) results.note(subject, "or more", "stopped by the time limit");
  if (!timeUp && !s.search.foundFailure()) results.note(subject, "or more", "the largest count allowed");
}

/// --quick is weaker than what is given by name.
ScalingOptions scalingOptions(const Options& options) {
  const bool quick = options.quick;
  ScalingOptions o;
  o.seconds = options.number("seconds", quick ? 1.0 : 10.0);
  o.maxBodies = static_cast<std::uint32_t>(options.number("maxBodies", quick ? 256 : 65536));
  o.repeats = static_cast<int>(options.number("repeats", quick ? 1 : 3));
  o.minutes = options.number("minutes", quick ? 0.75 : 12.0);
  o.width = static_cast<int>(options.number("width", quick ? 320 : 1280));
  o.height = static_cast<int>(options.number("height", quick ? 180 : 720));
  o.sleep = options.word("sleep") == "yes";
  return o;
}

void runScaling(const Options& options, Results& results) {
  const ScalingOptions own = scalingOptions(options);
  std::vector<Mode> modes;
  for (const Mode mode : {Mode::Bare, Mode::None, Mode::Shaded, Mode::Wireframe})
    if (options.wantsEngine(engineOf(mode), settingOf(mode))) modes.push_back(mode);
  Run run{own, results, {}, {}};
  for (const double count : options.numbers("counts", {}))
    for (const Mode mode : modes) measureAndKeep(mode, static_cast<std::uint32_t>(count), RowLimits(), run);
  if (!options.word("counts").empty()) return;
  std::vector<ModeSearch> searches;
  for (const Mode mode : modes)
    searches.push_back({mode, CountSearch(CountSearchSettings{kPaperCount, own.maxBodies})});
  searchAll(searches, run);
  for (const ModeSearch& search : searches) addEnd(search, results);
}

}  // namespace

Bench scalingBench() {
  return {"scaling",
          "the paper's Tables 1 and 2: cubes until real time is lost",
          "12 minutes",
          {{"counts", "measure these numbers of cubes instead of searching", 1, 1048576, true},
           {"seconds", "simulated time of a run", 0.1, 600},
           {"maxBodies", "largest number of cubes", 1, 1048576},
           {"repeats", "runs per row if they take 4 s at most", 1, 99},
           {"minutes", "wall time after which no more rows are begun", 0.01, 1e4},
           {"width", "pixels of a frame", 16, 8192},
           {"height", "pixels of a frame", 16, 8192},
           {"sleep", "bodies at rest may fall asleep", {"yes", "no"}}},
          nullptr,
          &runScaling};
}

}  // namespace limber::bench
