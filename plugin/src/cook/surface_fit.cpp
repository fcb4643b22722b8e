// SPDX-License-Identifier: Zlib
#include "cook/surface_fit.h"

#include "cook/tetrahedron_faces.h"
#include "cook/triangle_geometry.h"
#include "solver/linear_algebra.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Rounds over all points.
constexpr int kRounds = 6;

/// Weight of staying in place against the planes: it decides only along directions that no plane does.
constexpr double kStayInPlace = 0.05;

struct Fit {
  TetrahedralMesh& mesh;
  std::vector<std::vector<std::uint32_t>> tetrahedraAt, trianglesAt;  ///< of each point
};

/// How far the angles at a point are within their bounds, radians; negative outside, -10 for a tetrahedron
/// that is turned over.
double slack(const Fit& fit, std::uint32_t point) {
  double least = kPi;
  for (const std::uint32_t i : fit.tetrahedraAt[point]) {
    const Tetrahedron& t = fit.mesh.tetrahedra[i];
    if (volumeOf(fit.mesh.points, t) <= 0.0) return -10.0;
    const DihedralAngles angles = dihedralAngles(fit.mesh.points, t);
    least = std::min({least, angles.smallest - kSmallestAngle * kPi / 180.0,
                      kLargestAngle * kPi / 180.0 - angles.largest});
  }
  return least;
}

/// Moves the point towards `target` as far as the angles stay within bounds, or no worse than they are.
void moveTowards(Fit& fit, std::uint32_t point, const Vector3d& target) {
  const Vector3d from = fit.mesh.points[point];
  const double least = std::min(0.0, slack(fit, point));
  for (const double share : {1.0, 0.5, 0.25}) {
    fit.mesh.points[point] = from + share * (target - from);
    if (slack(fit, point) >= least) return;
  }
  fit.mesh.points[point] = from;
}

/// Where the planes of the surface next to the triangles around a point meet.
Vector3d meetingOfPlanes(const Fit& fit, std::uint32_t point, const SolidSurface& surface) {
  const std::vector<Vector3d>& points = fit.mesh.points;
  const Vector3d& here = points[point];
  Matrix3d left = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double area = 0.0;
  for (const std::uint32_t i : fit.trianglesAt[point]) {
    const Triangle& t = fit.mesh.surface[i];
    const double weight = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).norm();
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vector3d sample = (points[t[0]] + points[t[1]] + points[t[2]] + 3.0 * points[t[corner]]) / 6.0;
      const SurfaceHit hit = surface.bvh.nearest(sample);
      const Vector3d& normal = surface.normals[hit.triangle];
      left += weight * normal * normal.transpose();
      right += weight * normal.dot(hit.position - here) * normal;
    }
    area += weight;
  }
  left += kStayInPlace * area * Matrix3d::Identity();
  solveSmall(left, right);
  return here + right;
}

Vector3d meanOfNeighbours(const Fit& fit, std::uint32_t point) {
  Vector3d sum = Vector3d::Zero();
  double weight = 0.0;
  for (const std::uint32_t i : fit.tetrahedraAt[point]) {
    const Tetrahedron& t = fit.mesh.tetrahedra[i];
    const double volume = volumeOf(fit.mesh.points, t);
    for (const std::uint32_t corner : t) sum += 0.25 * volume * fit.mesh.points[corner];
    weight += volume;
  }
  return sum / weight;
}

}  // namespace

void fitSurface(TetrahedralMesh& mesh, const SolidSurface& surface) {
  Fit fit{mesh, {}, {}};
  fit.tetrahedraAt.resize(mesh.points.size());
  fit.trianglesAt.resize(mesh.points.size());
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (const std::uint32_t point : mesh.tetrahedra[t]) fit.tetrahedraAt[point].push_back(t);
  for (std::uint32_t t = 0; t < mesh.surface.size(); ++t)
    for (const std::uint32_t point : mesh.surface[t]) fit.trianglesAt[point].push_back(t);
  for (int round = 0; round < kRounds; ++round)
    for (std::uint32_t point = 0; point < mesh.points.size(); ++point)
      moveTowards(fit, point,
                  fit.trianglesAt[point].empty() ? meanOfNeighbours(fit, point)
                                                 : meetingOfPlanes(fit, point, surface));
}

}  // namespace limber
