// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/network_builder.h>

namespace limber {

/// Method by which the vertices of a detailed mesh follow the points of a coarse network.
enum class SkinKind : std::uint8_t {
  Dense,       ///< radial basis functions over all points: smoothest
  Sparse,      ///< the same over the nearest points, distances measured through the body: cheaper, local
  Barycentric  ///< over the corners of the tetrahedron that contains the vertex or is next to it (material
               ///< mode), or those of the nearest triangle and a point on the opposite side of the body:
               ///< cheapest, piecewise linear
};

struct SkinSettings {
  SkinKind kind = SkinKind::Dense;
  std::uint32_t neighbours = 32;  ///< Sparse: maximum number of weights per vertex, 4 or more
  double weldTolerance = 0.0;     ///< m, see weld()
};

/// Returns the network with `mesh` as its render surface. The mesh keeps its position relative to the rest
/// points. Closed components whose normals point inward are flipped. Affine motions are reproduced exactly,
/// to the precision of the weights. A point has little or no influence if the path to it through the inside
/// of the body is much longer than the straight line, so that parts that almost touch do not drag each other.
/// Errors: those of weld(); a network without a surface, or whose points lie in a plane; fewer than 4
/// neighbours; a dense skin of more than 20 million weights.
Result<SharedNetwork> withSkin(const SpringNetwork& network, const TriangleMesh& mesh,
                               const SkinSettings& settings = {});

/// Computes the positions of all places of `skin` (xyz, #places x 3) from the positions of the points (xyz,
/// #points x 3). `places` is written in order and never read.
void applySkin(const Skin& skin, const float* points, float* places);

}  // namespace limber
