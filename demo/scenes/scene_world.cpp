// SPDX-License-Identifier: Zlib
#include "scenes/scene_world.h"

#include <utility>

namespace limber::scenes {

btRigidBody& addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape,
                       const Eigen::Vector3d& centre, double friction) {
  auto body = std::make_unique<btRigidBody>(btScalar(0), nullptr, shape.get());
  body->getWorldTransform().setOrigin(toBullet(centre));
  body->setFriction(btScalar(friction));
  world.dynamics.addRigidBody(body.get());
  world.shapes.push_back(std::move(shape));
  world.statics.push_back(std::move(body));
  return *world.statics.back();
}

btRigidBody& addMovable(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, double mass,
                        const Eigen::Vector3d& centre, double friction) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0.0) shape->calculateLocalInertia(btScalar(mass), inertia);
  auto body = std::make_unique<btRigidBody>(btScalar(mass), nullptr, shape.get(), inertia);
  body->getWorldTransform().setOrigin(toBullet(centre));
  body->setInterpolationWorldTransform(body->getWorldTransform());
  body->setFriction(btScalar(friction));
  if (mass == 0.0) {
    body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
  }
  world.dynamics.addRigidBody(body.get());
  world.shapes.push_back(std::move(shape));
  world.movables.push_back(std::move(body));
  return *world.movables.back();
}

void moveTo(btRigidBody& body, const Eigen::Vector3d& centre) {
  btTransform transform = body.getWorldTransform();
  transform.setOrigin(toBullet(centre));
  body.setWorldTransform(transform);
}

}  // namespace limber::scenes
