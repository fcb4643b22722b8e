// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/mesh.h>
#include <limber/soft_body.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

namespace limber::scenes {

/// A surface in its present position. The triangles must outlive it.
struct PosedSurface {
  Eigen::Matrix3Xd points;  ///< 3 x #points, m
  const std::vector<Triangle>* triangles = nullptr;
  Eigen::AlignedBox3d box;
  bool encloses = true;  ///< false: an open surface without an inside
};

PosedSurface posed(const Eigen::Matrix3Xd& points, const std::vector<Triangle>& triangles);
PosedSurface posed(const SoftBody& body);

/// Returns the distance of a point from the surface, m; negative inside of a closed one. A point is inside if
/// the absolute winding number is above 1/2, so that a few intersecting triangles do no harm.
double signedDistance(const PosedSurface& surface, const Eigen::Vector3d& point);

/// Depth of one surface inside another.
struct Overlap {
  double depth = 0.0;  ///< m, 0: nowhere
  std::size_t inner = 0, outer = 0;
};

/// Returns the largest depth of a corner, midpoint of an edge or centre of a triangle in any other surface.
Overlap deepestOverlap(const std::vector<PosedSurface>& surfaces);

/// Returns the depth of a point inside a rigid box or ball, m; 0 outside, and for other shapes.
double depthIn(const btRigidBody& rigid, const Eigen::Vector3d& point);

/// Returns the depth of a ball or a box (its corners and midpoints) inside a surface, m. For an open surface
/// it is the depth of the surface in a ball. 0 if they are apart, and for other shapes.
double depthIn(const PosedSurface& surface, const btRigidBody& rigid);

/// Depth of a soft and a rigid body in each other.
struct RigidOverlap {
  double depth = 0.0;  ///< m, 0: nowhere
  std::size_t soft = 0, rigid = 0;
};

/// Returns the largest depth of all soft bodies in this rigid one.
RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs, const btRigidBody& rigid);

/// Returns the largest depth of all pairs.
RigidOverlap deepestOverlap(const std::vector<PosedSurface>& softs,
                            const std::vector<std::unique_ptr<btRigidBody>>& rigids);

}  // namespace limber::scenes
