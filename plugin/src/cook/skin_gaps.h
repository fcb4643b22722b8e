// SPDX-License-Identifier: Zlib
#pragma once

#include "mesh/triangle_bvh.h"

#include <limber/mesh_weld.h>
#include <limber/spring_network.h>

#include <Eigen/SparseCore>

namespace limber {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// How little a point tells about another that is near it through the air only, #points x #points, m^3: a
/// variance to set against that of |r|^3 interpolation, where the expected square of the difference between
/// two positions grows with the cube of their distance. It rises from 0 as the shortest way through the body
/// becomes longer than the straight line. Not stored: 0, and for points that are not among each other's
/// nearest.
SparseRows gapVariances(const SpringNetwork& network, const TriangleBvh& surface);

/// How far the vertices of a detailed mesh belong to the points of the coarse surface, #vertices x #points,
/// from 0 to 1: smooth over the detailed mesh, so that it knows of no part that is only near.
SparseRows belonging(const WeldedMesh& mesh, const SpringNetwork& network, const TriangleBvh& surface);

}  // namespace limber
