// SPDX-License-Identifier: Zlib
#include "collide/contact_candidates.h"

#include "solver/closest_points.h"

#include <algorithm>

namespace limber {
namespace {

using Eigen::Vector3d;

/// A round surface is this many times thicker than the other.
constexpr double kRound = 2.0;

template <std::size_t N>
SurfacePlace placeOn(std::uint32_t feature, const std::array<std::uint32_t, N>& corners,
                     const Vector3d& weights) {
  SurfacePlace place;
  place.kind = static_cast<FeatureKind>(N - 1);
  place.feature = feature;
  for (std::size_t i = 0; i < 3; ++i) place.points[i] = corners[std::min(i, N - 1)];
  place.weights = weights;
  return place;
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePlace& place, double time) {
  Vector3d position = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    position += place.weights[static_cast<Eigen::Index>(i)] * surface.at(place.points[i], time);
  return position;
}

bool shareVertex(const SurfacePlace& a, const SurfacePlace& b) {
  return std::any_of(a.points.begin(), a.points.end(), [&](std::uint32_t v) {
    return std::find(b.points.begin(), b.points.end(), v) != b.points.end();
  });
}

/// m, of a vertex or edge from a vertex, an edge or, of a vertex, a triangle.
double distanceAtRest(const Points& rest, const SurfacePlace& a, const SurfacePlace& b) {
  if (a.kind == FeatureKind::OnTriangle) return distanceAtRest(rest, b, a);
  const auto corner = [&](const SurfacePlace& place, std::size_t i) { return Vector3d(rest.col(place.points[i])); };
  if (b.kind == FeatureKind::OnTriangle) {
    const Vector3d weights = nearestBarycentric({corner(b, 0), corner(b, 1), corner(b, 2)}, corner(a, 0));
    return (weights[0] * corner(b, 0) + weights[1] * corner(b, 1) + weights[2] * corner(b, 2) - corner(a, 0)).norm();
  }
  // an edge without length is a vertex
  const SegmentPair along = nearestOnSegments(corner(a, 0), corner(a, 1), corner(b, 0), corner(b, 1));
  return (corner(a, 0) + along.a * (corner(a, 1) - corner(a, 0)) - corner(b, 0) -
          along.b * (corner(b, 1) - corner(b, 0)))
      .norm();
}

/// Wherever on them: braces that cross at rest lie in each other for ever, also where they are sheared.
bool areCloseAtRest(const SurfacePair& pair, const SurfacePlace& a, const SurfacePlace& b) {
  return distanceAtRest(pair.a.topology->rest, a, b) <= pair.reach() + pair.margin - pair.farther;
}

}  // namespace

bool isRound(const MovingSurface& surface, const MovingSurface& other) {
  return surface.topology->triangles.empty() && surface.radius > kRound * other.radius;
}

SurfacePlace atVertex(std::uint32_t v) {
  return placeOn(v, std::array<std::uint32_t, 1>{v}, Vector3d::UnitX());
}

SurfacePlace onEdge(const SurfaceTopology& t, std::uint32_t edge, const Eigen::Vector2d& weights) {
  return placeOn(edge, t.edges[edge], {weights[0], weights[1], 0.0});
}

SurfacePlace onTriangle(const SurfaceTopology& t, std::uint32_t triangle, const Vector3d& weights) {
  return placeOn(triangle, t.triangles[triangle], weights);
}

std::uint64_t meetingVertex(const SurfacePair& pair, std::uint32_t v, bool ofB) {
  return std::uint64_t{v} * 2 + (ofB && !pair.self ? 1 : 0);
}

void addCandidate(const SurfacePair& pair, ContactCandidate& candidate, ContactSearch& search) {
  SurfaceContact& c = candidate.contact;
  if (pair.self && (shareVertex(c.a, c.b) || areCloseAtRest(pair, c.a, c.b))) return;
  c.gap = c.normal.dot(positionOf(pair.a, c.a, 0.0) - positionOf(pair.b, c.b, 0.0)) - pair.reach();
  c.key = std::uint64_t{candidate.rank} << 60 | std::uint64_t{c.a.feature} << 30 | c.b.feature;
  candidate.place = 0.5 * (positionOf(pair.a, c.a, c.time) + positionOf(pair.b, c.b, c.time));
  search.candidates.push_back(candidate);
}

}  // namespace limber
