// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace limber {

/// Edges of a surface that pass through the inside of one of its triangles. Where two triangles cross, an
/// edge of one does. Sheets that lie in each other or touch, and edges that meet edges, do not count.
std::size_t countPiercingEdges(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles);

}  // namespace limber
