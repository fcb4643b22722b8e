// SPDX-License-Identifier: Zlib
// Declares a tree of boxes over the triangles of a surface, for queries about rays, distances and insides.
#pragma once

#include "mesh/surface.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// Result of a ray or a nearest-point query.
struct TriangleHit {
  std::uint32_t triangle = 0xffffffffu;  ///< none: 0xffffffff
  double distance = 0.0;                 ///< m; along the ray, or to the nearest point
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the position in the triangle

  explicit operator bool() const { return triangle != 0xffffffffu; }
};

/// Triangles in a tree of boxes, for the queries of network building. Immutable, for any thread.
/// Deterministic: of equally near triangles it returns the one with the lowest index.
class TriangleBvh {
 public:
  TriangleBvh(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

  /// Returns the first triangle that the ray hits, from either side, between `from` and `to` along the unit
  /// `direction` (m).
  TriangleHit firstHit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double from,
                       double to) const;
  /// Returns whether the segment passes through the inside of a triangle that `accepts` returns true for, by
  /// more than a millionth of its length on either side.
  bool isPierced(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 const std::function<bool(std::uint32_t)>& accepts) const;
  /// Returns the nearest triangle up to `distance` (m), if there is one. Of those that face against `normal`
  /// none counts.
  TriangleHit nearestWithin(const Eigen::Vector3d& position, double distance,
                            const Eigen::Vector3d& normal = Eigen::Vector3d::Zero()) const;
  TriangleHit nearest(const Eigen::Vector3d& position) const { return nearestWithin(position, HUGE_VAL); }

  /// Returns the generalized winding number (Jacobson, Kavan, Sorkine 2013; far triangles by their dipole,
  /// Barill et al. 2018): 1 inside a closed surface, 0 outside, between them near holes.
  double windingNumber(const Eigen::Vector3d& position) const;
  bool inside(const Eigen::Vector3d& position) const { return windingNumber(position) > 0.5; }

  /// Returns whether the segment between two points of the surface stays inside it. Chords in the surface (in
  /// a flat face) do. A hundredth of the length at each end is ignored. `tolerance` (m) is the largest
  /// distance by which the segment may leave the surface.
  bool staysInside(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0, count = 0;  ///< count 0: inner node whose children are first and first + 1
    Eigen::Vector3d centre = Eigen::Vector3d::Zero(), areaNormal = Eigen::Vector3d::Zero();  ///< dipole
    double radius = 0.0;  ///< of the ball about `centre` that contains all triangles
  };
  Eigen::AlignedBox3d boxOf(std::uint32_t first, std::uint32_t count) const;
  void setDipole(Node& node, std::uint32_t first, std::uint32_t count) const;
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);
  template <class Enters, class PrefersSecond, class Visit>
  void traverse(Enters enters, PrefersSecond prefersSecond, Visit visit) const;
  template <class Visit>
  void forEachCrossing(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double margin, Visit visit) const;

  std::vector<TriangleCorners> corners_;  ///< #triangles
  std::vector<std::uint32_t> order_;      ///< triangles in the order of the leaves
  std::vector<Node> nodes_;
  double margin_ = 0.0;  ///< m, by which boxes are larger than their triangles
};

}  // namespace limber
