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

/// The side of a triangle from one corner to the next.
struct Side {
  Edge edge;
  std::uint32_t triangle, corner;
};

/// Returns the sides of the triangles, sorted by their edges, those at one edge by their triangles.
std::vector<Side> sortedSides(const std::vector<Triangle>& triangles);

/// Calls visit(first, count) for the edges of the triangles, sorted, with the sides at each of them.
template <class Visit>
void forEachEdge(const std::vector<Triangle>& triangles, Visit visit) {
  const std::vector<Side> sides = sortedSides(triangles);
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    visit(&sides[first], last - first);
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

/// Gives indices new numbers, in the order in which they are first seen.
class Renumbering {
 public:
  explicit Renumbering(std::size_t count) : numbers_(count, kNoPoint) {}

  std::uint32_t operator()(std::uint32_t index) {
    std::uint32_t& number = numbers_[index];
    if (number == kNoPoint) {
      number = static_cast<std::uint32_t>(kept_.size());
      kept_.push_back(index);
    }
    return number;
  }
  template <std::size_t N>
  std::array<std::uint32_t, N> operator()(std::array<std::uint32_t, N> corners) {
    for (std::uint32_t& corner : corners) corner = (*this)(corner);
    return corners;
  }

  /// Returns the index that has each number.
  const std::vector<std::uint32_t>& kept() const { return kept_; }
  bool has(std::uint32_t index) const { return numbers_[index] != kNoPoint; }

 private:
  std::vector<std::uint32_t> numbers_, kept_;
};

/// Returns the values with these indices; none if there are no values.
template <class T>
std::vector<T> chosen(const std::vector<T>& values, const std::vector<std::uint32_t>& indices) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(indices.size());
  for (const std::uint32_t i : indices) result.push_back(values[i]);
  return result;
}

/// Sorts values and removes those that occur twice.
template <class T>
void sortUnique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Returns the corners of triangles or tetrahedra, of `points` points, ascending.
template <class Corners>
std::vector<std::uint32_t> usedPoints(std::size_t points, const std::vector<Corners>& all) {
  std::vector<char> isUsed(points, 0);
  for (const Corners& corners : all)
    for (const std::uint32_t corner : corners) isUsed[corner] = 1;
  std::vector<std::uint32_t> used;
  for (std::uint32_t point = 0; point < points; ++point)
    if (isUsed[point]) used.push_back(point);
  return used;
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
std::vector<std::vector<Triangle>> trianglesOfPieces(std::size_t points,
                                                     const std::vector<Triangle>& triangles);

/// Returns the mesh of a surface: no normals, no texture coordinates.
TriangleMesh meshOf(std::vector<Eigen::Vector3d> points, std::vector<Triangle> triangles);

/// Returns the part of a mesh with these of its triangles, and the vertices that they use.
TriangleMesh partOf(const TriangleMesh& mesh, std::vector<Triangle> triangles);

/// An edge from a point, and its length, m.
struct Link {
  std::uint32_t to;
  double length;
};
using Links = std::vector<std::vector<Link>>;  ///< #points

void connect(Links& links, const std::vector<Eigen::Vector3d>& points, std::uint32_t a, std::uint32_t b);

Links edgeLinks(const std::vector<Eigen::Vector3d>& points, const std::vector<Edge>& edges);

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

inline TriangleCorners cornersOf(const std::vector<Eigen::Vector3d>& points, const Triangle& t) {
  return {points[t[0]], points[t[1]], points[t[2]]};
}

inline Eigen::Vector3d areaVector(const TriangleCorners& t) { return areaVector(t[0], t[1], t[2]); }
inline Eigen::Vector3d areaVector(const std::vector<Eigen::Vector3d>& points, const Triangle& t) {
  return areaVector(points[t[0]], points[t[1]], points[t[2]]);
}

inline Eigen::Vector3d centroid(const TriangleCorners& t) { return (t[0] + t[1] + t[2]) / 3.0; }
inline Eigen::Vector3d centroid(const std::vector<Eigen::Vector3d>& points, const Triangle& t) {
  return (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
}

Eigen::AlignedBox3d boxOf(const std::vector<Eigen::Vector3d>& points);

/// Returns the longest side (m) of the points' bounding box; 0 without points.
double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points);
double extent(const std::vector<Eigen::Vector3d>& points);

/// Returns the same of the triangles: vertices that none uses do not count.
double extent(const TriangleMesh& mesh);

/// Returns the area of the triangles, m^2.
double areaOf(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

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

void flip(std::vector<Triangle>& triangles, const std::vector<bool>& marked);

/// Returns the surface with its closed components facing outward.
std::vector<Triangle> facingOutward(const std::vector<Eigen::Vector3d>& points,
                                    std::vector<Triangle> triangles);

// --- wraps -------------------------------------------------------------------------------------------------

/// Returns the settings with defaults for the sizes that are 0, of a mesh of this extent (m).
WrapSettings withDefaults(WrapSettings settings, double extent);

/// Returns the first setting out of range, with the prefix before its name, and its rule; or an empty string.
std::string checkWrapSettings(const WrapSettings& settings, const std::string& prefix);

/// Fraction of the volume below which wrap() leaves out a piece.
constexpr double kCrumb = 1e-4;

/// wrap() for functions whose settings contain its settings: errors name the fields with this prefix.
Result<WrappedMesh> wrapOfField(const TriangleMesh& mesh, const WrapSettings& settings,
                                const std::string& prefix, double crumb = kCrumb);

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
