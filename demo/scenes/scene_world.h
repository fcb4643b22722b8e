// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

namespace limber::scenes {

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(btScalar(v.x()), btScalar(v.y()), btScalar(v.z()));
}

/// A plain Bullet world under earth's gravity with the static bodies in it.
struct SceneWorld {
  // the world comes last, so that it goes first, while what is in it still exists
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> statics;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};

  SceneWorld() { dynamics.setGravity(btVector3(0, btScalar(-9.81), 0)); }
  SceneWorld(const SceneWorld&) = delete;
  SceneWorld& operator=(const SceneWorld&) = delete;
};

/// Adds an immovable body of the given shape and friction.
void addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& centre,
               double friction);

}  // namespace limber::scenes
