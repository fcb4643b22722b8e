// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"

namespace limber::bench {

/// Those from CoarseMesh on are cut into tiles of 1 m, FineMesh into ones of 0.1 m: triangles of a mesh,
/// cells of a height field, bodies side by side, children of one body.
enum class Floor : std::uint8_t {
  Plane,
  Box,
  Hull,
  TriangleMesh,
  CoarseMesh,
  FineMesh,
  HeightField,
  Boxes,
  Compound,
  Hulls
};

/// Adds a floor whose top is y = 0. It reaches at least 3 m from the origin, a tiled one 4 m, and 13 m along
/// x. btSoftBody does not collide with planes.
void addFloor(RigidBodies& rigid, btDiscreteDynamicsWorld& world, Floor floor, double friction);

/// Adds a box with this centre; with mass 0 it is static.
void addBox(RigidBodies& rigid, btDiscreteDynamicsWorld& world, const Eigen::Vector3d& halfSize, double mass,
            const Eigen::Vector3d& centre, double friction);

}  // namespace limber::bench
