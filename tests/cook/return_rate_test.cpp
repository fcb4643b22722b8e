// SPDX-License-Identifier: Zlib
// Large deformations, the shapes to which bodies relax from them, and how often that is the rest shape.
#include "analysis/analysis.h"

#include "cook/cooked_figure.h"
#include "mesh/linear_algebra.h"
#include "network/stability.h"
#include "solver/springs.h"
#include "support/network_shapes.h"
#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/test_shapes.h"
#include "support/variants.h"

#include <limber/network_builder.h>

#include <limber/cook.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace limber {
namespace {

constexpr double kIrregularity = 1e-4;  // of the size, largest irregularity that deform() adds to each point

const std::vector<Deformation> kKinds{Deformation::Squash,   Deformation::Twist,  Deformation::Noise,
                                      Deformation::Push,     Deformation::Mirror, Deformation::Flatten,
                                      Deformation::Inversion};

/// Returns the network with an open surface, so without a volume term.
SpringNetwork withoutVolumeTerm(SpringNetwork network) {
  network.surface.pop_back();
  return network;
}

double largestMove(const Points& a, const Points& b) { return (a - b).colwise().norm().maxCoeff(); }

/// Returns the root mean square distance from the best plane.
double thickness(const Points& x) {
  const Points r = x.colwise() - x.rowwise().mean();
  return std::sqrt(symmetricValues(product(r, r.transpose()))[0] / static_cast<double>(x.cols()));
}

TEST(Deformations, dependOnKindSeedAndRunAlone) {
  const Points rest = RelaxedBody(*test::cubeNetwork()).rest;
  for (const Deformation kind : kKinds) {
    const Points x = deform(rest, kind, 7, 3);
    EXPECT_EQ(x, deform(rest, kind, 7, 3));
    EXPECT_NE(x, deform(rest, kind, 8, 3));
    EXPECT_NE(x, deform(rest, kind, 7, 4));
  }
}

TEST(Deformations, areWhatTheyAreCalled) {
  const Points rest = RelaxedBody(*network_shapes::bare(network_shapes::ico42())).rest;
  const double roundThickness = thickness(rest);
  for (std::uint64_t run = 0; run < 5; ++run) {
    EXPECT_LT(thickness(deform(rest, Deformation::Flatten, 1, run)), kIrregularity);
    EXPECT_NEAR(thickness(deform(rest, Deformation::Squash, 1, run)), 0.1 * roundThickness, kIrregularity);
    EXPECT_LT(largestMove(deform(rest, Deformation::Inversion, 1, run), -rest), 1.01 * kIrregularity);
    EXPECT_LE(largestMove(deform(rest, Deformation::Noise, 1, run), rest), 0.5 + kIrregularity);
    const Points pushed = deform(rest, Deformation::Push, 1, run);
    EXPECT_EQ(((pushed - rest).colwise().norm().array() > 1.01 * kIrregularity).count(), 1);
    EXPECT_GT(largestMove(pushed, rest), 0.2);
    const Points mirrored = deform(rest, Deformation::Mirror, 1, run);
    const auto moved = ((mirrored - rest).colwise().norm().array() > 1.01 * kIrregularity).count();
    EXPECT_GT(moved, 0);
    EXPECT_LT(moved, rest.cols() / 2);
  }
}

TEST(DistanceToRest, leavesOutRigidMotionsOfEachPieceButNotReflections) {
  const RelaxedBody body(*network_shapes::bare(small_meshes::twoIslands()));
  ASSERT_EQ(body.pieces.size(), 2u);
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  Points x = rotation * body.rest;
  for (const std::uint32_t i : body.pieces[1]) x.col(i) += Eigen::Vector3d(5, 1, 0);
  // square root of the rounding of squares
  EXPECT_NEAR(distanceToRest(body, x), 0.0, 1e-7);
  EXPECT_GT(distanceToRest(body, -x), 0.05);
  x(0, 0) = std::nan("");
  EXPECT_FALSE(distanceToRest(body, x) < 1e9) << "positions that are none have not returned";
}

/// 24 runs of three kinds, together and one by one.
TEST(Relaxation, ofARunDependsOnItsStartAlone) {
  RelaxedBody body(*network_shapes::bare(network_shapes::ico42()));
  const auto start = [&](std::size_t i) { return deform(body.rest, kKinds[i % 3], 5, i); };
  std::vector<Points> together(24);
  relax(body, together.size(), start, [&](std::size_t i, const Points& x) {
    together[i] = x;
    return kAllStarts;
  });
  for (std::size_t i = 0; i < together.size(); ++i)
    relax(
        body, 1, [&](std::size_t) { return start(i); },
        [&](std::size_t, const Points& x) {
          EXPECT_EQ(x, together[i]) << i;
          return kAllStarts;
        });
}

TEST(Relaxation, endsInAMinimumOfTheEnergy) {
  RelaxedBody body(*network_shapes::bare(network_shapes::ico42()));
  std::size_t runs = 0;
  relax(
      body, 10, [&](std::size_t i) { return deform(body.rest, Deformation::Mirror, 3, i); },
      [&](std::size_t, const Points& x) {
        ++runs;
        if (distanceToRest(body, x) < kReturned) return kAllStarts;
        PointState state;
        state.resize(x.cols());
        state.position = x;
        computeSpringForces(body.terms.springs, state);
        addVolumeForces(body.terms.volumes, state);
        EXPECT_LT(state.force.cwiseAbs().maxCoeff(), 1e-5);
        return kAllStarts;
      });
  EXPECT_EQ(runs, 10u);
}

TEST(ReturnRate, ofTheBareCubeIsPerfectWithAVolumeOnly) {
  const SpringNetwork cube = *network_shapes::bare(network_shapes::cube8());
  for (const Deformation kind : kKinds) EXPECT_EQ(measureReturns(cube, kind, 20, 1).rate(), 1.0);
  // springs cannot distinguish a body from its mirror image
  const ReturnRate inverted = measureReturns(withoutVolumeTerm(cube), Deformation::Inversion, 20, 1);
  EXPECT_EQ(inverted.returned, 0u);
  EXPECT_EQ(inverted.mirrored, 20u);
  EXPECT_LT(measureReturns(withoutVolumeTerm(cube), Deformation::Squash, 40, 1).rate(), 0.8) << "folds flat";
}

TEST(ReturnRate, ofABareLIsNone) {
  const SpringNetwork bare = *network_shapes::bare(network_shapes::lshape90());
  EXPECT_EQ(measureReturns(bare, Deformation::Squash, 10, 1).returned, 0u);
}

TEST(ReturnRate, measuresOnOtherDeformationsThanBracingTried) {
  const Points rest = RelaxedBody(*test::cubeNetwork()).rest;
  for (std::uint64_t seed : {0u, 1u, 4711u})
    for (const Deformation kind : kKinds)
      for (std::uint64_t run = 0; run < 20; ++run)
        EXPECT_NE(deform(rest, kind, measuringSeed(seed), run), deform(rest, kind, seed, run));
}

SharedNetwork coarseMaterialCube() {
  MaterialMesh coarse;
  coarse.points = 60;
  return *buildMaterialNetwork(network_shapes::cube8(), coarse);
}

/// Without the volume term, springs are at rest in an inverted tetrahedron.
TEST(ReturnRate, ofAMaterialIsPerfect) {
  const SpringNetwork body = *coarseMaterialCube();
  for (const Deformation kind : kKinds) EXPECT_EQ(measureReturns(body, kind, 6, 1).returned, 6u);
  SpringNetwork hollow = body;
  hollow.tetrahedra.clear();
  hollow.surface.clear();
  EXPECT_EQ(measureReturns(hollow, Deformation::Inversion, 6, 1).returned, 0u);
}

SharedNetwork materialOf(const TriangleMesh& mesh, std::uint32_t points) {
  MaterialMesh settings;
  settings.points = points;
  return *buildMaterialNetwork(mesh, settings);
}

/// The exact springs of limbs of one cell are soft. With a volume term that pushed harder against crushing,
/// limbs stayed folded after a quarter of such noise.
TEST(ReturnRate, ofTetrahedraWithThinLimbsIsPerfect) {
  const SharedNetwork network = materialOf(test_shapes::figure(), 300);
  EXPECT_EQ(measureReturns(*network, Deformation::Noise, 15, 1000).returned, 15u);
}

/// Braces alone return the figure in a quarter of the runs.
TEST(ReturnRate, ofCookedThinLimbsIsPerfect) {
  const Result<CookedMesh> rabbit = cook(network_shapes::rabbit302());
  ASSERT_TRUE(rabbit) << rabbit.error();
  for (const SharedNetwork& body : {test::cookedFigure().bodies[0], rabbit->bodies[0]})
    for (const Deformation kind : kKinds) EXPECT_EQ(measureReturns(*body, kind, 1, 1).returned, 1u);
}

/// A bar of 32 x 1 x 1 untwists slowly: its softest oscillation is far softer than its springs. Runs must not
/// count as wrong because they ended too early: then nearly all would. One of 48 ended in a minimum of its
/// own, where the rounding of the machine's C library led it.
TEST(ReturnRate, ofASlenderBarIsNotCutShort) {
  TriangleMesh bar = network_shapes::cube26();
  for (Eigen::Vector3d& p : bar.positions) p.x() *= 32.0;
  EXPECT_GE(measureReturns(*materialOf(bar, 300), Deformation::Twist, 8, 1).returned, 7u);
}

/// Returns a function that runs the tasks on this many threads, the calling one among them.
ParallelFor onThreads(std::size_t count) {
  return [count](std::size_t tasks, const std::function<void(std::size_t)>& task) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks; i = next++) task(i);
    };
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < count; ++i) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
  };
}

TEST(Cooking, isTheSameOnAnyNumberOfThreads) {
  const TriangleMesh mesh = network_shapes::lshape90();
  const SharedNetwork alone = *buildNetwork(mesh);
  const ReturnRate rate = measureReturns(*alone, Deformation::Squash, 30, 1);
  EXPECT_GT(std::count_if(alone->springs.begin(), alone->springs.end(),
                          [](const NetworkSpring& s) { return s.kind == SpringKind::Brace; }),
            0);
  for (const std::size_t threads : test::variants<std::size_t>({3}, {1, 2})) {
    NetworkSettings settings;
    settings.parallel = onThreads(threads);
    const SharedNetwork network = *buildNetwork(mesh, settings);
    ASSERT_EQ(network->springs.size(), alone->springs.size());
    for (std::size_t i = 0; i < alone->springs.size(); ++i) {
      EXPECT_EQ(network->springs[i].a, alone->springs[i].a);
      EXPECT_EQ(network->springs[i].b, alone->springs[i].b);
    }
    const ReturnRate other = measureReturns(*network, Deformation::Squash, 30, 1, {}, settings.parallel);
    EXPECT_EQ(other.runs, 30u);
    EXPECT_EQ(other.returned, rate.returned);
    EXPECT_EQ(other.mirrored, rate.mirrored);
  }
}

/// Positions, to the bit.
TEST(Relaxation, isTheSameOnAnyNumberOfThreads) {
  RelaxedBody body(*network_shapes::bare(network_shapes::ico42()));
  const auto relaxed = [&](const ParallelFor& parallel) {
    std::vector<Points> ends(30);
    relax(
        body, ends.size(), [&](std::size_t i) { return deform(body.rest, kKinds[i % 3], 5, i); },
        [&](std::size_t i, const Points& x) {
          ends[i] = x;
          return kAllStarts;
        },
        parallel);
    return ends;
  };
  const std::vector<Points> alone = relaxed({});
  for (const std::size_t threads : {1u, 2u, 3u}) EXPECT_EQ(relaxed(onThreads(threads)), alone);
}

/// The first run to come to rest asks for 40 of 200 starts.
TEST(Relaxation, dropsStartsThatAreNoLongerWanted) {
  RelaxedBody body(*network_shapes::bare(network_shapes::ico42()));
  for (const std::size_t threads : {1u, 3u}) {
    std::vector<int> finished(200, 0);
    relax(
        body, finished.size(), [&](std::size_t i) { return deform(body.rest, kKinds[i % 3], 5, i); },
        [&](std::size_t i, const Points&) -> std::size_t {
          ++finished[i];
          return 40;
        },
        onThreads(threads));
    for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(finished[i], 1) << i;
    EXPECT_EQ(std::count(finished.begin() + 100, finished.end(), 1), 0) << "none of them had begun";
  }
}

/// Also after a run with so few substeps that the volume terms were limited.
TEST(Relaxation, descendsTheWholeEnergy) {
  RelaxedBody body(*coarseMaterialCube());
  const auto start = [&](std::size_t i) { return deform(body.rest, Deformation::Squash, 1, i); };
  relax(body, 8, start, [&](std::size_t, const Points&) {
    for (const double scale : body.terms.tetrahedra.stabilityScale) EXPECT_EQ(scale, 0.0);
    return kAllStarts;
  });
  RelaxedBody closed(*network_shapes::bare(network_shapes::ico42()));
  const auto squash = [&](std::size_t i) { return deform(closed.rest, Deformation::Squash, 1, i); };
  relax(closed, 8, squash, [&](std::size_t, const Points&) {
    EXPECT_EQ(closed.terms.volumes.timeStep, 0.0);
    return kAllStarts;
  });
}

TEST(ReturnRate, noneWhereStepsAreTooShort) {
  SpringNetwork cube = *test::cubeNetwork();
  cube.springs[3].stiffnessScale = 1e300;
  EXPECT_EQ(measureReturns(cube, Deformation::Squash, 3, 1).runs, 0u);
}

TEST(ReturnRate, endsWhenProgressSaysSo) {
  const SpringNetwork cube = *network_shapes::bare(network_shapes::cube8());
  std::uint32_t calls = 0;
  const ReturnRate rate = measureReturns(cube, Deformation::Twist, 100, 1, [&](const char*, double done) {
    EXPECT_GT(done, 0.0);
    EXPECT_LE(done, 1.0);
    return ++calls < 5;
  });
  EXPECT_EQ(calls, 5u);
  EXPECT_EQ(rate.runs, 5u);
}

}  // namespace
}  // namespace limber
