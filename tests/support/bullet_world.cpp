// SPDX-License-Identifier: Zlib
#include "support/bullet_world.h"

#include <cmath>

namespace limber::test {

BulletWorld::~BulletWorld() {
  if (!world) return;
  for (auto& body : bodies)
    if (body->isInWorld()) world->removeRigidBody(body.get());
}

btRigidBody* BulletWorld::add(std::unique_ptr<btCollisionShape> shape, double mass,
                              const btVector3& position) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape.get(), inertia);
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(position);
  shapes.push_back(std::move(shape));
  bodies.push_back(std::make_unique<btRigidBody>(info));
  world->addRigidBody(bodies.back().get());
  return bodies.back().get();
}

btRigidBody* BulletWorld::addBox(const btVector3& halfSize, double mass, const btVector3& position) {
  return add(std::make_unique<btBoxShape>(halfSize), mass, position);
}

btRigidBody* BulletWorld::addAwakeBox(const btVector3& halfSize, double mass, const btVector3& position) {
  btRigidBody* box = addBox(halfSize, mass, position);
  box->setActivationState(DISABLE_DEACTIVATION);
  return box;
}

btRigidBody* BulletWorld::addPlaneFloor() {
  return add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0, btVector3(0, 0, 0));
}

btRigidBody* BulletWorld::addBoxFloor() { return addBox(btVector3(50, 1, 50), 0, btVector3(0, -1, 0)); }

btRigidBody* BulletWorld::addHullFloor() {
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i) hull->addPoint(vec(i & 1 ? 30 : -30, i & 2 ? 1 : -1, i & 4 ? 30 : -30));
  const btScalar margin = hull->getMargin();
  return add(std::move(hull), 0, btVector3(0, -1 - margin, 0));
}

btRigidBody* BulletWorld::addTriangleFloor() {
  auto mesh = std::make_unique<btTriangleMesh>();
  const int cells = 40;
  const double size = 0.37;
  const auto corner = [&](int i, int j) { return vec((i - cells / 2) * size, 0, (j - cells / 2) * size); };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  meshes.push_back(std::move(mesh));
  return add(std::move(shape), 0, btVector3(0, 0, 0));
}

double BulletWorld::impulsesInManifolds() const {
  double sum = 0.0;
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
    for (int p = 0; p < manifold.getNumContacts(); ++p)
      sum += double(manifold.getContactPoint(p).m_appliedImpulse);
  }
  return sum;
}

void BulletWorld::simulate(double seconds, double dt) {
  const int ticks = static_cast<int>(std::lround(seconds / dt));
  for (int i = 0; i < ticks; ++i) tick(dt);
}

}  // namespace limber::test
