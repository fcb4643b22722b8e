// SPDX-License-Identifier: Zlib
// Contacts of single features: vertices with triangles, vertices inside a surface, and edges and vertices
// with each other.
#include "collide/feature_contacts.h"

#include <tuple>

namespace limber {

using Eigen::Vector3d;

Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& point, double time) {
  Vector3d position = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    position += point.weights[static_cast<Eigen::Index>(i)] * surface.at(point.points[i], time);
  return position;
}

namespace {

// --- candidates --------------------------------------------------------------------------------------------

/// A round surface is at least this many times thicker than the other.
constexpr double kRoundRatio = 2.0;

/// Whether `surface` has no triangles and is much thicker than the other, as a ball or a capsule.
bool isRound(const MovingSurface& surface, const MovingSurface& other) {
  return surface.topology->triangles.empty() && surface.radius > kRoundRatio * other.radius;
}

/// Cosine of the largest angle between equal directions, and the fraction of the feature size up to which the
/// contact points of a round surface are then equal. Farther apart they support it at several places: in a
/// shallow dent it touches features that move on their own.
constexpr double kSameDirection = 0.995, kSamePlace = 0.02;

double sameDirection(const SurfacePair& pair, double featureSize) {
  const double radius = isRound(pair.a, pair.b)   ? pair.a.radius
                        : isRound(pair.b, pair.a) ? pair.b.radius
                                                  : 0.0;
  const double angle = radius > 0.0 ? kSamePlace * featureSize / radius : 1.0;
  return std::max(kSameDirection, 1.0 - 0.5 * angle * angle);
}

bool shareVertex(const SurfacePoint& a, const SurfacePoint& b) {
  return std::any_of(a.points.begin(), a.points.end(), [&](std::uint32_t v) {
    return std::find(b.points.begin(), b.points.end(), v) != b.points.end();
  });
}

/// Returns the distance at rest of two vertices or edges, or of a vertex and a triangle, m.
double distanceAtRest(const Points& rest, const SurfacePoint& a, const SurfacePoint& b) {
  if (a.kind == FeatureKind::OnTriangle) return distanceAtRest(rest, b, a);
  const auto corner = [&](const SurfacePoint& point, std::size_t i) {
    return Vector3d(rest.col(point.points[i]));
  };
  if (b.kind == FeatureKind::OnTriangle) {
    const TriangleCorners corners{corner(b, 0), corner(b, 1), corner(b, 2)};
    return (pointAt(corners, nearestBarycentric(corners, corner(a, 0))) - corner(a, 0)).norm();
  }
  // an edge without length is a vertex
  const SegmentPair along = nearestOnSegments(corner(a, 0), corner(a, 1), corner(b, 0), corner(b, 1));
  return (corner(a, 0) + along.a * (corner(a, 1) - corner(a, 0)) - corner(b, 0) -
          along.b * (corner(b, 1) - corner(b, 0)))
      .norm();
}

/// Whether the whole features, not only the contact points, are close at rest. Braces that cross at rest
/// always overlap, also after shear.
bool areCloseAtRest(const SurfacePair& pair, const SurfacePoint& a, const SurfacePoint& b) {
  return distanceAtRest(pair.a.topology->rest, a, b) <= pair.radiusSum() + pair.margin - pair.extraMargin;
}

SurfacePoint atVertex(std::uint32_t v) { return {FeatureKind::OnVertex, v, {v, v, v}, Vector3d::UnitX()}; }

SurfacePoint onEdge(const SurfaceTopology& t, std::uint32_t edge, const Eigen::Vector2d& weights) {
  const auto [a, b] = t.edges[edge];
  return {FeatureKind::OnEdge, edge, {a, b, b}, {weights[0], weights[1], 0.0}};
}

/// Returns FeatureCandidate::vertex for vertex `v` of a, or of b.
std::uint64_t contactVertex(const SurfacePair& pair, std::uint32_t v, bool ofB) {
  return std::uint64_t{v} * 2 + (ofB && !pair.self ? 1 : 0);
}

/// Adds a candidate; computes its gap, key and point. `flipped`: its side a is on surface b. A contact of a
/// surface with itself is left out if the features share a vertex or are close at rest.
void addCandidate(const SurfacePair& pair, bool flipped, ContactRank rank, SurfaceContact c,
                  double featureSize, std::uint64_t vertex, ContactSearch& search) {
  if (flipped) std::swap(c.a, c.b), c.normal = -c.normal;
  if (pair.self && (shareVertex(c.a, c.b) || areCloseAtRest(pair, c.a, c.b))) return;
  c.gap = c.normal.dot(positionOf(pair.a, c.a) - positionOf(pair.b, c.b)) - pair.radiusSum();
  c.key = keyOf(rank, c.a.feature, c.b.feature);
  const Vector3d point = 0.5 * (positionOf(pair.a, c.a, c.time) + positionOf(pair.b, c.b, c.time));
  search.candidates.push_back({c, point, featureSize, vertex, rank, sameDirection(pair, featureSize)});
}

// --- time of impact ----------------------------------------------------------------------------------------

/// Returns an upper bound of the decrease of the distance along the unit `direction` from b to a during the
/// tick, m.
template <int N, int M>
double approachAlong(const Vector3d& direction, const MovingFeature<N>& a, const MovingFeature<M>& b) {
  return (direction.transpose() * b.motion).maxCoeff() - (direction.transpose() * a.motion).minCoeff();
}

/// Limit of iterations; features that rotate past each other need most of them.
constexpr int kMaxIterations = 32;
/// Fraction of the margin: features with a smaller gap touch.
constexpr double kTouchTolerance = 0.01;
/// The time of an impact that does not happen during the tick.
constexpr double kNever = std::numeric_limits<double>::infinity();

/// Finds when the features come within `radiusSum` (m) of each other, by conservative advancement (Mirtich
/// 1996). Each step uses the direction between the nearest points, along which no two points of the features
/// are nearer. A head-on impact takes one step.
/// @returns the nearest points at the time of impact. Without an impact: the nearest points at the start of
/// the tick if the gap is at most `margin` (m) then, else a time of kNever.
template <int N, int M>
NearestPoints<N, M> findFeatureContact(const MovingFeature<N>& a, const MovingFeature<M>& b, double radiusSum,
                                       double margin) {
  const NearestPoints<N, M> start = nearestPoints(a, b, 0.0);
  NearestPoints<N, M> nearest = start;  // at the present time
  for (int i = 0; i < kMaxIterations; ++i) {
    const double gap = nearest.distance - radiusSum;
    if (gap <= kTouchTolerance * margin) return nearest;
    const double approach = approachAlong(nearest.offset / nearest.distance, a, b);
    const double time = approach > 0.0 ? nearest.time + gap / approach : kNever;
    if (time > 1.0) break;
    nearest = nearestPoints(a, b, time);
  }
  nearest = start;
  if (start.distance - radiusSum > margin) nearest.time = kNever;
  return nearest;
}

// --- vertices and triangles --------------------------------------------------------------------------------

/// Barycentric: a foot outside the triangle by this much counts as inside.
constexpr double kFootTolerance = 1e-4;

/// For a vertex behind a triangle whose foot is outside it: the least ratio of its depth below the plane to
/// its distance from the triangle.
constexpr double kMinSlopeCosine = 0.5;

struct VertexTriangle {
  const SurfacePair& pair;
  const MovingFeature<1>& vertex;
  const MovingFeature<3>& triangle;
  PenetratingVertex record;  ///< depth and isFootInside are set only behind a one-sided triangle
  double side = 1.0;         ///< -1: the vertex is behind a triangle that is not one-sided

  Vector3d normal(double time) const { return side * normalOf<3>(triangle.at(time)); }
  double height(double time) const {
    return normal(time).dot((vertex.start + time * vertex.motion) - triangle.at(time).col(0));
  }
};

}  // namespace

void addVertexOnTriangle(const SurfacePair& pair, const PenetratingVertex& vertex, const Vector3d& normal,
                         double time, ContactSearch& search) {
  const SurfaceTopology& t = *(vertex.ofB ? pair.a : pair.b).topology;
  const SurfacePoint onTriangle{FeatureKind::OnTriangle, vertex.triangle, t.triangles[vertex.triangle],
                                vertex.barycentric};
  addCandidate(pair, vertex.ofB, vertex.ofB ? kTriangleVertex : kVertexTriangle,
               {atVertex(vertex.vertex), onTriangle, normal, 0.0, time}, t.depthLimit[vertex.triangle],
               contactVertex(pair, vertex.vertex, vertex.ofB), search);
}

namespace {

void addVertexInFront(VertexTriangle& features, double time, ContactSearch& search) {
  if (!projectOnTriangle(features.triangle.at(time), features.vertex.at(time), features.record.barycentric))
    return;
  const Vector3d normal = features.normal(time);
  const MovingSurface& own = features.record.ofB ? features.pair.b : features.pair.a;
  if (!facesOutward(own, time, features.record.vertex, -normal)) return;
  addVertexOnTriangle(features.pair, features.record, normal, time, search);
}

void addPenetrating(VertexTriangle& features, double depth, double limit, ContactSearch& search) {
  if (features.pair.self || depth > limit) return;
  const MovingFeature<3>::Corners& t = features.triangle.start;
  PenetratingVertex& vertex = features.record;
  vertex.isFootInside = projectOnTriangle(t, features.vertex.start, vertex.barycentric);
  if (!vertex.isFootInside)
    vertex.barycentric = nearestBarycentric({t.col(0), t.col(1), t.col(2)}, features.vertex.start);
  vertex.depth = (t * vertex.barycentric - features.vertex.start).norm();
  if (!vertex.isFootInside && (vertex.depth > limit || depth < kMinSlopeCosine * vertex.depth)) return;
  search.penetrating.push_back(vertex);
}

/// Returns when a vertex in front of the triangle's plane comes within the radius sum of it, by conservative
/// advancement as in findFeatureContact(); kNever if it does not within the tick.
double timeOfImpact(const VertexTriangle& features, double height) {
  const double radiusSum = features.pair.radiusSum(), tolerance = kTouchTolerance * features.pair.margin;
  double time = 0.0;
  Vector3d normal = features.normal(0.0);
  for (int i = 0; i < kMaxIterations && height - radiusSum > tolerance; ++i) {
    const double approach = approachAlong(normal, features.vertex, features.triangle);
    if (approach <= 0.0 || time + (height - radiusSum) / approach > 1.0) return kNever;
    time += (height - radiusSum) / approach;
    normal = features.normal(time);
    height = features.height(time);
  }
  return height - radiusSum > tolerance ? kNever : time;
}

/// Factor of a search distance at which something is known to be.
constexpr double kSlightlyMore = 1.001;

using PenetratingIterator = std::vector<PenetratingVertex>::const_iterator;

/// Cosine. A corner of a box faces what it hits with at least this, a side of a box what slides past it with
/// less.
constexpr double kFacingSquarely = 0.5;

/// Adds a candidate if the vertex is inside and its own surface faces the way out. `begin` to `end` are
/// entries of one vertex, in the order of addInsideVertices(). A vertex near a thin edge that is pushed out
/// of the far side would be hooked there. So would the rims of two boxes side by side, whose bottoms bulge a
/// little towards each other's: the ways that the vertex faces squarely come first.
void addInside(const SurfacePair& pair, PenetratingIterator begin, PenetratingIterator end,
               ContactSearch& search) {
  const MovingSurface &own = begin->ofB ? pair.b : pair.a, &other = begin->ofB ? pair.a : pair.b;
  const auto less = [](const PenetratingVertex& x, const PenetratingVertex& y) { return x.depth < y.depth; };
  const double depth = std::min_element(begin, end, less)->depth;
  if (!nearestOnSurface(other, own.position->col(begin->vertex), kSlightlyMore * depth).behind) return;
  const auto findFacing = [&](double cosine) {
    return std::find_if(begin, end, [&](const PenetratingVertex& vertex) {
      return facesOutward(own, 0.0, vertex.vertex, -normalAt(other, 0.0, vertex.triangle), cosine);
    });
  };
  auto facing = findFacing(kFacingSquarely);
  if (facing == end) facing = findFacing(kFacing);
  if (facing != end) addVertexOnTriangle(pair, *facing, normalAt(other, 0.0, facing->triangle), 0.0, search);
}

}  // namespace

bool projectOnTriangle(const MovingFeature<3>::Corners& triangle, const Vector3d& p, Vector3d& barycentric) {
  const Vector3d u = triangle.col(1) - triangle.col(0), v = triangle.col(2) - triangle.col(0);
  const Vector3d normal = u.cross(v), to = p - triangle.col(0);
  const double squared = normal.squaredNorm();
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  barycentric = {1.0 - second - third, second, third};
  if (!(barycentric.minCoeff() >= -kFootTolerance)) return false;
  barycentric = barycentric.cwiseMax(0.0);
  barycentric /= barycentric.sum();
  return true;
}

void collideVertexTriangle(const SurfacePair& pair, bool ofB, const NearVertex& vertex,
                           const NearTriangle& triangle, ContactSearch& search) {
  if (triangle.normal.squaredNorm() == 0.0) return;
  VertexTriangle features{pair, vertex.feature, triangle.feature, {ofB, vertex.vertex, triangle.triangle}};
  Vector3d normal = triangle.normal;
  double height = normal.dot(vertex.feature.start - triangle.feature.start.col(0));
  if (height < 0.0) {
    const SurfaceTopology& t = *(ofB ? pair.a : pair.b).topology;
    if (t.oneSided[triangle.triangle])
      return addPenetrating(features, -height, t.depthLimit[triangle.triangle], search);
    features.side = -1.0;
    normal = -normal;
    height = -height;
  }
  const double gap = height - pair.radiusSum();
  if (gap > pair.margin && approachAlong(normal, vertex.feature, triangle.feature) < gap) return;
  const double time = gap > 0.0 ? timeOfImpact(features, height) : 0.0;
  if (time != kNever)
    addVertexInFront(features, time, search);
  else if (gap <= pair.margin)
    addVertexInFront(features, 0.0, search);
}

void addInsideVertices(const SurfacePair& pair, ContactSearch& search) {
  const auto order = [](const PenetratingVertex& vertex) {
    return std::make_tuple(vertex.ofB, vertex.vertex, !vertex.isFootInside, vertex.depth, vertex.triangle);
  };
  std::sort(search.penetrating.begin(), search.penetrating.end(),
            [&](const PenetratingVertex& x, const PenetratingVertex& y) { return order(x) < order(y); });
  for (PenetratingIterator begin = search.penetrating.begin(), end = begin; begin != search.penetrating.end();
       begin = end) {
    while (end != search.penetrating.end() && end->ofB == begin->ofB && end->vertex == begin->vertex) ++end;
    addInside(pair, begin, end, search);
  }
}

// --- edges and vertices ------------------------------------------------------------------------------------

namespace {

/// Sines: tolerances of normal cones. That of crossing edges may be large because the contact normal is
/// computed from the edges, not from the cone.
constexpr double kVertexTolerance = 0.01, kCrossingTolerance = 0.1;

/// Returns the unit vector from b to a, or, if the points coincide, the direction of the motion of b relative
/// to a.
template <int N, int M>
Vector3d directionBetween(const NearestPoints<N, M>& nearest, const MovingFeature<N>& a,
                          const MovingFeature<M>& b) {
  constexpr double kCoincident = 1e-12;
  if (nearest.distance > kCoincident) return nearest.offset / nearest.distance;
  const Vector3d motion = b.motion * nearest.b - a.motion * nearest.a;
  return motion.squaredNorm() > 0.0 ? motion.normalized() : Vector3d::UnitY();
}

/// A vertex that approaches a point on another surface.
struct ApproachingVertex {
  std::uint32_t vertex;
  Vector3d outward;  ///< unit, from the vertex to the point
  Vector3d motion;   ///< m during the tick, of the vertex relative to the point
  double time, gap;  ///< time of impact (fraction of the tick), and the gap (m) then
};

/// Whether the vertex touches a round surface as it would touch a face. Its edges are at most as long as the
/// radius: between longer ones faces keep the round surface away. And it does not slide along the surface.
bool touchesRound(const SurfacePair& pair, const MovingSurface& own, const MovingSurface& other,
                  const ApproachingVertex& vertex) {
  constexpr double kTouchingShare = 0.1;  // fraction of the margin
  constexpr double kHeadOn = 0.5;         // cosine
  if (!isRound(other, own)) return false;
  const SurfaceTopology& t = *own.topology;
  const auto isLong = [&](std::uint32_t e) {
    return (own.position->col(t.edges[e][0]) - own.position->col(t.edges[e][1])).norm() > other.radius;
  };
  if (std::any_of(t.edgesAround.begin(vertex.vertex), t.edgesAround.end(vertex.vertex), isLong)) return false;
  const bool touches = vertex.time == 0.0 && vertex.gap <= kTouchingShare * pair.margin;
  return (touches || vertex.outward.dot(vertex.motion) >= kHeadOn * vertex.motion.norm()) &&
         facesOutward(own, vertex.time, vertex.vertex, vertex.outward);
}

bool vertexTouches(const SurfacePair& pair, bool ofB, const ApproachingVertex& vertex) {
  const MovingSurface &own = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  if (pair.self && own.topology->triangles.empty())
    return true;  // a folded surface is nearest to itself at its bend
  return isInVertexCone(own, vertex.time, vertex.vertex, vertex.outward) ||
         touchesRound(pair, own, other, vertex);
}

Vector3d edgeVector(const MovingFeature<2>& edge, double time) {
  const auto ends = edge.at(time);
  return ends.col(1) - ends.col(0);
}

/// Whether the edges are parallel: then only their end points are in contact.
bool areParallel(const Vector3d& a, const Vector3d& b) {
  constexpr double kSine = 0.01;
  return a.cross(b).squaredNorm() <= kSine * kSine * a.squaredNorm() * b.squaredNorm();
}

/// Whether the edges stay farther apart than `distance` (m) along `normal`, of any length.
bool stayApart(const MovingFeature<2>& a, const MovingFeature<2>& b, const Vector3d& normal,
               double distance) {
  const double start = normal.dot(b.start.col(0) - a.start.col(0)), side = start < 0.0 ? -1.0 : 1.0;
  const double a0 = side * normal.dot(a.motion.col(0)), a1 = side * normal.dot(a.motion.col(1)),
               b0 = side * normal.dot(b.motion.col(0)), b1 = side * normal.dot(b.motion.col(1));
  const double nearest = side * start + std::min(0.0, std::min(b0, b1) - std::max(a0, a1));
  return nearest > 0.0 && nearest * nearest > distance * distance * normal.squaredNorm();
}

/// Returns the tolerance of an edge of this length (m) for a vertex. The feet of the centre of a ball beside
/// a convex edge of the fold angle f are outside both triangles by up to R f / 2: a smaller angle is flat
/// only if that is within the tolerance of feet.
ConeTolerance vertexTolerance(const MovingSurface& own, const MovingSurface& other, double length) {
  ConeTolerance tolerance{kVertexTolerance};
  if (isRound(own, other))
    tolerance.flatFold = std::min(kFlatFold, 2.0 * kFootTolerance * length / own.radius);
  return tolerance;
}

double depthLimit(const SurfaceTopology& t, std::uint32_t edge) {
  double limit = 1e300;
  for (const std::uint32_t i : t.edgeTriangles[edge])
    if (i != kNoFeature) limit = std::min(limit, t.depthLimit[i]);
  return limit;
}

/// Whether a point at the distance `depth` (m) behind an edge is inside the surface or on it. Perpendicular
/// to a face the point is on the face beside the edge.
bool isInside(const MovingSurface& surface, const Vector3d& point, double depth) {
  const NearestOnSurface nearest = nearestOnSurface(surface, point, kSlightlyMore * depth);
  if (nearest.triangle == kNoFeature || !surface.topology->oneSided[nearest.triangle]) return false;
  return nearest.behind || nearest.distance <= kCrossingTolerance * depth;
}

/// Whether the edge belongs to a sheet. A sheet has no inside, so that both its sides count as front.
bool isSheetEdge(const SurfaceTopology& t, std::uint32_t edge) {
  const auto [first, second] = t.edgeTriangles[edge];
  const auto hasInside = [&](std::uint32_t i) { return i != kNoFeature && t.oneSided[i]; };
  return !hasInside(first) && !hasInside(second);
}

/// Whether `outward` points away from the solid behind the triangles of the edge.
bool pointsOut(const MovingSurface& surface, double time, std::uint32_t edge, const Vector3d& outward) {
  double sum = 0.0;
  for (const std::uint32_t i : surface.topology->edgeTriangles[edge])
    if (i != kNoFeature) sum += outward.dot(normalAt(surface, time, i));
  return sum > 0.0;
}

/// Two edges that cross, at a time of the tick.
struct Crossing {
  const SurfacePair& pair;
  std::uint32_t ea, eb;
  double time;
  bool bears;  ///< whether their contact bore a load in the last tick

  /// Whether the edges can touch with the normal `fromB` from b to a: both are convex, or one is convex and
  /// the other bears a load. An edge under load that bends from convex to concave would otherwise be set
  /// free, and jump through the other by its springs before it is convex again. With `sheetsToo` also if one
  /// is convex and the other is any edge of a sheet.
  bool mayTouch(const Vector3d& fromB, bool sheetsToo) const {
    const auto isConvex = [&](const MovingSurface& s, std::uint32_t edge, const Vector3d& outward) {
      return isInNormalCone(s, time, edge, outward, {kCrossingTolerance, bears});
    };
    const auto mayBeConcave = [&](const MovingSurface& s, std::uint32_t edge, const Vector3d& outward) {
      return isSheetEdge(*s.topology, edge) ? sheetsToo : bears && pointsOut(s, time, edge, outward);
    };
    const bool isConvexA = isConvex(pair.a, ea, -fromB), isConvexB = isConvex(pair.b, eb, fromB);
    return isConvexA ? isConvexB || mayBeConcave(pair.b, eb, fromB)
                     : isConvexB && mayBeConcave(pair.a, ea, -fromB);
  }
};

/// m, the largest distance of edges that have passed through each other.
double passLimit(const SurfacePair& pair, std::uint32_t ea, std::uint32_t eb) {
  return std::min(depthLimit(*pair.a.topology, ea), depthLimit(*pair.b.topology, eb));
}

/// Whether the crossing edges can touch from outside. `normal` is the direction from b to a.
///
/// Edges of sheets need not be convex: a convex edge that pushes a sheet back at one edge bends it, and the
/// sheet's next edge becomes the nearest one in the same tick. If only convex edges of the sheet counted, the
/// two would fall and be pushed back in turn. Flat edges count too where a triangle beside the convex edge
/// supports the sheet: otherwise it would not come to rest there.
bool areInFront(const Crossing& crossing, const Vector3d& normal) { return crossing.mayTouch(normal, true); }

/// Whether the crossing edges have passed through each other.
bool havePassedThrough(const Crossing& crossing, const NearestPoints<2, 2>& nearest, const Vector3d& normal) {
  const auto& [pair, ea, eb, time, bears] = crossing;
  if (pair.self || time > 0.0 || nearest.distance > passLimit(pair, ea, eb)) return false;
  if (!crossing.mayTouch(-normal, false)) return false;
  return isInside(pair.b, featureOf<2>(pair.a, pair.a.topology->edges[ea]).start * nearest.a,
                  nearest.distance) ||
         isInside(pair.a, featureOf<2>(pair.b, pair.b.topology->edges[eb]).start * nearest.b,
                  nearest.distance);
}

}  // namespace

void collideVertices(const SurfacePair& pair, const NearVertex& vertexA, const NearVertex& vertexB,
                     ContactSearch& search) {
  const MovingFeature<1>&a = vertexA.feature, &b = vertexB.feature;
  const std::uint32_t va = vertexA.vertex, vb = vertexB.vertex;
  const auto nearest = findFeatureContact(a, b, pair.radiusSum(), pair.margin);
  if (nearest.time == kNever) return;
  const Vector3d normal = directionBetween(nearest, a, b), motion = a.motion - b.motion;
  const double gap = nearest.distance - pair.radiusSum();
  if (!vertexTouches(pair, false, {va, -normal, motion, nearest.time, gap})) return;
  if (!vertexTouches(pair, true, {vb, normal, -motion, nearest.time, gap})) return;
  // vertices near a ball have one contact each; the contact of the ball's own vertex is the nearest one
  std::uint64_t vertex = kNoVertex;
  if (isRound(pair.a, pair.b) && !isInVertexCone(pair.b, nearest.time, vb, normal))
    vertex = contactVertex(pair, vb, true);
  else if (isRound(pair.b, pair.a) || pair.self)
    vertex = contactVertex(pair, va, false);
  addCandidate(pair, false, kVertexVertex, {atVertex(va), atVertex(vb), normal, 0.0, nearest.time},
               pair.radiusSum(), vertex, search);
}

void collideVertexEdge(const SurfacePair& pair, bool ofB, const NearVertex& nearVertex,
                       const NearEdge& nearEdge, ContactSearch& search) {
  const MovingSurface &own = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  const std::uint32_t v = nearVertex.vertex, edge = nearEdge.edge;
  const MovingFeature<1>& vertex = nearVertex.feature;
  const MovingFeature<2>& segment = nearEdge.feature;
  const auto nearest = findFeatureContact(vertex, segment, pair.radiusSum(), pair.margin);
  if (nearest.time == kNever || nearest.b.minCoeff() <= 0.0) return;
  const Vector3d outward = directionBetween(nearest, vertex, segment);
  const double length = nearEdge.along.norm();
  const ConeTolerance tolerance = vertexTolerance(own, other, length);
  if (!isInNormalCone(other, nearest.time, edge, outward, tolerance)) return;
  const Vector3d motion = vertex.motion - segment.motion * nearest.b;
  const double gap = nearest.distance - pair.radiusSum();
  if (!vertexTouches(pair, ofB, {v, -outward, motion, nearest.time, gap})) return;
  addCandidate(pair, ofB, ofB ? kEdgeVertex : kVertexEdge,
               {atVertex(v), onEdge(*other.topology, edge, nearest.b), outward, 0.0, nearest.time}, length,
               contactVertex(pair, v, ofB), search);
}

void collideEdges(const SurfacePair& pair, const NearEdge& edgeA, const NearEdge& edgeB, bool bears,
                  ContactSearch& search) {
  const MovingFeature<2>&a = edgeA.feature, &b = edgeB.feature;
  const std::uint32_t ea = edgeA.edge, eb = edgeB.edge;
  // under load the edges may be through each other by more than their radii
  const double reach = bears ? std::max(pair.radiusSum(), passLimit(pair, ea, eb)) : pair.radiusSum();
  if (stayApart(a, b, edgeA.along.cross(edgeB.along), reach + pair.margin)) return;
  if (areParallel(edgeA.along, edgeB.along)) return;
  auto nearest = findFeatureContact(a, b, pair.radiusSum(), pair.margin);
  const bool deep = nearest.time == kNever && reach > pair.radiusSum();
  if (deep) nearest = findFeatureContact(a, b, reach, pair.margin);
  if (nearest.time == kNever || nearest.a.minCoeff() <= 0.0 || nearest.b.minCoeff() <= 0.0) return;
  const Vector3d alongA = edgeVector(a, nearest.time), alongB = edgeVector(b, nearest.time);
  if (areParallel(alongA, alongB)) return;
  Vector3d normal = alongA.cross(alongB).normalized();
  if (normal.dot(directionBetween(nearest, a, b)) < 0.0) normal = -normal;
  if (bears && areFlatEdges(pair.a, ea, pair.b, eb, normal)) return;
  const Crossing crossing{pair, ea, eb, nearest.time, bears};
  const bool apart = areInFront(crossing, normal);
  if (apart ? deep : !havePassedThrough(crossing, nearest, normal)) return;
  addCandidate(pair, false, kEdgeEdge,
               {onEdge(*pair.a.topology, ea, nearest.a), onEdge(*pair.b.topology, eb, nearest.b),
                apart ? normal : Vector3d(-normal), 0.0, nearest.time},
               std::min(alongA.norm(), alongB.norm()), kNoVertex, search);
}

}  // namespace limber
