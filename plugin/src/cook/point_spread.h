// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/spring_network.h>

#include <vector>

namespace limber {

/// Rope for points on a line, Cloth for points in a plane, else Solid; to within a ten-thousandth of their
/// largest distance from the centre.
NetworkKind spreadOf(const std::vector<Eigen::Vector3d>& points);

}  // namespace limber
