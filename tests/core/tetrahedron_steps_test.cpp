// SPDX-License-Identifier: Zlib
// The volumes of tetrahedra in all steppers: a closed form, conservation laws, and recovery.
#include "solver/implicit_step.h"
#include "solver/point_state.h"
#include "solver/simd_steps.h"
#include "solver/stepping_choice.h"
#include "support/networks.h"
#include "support/small_meshes.h"
#include "support/stepped_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace limber {
namespace {

using test::SteppedTestBody;

enum class TetrahedronStepper { Verlet, Quads, Linked, Shared, Newton };

class TetrahedronSteps : public testing::TestWithParam<TetrahedronStepper> {
 public:
  void SetUp() override {
    if (GetParam() == TetrahedronStepper::Quads && !canStepSpringBatches())
      GTEST_SKIP() << "this machine has neither AVX2 nor NEON";
  }

  void advance(SteppedTestBody& body, double time, int substeps) {
    if (GetParam() == TetrahedronStepper::Shared || GetParam() == TetrahedronStepper::Newton) {
      const auto kind = GetParam() == TetrahedronStepper::Shared ? MidpointSolver::Kind::Shared
                                                                 : MidpointSolver::Kind::Newton;
      stepImplicit(body.stepped(), implicit, kind, time, substeps, factors);
      return;
    }
    tetrahedronFrequencyBoundSquared(body.tetrahedra, body.state);
    body.stepped().springBatches = GetParam() == TetrahedronStepper::Quads ? &springBatches : nullptr;
    // an unlinked rigid body selects the code for islands
    if (GetParam() == TetrahedronStepper::Linked) body.group.links.rigids.resize(1);
    stepVerlet(body.group, time, substeps);
  }

  /// Returns the momentum error by rounding: larger for the implicit steppers, which solve factorised
  /// systems.
  double rounding() const {
    return GetParam() == TetrahedronStepper::Shared || GetParam() == TetrahedronStepper::Newton ? 1e-9
                                                                                                : 1e-11;
  }

  SpringBatchArrays springBatches;
  ImplicitState implicit;
  SharedFactors factors;
};

/// By symmetry, a regular tetrahedron that is enlarged uniformly keeps its shape and oscillates:
///     omega^2 = (k sum L^2 + 9 K V0) / sum m |x|^2.
TEST_P(TetrahedronSteps, breatheWithTheRightPeriod) {
  SteppedTestBody body(test::tetrahedronNetwork(), 100.0, 0.0);
  const double push = 9.0 * body.tetrahedra->modulus * body.tetrahedra->restVolume[0];
  ASSERT_GT(push, 100.0 * 6.0) << "the volume matters";
  const double radius = body.state.position.col(0).norm();
  const double omega = std::sqrt((100.0 * 6.0 + push) / (radius * radius));
  body.state.position *= 1.0 + 1e-4;
  const double before = body.energy();
  advance(body, 2.0 * std::acos(-1.0) / omega, 400);
  // the errors of the period are (2 pi / 400)^2 / 24 and / 12 or less, 2e-5
  for (Eigen::Index i = 0; i < 4; ++i)
    EXPECT_NEAR((body.state.position.col(i).norm() / radius - 1.0) / 1e-4, 1.0, 1e-3);
  EXPECT_NEAR(body.energy(), before, 1e-3 * before);
}

TEST_P(TetrahedronSteps, keepMomentumAndComeBackFromFlatAndInsideOut) {
  for (const double squash : {0.0, -1.0}) {
    SCOPED_TRACE(squash);
    SteppedTestBody body(test::tetrahedronNetwork(), 100.0, 0.5);
    for (Eigen::Index i = 0; i < 4; ++i)
      body.state.position.col(i) +=
          1e-3 * Eigen::Vector3d(std::sin(9.0 * double(i)), std::cos(7.0 * double(i)), 0);
    body.state.position.row(2) *= squash;
    body.state.velocity.colwise() = Eigen::Vector3d(1, 2, 3);
    const Eigen::Vector3d momentum = linearMomentum(body.state);
    const Eigen::Vector3d spin = spinOf(body.state);
    for (int i = 0; i < 1200; ++i) advance(body, 1.0 / 60.0, 8);
    EXPECT_LT((linearMomentum(body.state) - momentum).norm(), rounding());
    EXPECT_LT((spinOf(body.state) - spin).norm(), 1e-9);
    EXPECT_LT(tetrahedronEnergy(body.tetrahedra, body.state.position), 1e-9);
    EXPECT_LT(elasticEnergy(body.stepped(), body.state.position), 1e-9);
  }
}

/// Points are scattered at random over twice the body's size, with substeps too long for such forces. Verlet
/// must limit the volume term to what it can resolve.
TEST_P(TetrahedronSteps, areStableWhenScattered) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
  for (int run = 0; run < 10; ++run) {
    SCOPED_TRACE(run);
    SteppedTestBody body(test::tetrahedralCubeNetwork(), 1e4, 3.0);
    for (double& x : body.state.position.reshaped()) x = coordinate(random);
    const double before = body.energy();
    // Verlet's limit for the springs, 2 / omega, is 5 ms; 8 points of 1/8 kg with up to 7 springs each
    for (int i = 0; i < 600; ++i) {
      advance(body, 1.0 / 60.0, 12);
      ASSERT_TRUE(body.state.position.allFinite());
      ASSERT_LT(body.energy(), 4.0 * before) << i;
    }
    EXPECT_LT(kineticEnergy(body.state), 1e-3 * before);
  }
}

std::string nameOfTetrahedronStepper(const testing::TestParamInfo<TetrahedronStepper>& how) {
  const char* const names[] = {"Verlet", "Quads", "Linked", "Shared", "Newton"};
  return names[static_cast<int>(how.param)];
}

INSTANTIATE_TEST_SUITE_P(Steppers, TetrahedronSteps,
                         testing::Values(TetrahedronStepper::Verlet, TetrahedronStepper::Quads,
                                         TetrahedronStepper::Linked, TetrahedronStepper::Shared,
                                         TetrahedronStepper::Newton),
                         nameOfTetrahedronStepper);

/// At the number of substeps that is stable for the rest shape, no force may be scaled down there.
TEST(TetrahedronVolumes, areNotHeldBackAtRest) {
  MaterialMesh settings;
  settings.points = 100;
  const SharedNetwork filled = *buildMaterialNetwork(small_meshes::icosphere(2), settings);
  for (const SharedNetwork& network : {test::tetrahedronNetwork(), test::tetrahedralCubeNetwork(), filled}) {
    SCOPED_TRACE(network->restPoints.size());
    SteppedTestBody body(network, 1000.0, 0.0);
    TetrahedronVolumes& v = body.tetrahedra;
    const double squared = tetrahedronFrequencyBoundSquared(v, body.state);
    EXPECT_FALSE(isHeldBack(v, body.state, std::sqrt(0.999 * kLargestCornerPhaseSquared / squared)));
    EXPECT_TRUE(isHeldBack(v, body.state, std::sqrt(3.0 * kLargestCornerPhaseSquared / squared)));
  }
}

}  // namespace
}  // namespace limber
