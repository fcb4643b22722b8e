// SPDX-License-Identifier: Zlib
// All engines accept the same set-up.
#include "engines/engines.h"

#include "bullet_soft/body_start.h"
#include "scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber::bench {
namespace {

constexpr double kTick = 1.0 / 240;

struct PlayedBody {
  std::unique_ptr<Engine> engine;
  Eigen::Matrix3Xd start;
};

PlayedBody play(const EngineChoice& choice, const BodySetup& body, double gravity, int ticks) {
  PlayedBody played{choice.make(kTick), {}};
  played.engine->world().setGravity(btVector3(0, static_cast<btScalar>(-gravity), 0));
  played.engine->addBody(body);
  played.start = played.engine->positions(0);
  for (int i = 0; i < ticks; ++i) played.engine->tick(kTick);
  return played;
}

std::string nameOf(const EngineChoice& choice) { return choice.engine + " " + choice.setting; }

TEST(Engines, allStartAsToldAndFallAlike) {
  BodySetup body = bodyOf(cubeNetwork(), 0.8, 500.0);
  body.settings.position = {1, 2, 3};
  body.settings.linearVelocity = {0.5, 1, 0};
  body.settings.angularVelocity = {0, 0, 2};
  for (const EngineChoice& choice : allEngines()) {
    const PlayedBody played = play(choice, body, 9.81, 120);
    EXPECT_TRUE(played.start.isApprox(startOf(body).positions, 1e-6)) << nameOf(choice);
    const Eigen::Vector3d centre = played.engine->positions(0).rowwise().mean();
    // symplectic Euler falls g h t / 2 = 1 cm too far
    EXPECT_NEAR(centre.y(), 2 + 0.5 - 0.5 * 9.81 * 0.25, 0.011) << nameOf(choice);
    EXPECT_NEAR(centre.x(), 1.25, 1e-3) << nameOf(choice);
    const Eigen::Vector3d edge = played.engine->positions(0).col(1) - played.engine->positions(0).col(0);
    EXPECT_NEAR(std::atan2(edge.y(), edge.x()), 1.0, 0.1) << nameOf(choice) << ": the spin";
  }
}

TEST(Engines, pinnedPointsStayUntilLetGo) {
  BodySetup body = bodyOf(barNetwork(4), 0.5, 200.0);
  body.pins = {0, 4};
  for (const EngineChoice& choice : allEngines()) {
    const PlayedBody played = play(choice, body, 9.81, 60);
    const Eigen::Matrix3Xd positions = played.engine->positions(0);
    EXPECT_TRUE(positions.col(0).isApprox(played.start.col(0), 1e-9)) << nameOf(choice);
    EXPECT_TRUE(positions.col(4).isApprox(played.start.col(4), 1e-6)) << nameOf(choice);
    EXPECT_LT(positions(1, 2), -1e-3) << nameOf(choice);
    played.engine->setPinned(0, 4, false);
    for (int i = 0; i < 60; ++i) played.engine->tick(kTick);
    EXPECT_LT(played.engine->positions(0)(1, 4), -0.1) << nameOf(choice);
    EXPECT_TRUE(played.engine->positions(0).col(0).isApprox(played.start.col(0), 1e-9)) << nameOf(choice);
  }
}

TEST(Engines, springsKeepTheRestLengthsOfTheNetworkWhereverPointsStart) {
  BodySetup body = bodyOf(pairNetwork(), 0.2, 50.0);
  body.pins = {0};
  body.drag = 5.0;
  body.settings.damping = 1.0;
  body.positions = Eigen::Matrix3Xd::Zero(3, 2);
  body.positions(0, 1) = 1.3;
  for (const EngineChoice& choice : allEngines())
    EXPECT_NEAR(play(choice, body, 0.0, 480).engine->positions(0)(0, 1), 1.0, 0.01) << nameOf(choice);
}

TEST(Engines, restOnAFloorWithinABodyRadius) {
  for (const EngineChoice& choice : allEngines()) {
    btBoxShape shape(btVector3(5, 1, 5));
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, &shape);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(btVector3(0, -1, 0));
    btRigidBody floor(info);
    const auto engine = choice.make(kTick);
    engine->world().setGravity(btVector3(0, btScalar(-9.81), 0));
    engine->world().addRigidBody(&floor);
    BodySetup body = bodyOf(cubeNetwork(), 0.8, 500.0, 2.0);
    body.settings.position = {0, 0.53, 0};
    body.settings.pointRadius = 0.02;
    body.drag = 2.0;
    engine->addBody(body);
    for (int i = 0; i < 480; ++i) engine->tick(kTick);
    EXPECT_NEAR(engine->positions(0).row(1).minCoeff(), 0.02, 0.02) << nameOf(choice);
    engine->world().removeRigidBody(&floor);
  }
}

TEST(Engines, refuseWhatOnlyLimberHas) {
  BodySetup body = bodyOf(pairNetwork(), 0.2, 50.0);
  body.settings.compressionStiffness = 10.0;
  EXPECT_NO_THROW(makeLimberEngine()->addBody(body));
  EXPECT_THROW(makeDeformableEngine(true)->addBody(body), std::runtime_error);
  EXPECT_THROW(makeSoftBodyEngine(kTick, 1, LinkStiffness::Full)->addBody(body), std::runtime_error);
}

TEST(Engines, substepsThatKeepABodyStable) {
  const BodySetup body = bodyOf(cubeNetwork(), 0.8, 1e5);
  EXPECT_GT(stableSubsteps(body, 1.0 / 60), 10);
  EXPECT_NEAR(stableSubsteps(body, 1.0 / 30), 2 * stableSubsteps(body, 1.0 / 60), 1);
}

}  // namespace
}  // namespace limber::bench
