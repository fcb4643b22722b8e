// SPDX-License-Identifier: Zlib
#include "core/feature_contacts.h"

#include "core/feature_meeting.h"
#include "core/normal_cone.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Barycentric: a foot this far beside a triangle is in it.
constexpr double kBeside = 1e-3;
/// Sines beyond normal cones. Where edges cross, the normal is theirs, so that a cone may be generous.
constexpr double kVertexTolerance = 0.01, kCrossingTolerance = 0.1;
/// Of a vertex behind a triangle but not beneath it: cosine of the slope at which it may be.
constexpr double kSteep = 0.5;
/// A round surface is this many times thicker than the other.
constexpr double kRound = 2.0;

enum Rank : std::uint8_t {
  kVertexTriangle,
  kTriangleVertex,
  kEdgeEdge,
  kVertexEdge,
  kEdgeVertex,
  kVertexVertex
};

bool isRound(const MovingSurface& surface, const MovingSurface& other) {
  return surface.topology->triangles.empty() && surface.radius > kRound * other.radius;
}

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

SurfacePlace atVertex(std::uint32_t v) {
  return placeOn(v, std::array<std::uint32_t, 1>{v}, Vector3d::UnitX());
}

SurfacePlace onEdge(const MovingSurface& surface, std::uint32_t edge, const Eigen::Vector2d& weights) {
  return placeOn(edge, surface.topology->edges[edge], {weights[0], weights[1], 0.0});
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePlace& place, double time) {
  Vector3d position = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    position += place.weights[static_cast<Eigen::Index>(i)] * surface.at(place.points[i], time);
  return position;
}

bool areJoined(const SurfaceTopology& t, const SurfacePlace& a, const SurfacePlace& b) {
  for (const std::uint32_t v : a.points) {
    const auto isNeighbour = [&](std::uint32_t edge) {
      const std::uint32_t other = t.edges[edge][t.edges[edge][0] == v ? 1 : 0];
      return std::find(b.points.begin(), b.points.end(), other) != b.points.end();
    };
    if (std::find(b.points.begin(), b.points.end(), v) != b.points.end()) return true;
    if (std::any_of(t.edgesAround.begin(v), t.edgesAround.end(v), isNeighbour)) return true;
  }
  return false;
}

bool areCloseAtRest(const SurfacePair& pair, const SurfacePlace& a, const SurfacePlace& b) {
  const MovingSurface resting{pair.a.topology, &pair.a.topology->rest, pair.a.motion, pair.a.radius, nullptr};
  return (positionOf(resting, a, 0.0) - positionOf(resting, b, 0.0)).norm() <= pair.reach();
}

std::uint64_t meetingVertex(const SurfacePair& pair, std::uint32_t v, bool ofB) {
  return std::uint64_t{v} * 2 + (ofB && !pair.self ? 1 : 0);
}

void add(const SurfacePair& pair, ContactCandidate candidate, ContactSearch& search) {
  SurfaceContact& c = candidate.contact;
  if (pair.self && (areJoined(*pair.a.topology, c.a, c.b) || areCloseAtRest(pair, c.a, c.b))) return;
  c.gap = c.normal.dot(positionOf(pair.a, c.a, 0.0) - positionOf(pair.b, c.b, 0.0)) - pair.reach();
  c.key = std::uint64_t{candidate.rank} << 60 | std::uint64_t{c.a.feature} << 30 | c.b.feature;
  candidate.place = 0.5 * (positionOf(pair.a, c.a, c.time) + positionOf(pair.b, c.b, c.time));
  search.candidates.push_back(candidate);
}

/// Unit, from b to a; where they coincide, against their relative motion.
template <int N, int M>
Vector3d directionBetween(const NearestPlaces<N, M>& places, const MovingFeature<N>& a,
                          const MovingFeature<M>& b) {
  constexpr double kCoincident = 1e-12;
  if (places.distance > kCoincident) return places.away / places.distance;
  const Vector3d motion = b.motion * places.b - a.motion * places.a;
  return motion.squaredNorm() > 0.0 ? motion.normalized() : Vector3d::UnitY();
}

bool vertexMeets(const MovingSurface& surface, const MovingSurface& other, std::uint32_t v, double time,
                 const Vector3d& outward) {
  return isRound(other, surface) ? facesOutward(surface, time, v, outward)
                                 : isInVertexCone(surface, time, v, outward);
}

void meetVertices(const SurfacePair& pair, std::uint32_t va, std::uint32_t vb, ContactSearch& search) {
  const auto a = featureOf<1>(pair.a, std::array<std::uint32_t, 1>{va});
  const auto b = featureOf<1>(pair.b, std::array<std::uint32_t, 1>{vb});
  const auto places = findMeeting(a, b, pair.reach(), pair.margin);
  if (places.time == kNever) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.normal = directionBetween(places, a, b);
  c.time = places.time;
  if (!vertexMeets(pair.a, pair.b, va, c.time, -c.normal)) return;
  if (!vertexMeets(pair.b, pair.a, vb, c.time, c.normal)) return;
  c.a = atVertex(va);
  c.b = atVertex(vb);
  candidate.rank = kVertexVertex;
  candidate.scale = pair.reach();
  const bool ofB = isRound(pair.a, pair.b);
  candidate.vertex = meetingVertex(pair, ofB ? vb : va, ofB);
  add(pair, candidate, search);
}

/// A vertex of a against an edge of b, or (`ofB`) of b against one of a.
void meetVertexEdge(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t edge,
                    ContactSearch& search) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  const auto vertex = featureOf<1>(mine, std::array<std::uint32_t, 1>{v});
  const auto segment = featureOf<2>(other, other.topology->edges[edge]);
  const auto places = findMeeting(vertex, segment, pair.reach(), pair.margin);
  if (places.time == kNever || places.b.minCoeff() <= 0.0) return;
  const Vector3d outward = directionBetween(places, vertex, segment);
  if (!isInNormalCone(other, places.time, edge, outward, kVertexTolerance)) return;
  if (!vertexMeets(mine, other, v, places.time, -outward)) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(v);
  c.b = onEdge(other, edge, places.b);
  if (ofB) std::swap(c.a, c.b);
  c.normal = ofB ? Vector3d(-outward) : outward;
  c.time = places.time;
  candidate.rank = ofB ? kEdgeVertex : kVertexEdge;
  candidate.scale = (segment.start.col(1) - segment.start.col(0)).norm();
  candidate.vertex = meetingVertex(pair, v, ofB);
  add(pair, candidate, search);
}

double depthLimit(const SurfaceTopology& t, std::uint32_t edge) {
  double limit = 1e300;
  for (const std::uint32_t i : t.edgeTriangles[edge])
    if (i != kNoFeature) limit = std::min(limit, t.depthLimit[i]);
  return limit;
}

bool isInside(const MovingSurface& surface, const Vector3d& place, double within) {
  const NearestOnSurface nearest = nearestOnSurface(surface, place, within);
  return nearest.triangle != kNoFeature && surface.topology->oneSided[nearest.triangle] && nearest.behind;
}

/// Whether the crossing edges have passed through each other.
bool havePassed(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb,
                const NearestPlaces<2, 2>& places, const Vector3d& normal) {
  if (pair.self || places.time > 0.0) return false;
  if (places.distance > std::min(depthLimit(*pair.a.topology, ea), depthLimit(*pair.b.topology, eb)))
    return false;
  if (!isInNormalCone(pair.a, 0.0, ea, normal, kCrossingTolerance)) return false;
  if (!isInNormalCone(pair.b, 0.0, eb, -normal, kCrossingTolerance)) return false;
  const double within = 1.001 * places.distance;  // so that the edge itself is in reach, rounded or not
  return isInside(pair.b, featureOf<2>(pair.a, pair.a.topology->edges[ea]).start * places.a, within) ||
         isInside(pair.a, featureOf<2>(pair.b, pair.b.topology->edges[eb]).start * places.b, within);
}

void meetEdges(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, ContactSearch& search) {
  const auto a = featureOf<2>(pair.a, pair.a.topology->edges[ea]);
  const auto b = featureOf<2>(pair.b, pair.b.topology->edges[eb]);
  const auto places = findMeeting(a, b, pair.reach(), pair.margin);
  if (places.time == kNever || places.a.minCoeff() <= 0.0 || places.b.minCoeff() <= 0.0) return;
  const auto atA = a.at(places.time), atB = b.at(places.time);
  const Vector3d alongA = atA.col(1) - atA.col(0), alongB = atB.col(1) - atB.col(0);
  Vector3d normal = alongA.cross(alongB);
  if (normal.norm() <= kParallel * alongA.norm() * alongB.norm()) return;
  normal.normalize();
  if (normal.dot(places.away) < 0.0) normal = -normal;
  const bool apart = isInNormalCone(pair.a, places.time, ea, -normal, kCrossingTolerance) &&
                     isInNormalCone(pair.b, places.time, eb, normal, kCrossingTolerance);
  if (!apart && !havePassed(pair, ea, eb, places, normal)) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = onEdge(pair.a, ea, places.a);
  c.b = onEdge(pair.b, eb, places.b);
  c.normal = apart ? normal : Vector3d(-normal);
  c.time = places.time;
  candidate.rank = kEdgeEdge;
  candidate.scale = std::min(alongA.norm(), alongB.norm());
  candidate.vertex = kNoVertex;
  add(pair, candidate, search);
}

/// Barycentric coordinates of the foot of `p` in the triangle's plane.
Vector3d footIn(const MovingFeature<3>::Corners& triangle, const Vector3d& p) {
  const Vector3d u = triangle.col(1) - triangle.col(0), v = triangle.col(2) - triangle.col(0);
  const Vector3d normal = u.cross(v), to = p - triangle.col(0);
  const double squared = normal.squaredNorm();
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  return {1.0 - second - third, second, third};
}

/// Moves a foot that is slightly beside its triangle into it.
bool moveInto(Vector3d& barycentric) {
  if (!(barycentric.minCoeff() >= -kBeside)) return false;
  barycentric = barycentric.cwiseMax(0.0);
  barycentric /= barycentric.sum();
  return true;
}

struct VertexTriangle {
  const SurfacePair& pair;
  MovingFeature<1> vertex;
  MovingFeature<3> triangle;
  VertexBehind at;
  double side = 1.0;  ///< -1: seen from behind

  Vector3d normal(double time) const { return side * normalOf<3>(triangle.at(time)); }
  double height(double time) const {
    return normal(time).dot((vertex.start + time * vertex.motion) - triangle.at(time).col(0));
  }
};

void addAt(VertexTriangle& meeting, double time, ContactSearch& search) {
  meeting.at.barycentric = footIn(meeting.triangle.at(time), meeting.vertex.at(time));
  if (!moveInto(meeting.at.barycentric)) return;
  const Vector3d normal = meeting.normal(time);
  const MovingSurface& mine = meeting.at.ofB ? meeting.pair.b : meeting.pair.a;
  if (!facesOutward(mine, time, meeting.at.vertex, -normal)) return;
  addVertexOnTriangle(meeting.pair, meeting.at, normal, time, search);
}

void addBehind(VertexTriangle& meeting, double depth, double limit, ContactSearch& search) {
  if (meeting.pair.self || depth > limit) return;
  const MovingFeature<3>::Corners& t = meeting.triangle.start;
  VertexBehind& at = meeting.at;
  at.depth = depth;
  at.barycentric = footIn(t, meeting.vertex.start);
  at.beneath = moveInto(at.barycentric);
  if (!at.beneath) {
    at.barycentric = nearestBarycentric({t.col(0), t.col(1), t.col(2)}, meeting.vertex.start);
    at.depth = (t * at.barycentric - meeting.vertex.start).norm();
    if (at.depth > limit || depth < kSteep * at.depth) return;
  }
  search.behind.push_back(at);
}

/// When a vertex in front of the triangle's plane comes within reach of it, by conservative advancement as in
/// findMeeting(); kNever if it does not, or not within the tick.
double timeOfLanding(const VertexTriangle& meeting, double height) {
  const double reach = meeting.pair.reach(), met = kMetShare * meeting.pair.margin;
  double time = 0.0;
  Vector3d normal = meeting.normal(0.0);
  for (int i = 0; i < kMostAdvances && height - reach > met; ++i) {
    const double approach = approachAlong(normal, meeting.vertex, meeting.triangle);
    if (approach <= 0.0 || time + (height - reach) / approach > 1.0) return kNever;
    time += (height - reach) / approach;
    normal = meeting.normal(time);
    height = meeting.height(time);
  }
  return height - reach > met ? kNever : time;
}

void meetVertexTriangle(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t triangle,
                        ContactSearch& search) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  VertexTriangle meeting{pair,
                         featureOf<1>(mine, std::array<std::uint32_t, 1>{v}),
                         featureOf<3>(other, other.topology->triangles[triangle]),
                         {},
                         1.0};
  meeting.at.ofB = ofB;
  meeting.at.vertex = v;
  meeting.at.triangle = triangle;
  Vector3d normal = meeting.normal(0.0);
  if (normal.squaredNorm() == 0.0) return;
  double height = normal.dot(meeting.vertex.start - meeting.triangle.start.col(0));
  if (height < 0.0) {
    if (other.topology->oneSided[triangle])
      return addBehind(meeting, -height, other.topology->depthLimit[triangle], search);
    meeting.side = -1.0;
    normal = -normal;
    height = -height;
  }
  const double gap = height - pair.reach();
  if (gap > pair.margin && approachAlong(normal, meeting.vertex, meeting.triangle) < gap) return;
  const double time = gap > 0.0 ? timeOfLanding(meeting, height) : 0.0;
  if (time != kNever)
    addAt(meeting, time, search);
  else if (gap <= pair.margin)
    addAt(meeting, 0.0, search);
}

}  // namespace

void addVertexOnTriangle(const SurfacePair& pair, const VertexBehind& at, const Vector3d& normal, double time,
                         ContactSearch& search) {
  const SurfaceTopology& t = *(at.ofB ? pair.a : pair.b).topology;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(at.vertex);
  c.b = placeOn(at.triangle, t.triangles[at.triangle], at.barycentric);
  if (at.ofB) std::swap(c.a, c.b);
  c.normal = at.ofB ? Vector3d(-normal) : normal;
  c.time = time;
  candidate.rank = at.ofB ? kTriangleVertex : kVertexTriangle;
  candidate.scale = t.depthLimit[at.triangle];
  candidate.vertex = meetingVertex(pair, at.vertex, at.ofB);
  add(pair, candidate, search);
}

void meetElements(const SurfacePair& pair, const SurfaceElement& a, const SurfaceElement& b,
                  ContactSearch& search) {
  for (const std::uint32_t va : a.vertices) {
    if (va == kNoFeature) continue;
    if (b.triangle != kNoFeature) meetVertexTriangle(pair, false, va, b.triangle, search);
    for (const std::uint32_t edge : b.edges)
      if (edge != kNoFeature) meetVertexEdge(pair, false, va, edge, search);
    for (const std::uint32_t vb : b.vertices)
      if (vb != kNoFeature) meetVertices(pair, va, vb, search);
  }
  for (const std::uint32_t vb : b.vertices) {
    if (vb == kNoFeature) continue;
    if (a.triangle != kNoFeature) meetVertexTriangle(pair, true, vb, a.triangle, search);
    for (const std::uint32_t edge : a.edges)
      if (edge != kNoFeature) meetVertexEdge(pair, true, vb, edge, search);
  }
  for (const std::uint32_t ea : a.edges)
    for (const std::uint32_t eb : b.edges)
      if (ea != kNoFeature && eb != kNoFeature) meetEdges(pair, ea, eb, search);
}

}  // namespace limber
