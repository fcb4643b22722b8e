// SPDX-License-Identifier: Zlib
#include "fuzz/bullet_shapes.h"

#include "mesh/random.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cmath>
#include <stdexcept>

namespace limber::fuzz {
namespace {

using Eigen::Vector3d;

void addQuad(btTriangleMesh& mesh, const btVector3& a, const btVector3& b, const btVector3& c,
             const btVector3& d) {
  mesh.addTriangle(a, b, c);
  mesh.addTriangle(a, c, d);
}

/// Returns a grid over -extent..extent with the heights `height(x, z)`, facing up.
template <class Height>
std::unique_ptr<btTriangleMesh> gridMesh(double extentX, double extentZ, int cells, Height height) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i, int j) {
    const double x = extentX * (2.0 * i / cells - 1.0), z = extentZ * (2.0 * j / cells - 1.0);
    return toBt(Vector3d(x, height(x, z), z));
  };
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      addQuad(*mesh, corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j));
  return mesh;
}

double waves(double x, double z, double height, int variant) {
  return variant % 3 == 0 ? 0.0 : height * 0.5 * std::sin(2.0 * x + variant) * std::cos(1.7 * z);
}

/// A closed box of 12 triangles.
std::unique_ptr<btTriangleMesh> boxMesh(const Vector3d& half) {
  auto mesh = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i) {
    return toBt(
        Vector3d(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()));
  };
  const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : faces) addQuad(*mesh, corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]));
  return mesh;
}

std::unique_ptr<btConvexHullShape> hull(const Vector3d& size, int variant) {
  auto made = std::make_unique<btConvexHullShape>();
  Random random(static_cast<std::uint64_t>(variant) + 77);
  const int points = 6 + variant % 20;
  for (int i = 0; i < points; ++i) made->addPoint(toBt(random.direction().cwiseProduct(size)));
  return made;
}

void makeConvex(OwnedShape& made, const std::string& name, const Vector3d& s, int variant) {
  const double round = 0.5 * (s.x() + s.z());
  const auto isKind = [&](const char* kind) { return name.rfind(kind, 0) == 0; };
  const char axis = name.back();
  if (name == "box")
    made.shape = std::make_unique<btBoxShape>(toBt(s));
  else if (name == "sphere")
    made.shape = std::make_unique<btSphereShape>(toBt(s.x()));
  else if (name == "hull")
    made.shape = hull(s, variant);
  else if (isKind("capsule")) {
    if (axis == 'x')
      made.shape = std::make_unique<btCapsuleShapeX>(toBt(s.y()), toBt(s.x()));
    else if (axis == 'y')
      made.shape = std::make_unique<btCapsuleShape>(toBt(s.x()), toBt(s.y()));
    else
      made.shape = std::make_unique<btCapsuleShapeZ>(toBt(s.x()), toBt(s.z()));
  } else if (isKind("cylinder")) {
    if (axis == 'x')
      made.shape = std::make_unique<btCylinderShapeX>(toBt(s));
    else if (axis == 'y')
      made.shape = std::make_unique<btCylinderShape>(toBt(s));
    else
      made.shape = std::make_unique<btCylinderShapeZ>(toBt(s));
  } else if (isKind("cone")) {
    if (axis == 'x')
      made.shape = std::make_unique<btConeShapeX>(toBt(round), toBt(2 * s.y()));
    else if (axis == 'y')
      made.shape = std::make_unique<btConeShape>(toBt(round), toBt(2 * s.y()));
    else
      made.shape = std::make_unique<btConeShapeZ>(toBt(round), toBt(2 * s.y()));
  } else if (name == "multi-sphere") {
    const btVector3 centres[3] = {btVector3(0, 0, 0), toBt(Vector3d(s.x() * 0.5, 0, 0)),
                                  toBt(Vector3d(0, s.y() * 0.4, s.z() * 0.3))};
    const btScalar radii[3] = {toBt(s.x() * 0.5), toBt(s.x() * 0.4), toBt(s.x() * 0.3)};
    made.shape = std::make_unique<btMultiSphereShape>(centres, radii, 1 + variant % 3);
  } else if (name == "tetrahedron") {
    auto simplex = std::make_unique<btBU_Simplex1to4>();
    for (const Vector3d& p : {Vector3d(-s.x(), -s.y(), -s.z()), Vector3d(s.x(), -s.y(), -s.z()),
                              Vector3d(0, -s.y(), s.z()), Vector3d(0, s.y(), 0)})
      simplex->addVertex(toBt(p));
    made.shape = std::move(simplex);
  } else if (name == "triangle-hull") {
    made.meshes.push_back(boxMesh(s));
    made.shape = std::make_unique<btConvexTriangleMeshShape>(made.meshes.back().get());
  } else if (name == "scaled") {
    made.parts.push_back(std::make_unique<btCylinderShape>(toBt(s * 2.0)));
    made.shape = std::make_unique<btUniformScalingShape>(static_cast<btConvexShape*>(made.parts.back().get()),
                                                         toBt(0.5));
  }
}

/// Returns a compound of two or more shapes; if `nested`, of a compound as well.
std::unique_ptr<btCompoundShape> compound(OwnedShape& owner, const Vector3d& s, int variant, bool nested) {
  auto made = std::make_unique<btCompoundShape>(variant % 4 != 3);
  const char* const kinds[] = {"box", "sphere", "capsule-y", "hull"};
  for (int i = 0; i < 2 + variant % 3; ++i) {
    OwnedShape child;
    makeConvex(child, kinds[(i + variant) % 4], s * 0.45, variant + i);
    btTransform at(rotationOf(Vector3d(0.3 * i, 0.2 * variant, 0)),
                   toBt(Vector3d(s.x() * (0.5 * i - 0.5), s.y() * 0.3 * (i % 2), s.z() * 0.2 * i)));
    owner.parts.push_back(std::move(child.shape));
    made->addChildShape(at, owner.parts.back().get());
  }
  if (nested) {
    owner.parts.push_back(compound(owner, s * 0.5, variant + 1, false));
    made->addChildShape(btTransform(btQuaternion::getIdentity(), toBt(Vector3d(0, s.y() * 0.5, 0))),
                        owner.parts.back().get());
  }
  return made;
}

void makeHeightField(OwnedShape& made, double extentX, double extentZ, int cells, double height,
                     int variant) {
  const int n = cells + 1;
  made.heights = std::make_unique<std::vector<btScalar>>();
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = extentX * (2.0 * i / cells - 1.0), z = extentZ * (2.0 * j / cells - 1.0);
      made.heights->push_back(toBt(waves(x, z, height, variant)));
    }
  auto field = std::make_unique<btHeightfieldTerrainShape>(
      n, n, made.heights->data(), btScalar(1), toBt(-height), toBt(height), 1, PHY_FLOAT, variant % 2 == 1);
  field->setLocalScaling(btVector3(toBt(2 * extentX / cells), btScalar(1), toBt(2 * extentZ / cells)));
  made.shape = std::move(field);
}

void makeConcave(OwnedShape& made, const std::string& name, const Vector3d& s, int variant) {
  made.fixed = true;
  const auto height = [&](double x, double z) { return waves(x, z, s.y(), variant); };
  if (name == "plane") {
    made.shape = std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0));
  } else if (name == "mesh") {
    made.meshes.push_back(gridMesh(s.x() * 3, s.z() * 3, 4 + variant % 8, height));
    made.shape = std::make_unique<btBvhTriangleMeshShape>(made.meshes.back().get(), true);
  } else if (name == "scaled-mesh") {
    made.meshes.push_back(variant % 2 ? boxMesh(s) : gridMesh(s.x() * 3, s.z() * 3, 5, height));
    made.parts.push_back(std::make_unique<btBvhTriangleMeshShape>(made.meshes.back().get(), true));
    made.shape = std::make_unique<btScaledBvhTriangleMeshShape>(
        static_cast<btBvhTriangleMeshShape*>(made.parts.back().get()),
        btVector3(1, btScalar(1.5), btScalar(0.8)));
  } else if (name == "height-field") {
    makeHeightField(made, s.x() * 3, s.z() * 3, 4 + variant % 8, s.y(), variant);
  }
}

double boundingRadius(const btCollisionShape& shape) {
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  return std::fmin(100.0, double(btMax(low.length(), high.length())));
}

}  // namespace

btQuaternion rotationOf(const Vector3d& axial) {
  const double angle = axial.norm();
  if (angle < 1e-12) return btQuaternion::getIdentity();
  return btQuaternion(toBt(axial / angle), toBt(angle));
}

OwnedShape makeShape(const std::string& name, const Vector3d& size, int variant) {
  OwnedShape made;
  variant = std::abs(variant) % 1000;
  makeConvex(made, name, size, variant);
  if (!made.shape) makeConcave(made, name, size, variant);
  if (name == "compound" || name == "nested") {
    made.fixed = false;
    made.shape = compound(made, size, variant, name == "nested");
  }
  if (name == "gimpact") {
    made.fixed = false;
    made.meshes.push_back(boxMesh(size));
    auto shape = std::make_unique<btGImpactMeshShape>(made.meshes.back().get());
    shape->updateBound();
    made.shape = std::move(shape);
  }
  if (!made.shape) throw std::runtime_error("no shape is called " + name);
  made.radius = boundingRadius(*made.shape);
  return made;
}

// --- floors ------------------------------------------------------------------------------------------------

namespace {

/// m, half the thickness of floors made of boxes.
double thickness(double extent) { return extent / 6.0; }

FloorPiece onePiece(OwnedShape shape, double y = 0.0) {
  shape.fixed = true;
  return {std::move(shape), Vector3d(0, y, 0)};
}

OwnedShape hullBox(const Vector3d& half) {
  auto shape = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 8; ++i)
    shape->addPoint(toBt(
        Vector3d(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z())));
  OwnedShape made;
  made.shape = std::move(shape);
  return made;
}

/// Calls add(x, z) for the centre of each square of a floor.
template <class Add>
void forSquares(double extent, int cells, Add add) {
  const double width = 2.0 * extent / cells;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) add(width * (i + 0.5) - extent, width * (j + 0.5) - extent);
}

FloorPiece compoundFloor(double extent, int cells) {
  OwnedShape made;
  const Vector3d half(extent / cells, thickness(extent), extent / cells);
  auto whole = std::make_unique<btCompoundShape>();
  made.parts.push_back(std::make_unique<btBoxShape>(toBt(half)));
  forSquares(extent, cells, [&](double x, double z) {
    whole->addChildShape(btTransform(btQuaternion::getIdentity(), toBt(Vector3d(x, -thickness(extent), z))),
                         made.parts.back().get());
  });
  made.shape = std::move(whole);
  return onePiece(std::move(made));
}

std::vector<FloorPiece> tiledFloor(bool hulls, double extent, int cells) {
  std::vector<FloorPiece> pieces;
  const Vector3d half(extent / cells, thickness(extent), extent / cells);
  forSquares(extent, cells, [&](double x, double z) {
    FloorPiece piece = onePiece(hulls ? hullBox(half) : makeShape("box", half, 0), -thickness(extent));
    // the margin of a hull is outside of it
    if (hulls) piece.shape.shape->setMargin(0);
    piece.position += Vector3d(x, 0, z);
    pieces.push_back(std::move(piece));
  });
  return pieces;
}

OwnedShape meshFloor(const std::string& kind, double extent, int cells) {
  const auto flat = [](double, double) { return 0.0; };
  OwnedShape made;
  if (kind == "height-field") {
    makeHeightField(made, extent, extent, cells, 1.0, 0);
    return made;
  }
  const double factor = kind == "scaled-mesh" ? 0.5 : 1.0;
  made.meshes.push_back(gridMesh(extent * factor, extent * factor, cells, flat));
  if (kind == "gimpact") {
    auto shape = std::make_unique<btGImpactMeshShape>(made.meshes.back().get());
    shape->updateBound();
    made.shape = std::move(shape);
    return made;
  }
  made.shape = std::make_unique<btBvhTriangleMeshShape>(made.meshes.back().get(), true);
  if (kind == "mesh") return made;
  made.parts.push_back(std::move(made.shape));
  made.shape = std::make_unique<btScaledBvhTriangleMeshShape>(
      static_cast<btBvhTriangleMeshShape*>(made.parts.back().get()), btVector3(2, 2, 2));
  return made;
}

}  // namespace

std::vector<FloorPiece> makeFloor(const std::string& kind, double extent, double cell) {
  const int cells = std::min(40, std::max(1, static_cast<int>(std::lround(2.0 * extent / cell))));
  std::vector<FloorPiece> pieces;
  if (kind == "boxes" || kind == "hulls") return tiledFloor(kind == "hulls", extent, std::min(cells, 12));
  if (kind == "plane")
    pieces.push_back(onePiece(makeShape("plane", Vector3d::Ones(), 0)));
  else if (kind == "box")
    pieces.push_back(
        onePiece(makeShape("box", Vector3d(extent, thickness(extent), extent), 0), -thickness(extent)));
  else if (kind == "compound")
    pieces.push_back(compoundFloor(extent, std::min(cells, 12)));
  else
    pieces.push_back(onePiece(meshFloor(kind, extent, cells)));
  return pieces;
}

}  // namespace limber::fuzz
