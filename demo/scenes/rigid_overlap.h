// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/overlap.h"

namespace limber::scenes {

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
