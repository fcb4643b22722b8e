// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/moving_surface.h"

namespace limber {

// Two surfaces are locally nearest to each other where the direction between them is in the normal cones of
// both, at the given time of the tick. `outward` is a unit vector away from the surface.

/// Whether the edge is a ridge and `outward` is between the normals of its triangles (its Gauss arc). That of
/// a boundary is half a circle, that of a loose segment a full one (`outward` is perpendicular to it).
bool isInNormalCone(const MovingSurface& surface, double time, std::uint32_t edge,
                    const Eigen::Vector3d& outward, double tolerance);

/// Whether all edges around the vertex lead away from `outward`.
bool isInVertexCone(const MovingSurface& surface, double time, std::uint32_t vertex,
                    const Eigen::Vector3d& outward);

/// Whether a triangle around the vertex, if there are any, shows its outside to where `outward` points.
bool facesOutward(const MovingSurface& surface, double time, std::uint32_t vertex,
                  const Eigen::Vector3d& outward);

}  // namespace limber
