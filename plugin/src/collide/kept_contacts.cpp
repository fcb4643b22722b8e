// SPDX-License-Identifier: Zlib
#include "collide/kept_contacts.h"

#include "collide/feature_meeting.h"
#include "collide/vertex_triangle.h"

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Shares of the margin: by how much the surfaces may have moved against each other since the search, where
/// features begin and end to be nearest; and that and the coming motion together, within which nothing that
/// was not near meets.
constexpr double kMostMoved = 0.2, kMostWithMotion = 0.9;

/// Cosine by which a normal may have turned since.
constexpr double kSameNormal = 0.999;


/// m: the longest of the points' ways from `from` to `to`, after `common` is taken off.
double longestWay(const Points& from, const Points& to, const Vector3d& common) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < to.cols(); ++i) {
    const double x = to(0, i) - from(0, i) - common[0], y = to(1, i) - from(1, i) - common[1],
                 z = to(2, i) - from(2, i) - common[2];
    most = std::max(most, x * x + y * y + z * z);
  }
  return std::sqrt(most);
}

double longestMotion(const Points& motion, const Vector3d& common) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < motion.cols(); ++i)
    most = std::max(most, (Vector3d(motion.col(i)) - common).squaredNorm());
  return std::sqrt(most);
}

bool haveHardlyMoved(const MovingSurface& a, const MovingSurface& b, double margin,
                     const KeptContacts& kept) {
  const Vector3d way = a.position->col(0) - kept.a.col(0), motion = a.motion->col(0);
  const double moved = longestWay(kept.a, *a.position, way) + longestWay(kept.b, *b.position, way);
  if (!(moved <= kMostMoved * margin)) return false;
  return moved + longestMotion(*a.motion, motion) + longestMotion(*b.motion, motion) <=
         kMostWithMotion * margin;
}

/// Whether the place is on the vertex, within the edge or in the triangle that it was on; the weights are its
/// new ones there.
template <class Weights>
bool moveTo(SurfacePlace& place, const Weights& weights) {
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0.0)) return false;
    place.weights[i] = weights[i];
  }
  return true;
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePlace& place) {
  Vector3d x = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    x += place.weights[static_cast<Eigen::Index>(i)] * surface.position->col(place.points[i]);
  return x;
}

/// False where the two features no longer meet as they did; `normal` is not yet unit, nor of the right sign.
bool moveVertexTriangle(const MovingSurface& mine, SurfacePlace& vertex, const MovingSurface& other,
                        SurfacePlace& triangle, Vector3d& normal) {
  const Vector3d a = other.position->col(triangle.points[0]);
  const Vector3d u = other.position->col(triangle.points[1]) - a;
  const Vector3d v = other.position->col(triangle.points[2]) - a;
  const Vector3d to = mine.position->col(vertex.points[0]) - a;
  normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (!(squared > 0.0)) return false;
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  Vector3d weights(1.0 - second - third, second, third);
  if (!(weights.minCoeff() >= -kBeside)) return false;
  weights = weights.cwiseMax(0.0);
  triangle.weights = weights / weights.sum();
  return true;
}

bool moveEdges(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c, Vector3d& normal) {
  const auto ea = featureOf<2>(a, c.a.points), eb = featureOf<2>(b, c.b.points);
  const auto places = nearestPlaces(ea, eb, 0.0);
  normal = (ea.start.col(1) - ea.start.col(0)).cross(eb.start.col(1) - eb.start.col(0));
  return moveTo(c.a, places.a) && moveTo(c.b, places.b);
}

bool moveVertexEdge(const MovingSurface& mine, const SurfacePlace& vertex, const MovingSurface& other,
                    SurfacePlace& edge, Vector3d& normal) {
  const auto v = featureOf<1>(mine, vertex.points);
  const auto places = nearestPlaces(v, featureOf<2>(other, edge.points), 0.0);
  normal = places.away;
  return moveTo(edge, places.b);
}

bool movePlaces(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c, Vector3d& normal) {
  const FeatureKind onA = c.a.kind, onB = c.b.kind;
  if (onB == FeatureKind::OnTriangle) return moveVertexTriangle(a, c.a, b, c.b, normal);
  if (onA == FeatureKind::OnTriangle) return moveVertexTriangle(b, c.b, a, c.a, normal);
  if (onA == FeatureKind::OnEdge && onB == FeatureKind::OnEdge) return moveEdges(a, b, c, normal);
  if (onB == FeatureKind::OnEdge) return moveVertexEdge(a, c.a, b, c.b, normal);
  if (onA == FeatureKind::OnEdge) return moveVertexEdge(b, c.b, a, c.a, normal);
  normal = a.position->col(c.a.points[0]) - b.position->col(c.b.points[0]);
  return true;
}

bool refresh(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c) {
  Vector3d normal;
  if (!movePlaces(a, b, c, normal)) return false;
  const double length = normal.norm();
  if (!(length > 0.0)) return false;
  normal *= (normal.dot(c.normal) < 0.0 ? -1.0 : 1.0) / length;
  if (normal.dot(c.normal) < kSameNormal) return false;
  c.normal = normal;
  c.gap = normal.dot(positionOf(a, c.a) - positionOf(b, c.b)) - (a.radius + b.radius);
  c.time = 0.0;
  return true;
}

}  // namespace

bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, KeptContacts& kept) {
  if (kept.topologyA != a.topology || kept.topologyB != b.topology) return false;
  if (kept.a.cols() != a.position->cols() || kept.b.cols() != b.position->cols()) return false;
  if (!haveHardlyMoved(a, b, margin, kept)) return false;
  for (SurfaceContact& c : kept.contacts)
    if (!refresh(a, b, c)) return false;
  return true;
}

void keepContacts(const MovingSurface& a, const MovingSurface& b, const std::vector<SurfaceContact>& found,
                  KeptContacts& kept) {
  kept.contacts = found;
  kept.a = *a.position;
  kept.b = *b.position;
  kept.topologyA = a.topology;
  kept.topologyB = b.topology;
}

}  // namespace limber
