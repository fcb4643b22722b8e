// SPDX-License-Identifier: Zlib
// Declares the weights of skins, whose places follow the points of a network.
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/network_builder.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <cstdint>
#include <vector>

namespace limber {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// A Skin before its weights are rounded.
struct SkinWeights {
  std::vector<std::uint32_t> firstWeight{0};  ///< #places + 1
  std::vector<std::uint32_t> points;          ///< #weights
  std::vector<double> weights;                ///< #weights

  /// Adds a place that follows these points.
  template <class Indices>
  void add(const Indices& followed, const double* shares) {
    for (const auto point : followed) points.push_back(static_cast<std::uint32_t>(point));
    weights.insert(weights.end(), shares, shares + followed.size());
    firstWeight.push_back(static_cast<std::uint32_t>(points.size()));
  }
};

/// The places of a skin and the points that they follow.
struct SkinProblem {
  std::vector<Eigen::Vector3d> points;   ///< #points
  std::vector<Eigen::Vector3d> places;   ///< #places
  std::vector<Eigen::Vector3d> normals;  ///< #places, outward
  SparseRows variances;  ///< #places x #points, m^3: the uncertainty of a point's motion as a prediction of a
                         ///< place's motion, see gapVariances()
};

/// Returns whether the points do not lie in a plane, so that they determine affine motions.
bool spansSpace(const std::vector<Eigen::Vector3d>& points);

/// Interpolates by  sum l_i k(|x - x_i|) + c + a . x  over all points, with Matern's covariance k. The points
/// must span space.
SkinWeights denseWeights(const SkinProblem& problem);

/// Interpolates with |x - x_i|^3 over the `neighbours` nearest points of each place. At most three of them
/// are replaced by farther ones if the nearest lie in a plane.
SkinWeights sparseWeights(const SkinProblem& problem, std::uint32_t neighbours);

/// Returns barycentric coordinates in the tetrahedron that contains the place or is next to it.
SkinWeights tetrahedronWeights(const SkinProblem& problem, const std::vector<Tetrahedron>& tetrahedra);

/// Returns barycentric coordinates in the tetrahedron of the nearest triangle and a point on the opposite
/// side of the body.
SkinWeights triangleWeights(const SkinProblem& problem, const std::vector<Triangle>& surface);

/// Makes the render surface of a welded mesh. Its vertices follow the welded points or, with a skin, the
/// places of the skin.
RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded, Skin skin = {});

/// Rounds the weights so that those of each place sum to 1 as closely as floats allow.
Skin rounded(const SkinWeights& exact);

/// Computes the weights of the welded mesh's points on the points of the network. Errors: as in withSkin().
Result<SkinWeights> skinWeights(const SpringNetwork& network, const WeldedMesh& mesh,
                                const SkinSettings& settings);

}  // namespace limber
