// SPDX-License-Identifier: Zlib
#include "mesh/closest_points.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Returns a position on an edge, from 0 at the first to 1 at the second corner. `numerator` and `rest` are
/// the distances from the corners along the edge, times the edge's length.
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

double nearestOnSegment(const Vector3d& from, const Vector3d& to, const Vector3d& p) {
  const Vector3d along = to - from;
  const double squared = along.squaredNorm();
  return squared > 0.0 ? std::clamp(along.dot(p - from) / squared, 0.0, 1.0) : 0.0;
}

SegmentPair nearestOnSegments(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                              const Vector3d& b1) {
  const Vector3d u = a1 - a0, v = b1 - b0, w = a0 - b0;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 0.0 ? std::clamp((uv * vw - vv * uw) / determinant, 0.0, 1.0) : 0.0;
  const double t = vv > 0.0 ? std::clamp((uv * s + vw) / vv, 0.0, 1.0) : 0.0;
  s = uu > 0.0 ? std::clamp((uv * t - uw) / uu, 0.0, 1.0) : 0.0;
  return {s, t};
}

}  // namespace limber
