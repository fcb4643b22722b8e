// SPDX-License-Identifier: Zlib
#include "cook/antipodal_braces.h"

#include <algorithm>

namespace limber {
namespace {

/// Share of the size from which on a ray counts as having left its own surface.
constexpr double kAway = 1e-4;

/// Of the size: longer than any ray within the body.
constexpr double kFarAway = 2.0;

using Positions = std::vector<Eigen::Vector3d>;

Positions pointNormals(const Positions& points, const std::vector<Triangle>& triangles) {
  Positions normals(points.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : triangles) {
    const Eigen::Vector3d area = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    for (const std::uint32_t corner : t) normals[corner] += area;
  }
  for (Eigen::Vector3d& n : normals) n.normalize();
  return normals;
}

/// The corners of the triangle that was hit, the nearest first.
Triangle byDistance(const Positions& points, Triangle t, const Eigen::Vector3d& hit) {
  std::stable_sort(t.begin(), t.end(), [&](std::uint32_t a, std::uint32_t b) {
    return (points[a] - hit).squaredNorm() < (points[b] - hit).squaredNorm();
  });
  return t;
}

}  // namespace

void addAntipodalBraces(BracedPiece& piece) {
  const Positions& points = piece.network.restPoints;
  const std::vector<Triangle>& triangles = piece.network.surface;
  const Positions normals = pointNormals(points, triangles);
  const double size = piece.chords.size();
  std::vector<bool> reached(points.size(), false);
  for (std::uint32_t i = 0; i < points.size() && !piece.full(); ++i) {
    if (reached[i]) continue;
    const SurfaceHit hit =
        piece.chords.surface().firstHit(points[i], -normals[i], kAway * size, kFarAway * size);
    if (!hit) continue;
    for (const std::uint32_t j : byDistance(points, triangles[hit.triangle], hit.position)) {
      if (!piece.chords.allowed(i, j)) continue;
      addBrace(piece, {std::min(i, j), std::max(i, j)});
      reached[i] = reached[j] = true;
      break;
    }
  }
}

}  // namespace limber
