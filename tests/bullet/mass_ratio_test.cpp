// SPDX-License-Identifier: Zlib
// Light bodies between far heavier ones.
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <algorithm>

namespace limber::test {
namespace {

constexpr double kClothRadius = 0.01, kHalfHeight = 0.2;

/// Adds a cloth of 1.2 m and 0.2 kg, 1 cm above the floor.
SoftBody* addCloth(SoftBodySystem& system) {
  SoftBodySettings s;
  s.totalMass = 0.2;
  setSprings(s, 500.0, 0.3);
  s.pointRadius = kClothRadius;
  s.friction = 0.5;
  s.position = {0, 2 * kClothRadius, 0};
  return *system.createBody(squareCloth(14, 1.2), s);
}

/// Adds a box that falls on one of its edges.
btRigidBody* addTiltedBox(BulletWorld& bullet, double mass) {
  btRigidBody* box = bullet.addBox(vec(0.25, kHalfHeight, 0.3), mass, vec(0.03, 0.6, 0.02));
  box->getWorldTransform().setRotation(
      btQuaternion(btVector3(1, btScalar(0.3), 0).normalized(), btScalar(0.5)));
  box->setInterpolationWorldTransform(box->getWorldTransform());
  return box;
}

TEST(SurfaceMassRatio, aHeavyBoxComesToRestOnAClothOnTheFloor) {
  for (const double mass : {2.0, 20.0}) {  // a point of the cloth has 1 g
    SoftWorld bullet;
    bullet.addBoxFloor()->setFriction(0.5);
    SoftBody* cloth = addCloth(bullet.system);
    btRigidBody* box = addTiltedBox(bullet, mass);
    double lowest = 1.0;
    for (int i = 0; i < 300; ++i) {
      bullet.tick();
      for (std::uint32_t p = 0; p < cloth->pointCount(); ++p)
        lowest = std::min(lowest, cloth->position(p).y());
    }
    EXPECT_FALSE(box->isActive()) << mass;
    EXPECT_FALSE(cloth->surfaceObject()->isActive()) << mass;
    // contacts at rest are compliant: their depth grows with their impulse, see contact_row.h
    EXPECT_NEAR(heightOf(*box), kHalfHeight + 2 * kClothRadius, 2e-4) << mass;
    // The present value is 0.46: the sweeps end before they have converged for a mass ratio of 20 000 : 1.
    EXPECT_GT(lowest, 0.4 * kClothRadius) << "at the hit, " << mass;
  }
}

constexpr double kCubeSize = 0.3, kHalfBox = 0.09, kCubeRadius = 0.0015;

/// Adds a cube of 98 points, 1 kg and 1000 N/m, just above the floor.
SoftBody* addBracedCube(SoftBodySystem& system) {
  SoftBodySettings s;
  s.scale = Eigen::Vector3d::Constant(kCubeSize);
  s.position = {0, 0.505 * kCubeSize, 0};
  s.pointRadius = kCubeRadius;
  return *system.createBody(bracedNetwork(small_meshes::cube(4)), s);
}

btRigidBody* addBoxAbove(BulletWorld& bullet, double mass) {
  bullet.addBoxFloor();
  btRigidBody* box =
      bullet.addBox(vec(kHalfBox, kHalfBox, kHalfBox), mass, vec(0, 1.01 * kCubeSize + kHalfBox + 0.01, 0));
  box->setFriction(1);
  return box;
}

/// Returns the depth (m) of the deepest point of the surface's middle in the box.
double depthIn(const btRigidBody& box, const SoftBody& body) {
  const btTransform& pose = box.getWorldTransform();
  const auto local = [&](std::uint32_t i) {
    const Eigen::Vector3d x = body.position(i);
    const btVector3 p = pose.invXform(vec(x.x(), x.y(), x.z()));
    return Eigen::Vector3d(double(p.x()), double(p.y()), double(p.z()));
  };
  constexpr int kSteps = 6;
  double deepest = -1.0;
  for (const Triangle& t : body.network().surface) {
    const Eigen::Vector3d a = local(t[0]), b = local(t[1]), c = local(t[2]);
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const Eigen::Vector3d x = a + (i * (b - a) + j * (c - a)) / kSteps;
        deepest = std::max(deepest, kHalfBox - x.cwiseAbs().maxCoeff());
      }
  }
  return deepest;
}

// Under these loads the surface folds about the edges of the box. A point that slides off the face, and an
// edge that bends from convex to concave, are pressed by their springs with some hundred times their weight.

TEST(SurfaceMassRatio, aHeavyBoxSinksIntoNoBracedCube) {
  for (const double mass : {20.0, 25.0}) {
    SoftWorld bullet;
    const btRigidBody* box = addBoxAbove(bullet, mass);
    const SoftBody* cube = addBracedCube(bullet.system);
    double deepest = -1.0;
    for (int i = 0; i < 60; ++i) {
      bullet.tick();
      deepest = std::max(deepest, depthIn(*box, *cube));
    }
    // the radius is still between them
    EXPECT_LT(deepest, 0.0) << mass;
  }
}

TEST(SurfaceMassRatio, aKinematicBoxSinksIntoNoBracedCube) {
  SoftWorld bullet;
  btRigidBody* box = addBoxAbove(bullet, 0.0);
  makeKinematic(*box);
  const SoftBody* cube = addBracedCube(bullet.system);
  const double start = heightOf(*box), speed = 0.06, depth = 0.11;
  double deepest = -1.0;
  for (int i = 1; i <= 140; ++i) {
    box->getWorldTransform().setOrigin(vec(0, start - std::min(speed * i / 60.0, depth), 0));
    bullet.tick();
    deepest = std::max(deepest, depthIn(*box, *cube));
  }
  EXPECT_LT(deepest, 0.0);
}

TEST(SurfaceMassRatio, aKinematicBallSinksIntoNoBracedCube) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  const SoftBody* cube = addBracedCube(bullet.system);
  const double start = 1.03 * kCubeSize + kHalfBox, speed = 0.06;
  btRigidBody* ball = bullet.add(std::make_unique<btSphereShape>(btScalar(kHalfBox)), 0.0, vec(0, start, 0));
  ball->setFriction(1);
  makeKinematic(*ball);
  double deepest = -1.0;
  for (int i = 1; i <= 75; ++i) {
    const Eigen::Vector3d centre(0, start - speed * i / 60.0, 0);
    ball->getWorldTransform().setOrigin(vec(0, centre.y(), 0));
    bullet.tick();
    for (const Triangle& t : cube->network().surface)
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d middle = 0.5 * (cube->position(t[k]) + cube->position(t[(k + 1) % 3]));
        deepest = std::max(deepest, kHalfBox - (middle - centre).norm());
      }
  }
  // the sag of an edge under the ball is 8 mm
  EXPECT_LT(deepest, 0.001);
}

/// Its points of 7 g swing under the ball of 50 kg and turn the triangles on it. What that closes of their
/// gaps must not add up.
TEST(SurfaceMassRatio, aHeavyBallSinksIntoNoTrampoline) {
  constexpr double kBall = 0.3, kThin = 0.005;  // m
  constexpr std::uint32_t kCells = 16;
  for (const double tick : {1.0 / 60.0, 1.0 / 240.0}) {
    SoftWorld bullet;
    SoftBodySettings s;
    s.totalMass = 2.0;
    s.extensionStiffness = s.compressionStiffness = 5000.0;
    s.damping = s.friction = 0.0;
    s.flow.drag = s.flow.linearDrag = 0.0;
    s.pointRadius = kThin;
    SoftBody* cloth = bullet.addSoft(squareCloth(kCells, 4.0), s);
    for (std::uint32_t i = 0; i < cloth->pointCount(); ++i) {
      const std::uint32_t x = i % (kCells + 1), z = i / (kCells + 1);
      if (x % kCells == 0 || z % kCells == 0) cloth->pin(i);
    }
    btRigidBody* ball =
        bullet.add(std::make_unique<btSphereShape>(btScalar(kBall)), 50, vec(0, 1.5 + kBall + kThin, 0));
    ball->setActivationState(DISABLE_DEACTIVATION);
    const double start = energyOf(*ball, kGravity);
    double deepest = 0.0;
    for (double time = 0.0; time < 1.0; time += tick) {
      bullet.tick(tick);
      const Eigen::Vector3d centre = eigen(ball->getWorldTransform().getOrigin());
      for (const Triangle& t : cloth->network().surface)
        for (int a = 0; a <= 4; ++a)
          for (int b = 0; a + b <= 4; ++b) {
            const Eigen::Vector3d p = (a * cloth->position(t[0]) + b * cloth->position(t[1]) +
                                       (4 - a - b) * cloth->position(t[2])) /
                                      4.0;
            deepest = std::max(deepest, kBall + kThin - (p - centre).norm());
          }
    }
    EXPECT_LT(deepest, 0.01) << tick;
    const double end = energyOf(*ball, kGravity) + energyOf(*cloth, kGravity);
    // falling for 0.55 s in Bullet's ticks of 1/60 s, the ball loses 2.5 % of it: M g v tick / 2
    EXPECT_NEAR(end / start, 1.0, 0.06) << tick;
  }
}

}  // namespace
}  // namespace limber::test
