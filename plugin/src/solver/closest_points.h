// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>

namespace limber {

using TriangleCorners = std::array<Eigen::Vector3d, 3>;

/// Barycentric coordinates of the point of the triangle that is nearest to `p` (C. Ericson, "Real-Time
/// Collision Detection", 2005, 5.1.5). Sound for triangles without area.
Eigen::Vector3d nearestBarycentric(const TriangleCorners& triangle, const Eigen::Vector3d& p);

/// From 0 at `from` to 1 at `to`: the point of the segment that is nearest to `p`. Sound without length.
double nearestOnSegment(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& p);

/// Where two segments come nearest to each other, from 0 to 1 on each.
struct SegmentPair {
  double a, b;
};

/// Ericson 2005, 5.1.9. Of parallel segments, one of the nearest pairs.
SegmentPair nearestOnSegments(const Eigen::Vector3d& a0, const Eigen::Vector3d& a1, const Eigen::Vector3d& b0,
                              const Eigen::Vector3d& b1);

}  // namespace limber
