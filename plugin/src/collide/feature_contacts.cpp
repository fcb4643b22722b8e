// SPDX-License-Identifier: Zlib
// Contacts of single features: vertices on triangles, vertices that have come inside, and edges and vertices
// where surfaces touch at edges and corners.
#include "collide/feature_contacts.h"

#include "solver/closest_points.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;

// --- when features meet ------------------------------------------------------------------------------------

/// m over the tick: how much the distance of the features along the unit `direction` from b to a can shrink.
template <int N, int M>
double approachAlong(const Eigen::Vector3d& direction, const MovingFeature<N>& a, const MovingFeature<M>& b) {
  return (direction.transpose() * b.motion).maxCoeff() - (direction.transpose() * a.motion).minCoeff();
}

/// Steps to a meeting; features that turn past each other need most.
constexpr int kMaxAdvances = 32;
/// Share of the margin within which features have met.
constexpr double kMetShare = 0.01;
/// Later than the tick.
constexpr double kNever = std::numeric_limits<double>::infinity();

/// When the features come within `radiusSum` (m) of each other: conservative advancement (Mirtich 1996), each
/// step along the direction between the nearest places, which bounds the approach of all others. A direct
/// hit takes one step.
/// @returns where they meet; or, if they do not within the tick but start within `margin` more, where they
/// are nearest at its start; else a time of kNever.
template <int N, int M>
NearestPoints<N, M> findFeatureContact(const MovingFeature<N>& a, const MovingFeature<M>& b, double radiusSum,
                                       double margin) {
  const NearestPoints<N, M> start = nearestPoints(a, b, 0.0);
  NearestPoints<N, M> places = start;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const double gap = places.distance - radiusSum;
    if (gap <= kMetShare * margin) return places;
    const double approach = approachAlong(places.away / places.distance, a, b);
    const double time = approach > 0.0 ? places.time + gap / approach : kNever;
    if (time > 1.0) break;
    places = nearestPoints(a, b, time);
  }
  places = start;
  if (start.distance - radiusSum > margin) places.time = kNever;
  return places;
}

// --- normal cones ------------------------------------------------------------------------------------------

// Two surfaces are locally nearest to each other where the direction between them is in the normal cones of
// both, at the given time of the tick. `outward` is a unit vector away from the surface.

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

/// Whether the edge is a ridge and `outward` is between the normals of its triangles (its Gauss arc). That of
/// a boundary is half a circle, that of a loose segment a full one (`outward` is perpendicular to it).
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

/// Whether a triangle around the vertex, if there are any, shows its outside to where `outward` points.
bool facesOutward(const MovingSurface& surface, double time, std::uint32_t vertex, const Vector3d& outward) {
  const SurfaceTopology& t = *surface.topology;
  const std::uint32_t *begin = t.trianglesAround.begin(vertex), *end = t.trianglesAround.end(vertex);
  return begin == end || std::any_of(begin, end, [&](std::uint32_t i) {
           return !t.oneSided[i] || outward.dot(normalAt(surface, time, i)) > kFacing;
         });
}

/// Whether all edges around the vertex lead away from `outward`.
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

// --- vertices and triangles --------------------------------------------------------------------------------

/// Barycentric: a foot this far beside a triangle is in it.
constexpr double kBeside = 1e-4;

/// Of a vertex behind a triangle but not beneath it: cosine of the slope at which it may be.
constexpr double kSteepFoot = 0.5;

/// Barycentric coordinates of the foot of `p` in the triangle's plane.
Vector3d footIn(const MovingFeature<3>::Corners& triangle, const Vector3d& p) {
  const Vector3d u = triangle.col(1) - triangle.col(0), v = triangle.col(2) - triangle.col(0);
  const Vector3d normal = u.cross(v), to = p - triangle.col(0);
  const double squared = normal.squaredNorm();
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  return {1.0 - second - third, second, third};
}

struct VertexTriangle {
  const SurfacePair& pair;
  MovingFeature<1> vertex;
  MovingFeature<3> triangle;
  PenetratingVertex at;
  double side = 1.0;  ///< -1: seen from behind

  Vector3d normal(double time) const { return side * normalOf<3>(triangle.at(time)); }
  double height(double time) const {
    return normal(time).dot((vertex.start + time * vertex.motion) - triangle.at(time).col(0));
  }
};

/// The candidate of a vertex that the triangle pushes along its unit `normal`.
void addVertexOnTriangle(const SurfacePair& pair, const PenetratingVertex& at, const Vector3d& normal,
                         double time, ContactSearch& search) {
  const SurfaceTopology& t = *(at.ofB ? pair.a : pair.b).topology;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(at.vertex);
  c.b = onTriangle(t, at.triangle, at.barycentric);
  if (at.ofB) std::swap(c.a, c.b);
  c.normal = at.ofB ? Vector3d(-normal) : normal;
  c.time = time;
  candidate.rank = at.ofB ? kTriangleVertex : kVertexTriangle;
  candidate.scale = t.depthLimit[at.triangle];
  candidate.vertex = contactVertex(pair, at.vertex, at.ofB);
  addCandidate(pair, candidate, search);
}

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
  PenetratingVertex& at = meeting.at;
  at.barycentric = footIn(t, meeting.vertex.start);
  at.beneath = moveInto(at.barycentric);
  if (!at.beneath) at.barycentric = nearestBarycentric({t.col(0), t.col(1), t.col(2)}, meeting.vertex.start);
  at.depth = (t * at.barycentric - meeting.vertex.start).norm();
  if (!at.beneath && (at.depth > limit || depth < kSteepFoot * at.depth)) return;
  search.behind.push_back(at);
}

/// When a vertex in front of the triangle's plane comes within reach of it, by conservative advancement as in
/// findFeatureContact(); kNever if it does not, or not within the tick.
double timeOfLanding(const VertexTriangle& meeting, double height) {
  const double radiusSum = meeting.pair.radiusSum(), met = kMetShare * meeting.pair.margin;
  double time = 0.0;
  Vector3d normal = meeting.normal(0.0);
  for (int i = 0; i < kMaxAdvances && height - radiusSum > met; ++i) {
    const double approach = approachAlong(normal, meeting.vertex, meeting.triangle);
    if (approach <= 0.0 || time + (height - radiusSum) / approach > 1.0) return kNever;
    time += (height - radiusSum) / approach;
    normal = meeting.normal(time);
    height = meeting.height(time);
  }
  return height - radiusSum > met ? kNever : time;
}

}  // namespace

bool moveInto(Vector3d& barycentric) {
  if (!(barycentric.minCoeff() >= -kBeside)) return false;
  barycentric = barycentric.cwiseMax(0.0);
  barycentric /= barycentric.sum();
  return true;
}

void collideVertexTriangle(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t triangle,
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
  const double gap = height - pair.radiusSum();
  if (gap > pair.margin && approachAlong(normal, meeting.vertex, meeting.triangle) < gap) return;
  const double time = gap > 0.0 ? timeOfLanding(meeting, height) : 0.0;
  if (time != kNever)
    addAt(meeting, time, search);
  else if (gap <= pair.margin)
    addAt(meeting, 0.0, search);
}

// --- vertices inside ---------------------------------------------------------------------------------------

namespace {

using Behind = std::vector<PenetratingVertex>::const_iterator;

Vector3d normalAt(const MovingSurface& surface, std::uint32_t triangle) {
  return normalOf<3>(featureOf<3>(surface, surface.topology->triangles[triangle]).start);
}

/// What is nearest to a vertex inside is something it is behind of. One triangle is as near as `depth`.
bool isBehindNearest(const MovingSurface& surface, const Vector3d& position, double depth) {
  constexpr double kSlightlyMore = 1.001;
  return nearestOnSurface(surface, position, kSlightlyMore * depth).behind;
}

/// `begin` to `end` are one vertex, the nearest triangle first.
void addInside(const SurfacePair& pair, Behind begin, Behind end, ContactSearch& search) {
  const MovingSurface &mine = begin->ofB ? pair.b : pair.a, &other = begin->ofB ? pair.a : pair.b;
  const auto less = [](const PenetratingVertex& x, const PenetratingVertex& y) { return x.depth < y.depth; };
  const double depth = std::min_element(begin, end, less)->depth;
  if (!isBehindNearest(other, mine.position->col(begin->vertex), depth)) return;
  const auto facing = std::find_if(begin, end, [&](const PenetratingVertex& at) {
    return facesOutward(mine, 0.0, at.vertex, -normalAt(other, at.triangle));
  });
  const PenetratingVertex& at = facing != end ? *facing : *begin;
  addVertexOnTriangle(pair, at, normalAt(other, at.triangle), 0.0, search);
}

}  // namespace

void addInsideVertices(const SurfacePair& pair, ContactSearch& search) {
  const auto order = [](const PenetratingVertex& at) {
    return std::make_tuple(at.ofB, at.vertex, !at.beneath, at.depth, at.triangle);
  };
  std::sort(search.behind.begin(), search.behind.end(),
            [&](const PenetratingVertex& x, const PenetratingVertex& y) { return order(x) < order(y); });
  for (Behind begin = search.behind.begin(), end = begin; begin != search.behind.end(); begin = end) {
    while (end != search.behind.end() && end->ofB == begin->ofB && end->vertex == begin->vertex) ++end;
    addInside(pair, begin, end, search);
  }
}

// --- edges and corners -------------------------------------------------------------------------------------

namespace {

/// Sines beyond normal cones. Where edges cross, the normal is theirs, so that a cone may be generous.
constexpr double kVertexTolerance = 0.01, kCrossingTolerance = 0.1;

/// Unit, from b to a; where they coincide, against their relative motion.
template <int N, int M>
Vector3d directionBetween(const NearestPoints<N, M>& places, const MovingFeature<N>& a,
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
  constexpr double kTouchingShare = 0.1;  // share of the margin
  constexpr double kHeadOn = 0.5;         // cosine
  if (!isRound(other, mine)) return false;
  const SurfaceTopology& t = *mine.topology;
  const auto isLong = [&](std::uint32_t e) {
    return (mine.position->col(t.edges[e][0]) - mine.position->col(t.edges[e][1])).norm() > other.radius;
  };
  if (std::any_of(t.edgesAround.begin(at.vertex), t.edgesAround.end(at.vertex), isLong)) return false;
  const bool touches = at.time == 0.0 && at.gap <= kTouchingShare * pair.margin;
  return (touches || at.outward.dot(at.motion) >= kHeadOn * at.motion.norm()) &&
         facesOutward(mine, at.time, at.vertex, at.outward);
}

bool vertexTouches(const SurfacePair& pair, bool ofB, const Arrival& at) {
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
  constexpr double kSlightlyMore = 1.001;
  const NearestOnSurface nearest = nearestOnSurface(surface, place, kSlightlyMore * depth);
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
                const NearestPoints<2, 2>& places, const Vector3d& normal) {
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

void collideVertices(const SurfacePair& pair, std::uint32_t va, std::uint32_t vb, ContactSearch& search) {
  const auto a = featureOf<1>(pair.a, std::array<std::uint32_t, 1>{va});
  const auto b = featureOf<1>(pair.b, std::array<std::uint32_t, 1>{vb});
  const auto places = findFeatureContact(a, b, pair.radiusSum(), pair.margin);
  if (places.time == kNever) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.normal = directionBetween(places, a, b);
  c.time = places.time;
  const Vector3d motion = a.motion - b.motion;
  const double gap = places.distance - pair.radiusSum();
  if (!vertexTouches(pair, false, {va, -c.normal, motion, c.time, gap})) return;
  if (!vertexTouches(pair, true, {vb, c.normal, -motion, c.time, gap})) return;
  c.a = atVertex(va);
  c.b = atVertex(vb);
  candidate.rank = kVertexVertex;
  candidate.scale = pair.radiusSum();
  // each of many vertices around a ball has a contact; the nearest one is the ball's
  candidate.vertex = kNoVertex;
  if (isRound(pair.a, pair.b) && !isInVertexCone(pair.b, c.time, vb, c.normal))
    candidate.vertex = contactVertex(pair, vb, true);
  else if (isRound(pair.b, pair.a) || pair.self)
    candidate.vertex = contactVertex(pair, va, false);
  addCandidate(pair, candidate, search);
}

void collideVertexEdge(const SurfacePair& pair, bool ofB, std::uint32_t v, std::uint32_t edge,
                       ContactSearch& search) {
  const MovingSurface &mine = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  const auto vertex = featureOf<1>(mine, std::array<std::uint32_t, 1>{v});
  const auto segment = featureOf<2>(other, other.topology->edges[edge]);
  const auto places = findFeatureContact(vertex, segment, pair.radiusSum(), pair.margin);
  if (places.time == kNever || places.b.minCoeff() <= 0.0) return;
  const Vector3d outward = directionBetween(places, vertex, segment);
  if (!isInNormalCone(other, places.time, edge, outward, kVertexTolerance)) return;
  const Vector3d motion = vertex.motion - segment.motion * places.b;
  const double gap = places.distance - pair.radiusSum();
  if (!vertexTouches(pair, ofB, {v, -outward, motion, places.time, gap})) return;
  ContactCandidate candidate;
  SurfaceContact& c = candidate.contact;
  c.a = atVertex(v);
  c.b = onEdge(*other.topology, edge, places.b);
  if (ofB) std::swap(c.a, c.b);
  c.normal = ofB ? Vector3d(-outward) : outward;
  c.time = places.time;
  candidate.rank = ofB ? kEdgeVertex : kVertexEdge;
  candidate.scale = (segment.start.col(1) - segment.start.col(0)).norm();
  candidate.vertex = contactVertex(pair, v, ofB);
  addCandidate(pair, candidate, search);
}

void collideEdges(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb, ContactSearch& search) {
  const auto a = featureOf<2>(pair.a, pair.a.topology->edges[ea]);
  const auto b = featureOf<2>(pair.b, pair.b.topology->edges[eb]);
  if (areParallel(alongOf(a, 0.0), alongOf(b, 0.0))) return;
  const auto places = findFeatureContact(a, b, pair.radiusSum(), pair.margin);
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
