// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <vector>

namespace limber {

/// Rope for points on a line, Cloth for points in a plane, else Solid; to within a ten-thousandth of their
/// largest distance from the centre.
NetworkKind spreadOf(const std::vector<Eigen::Vector3d>& points);

/// The points moved into their plane (Cloth) or onto their line (Rope): what lies out of it by less than
/// spreadOf() sees would, by the square of that, resist bending as though it were a body's own stiffness.
std::vector<Eigen::Vector3d> flattened(std::vector<Eigen::Vector3d> points, NetworkKind kind);

}  // namespace limber
