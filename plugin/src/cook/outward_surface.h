// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Which triangles must be turned, #triangles, so that the closed components of a surface face outward. A
/// component within another one is turned or left along with the outermost around it: which of them bound
/// hollows is for the mesh to say. Triangles of components that are not closed are left as they are.
std::vector<bool> facingInward(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles);

/// Turns the triangles that are marked.
void turn(std::vector<Triangle>& triangles, const std::vector<bool>& marked);

/// The surface, with its outside outside.
std::vector<Triangle> turnedOutward(const std::vector<Eigen::Vector3d>& points,
                                    std::vector<Triangle> triangles);

}  // namespace limber
