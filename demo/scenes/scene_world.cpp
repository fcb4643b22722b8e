// SPDX-License-Identifier: Zlib
#include "scenes/scene_world.h"

#include <utility>

namespace limber::scenes {

void addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& centre,
               double friction) {
  auto body = std::make_unique<btRigidBody>(btScalar(0), nullptr, shape.get());
  body->getWorldTransform().setOrigin(toBullet(centre));
  body->setFriction(btScalar(friction));
  world.dynamics.addRigidBody(body.get());
  world.shapes.push_back(std::move(shape));
  world.statics.push_back(std::move(body));
}

}  // namespace limber::scenes
