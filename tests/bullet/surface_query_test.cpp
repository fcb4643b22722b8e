// SPDX-License-Identifier: Zlib
// Rays, sweeps and contact tests find the deformed surface of a soft body and return the point on it.
#include "support/soft_world.h"

#include <limits>

namespace limber::test {
namespace {

/// Records the triangle that Bullet reports for a ray's hit.
struct Contacts final : btCollisionWorld::ContactResultCallback {
  const btCollisionObject* surface = nullptr;
  int triangle = -1, found = 0;
  btScalar nearest = 1e9f;
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int indexA,
                           const btCollisionObjectWrapper* b, int, int indexB) override {
    ++found;
    const bool first = findSurface(a->getCollisionObject()).body != nullptr;
    surface = (first ? a : b)->getCollisionObject();
    triangle = first ? indexA : indexB;
    nearest = std::min(nearest, point.getDistance());
    return 0;
  }
};

Eigen::Vector3d pointOf(const SurfaceHit& hit) {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    point += hit.weights[static_cast<Eigen::Index>(i)] * hit.body->position(hit.points[i]);
  return point;
}

/// A closed cube after motion, rotation and deformation: its triangles are far from where they started.
struct SurfaceQuery : testing::Test {
  SurfaceQuery() : bullet(0.0), system(*bullet.world) {
    SoftBodySettings s = settingsAt({3, 1, -2});
    s.linearVelocity = {1, 0.5, 0};
    s.angularVelocity = {1, 2, 3};
    body = *system.createBody(closedCubeNetwork(), s);
    body->point(7)->applyCentralImpulse(vec(-0.3, -0.2, 0));
    bullet.simulate(0.3);
  }
  BulletWorld bullet;
  SoftBodySystem system;
  SoftBody* body;
};

TEST_F(SurfaceQuery, theObjectTellsOfTheBody) {
  const btRigidBody* object = body->surfaceObject();
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(findSurface(object).body, body);
  EXPECT_EQ(findSurface(nullptr).body, nullptr);
  EXPECT_EQ(findSurface(body->point(0)).body, nullptr);
  EXPECT_EQ(findPoint(body->point(3)).index, 3u);
  EXPECT_TRUE(object->hasContactResponse());
  EXPECT_FALSE(object->isStaticOrKinematicObject());
  // floats a few metres from the origin
  EXPECT_LT((eigen(object->getWorldTransform().getOrigin()) - body->centerOfMass()).norm(), 1e-6);
  EXPECT_LT((eigen(object->getLinearVelocity()) - body->linearMomentum() / body->totalMass()).norm(), 1e-6);
}

TEST_F(SurfaceQuery, aRayHitsTheMiddleOfEveryTriangle) {
  const auto& surface = body->network().surface;
  const Eigen::Vector3d weights(0.5, 0.3, 0.2);
  for (std::size_t t = 0; t < surface.size(); ++t) {
    Eigen::Matrix3d x;
    for (int i = 0; i < 3; ++i) x.col(i) = body->position(surface[t][static_cast<std::size_t>(i)]);
    const Eigen::Vector3d normal = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).normalized();
    const Eigen::Vector3d target = x * weights, from = target + 0.1 * normal, to = target - 0.1 * normal;
    TriangleRay ray(vec(from.x(), from.y(), from.z()), vec(to.x(), to.y(), to.z()));
    bullet.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    ASSERT_TRUE(ray.hasHit()) << t;
    EXPECT_EQ(ray.m_collisionObject, body->surfaceObject());
    EXPECT_EQ(ray.triangle, static_cast<int>(t));
    const SurfaceHit hit = surfaceHit(ray.m_collisionObject, ray.triangle, ray.m_hitPointWorld);
    EXPECT_EQ(hit.body, body);
    EXPECT_EQ(hit.triangle, t);
    // Bullet's floats: 1e-6 of a metre; edges are about a metre long
    EXPECT_LT((hit.weights - weights).norm(), 1e-5);
    EXPECT_LT((hit.normal - normal).norm(), 1e-9);
    EXPECT_LT((pointOf(hit) - target).norm(), 1e-5);
  }
}

TEST_F(SurfaceQuery, whatIsNoTriangleIsNoHit) {
  const btRigidBody* object = body->surfaceObject();
  EXPECT_EQ(surfaceHit(object, 12, btVector3(0, 0, 0)).body, nullptr);
  EXPECT_EQ(surfaceHit(object, -1, btVector3(0, 0, 0)).body, nullptr);
  EXPECT_EQ(surfaceHit(body->point(0), 0, btVector3(0, 0, 0)).body, nullptr);
  EXPECT_EQ(surfaceHit(nullptr, 0, btVector3(0, 0, 0)).body, nullptr);
  const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
  EXPECT_EQ(surfaceHit(object, 0, btVector3(nan, 0, 0)).body, nullptr);
  SurfaceHit hit = surfaceHit(object, 0, btVector3(0, 0, 0));
  hit.weights[1] = double(nan);
  EXPECT_EQ(body->applyImpulse(btVector3(0, 1, 0), hit).error(), "the weights of the hit are not finite");
}

TEST_F(SurfaceQuery, aPlaceBesideATriangleIsMovedToItsNearestSide) {
  const Triangle& corners = body->network().surface[4];
  const Eigen::Vector3d a = body->position(corners[0]), b = body->position(corners[1]),
                        c = body->position(corners[2]), beyond = b + 0.5 * (b - 0.5 * (a + c));
  const SurfaceHit hit = surfaceHit(body->surfaceObject(), 4, vec(beyond.x(), beyond.y(), beyond.z()));
  EXPECT_GE(hit.weights.minCoeff(), 0.0);
  EXPECT_NEAR(hit.weights.sum(), 1.0, 1e-12);
  // the smallest distance over a grid on the triangle
  double nearest = 1e9;
  for (int i = 0; i <= 200; ++i)
    for (int j = 0; j + i <= 200; ++j) {
      const double v = i / 200.0, w = j / 200.0;
      nearest = std::min(nearest, ((1 - v - w) * a + v * b + w * c - beyond).norm());
    }
  EXPECT_NEAR((pointOf(hit) - beyond).norm(), nearest, 1e-4) << "the grid of the brute force is 1 / 200";
}

TEST_F(SurfaceQuery, sweepsAndContactTestsFindItToo) {
  const Eigen::Vector3d center = body->centerOfMass();
  const btVector3 c = vec(center.x(), center.y(), center.z());
  btSphereShape ball(vec(0.1, 0, 0).x());
  btTransform from(btQuaternion::getIdentity(), c + vec(0, 3, 0)), to(btQuaternion::getIdentity(), c);
  btCollisionWorld::ClosestConvexResultCallback sweep(from.getOrigin(), to.getOrigin());
  bullet.world->convexSweepTest(&ball, from, to, sweep);
  ASSERT_TRUE(sweep.hasHit());
  EXPECT_EQ(sweep.m_hitCollisionObject, body->surfaceObject());

  const Triangle& corners = body->network().surface[0];
  const Eigen::Vector3d middle =
      (body->position(corners[0]) + body->position(corners[1]) + body->position(corners[2])) / 3;
  btCollisionObject probe;
  probe.setCollisionShape(&ball);
  probe.getWorldTransform().setOrigin(vec(middle.x(), middle.y(), middle.z()));
  Contacts all, pair;
  bullet.world->contactTest(&probe, all);
  EXPECT_EQ(all.surface, body->surfaceObject());
  EXPECT_GE(all.found, 1);
  bullet.world->contactPairTest(&probe, body->surfaceObject(), pair);
  EXPECT_GE(pair.found, 1);
  EXPECT_NE(surfaceHit(pair.surface, pair.triangle, probe.getWorldTransform().getOrigin()).body, nullptr);
  probe.getWorldTransform().setOrigin(vec(50, 50, 50));
  Contacts none;
  bullet.world->contactPairTest(&probe, body->surfaceObject(), none);
  EXPECT_EQ(none.found, 0);
}

TEST(SurfaceOfARope, isFoundAlongItsSprings) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = settingsAt({0, 1, 0});
  s.pointRadius = 0.05;
  SoftBody* rope = bullet.addSoft(chainNetwork(4), s);
  bullet.tick();
  // at 0.6 of the third spring, from two sides; 4 cm off axis still hits, 6 cm does not
  for (const auto& [direction, side] :
       {std::pair(vec(1, 0, 0), vec(0, 0, 1)), std::pair(vec(0, 0, 1), vec(1, 0, 0))})
    for (const double off : {0.0, 0.04, 0.06}) {
      const btVector3 target = vec(0, 1 - 0.65, 0) + side * vec(off, 0, 0).x();
      TriangleRay ray(target - direction, target + direction);
      bullet.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
      EXPECT_EQ(ray.hasHit(), off < 0.05);
      if (!ray.hasHit()) continue;
      const SurfaceHit hit = surfaceHit(ray.m_collisionObject, ray.triangle, ray.m_hitPointWorld);
      EXPECT_EQ(hit.body, rope);
      EXPECT_EQ(hit.triangle, 2u);
      EXPECT_EQ(hit.points[0], 2u);
      EXPECT_EQ(hit.points[1], 3u);
      EXPECT_NEAR(hit.weights[1], 0.6, 1e-5);
    }
}

TEST(SurfaceQueries, findAMovedBodyAtOnce) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.05;
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), s);
  bullet.tick();
  const auto isHitAt = [&](double x) {
    TriangleRay ray(vec(x, 5, 0.5), vec(x, -5, 0.5));
    bullet.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    return ray.hasHit();
  };
  ASSERT_TRUE(isHitAt(0.5));
  const std::vector<std::uint8_t> state = body->saveState();
  const btTransform there(btQuaternion::getIdentity(), vec(100, 0, 0));
  ASSERT_TRUE(body->setTransform(there));
  EXPECT_TRUE(isHitAt(100.5));
  EXPECT_FALSE(isHitAt(0.5));
  ASSERT_TRUE(body->reset());
  EXPECT_TRUE(isHitAt(0.5));
  EXPECT_FALSE(isHitAt(100.5));
  SoftBodySettings large = body->settings();
  large.scale = {3, 1, 1};
  ASSERT_TRUE(body->change(large));
  EXPECT_TRUE(isHitAt(1.5));
  ASSERT_TRUE(body->reset(there));
  EXPECT_TRUE(isHitAt(101.5));
  ASSERT_TRUE(body->restoreState(state));
  EXPECT_TRUE(isHitAt(0.5));
  EXPECT_FALSE(isHitAt(101.5));
}

}  // namespace
}  // namespace limber::test
