// SPDX-License-Identifier: Zlib
#include "cook/antipodal_chords.h"

#include <algorithm>
#include <array>

namespace limber {
namespace {

/// Share of the size from which on a ray counts as having left its own surface.
constexpr double kAway = 1e-4;

std::vector<Eigen::Vector3d> pointNormals(const std::vector<Eigen::Vector3d>& points,
                                          const std::vector<Triangle>& triangles) {
  std::vector<Eigen::Vector3d> normals(points.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : triangles) {
    const Eigen::Vector3d area = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    for (const std::uint32_t corner : t) normals[corner] += area;
  }
  for (Eigen::Vector3d& n : normals)
    if (n.norm() > 0.0) n.normalize();
  return normals;
}

/// The corners of the triangle that was hit, the nearest first.
Triangle byDistance(const std::vector<Eigen::Vector3d>& points, Triangle t, const Eigen::Vector3d& hit) {
  std::stable_sort(t.begin(), t.end(), [&](std::uint32_t a, std::uint32_t b) {
    return (points[a] - hit).squaredNorm() < (points[b] - hit).squaredNorm();
  });
  return t;
}

}  // namespace

std::vector<Edge> antipodalChords(const std::vector<Eigen::Vector3d>& points,
                                  const std::vector<Triangle>& triangles, InsideChords& chords) {
  const std::vector<Eigen::Vector3d> normals = pointNormals(points, triangles);
  std::vector<Edge> found;
  std::vector<bool> ends(points.size(), false);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (ends[i] && getenv("THIN")) continue;
    const SurfaceHit hit =
        chords.surface().firstHit(points[i], -normals[i], kAway * chords.size(), 4.0 * chords.size());
    if (!hit) continue;
    for (const std::uint32_t j : byDistance(points, triangles[hit.triangle], hit.position)) {
      if (std::find(found.begin(), found.end(), Edge{std::min(i, j), std::max(i, j)}) != found.end()) break;
      if (!chords.allowed(i, j)) continue;
      chords.join(i, j);
      ends[i] = ends[j] = true;
      found.push_back({std::min(i, j), std::max(i, j)});
      break;
    }
  }
  return found;
}

}  // namespace limber
