// SPDX-License-Identifier: Zlib
// A tree of boxes over the triangles of a surface, which answers questions about rays, distances and insides.
#pragma once

#include "mesh/surface.h"

#include <limber/triangle_mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace limber {

/// Where a ray or a nearest-point query met the surface.
struct TriangleHit {
  std::uint32_t triangle = 0xffffffffu;  ///< none: 0xffffffff
  double distance = 0.0;                 ///< m; along the ray, or to the nearest point
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the position in the triangle

  explicit operator bool() const { return triangle != 0xffffffffu; }
};

/// Triangles in a tree of boxes, for the questions that cooking asks of a surface. Immutable, any thread.
/// Deterministic: of equally near triangles the one with the lowest index.
class TriangleBvh {
 public:
  TriangleBvh(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

  /// The first triangle that the ray meets between `from` and `to` along the unit `direction` (m); triangles
  /// seen from either side.
  TriangleHit firstHit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double from,
                       double to) const;
  /// Whether the segment passes through the inside of a triangle that `counts` accepts, by more than a
  /// millionth of its length on either side.
  bool isPierced(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 const std::function<bool(std::uint32_t)>& counts) const;
  TriangleHit nearest(const Eigen::Vector3d& position) const;

  /// Among the triangles whose normal does not point against `normal`, if there are any.
  TriangleHit nearestFacing(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) const;

  /// Generalized winding number (Jacobson, Kavan, Sorkine 2013; far triangles by their dipole, Barill et al.
  /// 2018): 1 inside a closed surface, 0 outside, in between near holes.
  double windingNumber(const Eigen::Vector3d& position) const;
  bool inside(const Eigen::Vector3d& position) const { return windingNumber(position) > 0.5; }

  /// m, below 0 inside.
  double signedDistance(const Eigen::Vector3d& position) const;

  /// Whether the segment between two points of the surface stays inside it; chords that lie in the surface
  /// (in a flat face) do. Its ends are drawn in by a hundredth of its length, and `tolerance` (m) is how far
  /// it may leave the surface.
  bool staysInside(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0, count = 0;  ///< count 0: inner node whose children are first and first + 1
    Eigen::Vector3d centre = Eigen::Vector3d::Zero(), areaNormal = Eigen::Vector3d::Zero();  ///< dipole
    double radius = 0.0;  ///< of the ball about `centre` that holds all triangles
  };
  Eigen::AlignedBox3d boxOf(std::uint32_t first, std::uint32_t count) const;
  void setDipole(Node& node, std::uint32_t first, std::uint32_t count) const;
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);
  TriangleHit nearestWithin(const Eigen::Vector3d& position, double distance,
                            const Eigen::Vector3d& normal = Eigen::Vector3d::Zero()) const;
  bool isInsideOrNear(const Eigen::Vector3d& position, double tolerance) const;
  std::vector<double> crossings(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  std::vector<TriangleCorners> corners_;  ///< #triangles
  std::vector<std::uint32_t> order_;      ///< triangles in the order of the leaves
  std::vector<Node> nodes_;
  double margin_ = 0.0;  ///< m, by which boxes are larger than their triangles
};

/// Edges of a surface that pass through the inside of one of its triangles. Where two triangles cross, an
/// edge of one does. Sheets that lie in each other or touch, and edges that meet edges, do not count.
std::size_t countPiercingEdges(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles);

}  // namespace limber
