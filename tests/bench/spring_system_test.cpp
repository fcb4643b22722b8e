// SPDX-License-Identifier: Zlib
// The bench's own reference solutions, compared with closed forms.
#include "scene/reference.h"

#include "scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber::bench {
namespace {

constexpr double kBulletRounding = sizeof(btScalar) == sizeof(float) ? 1e-6 : 1e-10;

TEST(SpringSystem, aMassOnASpringFollowsTheCosine) {
  BodySetup body = bodyOf(pairNetwork(), 0.2, 16.0);
  body.pins = {0};
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions(0, 1) = 1.125;
  const State state = integrate(systemOf(body, Eigen::Vector3d::Zero()), 3.0, 100.0);
  const double omega = std::sqrt(160.0);
  EXPECT_NEAR(state.x(0, 1), 1.0 + 0.125 * std::cos(3 * omega), 10 * kBulletRounding);
  EXPECT_NEAR(state.v(0, 1), -0.125 * omega * std::sin(3 * omega), 100 * kBulletRounding);
  EXPECT_EQ(state.x(0, 0), 0.0);
}

TEST(SpringSystem, dampersDecay) {
  BodySetup body = bodyOf(pairNetwork(), 0.2, 16.0, 0.05);
  body.pins = {0};
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions(0, 1) = 1.125;
  const State state = integrate(systemOf(body, Eigen::Vector3d::Zero()), 3.0, 100.0);
  const double rate = 0.25, omega = std::sqrt(160.0 - rate * rate);
  const double exact =
      0.125 * std::exp(-3 * rate) * (std::cos(3 * omega) + rate / omega * std::sin(3 * omega));
  EXPECT_NEAR(state.x(0, 1), 1.0 + exact, 10 * kBulletRounding);
}

TEST(SpringSystem, aChainHangsAsItMust) {
  BodySetup body = bodyOf(chainNetwork(16), 1.7, 1000.0);
  body.pins = {0};
  const Eigen::Matrix3Xd rest = equilibrium(systemOf(body, {0, -9.81, 0}));
  EXPECT_NEAR(-rest(1, 16) - 1.0, 0.1 * 9.81 / 1000 * 16 * 17 / 2, kBulletRounding);
  EXPECT_NEAR(rest.row(0).cwiseAbs().maxCoeff(), 0.0, 1e-9);
}

TEST(SpringSystem, aMassThatMeetsAWallStaysThereOrLeaves) {
  BodySetup body = bodyOf(pairNetwork(), 2.0, 1e-9);
  body.settings.linearVelocity = {0, -1, 0};
  body.settings.position = {0, 1, 0};
  double lowest = 1.0;
  const Wall wall{Eigen::Vector3d::UnitY(), 0.25};
  integrateAgainst(systemOf(body, {0, -9.81, 0}), wall, 1.0, 1e-4,
                   [&](double, const State& state) { lowest = std::min(lowest, state.x.row(1).minCoeff()); });
  EXPECT_NEAR(lowest, 0.25, 1e-9);
}

TEST(RestingCube, stiffCubesStandOnTheirPoints) {
  const double unloaded = 1 + kCubeRadius;
  EXPECT_NEAR(restHeight(restingCube(1e9), 0.0), unloaded, 1e-6);
  const double soft = unloaded - restHeight(restingCube(1e5), 0.0);
  EXPECT_NEAR(unloaded - restHeight(restingCube(1e6), 0.0), soft / 10, 1e-3 * soft)
      << "weight over stiffness";
  EXPECT_GT(restHeight(restingCube(1e5), 0.0), restHeight(restingCube(1e5), 10.0));
}

}  // namespace
}  // namespace limber::bench
