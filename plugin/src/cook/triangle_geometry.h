// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/closest_points.h"

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

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
std::optional<LineHit> meetLine(const TriangleCorners& triangle, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction, double margin);

/// Signed solid angle of the triangle seen from `p`, positive from behind, where its corners run clockwise
/// (A. van Oosterom, J. Strackee, "The solid angle of a plane triangle", 1983). 0 in its plane.
double solidAngle(const TriangleCorners& triangle, const Eigen::Vector3d& p);

inline Eigen::Vector3d pointAt(const TriangleCorners& triangle, const Eigen::Vector3d& barycentric) {
  return barycentric[0] * triangle[0] + barycentric[1] * triangle[1] + barycentric[2] * triangle[2];
}

/// m: the longest side of the points' bounding box; 0 without points.
double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points);
double extent(const std::vector<Eigen::Vector3d>& points);

/// m^3: what the triangles enclose, below 0 where they face inward.
double signedVolume(const std::vector<Eigen::Vector3d>& points, const std::vector<Triangle>& triangles);

/// By the area of the triangles around each point; zero where they cancel. Unit vectors, #points.
std::vector<Eigen::Vector3d> vertexNormals(const std::vector<Eigen::Vector3d>& points,
                                           const std::vector<Triangle>& triangles);

}  // namespace limber
