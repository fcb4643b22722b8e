// SPDX-License-Identifier: Zlib
// The geometry of single triangles and of whole surfaces: angles, extents, volumes, normals, and which side
// is outside.
#pragma once

#include "solver/closest_points.h"

#include <limber/triangle_mesh.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>
#include <vector>

namespace limber {

constexpr double kPi = 3.14159265358979323846;

/// Where a line meets a triangle.
struct LineHit {
  double along;  ///< in lengths of the direction
  Eigen::Vector3d barycentric;
};

/// T. Moller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997. Barycentric coordinates
/// down to -`margin` count as hits; lines in the triangle's plane do not.
std::optional<LineHit> intersectLine(const TriangleCorners& triangle, const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction, double margin);

/// Signed solid angle of the triangle seen from `p`, positive from behind, where its corners run clockwise
/// (A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", 1983). 0 in its plane.
double solidAngle(const TriangleCorners& triangle, const Eigen::Vector3d& p);

inline Eigen::Vector3d pointAt(const TriangleCorners& triangle, const Eigen::Vector3d& barycentric) {
  return barycentric[0] * triangle[0] + barycentric[1] * triangle[1] + barycentric[2] * triangle[2];
}

/// m^2, along the normal of the triangle with these corners.
inline Eigen::Vector3d areaVector(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

/// m: the longest side of the points' bounding box; 0 without points.
double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points);
double extent(const std::vector<Eigen::Vector3d>& points);

/// m^3: what the triangles enclose, below 0 where they face inward.
double signedVolume(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

/// By the area of the triangles around each point; zero where they cancel. Unit vectors, #points.
std::vector<Eigen::Vector3d> vertexNormals(const std::vector<Eigen::Vector3d>& points,
                                           const std::vector<Triangle>& triangles);

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
