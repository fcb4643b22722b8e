// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Splits a polygon of n >= 3 corners into n - 2 triangles of its corners, with its orientation; concave
/// polygons by clipping ears. Convex ones become a fan around corner 0. Drops nothing: polygons that are no
/// plane simple loop give triangles too, good or bad.
std::vector<Triangle> splitPolygon(const std::vector<Eigen::Vector3d>& corners);

}  // namespace limber
