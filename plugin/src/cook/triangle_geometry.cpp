// SPDX-License-Identifier: Zlib
#include "cook/triangle_geometry.h"

#include <Eigen/Geometry>

#include <cmath>

namespace limber {

using Eigen::Vector3d;

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
