// SPDX-License-Identifier: Zlib
#include "cook/triangle_geometry.h"

#include <Eigen/Geometry>

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// From 0 at the first to 1 at the second corner; `numerator` and `rest` are the distances from them along
/// the edge, both times its length.
double edgeFraction(double numerator, double rest) {
  const double sum = numerator + rest;
  return sum > 0.0 ? numerator / sum : 0.0;
}

}  // namespace

Vector3d nearestBarycentric(const TriangleCorners& t, const Vector3d& p) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0];
  const Vector3d ap = p - t[0], bp = p - t[1], cp = p - t[2];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};

  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double v = edgeFraction(d1, -d3);
    return {1.0 - v, v, 0.0};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double w = edgeFraction(d2, -d6);
    return {1.0 - w, 0.0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = edgeFraction(d4 - d3, d5 - d6);
    return {0.0, 1.0 - w, w};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {1.0 - v - w, v, w};
}

std::optional<LineHit> meetLine(const TriangleCorners& t, const Vector3d& origin, const Vector3d& direction,
                                double margin) {
  const Vector3d e1 = t[1] - t[0], e2 = t[2] - t[0];
  const Vector3d h = direction.cross(e2);
  const double determinant = e1.dot(h);
  if (determinant == 0.0) return std::nullopt;
  const Vector3d s = origin - t[0], q = s.cross(e1);
  const double v = s.dot(h) / determinant, w = direction.dot(q) / determinant;
  // the negation also refuses what is not a number
  if (!(v >= -margin && w >= -margin && v + w <= 1.0 + margin)) return std::nullopt;
  return LineHit{e2.dot(q) / determinant, Vector3d(1.0 - v - w, v, w)};
}

double solidAngle(const TriangleCorners& t, const Vector3d& p) {
  const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return numerator == 0.0 ? 0.0 : 2.0 * std::atan2(numerator, denominator);
}

double extent(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  if (points.cols() == 0) return 0.0;
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
}

double extent(const std::vector<Vector3d>& points) {
  if (points.empty()) return 0.0;
  return extent(
      Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, static_cast<Eigen::Index>(points.size())));
}

double signedVolume(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) return 0.0;
  const Vector3d& origin = points[triangles[0][0]];
  double six = 0.0;
  for (const Triangle& t : triangles)
    six += (points[t[0]] - origin).dot((points[t[1]] - origin).cross(points[t[2]] - origin));
  return six / 6.0;
}

std::vector<Vector3d> vertexNormals(const std::vector<Vector3d>& points,
                                    const std::vector<Triangle>& triangles) {
  std::vector<Vector3d> normals(points.size(), Vector3d::Zero());
  for (const Triangle& t : triangles) {
    const Vector3d twiceArea = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    for (const std::uint32_t corner : t) normals[corner] += twiceArea;
  }
  for (Vector3d& normal : normals) normal.normalize();
  return normals;
}

}  // namespace limber
