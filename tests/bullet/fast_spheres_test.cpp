// SPDX-License-Identifier: Zlib
// Compares the closed form of sphere-box contacts with the distance of a point from a box.
#include "support/soft_world.h"

#include <algorithm>
#include <random>

namespace limber::test {
namespace {

/// Returns the distance (m) of a point from a box about the origin with edges rounded by `round`. The normal
/// points out of the box.
double distanceToBox(const btVector3& half, double round, const btVector3& point, btVector3& normal) {
  const btVector3 core = half - vec(round, round, round);
  btVector3 nearest = point;
  nearest.setMax(-core);
  nearest.setMin(core);
  const double outside = double((point - nearest).length());
  if (outside > 0.0) {
    normal = (point - nearest) / btScalar(outside);
    return outside - round;
  }
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (half[i] - std::abs(point[i]) < half[axis] - std::abs(point[axis])) axis = i;
  normal.setZero();
  normal[axis] = point[axis] < 0 ? btScalar(-1) : btScalar(1);
  return -double(half[axis] - std::abs(point[axis]));
}

TEST(FastSpheres, contactsAreThoseOfTheClosedForm) {
  const btVector3 half = vec(0.5, 0.3, 0.7);
  const double r = 0.1;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  int touching = 0, inside = 0;
  for (int i = 0; i < 2000; ++i) {
    BulletWorld bullet(0.0);
    useFastSphereAlgorithms(bullet.dispatcher);
    const bool sphereFirst = i % 2 == 0;
    const auto addSphere = [&] {
      return bullet.add(std::make_unique<btSphereShape>(btScalar(r)), 1, vec(0, 0, 0));
    };
    btRigidBody* sphere = sphereFirst ? addSphere() : nullptr;
    btRigidBody* box = bullet.addBox(half, 1, vec(in(random), in(random), in(random)));
    if (!sphere) sphere = addSphere();
    btQuaternion rotation(btScalar(in(random)), btScalar(in(random)), btScalar(in(random)),
                          btScalar(in(random)));
    rotation.normalize();
    box->getWorldTransform().setRotation(rotation);
    const btVector3 local = vec(0.62 * in(random), 0.42 * in(random), 0.82 * in(random));
    sphere->getWorldTransform().setOrigin(box->getWorldTransform() * local);
    bullet.world->performDiscreteCollisionDetection();
    btVector3 normal;
    const double round = double(box->getCollisionShape()->getMargin());
    const double distance = distanceToBox(half, round, local, normal) - r;
    ASSERT_EQ(bullet.dispatcher.getNumManifolds(), 1);
    const btPersistentManifold& m = *bullet.dispatcher.getManifoldByIndexInternal(0);
    // Bullet keeps contacts up to its breaking threshold
    if (distance > double(m.getContactBreakingThreshold()) - 1e-5) continue;
    ++touching;
    inside += distance < -r;
    ASSERT_EQ(m.getNumContacts(), 1) << distance;
    const btManifoldPoint& p = m.getContactPoint(0);
    const double sign = m.getBody0() == sphere ? 1 : -1;
    // positions of 1 m in floats; with two nearest faces the normal may be that of either
    EXPECT_NEAR(double(p.getDistance()), distance, 2e-6);
    if (distance > -r) {
      EXPECT_GT(sign * double(p.m_normalWorldOnB.dot(box->getWorldTransform().getBasis() * normal)),
                1 - 1e-5);
    }
  }
  EXPECT_GT(touching, 500);
  EXPECT_GT(inside, 100);
}

TEST(FastSpheres, aSphereRestsOnABoxAndTheFunctionsOutliveTheCall) {
  BulletWorld bullet;
  useFastSphereAlgorithms(bullet.dispatcher);
  bullet.addBoxFloor();
  btRigidBody* sphere = bullet.add(std::make_unique<btSphereShape>(btScalar(0.1)), 1, vec(0.3, 0.5, 0.2));
  bullet.simulate(3.0);
  // the rest height has the error of Bullet's penetration slop, which is 0, and of rounding
  EXPECT_NEAR(heightOf(*sphere), 0.1, 1e-4);
  EXPECT_NEAR(double(sphere->getWorldTransform().getOrigin().x()), 0.3, 1e-4);
}

TEST(FastSpheres, aCubeOfPointsRestsOnAFreeBoxAsWithout) {
  double height[2];
  for (const bool fast : {false, true}) {
    SoftWorld bullet;
    if (fast) useFastSphereAlgorithms(bullet.dispatcher);
    bullet.addBoxFloor();
    bullet.addAwakeBox(vec(1, 0.2, 1), 2.0, vec(0, 0.2, 0));
    SoftBodySettings s;
    s.collision = Collision::Points;  // points are spheres to Bullet
    s.position = {0, 1.0, 0};
    s.damping = 5;
    s.pointRadius = 0.02;
    SoftBody* cube = bullet.addSoft(fullCubeNetwork(), s);
    bullet.simulate(5.0);
    height[fast] = cube->centerOfMass().y();
  }
  // the contacts of Bullet's general algorithm have errors of about 1e-5 m
  EXPECT_NEAR(height[0], height[1], 5e-5);
}

}  // namespace
}  // namespace limber::test
