// SPDX-License-Identifier: Zlib
#include "collide/edge_contacts.h"

#include "collide/feature_meeting.h"
#include "collide/normal_cone.h"

#include <algorithm>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Sines beyond normal cones. Where edges cross, the normal is theirs, so that a cone may be generous.
constexpr double kVertexTolerance = 0.01, kCrossingTolerance = 0.1;

/// Unit, from b to a; where they coincide, against their relative motion.
template <int N, int M>
Vector3d directionBetween(const NearestPlaces<N, M>& places, const MovingFeature<N>& a,
                          const MovingFeature<M>& b) {
  constexpr double kCoincident = 1e-12;
  if (places.distance > kCoincident) return places.away / places.distance;
  const Vector3d motion = b.motion * places.b - a.motion * places.a;
  return motion.squaredNorm() > 0.0 ? motion.normalized() : Vector3d::UnitY();
}

/// A vertex that comes near a place on another surface.
struct Arrival {
  std::uint32_t vertex;
  Vector3d outward;  ///< unit, from the vertex to the place
  Vector3d motion;   ///< m over the tick, of the vertex relative to the place
  double time, gap;  ///< when they are nearest, and the gap then
};

/// Whether the vertex touches a round surface as it would a face: it has neighbours within the radius, so
/// that faces between them do not keep the round away, and it does not just pass along it.
bool meetsRound(const SurfacePair& pair, const MovingSurface& mine, const MovingSurface& other,
                const Arrival& at) {
  constexpr double kTouching = 0.1;  // share of the margin
  constexpr double kHeadOn = 0.5;    // cosine
  if (!isRound(other, mine)) return false;
  const SurfaceTopology& t = *mine.topology;
  const auto isLong = [&](std::uint32_t e) {
    return (mine.position->col(t.edges[e][0]) - mine.position->col(t.edges[e][1])).norm() > other.radius;
  };
  if (std::any_of(t.edgesAround.begin(at.vertex), t.edgesAround.end(at.vertex), isLong)) return false;
  const bool touches = at.time == 0.0 && at.gap <= kTouching * pair.margin;
  return (touches || at.outward.dot(at.motion) >= kHeadOn * at.motion.norm()) &&
         facesOutward(mine, at.time, at.vertex, at.outward);
}

bool vertexMeets(const SurfacePair& pair, bool ofB, const Arrival& at) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  if (pair.self && mine.topology->triangles.empty())
    return true;  // a fold is nearest to itself where it bends
  return isInVertexCone(mine, at.time, at.vertex, at.outward) || meetsRound(pair, mine, other, at);
}

Vector3d alongOf(const MovingFeature<2>& edge, double time) {
  const auto ends = edge.at(time);
  return ends.col(1) - ends.col(0);
}

/// The contacts of parallel edges are those of their ends.
bool areParallel(const Vector3d& a, const Vector3d& b) {
  constexpr double kSine = 0.01;
  return a.cross(b).squaredNorm() <= kSine * kSine * a.squaredNorm() * b.squaredNorm();
}

double depthLimit(const SurfaceTopology& t, std::uint32_t edge) {
  double limit = 1e300;
  for (const std::uint32_t i : t.edgeTriangles[edge])
    if (i != kNoFeature) limit = std::min(limit, t.depthLimit[i]);
  return limit;
}

/// Of a place that is `depth` behind an edge, and so, straight below one, on a surface beside it.
bool isInside(const MovingSurface& surface, const Vector3d& place, double depth) {
  constexpr double kRounding = 1.001;
  const NearestOnSurface nearest = nearestOnSurface(surface, place, kRounding * depth);
  if (nearest.triangle == kNoFeature || !surface.topology->oneSided[nearest.triangle]) return false;
  return nearest.behind || nearest.distance <= kCrossingTolerance * depth;
}

/// Whether the edge is one of a sheet, which has no inside: whatever it does not cross is in front of it.
bool isOfSheet(const SurfaceTopology& t, std::uint32_t edge) {
  const auto [first, second] = t.edgeTriangles[edge];
  const auto hasInside = [&](std::uint32_t i) { return i != kNoFeature && t.oneSided[i]; };
  return !hasInside(first) && !hasInside(second);
}

/// Whether the crossing edges, of which `normal` is the direction from b to a, are apart from each other
/// where they may touch. Two ridges may.
///
/// So may a ridge and any fold of a sheet. A sheet that a ridge pushes back at one of its folds bends there,
/// so that the next fold becomes what is nearest, within the tick: if only ridges counted, the two would fall
/// and be pushed back in turn. Folds are no nearer than the ridges beside them, and bear nothing until they
/// must. Nor are flat ones left out where a triangle beside the ridge bears the sheet: that is how one comes
/// to rest there.
bool areApart(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, double time,
              const Vector3d& normal) {
  const bool isRidgeOfA = isInNormalCone(pair.a, time, ea, -normal, kCrossingTolerance);
  const bool isRidgeOfB = isInNormalCone(pair.b, time, eb, normal, kCrossingTolerance);
  return isRidgeOfA ? isRidgeOfB || isOfSheet(*pair.b.topology, eb)
                    : isRidgeOfB && isOfSheet(*pair.a.topology, ea);
}

/// Whether the crossing edges have passed through each other.
bool havePassed(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb,
                const NearestPlaces<2, 2>& places, const Vector3d& normal) {
  if (pair.self || places.time > 0.0) return false;
  if (places.distance > std::min(depthLimit(*pair.a.topology, ea), depthLimit(*pair.b.topology, eb)))
    return false;
  if (!isInNormalCone(pair.a, 0.0, ea, normal, kCrossingTolerance)) return false;
  if (!isInNormalCone(pair.b, 0.0, eb, -normal, kCrossingTolerance)) return false;
  return isInside(pair.b, featureOf<2>(pair.a, pair.a.topology->edges[ea]).start * places.a,
                  places.distance) ||
         isInside(pair.a, featureOf<2>(pair.b, pair.b.topology->edges[eb]).start * places.b, places.distance);
}

}  // namespace

void meetVertices(const SurfacePair& pair, std::uint32_t va, std::uint32_t vb, ContactSearch& search) {
  const auto a = featureOf<1>(pair.a, std::array<std::uint32_t, 1>{va});
  const auto b = featureOf<1>(pair.b, std::array<std::uint32_t, 1>{vb});
  const auto places = findMeeting(a, b, pair.reach(), pair.margin);
  if (places.time == kNever) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.normal = directionBetween(places, a, b);
  c.time = places.time;
  const Vector3d motion = a.motion - b.motion;
  const double gap = places.distance - pair.reach();
  if (!vertexMeets(pair, false, {va, -c.normal, motion, c.time, gap})) return;
  if (!vertexMeets(pair, true, {vb, c.normal, -motion, c.time, gap})) return;
  c.a = atVertex(va);
  c.b = atVertex(vb);
  candidate.rank = kVertexVertex;
  candidate.scale = pair.reach();
  // each of many vertices around a ball has a contact; the nearest one is the ball's
  candidate.vertex = kNoVertex;
  if (isRound(pair.a, pair.b) && !isInVertexCone(pair.b, c.time, vb, c.normal))
    candidate.vertex = meetingVertex(pair, vb, true);
  else if (isRound(pair.b, pair.a) || pair.self)
    candidate.vertex = meetingVertex(pair, va, false);
  addCandidate(pair, candidate, search);
}

void meetVertexEdge(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t edge,
                    ContactSearch& search) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  const auto vertex = featureOf<1>(mine, std::array<std::uint32_t, 1>{v});
  const auto segment = featureOf<2>(other, other.topology->edges[edge]);
  const auto places = findMeeting(vertex, segment, pair.reach(), pair.margin);
  if (places.time == kNever || places.b.minCoeff() <= 0.0) return;
  const Vector3d outward = directionBetween(places, vertex, segment);
  if (!isInNormalCone(other, places.time, edge, outward, kVertexTolerance)) return;
  const Vector3d motion = vertex.motion - segment.motion * places.b;
  const double gap = places.distance - pair.reach();
  if (!vertexMeets(pair, ofB, {v, -outward, motion, places.time, gap})) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(v);
  c.b = onEdge(*other.topology, edge, places.b);
  if (ofB) std::swap(c.a, c.b);
  c.normal = ofB ? Vector3d(-outward) : outward;
  c.time = places.time;
  candidate.rank = ofB ? kEdgeVertex : kVertexEdge;
  candidate.scale = (segment.start.col(1) - segment.start.col(0)).norm();
  candidate.vertex = meetingVertex(pair, v, ofB);
  addCandidate(pair, candidate, search);
}

void meetEdges(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, ContactSearch& search) {
  const auto a = featureOf<2>(pair.a, pair.a.topology->edges[ea]);
  const auto b = featureOf<2>(pair.b, pair.b.topology->edges[eb]);
  if (areParallel(alongOf(a, 0.0), alongOf(b, 0.0))) return;
  const auto places = findMeeting(a, b, pair.reach(), pair.margin);
  if (places.time == kNever || places.a.minCoeff() <= 0.0 || places.b.minCoeff() <= 0.0) return;
  const Vector3d alongA = alongOf(a, places.time), alongB = alongOf(b, places.time);
  if (areParallel(alongA, alongB)) return;
  Vector3d normal = alongA.cross(alongB).normalized();
  if (normal.dot(directionBetween(places, a, b)) < 0.0) normal = -normal;
  const bool apart = areApart(pair, ea, eb, places.time, normal);
  if (!apart && !havePassed(pair, ea, eb, places, normal)) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = onEdge(*pair.a.topology, ea, places.a);
  c.b = onEdge(*pair.b.topology, eb, places.b);
  c.normal = apart ? normal : Vector3d(-normal);
  c.time = places.time;
  candidate.rank = kEdgeEdge;
  candidate.scale = std::min(alongA.norm(), alongB.norm());
  candidate.vertex = kNoVertex;
  addCandidate(pair, candidate, search);
}

}  // namespace limber
