// SPDX-License-Identifier: Zlib
// Declares the geometry of single triangles and segments, and of whole surfaces: nearest points, angles,
// extents, volumes, normals, and the outward orientation.
#pragma once

#include <limber/mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <optional>
#include <vector>

namespace limber {

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

}  // namespace limber
