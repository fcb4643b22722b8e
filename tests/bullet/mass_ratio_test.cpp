// SPDX-License-Identifier: Zlib
// Light bodies between far heavier ones.
#include "support/bullet_world.h"

#include <limber/network_builder.h>
#include <limber/soft_body_system.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace limber {
namespace {

using test::BulletWorld;
using test::vec;

constexpr double kClothRadius = 0.01, kHalfHeight = 0.2;

/// Adds a cloth of 1.2 m and 0.2 kg, 1 cm above the floor.
SoftBody* addCloth(SoftBodySystem& system) {
  ClothSettings shape;
  shape.width = shape.depth = 1.2;
  shape.columns = shape.rows = 14;
  SoftBodySettings s;
  s.totalMass = 0.2;
  s.extensionStiffness = s.compressionStiffness = 500.0;
  s.damping = 0.3;
  s.pointRadius = kClothRadius;
  s.friction = 0.5;
  s.position = {0, 2 * kClothRadius, 0};
  return *system.createBody(*buildCloth(shape), s);
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
    BulletWorld bullet;
    bullet.addBoxFloor()->setFriction(0.5);
    SoftBodySystem system(*bullet.world);
    SoftBody* cloth = addCloth(system);
    btRigidBody* box = addTiltedBox(bullet, mass);
    double lowest = 1.0;
    for (int i = 0; i < 300; ++i) {
      bullet.tick();
      for (std::uint32_t p = 0; p < cloth->pointCount(); ++p)
        lowest = std::min(lowest, cloth->position(p).y());
    }
    EXPECT_FALSE(box->isActive()) << mass;
    EXPECT_FALSE(cloth->surfaceObject()->isActive()) << mass;
    // contacts at rest are compliant: their depth grows with their impulse, see contact_solver.cpp
    EXPECT_NEAR(double(box->getWorldTransform().getOrigin().y()), kHalfHeight + 2 * kClothRadius, 2e-4)
        << mass;
    // The present value is 0.46: the sweeps end before they have converged for a mass ratio of 20 000 : 1.
    EXPECT_GT(lowest, 0.4 * kClothRadius) << "at the hit, " << mass;
  }
}

}  // namespace
}  // namespace limber
