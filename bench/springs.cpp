// SPDX-License-Identifier: Zlib
// Time of a spring per substep, by instruction set, and what contacts of a resting cube add to it.
#include "solver/springs.h"
#include "bench.h"
#include "results.h"
#include "solver/simd_steps.h"
#include "support/networks.h"
#include "timing.h"

#include <Eigen/Geometry>

#include <deque>
#include <functional>
#include <memory>

namespace limber::bench {
namespace {

constexpr double kTick = 1.0 / 60;
constexpr int kSubsteps = 20;

// --- cubes of 8 points and 28 springs that rotate; all but the first pulsate -------------------------------

struct TestCube {
  PointState state;
  SpringArrays springs;
  std::vector<PlaneContact> contacts;
  SpringBatchArrays springBatches;
  SolverIsland group;
};

constexpr double kStiffness = 1000.0, kPointMass = 0.125;

void addFloor(TestCube& cube) {
  for (std::uint32_t i = 0; i < 8; ++i) {
    cube.state.velocity.col(i).setZero();
    if (cube.state.position(1, i) > 0.0) continue;
    PlaneContact row;
    row.point = i;
    row.friction = 0.5;
    row.touch = cube.state.position.col(i);
    cube.contacts.push_back(row);
  }
}

void fill(TestCube& cube, const SpringNetwork& network, int which, double damping, bool resting) {
  SoftBodySettings settings;
  settings.extensionStiffness = settings.compressionStiffness = kStiffness;
  settings.damping = damping;
  if (!cube.springs.size()) cube.springs = makeSprings(network, settings);
  cube.state.resize(8);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d x = network.restPoints[i];
    cube.state.position.col(i) = resting ? x : Eigen::Vector3d((1.0 + 0.01 * which) * x);
    cube.state.velocity.col(i) = Eigen::Vector3d(1.0, 2.0, 0.5).cross(x);
    cube.state.acceleration.col(i) = Eigen::Vector3d(0.0, resting ? -9.81 : 0.0, 0.0);
    cube.state.inverseMass.col(i).setConstant(1.0 / kPointMass);
  }
  if (resting) addFloor(cube);
  cube.group.bodies.push_back({&cube.state, &cube.springs, &cube.contacts});
  cube.group.links.points.push_back(&cube.state);
}

/// Returns cubes that may share lanes; `resting` gives each the four contacts of one that lies on a floor.
std::deque<TestCube> makeCubes(int count, double damping, bool resting) {
  const SharedNetwork network = test::fullCubeNetwork();
  std::deque<TestCube> cubes(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    TestCube& cube = cubes[static_cast<std::size_t>(i)];
    cube.springs = cubes[0].springs;  // equal bodies share their constants
    fill(cube, *network, i, damping, resting);
  }
  return cubes;
}

// --- methods of stepping -----------------------------------------------------------------------------------

/// A method of stepping cubes.
struct Method {
  std::string name;
  bool damped = false, resting = false;
  double springs = 0.0;  ///< stepped by each run()
  std::function<void()> run;
  std::vector<double> ns;  ///< per spring and substep, one for each repeat
};

Method method(const std::string& name, double damping, bool resting, int bodies) {
  return {name, damping > 0.0, resting, 28.0 * bodies, {}, {}};
}

void addSingles(double damping, bool resting, std::vector<Method>& methods) {
  for (const bool four : {false, true}) {
    if (four && !canStepSpringBatches()) continue;
    auto cubes = std::make_shared<std::deque<TestCube>>(makeCubes(1, damping, resting));
    if (four) cubes->front().group.bodies[0].springBatches = &cubes->front().springBatches;
    methods.push_back(method(four ? "one body, four springs at a time (AVX2)" : "one body, spring by spring",
                             damping, resting, 1));
    methods.back().run = [cubes] { stepVerlet(cubes->front().group, kTick, kSubsteps); };
  }
}

void addLanes(double damping, bool resting, std::vector<Method>& methods) {
  for (const InstructionSet set : {InstructionSet::Sse2, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!isAvailable(set)) continue;
    auto cubes = std::make_shared<std::deque<TestCube>>(makeCubes(laneCount(set), damping, resting));
    auto scratch = std::make_shared<LaneScratch>();
    methods.push_back(method(std::to_string(laneCount(set)) + " bodies in " + nameOf(set) + " lanes", damping,
                             resting, laneCount(set)));
    methods.back().run = [cubes, scratch, set] {
      std::vector<SolverBody*> bodies;
      for (TestCube& cube : *cubes) bodies.push_back(&cube.group.bodies[0]);
      stepLanes(bodies.data(), bodies.size(), *scratch, kTick, kSubsteps, set);
    };
  }
}

std::vector<Method> allMethods() {
  std::vector<Method> methods;
  for (const bool resting : {false, true})
    for (const double damping : {0.0, 1.0}) {
      addSingles(damping, resting, methods);
      addLanes(damping, resting, methods);
    }
  return methods;
}

/// Runs the methods in turns, so that other load of the machine affects them alike.
void measure(std::vector<Method>& methods, int repeats) {
  constexpr int kRuns = 100;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (Method& m : methods) {
      m.run();
      const Stopwatch watch;
      for (int i = 0; i < kRuns; ++i) m.run();
      m.ns.push_back(1e6 * watch.time().cpuMs / (kRuns * kSubsteps * m.springs));
    }
}

void runSprings(const Options& options, Results& results) {
  std::vector<Method> methods;
  for (Method& m : allMethods())
    if (options.wantsEngine("Limber", m.name)) methods.push_back(std::move(m));
  measure(methods, static_cast<int>(options.number("repeats", options.quick ? 5 : 41)));
  for (const Method& m : methods)
    results.add(
        {m.damped ? "damped" : "undamped", m.resting ? "at rest on four points" : "free", "Limber", m.name},
        "spring and substep", "ns", m.ns);
}

}  // namespace

Bench springsBench() {
  return {"springs",    "time of a spring per substep, by instruction set",
          "20 seconds", {{"repeats", "repeats of each method", 1, 1000}},
          nullptr,      &runSprings};
}

}  // namespace limber::bench
