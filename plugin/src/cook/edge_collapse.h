// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/quadric.h"

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <vector>

namespace limber {

/// A surface whose edges can be collapsed. Dead points have no triangles; dead triangles are in no list.
struct CollapsibleSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<std::vector<std::uint32_t>> trianglesOf;  ///< #points, ascending
  std::vector<Quadric> quadrics;                        ///< #points
  std::vector<char> onBorder;                           ///< #points, on an edge of one triangle
  std::vector<char> fixed;  ///< #points, where the surface is not manifold: never moved
};

CollapsibleSurface makeCollapsible(std::vector<Eigen::Vector3d> points, std::vector<Triangle> triangles);

/// Ascending, without `point`.
std::vector<std::uint32_t> neighboursOf(const CollapsibleSurface& surface, std::uint32_t point);

/// Whether joining a and b at `place` leaves a surface of the same topology (the link condition: Dey,
/// Edelsbrunner, Guha, Nekhayev 1999), and no triangle turned over or made a sliver.
bool mayCollapse(const CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b,
                 const Eigen::Vector3d& place);

/// Moves a to `place` and lets b die.
void collapse(CollapsibleSurface& surface, std::uint32_t a, std::uint32_t b, const Eigen::Vector3d& place);

}  // namespace limber
