// SPDX-License-Identifier: Zlib
// Kinematic drums, rollers and thin discs that turn or move under soft bodies.
#include "support/soft_world.h"

#include <cmath>
#include <memory>
#include <vector>

namespace limber::test {
namespace {

btRigidBody* addKinematic(BulletWorld& bullet, std::unique_ptr<btCollisionShape> shape,
                          const btVector3& position) {
  btRigidBody* body = bullet.add(std::move(shape), 0, position);
  body->setFriction(1);
  makeKinematic(*body);
  return body;
}

/// Returns settings of a cube with friction that comes to rest soon.
SoftBodySettings cubeOn(double size, double mass, double stiffness, double pointRadius) {
  SoftBodySettings s = testedSettings();
  s.scale.setConstant(size);
  s.totalMass = mass;
  setSprings(s, stiffness, 0.2 * std::sqrt(stiffness * 0.125 * mass));
  s.friction = 1.0;
  s.pointRadius = pointRadius;
  return s;
}

/// The points of a rope that does not slip are at the drum's radius and their own, and turn with it.
TEST(Drum, takesATautRopeAlong) {
  constexpr double kDrum = 0.3, kThick = 0.05, kSpeed = 1.0;  // m, m, rad/s
  constexpr std::uint32_t kPoints = 40;
  for (const bool capsule : {true, false}) {
    SoftWorld bullet(0.0);
    std::unique_ptr<btCollisionShape> shape;
    if (capsule)
      shape = std::make_unique<btCapsuleShapeZ>(btScalar(kDrum), btScalar(1.2));
    else
      shape = std::make_unique<btCylinderShapeZ>(vec(kDrum, kDrum, 0.6));
    btRigidBody* drum = addKinematic(bullet, std::move(shape), vec(0, 0, 0));
    auto loop = std::make_shared<SpringNetwork>();
    loop->kind = NetworkKind::Rope;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const double angle = 2.0 * kPi * i / kPoints;
      loop->restPoints.push_back((kDrum + kThick) * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
      loop->massFractions.push_back(1.0 / kPoints);
      if (i > 0) loop->springs.push_back({i - 1, i, SpringKind::Structural, 1.0});
    }
    loop->springs.insert(loop->springs.begin() + 1, {0, kPoints - 1, SpringKind::Structural, 1.0});
    SoftBodySettings s = testedSettings();
    setSprings(s, 1e4, 10.0);
    s.friction = 1.0;
    s.pointRadius = kThick;
    s.angularVelocity = {0, 0, kSpeed};
    SoftBody* rope = bullet.addSoft(loop, s);
    SoftBodySettings tight = s;
    tight.scale *= 0.97;
    ASSERT_TRUE(rope->change(tight));
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d& x = loop->restPoints[i];
      rope->point(i)->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(x.x(), x.y(), x.z())));
    }
    const auto angle = [&] { return std::atan2(rope->position(0).y(), rope->position(0).x()); };
    double start = 0.0;
    for (int i = 1; i <= 90; ++i) {
      drum->setWorldTransform(
          btTransform(btQuaternion(vec(0, 0, 1), btScalar(kSpeed * i / 60.0)), vec(0, 0, 0)));
      bullet.tick();
      if (i == 30) start = angle();
    }
    // with the speed of the drum's surface it would turn by 0.857
    EXPECT_NEAR(angle() - start, kSpeed, 0.002) << capsule;
  }
}

/// What does not turn with rollers moves as their surface does, not as the centres of its points would on a
/// drum: a fifth faster here.
TEST(Rollers, conveyACubeAtTheSpeedOfTheirSurface) {
  if (!kSurface) GTEST_SKIP() << "points fall between the rollers";
  constexpr double kRoller = 0.05, kThick = 0.01, kSpeed = 0.8;  // m, m, m/s
  SoftWorld bullet;
  std::vector<btRigidBody*> rollers;
  for (int k = 0; k < 24; ++k) {
    auto shape = std::make_unique<btCapsuleShapeZ>(btScalar(kRoller), btScalar(3));
    rollers.push_back(addKinematic(bullet, std::move(shape), vec(0.11 * k - 0.7, -kRoller, 0)));
  }
  SoftBodySettings s = cubeOn(1.0, 1.0, 3000.0, kThick);
  s.position.y() = 0.5 + kThick;
  SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
  double reached = 0.0;
  for (int i = 1; i <= 90; ++i) {
    const btQuaternion turned(vec(0, 0, 1), btScalar(-kSpeed / kRoller * i / 60.0));
    for (btRigidBody* roller : rollers)
      roller->setWorldTransform(btTransform(turned, roller->getWorldTransform().getOrigin()));
    bullet.tick();
    if (i == 60) reached = cube->centerOfMass().x();
  }
  EXPECT_NEAR((cube->centerOfMass().x() - reached) / 0.5, kSpeed, 0.01 * kSpeed);
}

/// Bullet's narrowphase loses the margins of shapes whose cores are nearer than a millimetre.
TEST(Discs, asThinAsCoinsCarryACubeAtItsRadius) {
  if (!kSurface) GTEST_SKIP() << "point masses have the contacts that Bullet finds";
  constexpr double kPoint = 0.0005, kDisc = 0.2;
  for (const bool hull : {false, true})
    for (const double half : {0.01, 0.005, 0.002}) {
      SoftWorld bullet;
      std::unique_ptr<btCollisionShape> shape;
      double top = 0.0;
      if (hull) {
        auto prism = std::make_unique<btConvexHullShape>();
        prism->setMargin(btScalar(0.1 * half));
        for (int i = 0; i < 32; ++i)
          prism->addPoint(vec(kDisc * std::cos(i / 2 * kPi / 8), i % 2 ? half : -half,
                              kDisc * std::sin(i / 2 * kPi / 8)));
        top = double(prism->getMargin());
        shape = std::move(prism);
      } else {
        shape = std::make_unique<btCylinderShape>(vec(kDisc, half, kDisc));
      }
      btRigidBody* disc = addKinematic(bullet, std::move(shape), vec(0, -half, 0));
      SoftBodySettings s = cubeOn(0.05, 0.1, 1000.0, kPoint);
      s.position.y() = 0.03;
      SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
      double lowest = 1.0;
      for (int i = 1; i <= 60; ++i) {
        disc->setWorldTransform(btTransform(btQuaternion::getIdentity(), vec(0.001 * i, -half, 0)));
        bullet.tick();
        if (i < 45) continue;
        for (std::uint32_t k = 0; k < cube->pointCount(); ++k)
          lowest = std::min(lowest, cube->position(k).y());
      }
      EXPECT_NEAR(lowest, top + kPoint, 0.05 * kPoint) << hull << ' ' << half;
    }
}

/// Bullet's GJK ends a millimetre before it has the nearest point: the cloth fell through.
TEST(Hulls, ofMillimetresThatTurnCarryACloth) {
  if (!kSurface) GTEST_SKIP() << "point masses have the contacts that Bullet finds";
  for (const double half : {0.005, 0.002, 0.001}) {
    SoftWorld bullet;
    auto cube = std::make_unique<btConvexHullShape>();
    cube->setMargin(btScalar(0.02 * half));
    for (int k = 0; k < 8; ++k)
      cube->addPoint(vec(k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half));
    btRigidBody* table = addKinematic(bullet, std::move(cube), vec(0, -half, 0));
    const double mass = 1000.0 * half * half * half;
    SoftBodySettings s = cubeOn(1.0, mass, mass / 25.0 * kGravity / (0.001 * half), 0.05 * half);
    s.position.y() = 0.0725 * half;
    SoftBody* cloth = bullet.addSoft(squareCloth(4, half), s);
    for (int i = 1; i <= 30; ++i) {
      table->setWorldTransform(btTransform(btQuaternion(vec(0, 1, 0), btScalar(i / 12.0)), vec(0, -half, 0)));
      bullet.tick();
    }
    EXPECT_GT(cloth->centerOfMass().y(), 0.0) << half;
  }
}

}  // namespace
}  // namespace limber::test
