// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>

namespace limber {

using TriangleCorners = std::array<Eigen::Vector3d, 3>;

/// Returns the barycentric coordinates of the triangle's point that is nearest to `p` (C. Ericson, "Real-Time
/// Collision Detection", 2005, 5.1.5). Also valid for triangles without area.
Eigen::Vector3d nearestBarycentric(const TriangleCorners& triangle, const Eigen::Vector3d& p);

/// Returns the point of the segment nearest to `p`, from 0 at `from` to 1 at `to`. Also valid for length 0.
double nearestOnSegment(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& p);

/// The nearest points of two segments, from 0 to 1 on each.
struct SegmentPair {
  double a, b;
};

/// Returns the nearest points of two segments (Ericson 2005, 5.1.9); of parallel ones, one nearest pair.
SegmentPair nearestOnSegments(const Eigen::Vector3d& a0, const Eigen::Vector3d& a1, const Eigen::Vector3d& b0,
                              const Eigen::Vector3d& b1);

}  // namespace limber
