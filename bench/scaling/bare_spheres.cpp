// SPDX-License-Identifier: Zlib
#include "scaling/bare_spheres.h"

#include <cstring>

namespace limber::bench {
namespace {

/// Without inertia, as the point masses of soft bodies are.
std::unique_ptr<btRigidBody> sphereLike(const btRigidBody& point, btSphereShape& shape) {
  btRigidBody::btRigidBodyConstructionInfo info(point.getMass(), nullptr, &shape, btVector3(0, 0, 0));
  info.m_startWorldTransform = point.getWorldTransform();
  info.m_friction = point.getFriction();
  auto sphere = std::make_unique<btRigidBody>(info);
  sphere->setAngularFactor(btScalar(0));
  sphere->setFlags(sphere->getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  return sphere;
}

void addFloorOf(const scenes::Scene& scene, scenes::SceneWorld& world) {
  const btRigidBody& floor = *scene.world->statics.front();
  const auto& box = static_cast<const btBoxShape&>(*floor.getCollisionShape());
  const btVector3 centre = floor.getWorldTransform().getOrigin();
  scenes::addStatic(world, std::make_unique<btBoxShape>(box.getHalfExtentsWithMargin()),
                    {double(centre.x()), double(centre.y()), double(centre.z())},
                    double(floor.getFriction()));
}

void addToHash(std::uint64_t& hash, const btVector3& v) {
  for (const btScalar value : {v.x(), v.y(), v.z()}) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof value);
    hash = (hash ^ bits) * 1099511628211ull;  // FNV-1a
  }
}

}  // namespace

std::unique_ptr<BareSpheres> makeBareSpheres(const scenes::Scene& scene) {
  auto bare = std::make_unique<BareSpheres>();
  addFloorOf(scene, bare->world);
  const SoftBody& first = *scene.soft->body(0);
  bare->shape =
      std::make_unique<btSphereShape>(static_cast<btScalar>(pointRadius(first.network(), first.settings())));
  for (std::size_t b = 0; b < scene.soft->bodyCount(); ++b) {
    const SoftBody& body = *scene.soft->body(b);
    for (std::uint32_t i = 0; i < body.pointCount(); ++i) {
      bare->spheres.push_back(sphereLike(*body.point(i), *bare->shape));
      bare->world.dynamics.addRigidBody(bare->spheres.back().get());
    }
  }
  return bare;
}

std::uint64_t stateHash(const BareSpheres& bare) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const auto& sphere : bare.spheres) {
    addToHash(hash, sphere->getWorldTransform().getOrigin());
    addToHash(hash, sphere->getLinearVelocity());
  }
  return hash;
}

}  // namespace limber::bench
