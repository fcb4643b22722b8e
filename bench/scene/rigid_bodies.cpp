// SPDX-License-Identifier: Zlib
#include "scene/rigid_bodies.h"

#include "bullet_soft/body_start.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

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

std::unique_ptr<btConvexHullShape> hull(const Eigen::Vector3d& half) {
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i)
    shape->addPoint(
        toBullet({i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()}));
  return shape;
}

/// Returns a mesh of nx x nz cells of `size` (m), two triangles each, from the corner (x, 0, z) on.
std::unique_ptr<btCollisionShape> triangles(RigidBodies& rigid, double x, double z, int nx, int nz,
                                            double size) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) { return toBullet({x + i * size, 0, z + j * size}); };
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < nz; ++j) {
      mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
      mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
    }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
  rigid.meshes.push_back(std::move(mesh));
  return shape;
}

// --- tiled floors ------------------------------------------------------------------------------------------

constexpr int kTilesAlong = 17, kTilesAcross = 8;  // of 1 m
constexpr double kFirstX = -4.0, kFirstZ = -4.0;   // m
const Eigen::Vector3d kHalfTile(0.5, 0.5, 0.5);

/// Calls visit(centre) for each tile; the tiles' tops are y = 0.
template <class Visit>
void forEachTile(Visit visit) {
  for (int i = 0; i < kTilesAlong; ++i)
    for (int j = 0; j < kTilesAcross; ++j)
      visit(Eigen::Vector3d(kFirstX + i + 0.5, -kHalfTile.y(), kFirstZ + j + 0.5));
}

std::unique_ptr<btCollisionShape> heightField() {
  static const std::vector<float> kFlat((kTilesAlong + 1) * (kTilesAcross + 1), 0.0f);
  return std::make_unique<btHeightfieldTerrainShape>(kTilesAlong + 1, kTilesAcross + 1, kFlat.data(),
                                                     btScalar(1), btScalar(-1), btScalar(1), 1, PHY_FLOAT,
                                                     false);
}

std::unique_ptr<btCollisionShape> compound(RigidBodies& rigid) {
  auto tile = std::make_unique<btBoxShape>(toBullet(kHalfTile));
  auto shape = std::make_unique<btCompoundShape>();
  forEachTile([&](const Eigen::Vector3d& centre) {
    shape->addChildShape(btTransform(btQuaternion::getIdentity(), toBullet(centre)), tile.get());
  });
  rigid.shapes.push_back(std::move(tile));
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
      auto shape = hull({10, 1, 10});
      const double margin = double(shape->getMargin());
      return add(rigid, world, std::move(shape), 0, {0, -1 - margin, 0}, friction);
    }
    case Floor::TriangleMesh:
      // the points of a cube stand on different triangles
      return add(rigid, world, triangles(rigid, -3.7, -3.7, 20, 20, 0.37), 0, {0, 0, 0}, friction);
    case Floor::CoarseMesh:
      return add(rigid, world, triangles(rigid, kFirstX, kFirstZ, kTilesAlong, kTilesAcross, 1.0), 0,
                 {0, 0, 0}, friction);
    case Floor::FineMesh:
      return add(rigid, world, triangles(rigid, kFirstX, kFirstZ, 10 * kTilesAlong, 10 * kTilesAcross, 0.1),
                 0, {0, 0, 0}, friction);
    case Floor::HeightField:
      return add(rigid, world, heightField(), 0,
                 {kFirstX + 0.5 * kTilesAlong, 0, kFirstZ + 0.5 * kTilesAcross}, friction);
    case Floor::Boxes:
      return forEachTile(
          [&](const Eigen::Vector3d& centre) { addBox(rigid, world, kHalfTile, 0, centre, friction); });
    case Floor::Compound:
      return add(rigid, world, compound(rigid), 0, {0, 0, 0}, friction);
    case Floor::Hulls:
      return forEachTile([&](const Eigen::Vector3d& centre) {
        auto shape = hull(kHalfTile);
        shape->setMargin(0);
        add(rigid, world, std::move(shape), 0, centre, friction);
      });
  }
}

void addBox(RigidBodies& rigid, btDiscreteDynamicsWorld& world, const Eigen::Vector3d& halfSize, double mass,
            const Eigen::Vector3d& centre, double friction) {
  add(rigid, world, std::make_unique<btBoxShape>(toBullet(halfSize)), mass, centre, friction);
}

}  // namespace limber::bench
