// SPDX-License-Identifier: Zlib
#include "collide/normal_cone.h"

#include <algorithm>

namespace limber {
namespace {

using Eigen::Vector3d;

/// About rad: an edge that is folded by less is flat.
constexpr double kFlatFold = 0.02;
/// Sine beyond a vertex's cone that rounding, and a body's slight sag, may come to.
constexpr double kConeTolerance = 0.01;
/// Cosine from which a triangle shows its outside: those beside a flat face do not.
constexpr double kFacing = 0.02;

/// Unit, from the edge into the triangle, perpendicular to the edge.
Vector3d inwardFrom(const MovingSurface& surface, double time, std::uint32_t edge, std::uint32_t triangle) {
  const Edge& ends = surface.topology->edges[edge];
  const Vector3d from = surface.at(ends[0], time), along = (surface.at(ends[1], time) - from).normalized();
  std::uint32_t opposite = ends[0];
  for (const std::uint32_t corner : surface.topology->triangles[triangle])
    if (corner != ends[0] && corner != ends[1]) opposite = corner;
  const Vector3d to = surface.at(opposite, time) - from;
  return (to - along * along.dot(to)).normalized();
}

Vector3d normalAt(const MovingSurface& surface, double time, std::uint32_t triangle) {
  return normalOf<3>(featureOf<3>(surface, surface.topology->triangles[triangle]).at(time));
}

}  // namespace

bool isInNormalCone(const MovingSurface& surface, double time, std::uint32_t edge, const Vector3d& outward,
                    double tolerance) {
  const auto [first, second] = surface.topology->edgeTriangles[edge];
  if (first == kNoFeature) return true;
  const Vector3d in0 = inwardFrom(surface, time, edge, first);
  if (second == kNoFeature) return outward.dot(in0) <= tolerance;
  const Vector3d in1 = inwardFrom(surface, time, edge, second);
  const double fold = (in0 + in1).norm();
  if (fold < kFlatFold || outward.dot(in0 + in1) >= 0.0) return false;
  const double most = std::min(tolerance, 0.25 * fold);
  if (outward.dot(in0) > most || outward.dot(in1) > most) return false;
  if (!surface.topology->oneSided[first] || !surface.topology->oneSided[second]) return true;
  return outward.dot(normalAt(surface, time, first) + normalAt(surface, time, second)) > 0.0;
}

bool isInVertexCone(const MovingSurface& surface, double time, std::uint32_t vertex,
                    const Vector3d& outward) {
  const SurfaceTopology& t = *surface.topology;
  const Vector3d from = surface.at(vertex, time);
  for (const std::uint32_t* e = t.edgesAround.begin(vertex); e != t.edgesAround.end(vertex); ++e) {
    const std::uint32_t other = t.edges[*e][t.edges[*e][0] == vertex ? 1 : 0];
    const Vector3d along = surface.at(other, time) - from;
    if (outward.dot(along) > kConeTolerance * along.norm()) return false;
  }
  return facesOutward(surface, time, vertex, outward);
}

bool facesOutward(const MovingSurface& surface, double time, std::uint32_t vertex, const Vector3d& outward) {
  const SurfaceTopology& t = *surface.topology;
  const std::uint32_t *begin = t.trianglesAround.begin(vertex), *end = t.trianglesAround.end(vertex);
  return begin == end || std::any_of(begin, end, [&](std::uint32_t i) {
           return !t.oneSided[i] || outward.dot(normalAt(surface, time, i)) > kFacing;
         });
}

}  // namespace limber
