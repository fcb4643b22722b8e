// SPDX-License-Identifier: Zlib
#include "support/tiled_floors.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <cmath>

namespace limber::test {
namespace {

constexpr int kFirst = -2, kEnd = 8, kHalfWidth = 2;  // m

class FloorMaker {
 public:
  FloorMaker(BulletWorld& bullet, double friction, double slope)
      : bullet_(bullet),
        friction_(friction),
        tilt_(btQuaternion(btVector3(0, 0, 1), static_cast<btScalar>(-slope)), btVector3(0, 0, 0)) {}

  /// Adds a static body of the shape, at `position` before the floor is tilted.
  void add(std::unique_ptr<btCollisionShape> shape, const btVector3& position) {
    btRigidBody* body = bullet_.add(std::move(shape), 0, btVector3(0, 0, 0));
    body->setWorldTransform(tilt_ * btTransform(btQuaternion::getIdentity(), position));
    body->setFriction(static_cast<btScalar>(friction_));
    bullet_.world->updateSingleAabb(body);
  }

  /// Calls make(centre of a tile's top).
  template <class Make>
  static void forEachTile(Make make) {
    for (int i = kFirst; i < kEnd; ++i)
      for (int j = -kHalfWidth; j < kHalfWidth; ++j) make(vec(i + 0.5, 0, j + 0.5));
  }

  /// Adds a mesh with two triangles for each cell, in the floor's coordinates before the tilt.
  void addMesh(double x0, double x1, double z0, double z1, double cell) {
    auto mesh = std::make_unique<btTriangleMesh>();
    const int nx = static_cast<int>(std::lround((x1 - x0) / cell));
    const int nz = static_cast<int>(std::lround((z1 - z0) / cell));
    const auto corner = [&](int i, int j) { return vec(x0 + i * cell, 0, z0 + j * cell); };
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nz; ++j) {
        mesh->addTriangle(corner(i, j), corner(i, j + 1), corner(i + 1, j));
        mesh->addTriangle(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
      }
    auto shape = std::make_unique<btBvhTriangleMeshShape>(mesh.get(), true);
    bullet_.meshes.push_back(std::move(mesh));
    add(std::move(shape), btVector3(0, 0, 0));
  }

  void addHeightField() {
    static const std::vector<float> heights(
        static_cast<std::size_t>((kEnd - kFirst + 1) * (2 * kHalfWidth + 1)));
    auto shape = std::make_unique<btHeightfieldTerrainShape>(
        kEnd - kFirst + 1, 2 * kHalfWidth + 1, heights.data(), btScalar(-1), btScalar(1), 1, false);
    add(std::move(shape), vec(0.5 * (kEnd + kFirst), 0, 0));
  }

  void addCompound() {
    auto compound = std::make_unique<btCompoundShape>();
    forEachTile([&](const btVector3& top) {
      bullet_.shapes.push_back(std::make_unique<btBoxShape>(vec(0.5, 0.5, 0.5)));
      compound->addChildShape(btTransform(btQuaternion::getIdentity(), top - vec(0, 0.5, 0)),
                              bullet_.shapes.back().get());
    });
    add(std::move(compound), btVector3(0, 0, 0));
  }

  /// Bullet adds the margin around a hull: the tops are flush, the sides overlap.
  void addHulls() {
    forEachTile([&](const btVector3& top) {
      auto hull = std::make_unique<btConvexHullShape>();
      for (int i = 0; i < 8; ++i) hull->addPoint(vec(i & 1 ? .5 : -.5, i & 2 ? .5 : -.5, i & 4 ? .5 : -.5));
      const btScalar margin = hull->getMargin();
      add(std::move(hull), top - btVector3(0, btScalar(0.5) + margin, 0));
    });
  }

  void addBoxes() {
    forEachTile([&](const btVector3& top) {
      add(std::make_unique<btBoxShape>(vec(0.5, 0.5, 0.5)), top - vec(0, 0.5, 0));
    });
  }

 private:
  BulletWorld& bullet_;
  double friction_;
  btTransform tilt_;
};

}  // namespace

const char* nameOf(FloorKind kind) {
  switch (kind) {
    case FloorKind::Plane:
      return "Plane";
    case FloorKind::Box:
      return "Box";
    case FloorKind::BoxTiles:
      return "BoxTiles";
    case FloorKind::Compound:
      return "Compound";
    case FloorKind::HullTiles:
      return "HullTiles";
    case FloorKind::CoarseMesh:
      return "CoarseMesh";
    case FloorKind::FineMesh:
      return "FineMesh";
    case FloorKind::MeshTiles:
      return "MeshTiles";
    case FloorKind::HeightField:
      return "HeightField";
  }
  return "";
}

void addTiledFloor(BulletWorld& bullet, FloorKind kind, double friction, double slope) {
  FloorMaker maker(bullet, friction, slope);
  switch (kind) {
    case FloorKind::Plane:
      return maker.add(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)),
                       btVector3(0, 0, 0));
    case FloorKind::Box:
      return maker.add(std::make_unique<btBoxShape>(vec(10, 1, 10)), vec(0, -1, 0));
    case FloorKind::BoxTiles:
      return maker.addBoxes();
    case FloorKind::Compound:
      return maker.addCompound();
    case FloorKind::HullTiles:
      return maker.addHulls();
    case FloorKind::CoarseMesh:
      return maker.addMesh(kFirst, kEnd, -kHalfWidth, kHalfWidth, 1.0);
    case FloorKind::FineMesh:
      return maker.addMesh(kFirst, kEnd, -kHalfWidth, kHalfWidth, 0.1);
    case FloorKind::MeshTiles:
      for (int i = kFirst; i < kEnd; i += 2) maker.addMesh(i, i + 2, -kHalfWidth, kHalfWidth, 1.0);
      return;
    case FloorKind::HeightField:
      return maker.addHeightField();
  }
}

}  // namespace limber::test
