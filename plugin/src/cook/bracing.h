// SPDX-License-Identifier: Zlib
#pragma once

#include "core/mesh_edges.h"

#include <limber/network_builder.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// One connected piece of a surface, and what bracing it takes.
struct PieceToBrace {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;   ///< of the triangles, sorted, unique
  bool closed = false;       ///< every edge has two triangles that run through it in opposite directions
  bool keepsVolume = false;  ///< whether the body that it is a piece of will have a volume term
};

/// The braces of BraceRule::Pipeline, sorted, at `weight`:
///
///   1. chords through the body, from each point to the opposite side (antipodal_braces.h),
///   2. braces for mechanisms and what is nearly one (soft_mode_braces.h),
///   3. braces for the wrong shapes that large deformations leave it in (counterexample_braces.h),
///
/// all inside the body. A piece without an inside (flat, open so that few chords are inside) gets the
/// two-ring instead, whatever settings.mostBraces says.
std::vector<Edge> bracePiece(const PieceToBrace& piece, const NetworkSettings& settings, double weight);

}  // namespace limber
