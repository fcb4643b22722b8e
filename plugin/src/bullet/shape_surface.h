// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/surface.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// The surface of a convex shape of Bullet's as vertices, edges and triangles with a radius around them, in
/// the shape's own coordinates: a sphere is one vertex, a capsule one edge, boxes and hulls are polyhedra,
/// and what is round otherwise (cylinders, cones, ...) is a polyhedron close to it.
struct ShapeSurface {
  SurfaceTopology topology;
  double radius = 0.0;                    ///< m
  std::vector<std::uint32_t> sharpEdges;  ///< those that are not flat
};

/// Nothing for shapes that have neither edges nor vertices (planes), are concave or are compounds.
ShapeSurface makeShapeSurface(const btCollisionShape& shape);

/// The triangles of a concave shape that overlap a box in the shape's own coordinates, two-sided; corners in
/// the same place are one vertex.
ShapeSurface makePatchSurface(const btConcaveShape& shape, const btVector3& low, const btVector3& high);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
