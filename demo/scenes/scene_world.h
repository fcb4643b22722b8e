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

inline Eigen::Vector3d fromBullet(const btVector3& v) {
  return {double(v.x()), double(v.y()), double(v.z())};
}

/// A plain Bullet world under earth's gravity with the rigid bodies in it.
struct SceneWorld {
  // the world comes last, so that it goes first, while what is in it still exists
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> statics;
  std::vector<std::unique_ptr<btRigidBody>> movables;  ///< dynamic and kinematic ones
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
btRigidBody& addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape,
                       const Eigen::Vector3d& centre, double friction);

/// Adds a body of that mass in kg, or, with mass 0, a kinematic one, which the scene moves.
btRigidBody& addMovable(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, double mass,
                        const Eigen::Vector3d& centre, double friction);

/// Moves a kinematic body; it gets there during the next tick.
void moveTo(btRigidBody& body, const Eigen::Vector3d& centre);

}  // namespace limber::scenes
