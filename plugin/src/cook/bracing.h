// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/edges.h"

#include <limber/network_builder.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// One connected piece of a surface, and what bracing it takes.
struct PieceToBrace {
  std::vector<Eigen::Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;  ///< of the triangles, sorted, unique
  bool closed = false;      ///< every edge has two triangles that run through it in opposite directions
};

/// With less, a body is a skin that is stiff against bending around an inside that is soft: at 0.3 the arms
/// of an L resist opening 1.6 times as much as a solid's with the same bulk modulus, at 0.5 1.4 times.
constexpr double kPipelineWeight = 0.5;

struct BracingSettings {
  double weight = kPipelineWeight;  ///< stiffnessScale of a brace
  double mostBraces = 1.5;          ///< per point
  std::uint64_t seed = 1;
};

/// The braces of BraceRule::Pipeline, sorted:
///
///   1. chords through the body, from each point to the opposite side (antipodal_braces.h),
///   2. braces for mechanisms and what is nearly one (soft_mode_braces.h),
///   3. braces for the wrong shapes that large deformations leave it in (counterexample_braces.h),
///
/// all inside the body. A piece without an inside (flat, or so open that few chords are inside) gets the
/// two-ring instead, however many braces that is. Once `goOn` returns false it must do so ever after; then
/// the braces found so far are returned.
std::vector<Edge> bracePiece(const PieceToBrace& piece, const BracingSettings& settings,
                             const Progress& goOn);

}  // namespace limber
