// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body.h>
#include <limber/triangle_mesh.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace limber::scenes {

/// A surface as it is now. The triangles must outlive it.
struct PosedSurface {
  Eigen::Matrix3Xd points;  ///< 3 x #points, m
  const std::vector<Triangle>* triangles = nullptr;
  Eigen::AlignedBox3d box;
  bool encloses = true;  ///< false: it is open and has no inside
};

PosedSurface posed(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles);
PosedSurface posed(const SoftBody& body);

/// m, of a place from the surface; below 0 inside of one that encloses. Inside is where the surface winds
/// around more often than not, so that a few faces that cross others do no harm.
double signedDistance(const PosedSurface& surface, const Eigen::Vector3d& place);

/// How deep what belongs to one surface is inside another one.
struct Overlap {
  double depth = 0.0;  ///< m, 0: nowhere
  std::size_t inner = 0, outer = 0;
};

/// The deepest of all surfaces' corners, midpoints of edges and of triangles in any other surface.
Overlap deepestOverlap(const std::vector<PosedSurface>& surfaces);

/// m, how deep a place is inside a rigid body, a box or a ball; 0 outside. Bodies of other shapes hold
/// nothing.
double depthIn(const btRigidBody& rigid, const Eigen::Vector3d& place);

/// m, how deep a ball or a box (its corners and middles) is inside a surface, or, where that encloses
/// nothing, how deep it cuts into a ball; 0 apart, and for other shapes.
double depthIn(const PosedSurface& surface, const btRigidBody& rigid);

/// How deep a soft body and a rigid one are in one another.
struct RigidOverlap {
  double depth = 0.0;  ///< m, 0: nowhere
  std::size_t soft = 0, rigid = 0;
};

/// The deepest of all soft bodies.
RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs, const btRigidBody& rigid);

/// The deepest of all pairs.
RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs,
                            const std::vector<std::unique_ptr<btRigidBody>>& rigids);

}  // namespace limber::scenes
