// SPDX-License-Identifier: Zlib
#pragma once

#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

namespace limber::fuzz {

inline btScalar toBt(double value) { return static_cast<btScalar>(value); }
inline btVector3 toBt(const Eigen::Vector3d& v) {
  return btVector3(static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z()));
}
inline Eigen::Vector3d fromBt(const btVector3& v) { return {double(v.x()), double(v.y()), double(v.z())}; }
btQuaternion rotationOf(const Eigen::Vector3d& axial);

/// A Bullet shape with all the objects that it refers to.
struct OwnedShape {
  std::unique_ptr<btCollisionShape> shape;
  std::vector<std::unique_ptr<btCollisionShape>> parts;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes;
  std::unique_ptr<std::vector<btScalar>> heights;
  bool fixed = false;   ///< only for static and kinematic bodies
  double radius = 0.5;  ///< m, of a bounding sphere around its origin
};

/// Returns a shape. `size`: approximate half sizes (m) of its bounding box; `variant` selects one of many
/// versions.
OwnedShape makeShape(const std::string& name, const Eigen::Vector3d& size, int variant);

/// One of the objects that make a flat floor, its top at y = 0.
struct FloorPiece {
  OwnedShape shape;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// Returns a floor of half size `extent` (m) in pieces of about `cell` (m).
std::vector<FloorPiece> makeFloor(const std::string& kind, double extent, double cell);

}  // namespace limber::fuzz
