// SPDX-License-Identifier: Zlib
// Declares the weights with which the places of a skin ride on the points of a network.
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/mesh_weld.h>
#include <limber/skin.h>
#include <limber/spring_network.h>

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
};

/// What rides on what.
struct SkinProblem {
  std::vector<Eigen::Vector3d> points;   ///< #points
  std::vector<Eigen::Vector3d> places;   ///< #places
  std::vector<Eigen::Vector3d> normals;  ///< #places, outward
  SparseRows
      variances;  ///< #places x #points, m^3: how little a point tells about a place, see gapVariances()
};

/// Whether the points lie in no plane, so that affine motions can be told from them.
bool spansSpace(const std::vector<Eigen::Vector3d>& points);

/// Interpolation by  sum l_i k(|x - x_i|) + c + a . x  over all points, k Matern's covariance. They must span
/// space.
SkinWeights denseWeights(const SkinProblem& problem);

/// The same with |x - x_i|^3 over the `neighbours` nearest points of each place, at most three exchanged for
/// farther ones where the nearest lie in a plane.
SkinWeights sparseWeights(const SkinProblem& problem, std::uint32_t neighbours);

/// Barycentric coordinates in the tetrahedron in which the place lies, or next to which it lies.
SkinWeights tetrahedronWeights(const SkinProblem& problem, const std::vector<Tetrahedron>& tetrahedra);

/// Barycentric coordinates in the tetrahedron of the nearest triangle and a point across the body from it.
SkinWeights triangleWeights(const SkinProblem& problem, const std::vector<Triangle>& surface);

/// How a welded mesh is drawn: its vertices ride on the welded points, or on the places of a skin.
RenderSurface makeRenderSurface(const TriangleMesh& mesh, const WeldedMesh& welded, Skin skin = {});

/// Rounded so that the weights of each place sum to 1 as closely as floats allow.
Skin rounded(const SkinWeights& exact);

/// The weights of the welded mesh's points on those of the network. Errors: as withSkin().
Result<SkinWeights> skinWeights(const SpringNetwork& network, const WeldedMesh& mesh,
                                const SkinSettings& settings);

}  // namespace limber
