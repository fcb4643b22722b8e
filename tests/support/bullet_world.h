// SPDX-License-Identifier: Zlib
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace limber::test {

/// A Bullet world set up as in Bullet's HelloWorld. Owns the bodies that a test adds.
struct BulletWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::unique_ptr<btDiscreteDynamicsWorld> world =
      std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration);

  explicit BulletWorld(double gravity = -9.81) {
    world->setGravity(btVector3(0, static_cast<btScalar>(gravity), 0));
  }
  ~BulletWorld();
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// Adds a body of the shape with its centre at `position`; mass 0 makes it static.
  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, double mass, const btVector3& position);
  btRigidBody* addBox(const btVector3& halfSize, double mass, const btVector3& position);
  btRigidBody* addAwakeBox(const btVector3& halfSize, double mass,
                           const btVector3& position);  ///< never sleeps
  btRigidBody* addPlaneFloor();                         ///< a static plane y = 0
  btRigidBody* addBoxFloor();                           ///< a static box with its top at y = 0
  btRigidBody* addHullFloor();      ///< a static convex hull with its top at y = 0, margin included
  btRigidBody* addTriangleFloor();  ///< a static triangle mesh at y = 0, cells of 0.37 m

  /// Returns the sum of the impulses (N s) in Bullet's manifolds.
  double impulsesInManifolds() const;

  /// Advances by one tick of dt. Bullet's accumulation of time is off.
  void tick(double dt = 1.0 / 60.0) { world->stepSimulation(static_cast<btScalar>(dt), 0); }
  void simulate(double seconds, double dt = 1.0 / 60.0);
};

/// An action that calls a function once. One that was added before the soft bodies runs before the end of
/// their tick.
struct ActionOnce final : btActionInterface {
  std::function<void()> act;
  void updateAction(btCollisionWorld*, btScalar) override {
    if (act) std::exchange(act, nullptr)();
  }
  void debugDraw(btIDebugDraw*) override {}
};

/// A ray that knows the part and the triangle of its nearest hit.
struct TriangleRay final : btCollisionWorld::ClosestRayResultCallback {
  using ClosestRayResultCallback::ClosestRayResultCallback;
  int part = -1, triangle = -1;
  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool inWorld) override {
    part = result.m_localShapeInfo ? result.m_localShapeInfo->m_shapePart : -1;
    triangle = result.m_localShapeInfo ? result.m_localShapeInfo->m_triangleIndex : -1;
    return ClosestRayResultCallback::addSingleResult(result, inWorld);
  }
};

/// Lets the user move a body of mass 0 in each tick.
inline void makeKinematic(btRigidBody& body) {
  body.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  body.setActivationState(DISABLE_DEACTIVATION);
}

inline btVector3 vec(double x, double y, double z) {
  return btVector3(static_cast<btScalar>(x), static_cast<btScalar>(y), static_cast<btScalar>(z));
}

}  // namespace limber::test
