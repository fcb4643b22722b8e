// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>

namespace limber {

/// How the vertices of a detailed mesh ride on the points of a coarse network.
enum class SkinKind : std::uint8_t {
  Dense,       ///< radial basis functions over all points: the smoothest
  Sparse,      ///< the same over the nearest points that are seen through the body: cheaper, local
  Barycentric  ///< the corners of the tetrahedron around or next to the vertex (material mode), or those of
               ///< the nearest triangle and a point across the body from it: cheapest, piecewise linear
};

struct SkinSettings {
  SkinKind kind = SkinKind::Dense;
  std::uint32_t neighbours = 32;  ///< Sparse: weights per vertex at most, 4 or more
  double weldTolerance = 0.0;     ///< m, see weld()
};

/// The network with `mesh` as its render surface, in the place where it lies relative to the rest points.
/// Closed parts of it that face inward are turned.
/// Exact for affine motions to the precision of the weights. Points to which the way through the inside of
/// the body is much longer than the straight line count little or nothing, so that parts that only nearly
/// touch do not drag each other along. Errors: those of weld(); a network without a surface, or whose points
/// lie in a plane; fewer than 4 neighbours; a dense skin of more than 20 million weights.
Result<SharedNetwork> withSkin(const SpringNetwork& network, const TriangleMesh& mesh,
                               const SkinSettings& settings = {});

/// Positions of all places of `skin` (xyz, #places x 3) for these positions of the points (xyz, #points x 3).
/// Only writes, in order.
void applySkin(const Skin& skin, const float* points, float* places);

}  // namespace limber
