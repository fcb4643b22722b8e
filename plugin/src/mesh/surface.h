// SPDX-License-Identifier: Zlib
// Declares the edges of triangle meshes, their components and defects; the geometry of single triangles and
// segments, and of whole surfaces: nearest points, angles, extents, volumes, normals, the outward orientation
// and wraps; and texts about counts, numbers and indices.
#pragma once

#include <limber/mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

namespace limber {

// --- edges -------------------------------------------------------------------------------------------------

/// Two point indices, the smaller one first.
using Edge = std::array<std::uint32_t, 2>;

inline Edge edgeBetween(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Calls visit(edge, number of its triangles) for the edges of the triangles, sorted.
template <class Visit>
void forEachEdge(const std::vector<Triangle>& triangles, Visit visit) {
  std::vector<Edge> edges;
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.push_back(edgeBetween(t[i], t[(i + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last] == edges[first]) ++last;
    visit(edges[first], last - first);
  }
}

/// Returns the edges of the triangles, sorted, each once. Corners of a triangle must differ.
std::vector<Edge> uniqueEdges(const std::vector<Triangle>& triangles);

/// Numbers of edges that a closed, oriented surface does not have; see MeshReport.
struct EdgeDefects {
  std::size_t open = 0;
  std::size_t nonManifold = 0;
  std::size_t inconsistent = 0;

  bool none() const { return open + nonManifold + inconsistent == 0; }
};

EdgeDefects findEdgeDefects(const std::vector<Triangle>& triangles);

/// Sets the numbers of defective edges in the report of a mesh with these triangles.
void setEdgeDefects(MeshReport& report, const std::vector<Triangle>& triangles);

/// Returns for each point the indices of the triangles or tetrahedra of which it is a corner, ascending.
template <class Corners>
std::vector<std::vector<std::uint32_t>> elementsOfPoints(std::size_t points,
                                                         const std::vector<Corners>& all) {
  std::vector<std::vector<std::uint32_t>> elements(points);
  for (std::uint32_t i = 0; i < all.size(); ++i)
    for (const std::uint32_t corner : all[i]) elements[corner].push_back(i);
  return elements;
}

/// Sets of indices that can be joined. The smallest member of a set, its root, identifies it.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) { reset(count); }

  /// Makes each index a set of its own.
  void reset(std::size_t count) {
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }

  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = root(i), j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Connected components of a surface. They share no point.
struct SurfaceComponents {
  std::size_t count = 0;
  std::vector<std::uint32_t> ofTriangle;  ///< #triangles, numbered in the order of their first triangles
};

SurfaceComponents findComponents(std::size_t points, const std::vector<Triangle>& triangles);

/// Returns the triangles of each connected component.
std::vector<std::vector<Triangle>> trianglesOfPieces(const TriangleMesh& mesh);

/// Returns the part of a mesh with these of its triangles, and the vertices that they use.
TriangleMesh partOf(const TriangleMesh& mesh, std::vector<Triangle> triangles);

/// An edge from a point, and its length, m.
struct Link {
  std::uint32_t to;
  double length;
};
using Links = std::vector<std::vector<Link>>;  ///< #points

void connect(Links& links, const std::vector<Eigen::Vector3d>& points, std::uint32_t a, std::uint32_t b);

/// Returns the edges of the triangles from each point.
Links edgeLinks(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

/// Returns the length (m) of the shortest path from `from` to each point (E. Dijkstra, 1959), `maxLength` if
/// there is no shorter one.
std::vector<double> shortestPaths(const Links& links, std::uint32_t from, double maxLength);

// --- triangles and surfaces --------------------------------------------------------------------------------

constexpr double kPi = 3.14159265358979323846;

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

/// Intersection of a line with a triangle.
struct LineHit {
  double along;  ///< in lengths of the direction
  Eigen::Vector3d barycentric;
};

/// Intersects a line with a triangle (T. Moller, B. Trumbore, "Fast, minimum storage ray/triangle
/// intersection", 1997). Barycentric coordinates down to -`margin` count as hits. Lines in the triangle's
/// plane do not.
std::optional<LineHit> intersectLine(const TriangleCorners& triangle, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double margin);

/// Returns the signed solid angle of the triangle seen from `p`: positive from behind, where its corners run
/// clockwise (A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", 1983). 0 in its plane.
double solidAngle(const TriangleCorners& triangle, const Eigen::Vector3d& p);

inline Eigen::Vector3d pointAt(const TriangleCorners& triangle, const Eigen::Vector3d& barycentric) {
  return barycentric[0] * triangle[0] + barycentric[1] * triangle[1] + barycentric[2] * triangle[2];
}

/// Returns the area (m^2) times the normal of the triangle with these corners.
inline Eigen::Vector3d areaVector(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

/// Returns the longest side (m) of the points' bounding box; 0 without points.
double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points);
double extent(const std::vector<Eigen::Vector3d>& points);

/// Returns the same of the triangles: vertices that none uses do not count.
double extent(const TriangleMesh& mesh);

/// Returns the volume (m^3) inside the triangles; negative if they face inward.
double signedVolume(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

/// Returns unit normals, #points, weighted by the area of the triangles around each point; zero where they
/// cancel.
std::vector<Eigen::Vector3d> vertexNormals(const std::vector<Eigen::Vector3d>& points,
                                           const std::vector<Triangle>& triangles);

/// Returns which triangles must be flipped, #triangles, so that the closed components of a surface face
/// outward. A component within other ones is flipped together with the outermost around it, because only the
/// mesh defines which components bound hollows. Triangles of components that are not closed are not flipped.
std::vector<bool> facingInward(const std::vector<Eigen::Vector3d>& points,
                               const std::vector<Triangle>& triangles);

/// Returns which triangles must be flipped, #triangles, so that every patch is oriented consistently and
/// faces outward, for meshes that need not be closed or consistent. A patch is a set of triangles joined by
/// edges of two triangles. Curved patches face away from their own middle. Flat ones keep the orientation of
/// the mesh if it is consistent, and else face away from the middle of the mesh.
std::vector<bool> patchesFacingInward(const std::vector<Eigen::Vector3d>& points,
                                      const std::vector<Triangle>& triangles);

/// Flips the marked triangles.
void flip(std::vector<Triangle>& triangles, const std::vector<bool>& marked);

/// Returns the surface with its closed components facing outward.
std::vector<Triangle> facingOutward(const std::vector<Eigen::Vector3d>& points,
                                    std::vector<Triangle> triangles);

// --- wraps -------------------------------------------------------------------------------------------------

/// Cells along the longest side of a mesh, unless settings say otherwise; and the default of the other sizes,
/// in cells.
constexpr double kWrapCells = 64.0, kWrapWidths = 2.0;

/// Returns the first setting out of range, with the prefix before its name, and its rule; or an empty string.
std::string checkWrapSettings(const WrapSettings& settings, const std::string& prefix);

/// wrap() for functions whose settings contain its settings: errors name the fields with this prefix.
Result<WrappedMesh> wrapOfField(const TriangleMesh& mesh, const WrapSettings& settings,
                                const std::string& prefix);

// --- texts -------------------------------------------------------------------------------------------------

/// Returns "1 vertex", "2 vertices".
inline std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Returns "0.0123", "1.23e+06".
inline std::string inThreeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Returns "damping is -1, must be 0 or more".
inline std::string mustBe(const std::string& name, double value, const char* rule) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return name + " is " + text + ", must be " + rule;
}

/// Returns "spring 3".
inline std::string numbered(const char* what, std::size_t index) {
  return what + (" " + std::to_string(index));
}

/// Describes the first corner of triangles or tetrahedra that is not below `count`, such as "triangle 17 uses
/// vertex 900 of 812"; empty if there is none.
template <class Corners>
std::string checkCorners(const std::vector<Corners>& all, std::size_t count, const char* name,
                         const char* cornerName) {
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const std::uint32_t corner : all[i])
      if (corner >= count)
        return numbered(name, i) + " uses " + numbered(cornerName, corner) + " of " + std::to_string(count);
  return {};
}

}  // namespace limber
