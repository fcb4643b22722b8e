// SPDX-License-Identifier: Zlib
#include "accuracy/rigid_bodies.h"

#include "engines/body_start.h"

#include <utility>

namespace limber::bench {
namespace {

void add(RigidBodies& rigid, btDiscreteDynamicsWorld& world, std::unique_ptr<btCollisionShape> shape,
         double mass, const Eigen::Vector3d& centre, double friction) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape.get(), inertia);
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(toBullet(centre));
  info.m_friction = static_cast<btScalar>(friction);
  auto body = std::make_unique<btRigidBody>(info);
  if (mass > 0) body->setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(body.get());
  rigid.shapes.push_back(std::move(shape));
  rigid.bodies.push_back(std::move(body));
}

std::unique_ptr<btCollisionShape> hull() {
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i)
    shape->addPoint(toBullet({i & 1 ? 10. : -10., i & 2 ? 1. : -1., i & 4 ? 10. : -10.}));
  return shape;
}

std::unique_ptr<btCollisionShape> triangles(RigidBodies& rigid) {
  const int cells = 20;
  const double size = 0.37;  // m; the cube's points stand on different triangles
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) {
    return toBullet({(i - cells / 2) * size, 0, (j - cells / 2) * size});
  };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  rigid.meshes.push_back(std::move(mesh));
  return shape;
}

}  // namespace

void addFloor(RigidBodies& rigid, btDiscreteDynamicsWorld& world, Floor floor, double friction) {
  switch (floor) {
    case Floor::Plane:
      return add(rigid, world, std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)), 0,
                 {0, 0, 0}, friction);
    case Floor::Box:
      return addBox(rigid, world, {10, 1, 10}, 0, {0, -1, 0}, friction);
    case Floor::Hull: {
      auto shape = hull();
      const double margin = double(shape->getMargin());
      return add(rigid, world, std::move(shape), 0, {0, -1 - margin, 0}, friction);
    }
    case Floor::TriangleMesh:
      return add(rigid, world, triangles(rigid), 0, {0, 0, 0}, friction);
  }
}

void addBox(RigidBodies& rigid, btDiscreteDynamicsWorld& world, const Eigen::Vector3d& halfSize, double mass,
            const Eigen::Vector3d& centre, double friction) {
  add(rigid, world, std::make_unique<btBoxShape>(toBullet(halfSize)), mass, centre, friction);
}

}  // namespace limber::bench
