// SPDX-License-Identifier: Zlib
// Finds the contacts of surfaces among the features that are near each other, keeps one of those that say the
// same, and refreshes those of an earlier search.
#include "collide/surface_contacts.h"

#include "collide/feature_contacts.h"
#include "solver/closest_points.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;

// --- features that are near --------------------------------------------------------------------------------

/// An element with the boxes of the features that belong to it.
struct BoxedElement {
  const SurfaceElement* element = nullptr;
  SweptBox whole;
  std::array<SweptBox, 3> edges;
  const std::vector<SweptBox>* points = nullptr;

  const SweptBox& vertexBox(std::uint32_t v) const { return (*points)[v]; }
};

BoxedElement boxed(const MovingSurface& surface, std::uint32_t leaf) {
  const std::vector<SweptBox>& points = surface.boxes->points;
  BoxedElement boxed;
  boxed.element = &surface.topology->elements[surface.topology->nodes[leaf].element];
  boxed.whole = surface.boxes->nodes[leaf];
  boxed.points = &points;
  for (std::size_t i = 0; i < 3; ++i) {
    if (boxed.element->edges[i] == kNoFeature) continue;
    const Edge& ends = surface.topology->edges[boxed.element->edges[i]];
    boxed.edges[i] = merged(points[ends[0]], points[ends[1]]);
  }
  return boxed;
}

/// The vertices in the care of `mine` against all that is in the care of `other`; `ofB` tells whose they are.
void collideVerticesOf(const SurfacePair& pair, bool ofB, const BoxedElement& mine, const BoxedElement& other,
                       ContactSearch& search) {
  for (const std::uint32_t v : mine.element->vertices) {
    if (v == kNoFeature || separation(mine.vertexBox(v), other.whole) > pair.margin) continue;
    const SweptBox& box = mine.vertexBox(v);
    if (other.element->triangle != kNoFeature)
      collideVertexTriangle(pair, ofB, v, other.element->triangle, search);
    for (std::size_t i = 0; i < 3; ++i)
      if (other.element->edges[i] != kNoFeature && separation(box, other.edges[i]) <= pair.margin)
        collideVertexEdge(pair, ofB, v, other.element->edges[i], search);
    for (const std::uint32_t w : other.element->vertices)
      if (!ofB && w != kNoFeature && separation(box, other.vertexBox(w)) <= pair.margin)
        collideVertices(pair, v, w, search);
  }
}

void collideEdgesOf(const SurfacePair& pair, const BoxedElement& a, const BoxedElement& b,
                    ContactSearch& search) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (a.element->edges[i] == kNoFeature || separation(a.edges[i], b.whole) > pair.margin) continue;
    for (std::size_t j = 0; j < 3; ++j)
      if (b.element->edges[j] != kNoFeature && separation(a.edges[i], b.edges[j]) <= pair.margin)
        collideEdges(pair, a.element->edges[i], b.element->edges[j], search);
  }
}

/// What the features in the care of the elements of `search.near` have to do with each other; adds to
/// `search.candidates` and `search.behind`.
void collideNearFeatures(const SurfacePair& pair, ContactSearch& search) {
  std::uint32_t leafA = kNoFeature, leafB = kNoFeature;
  BoxedElement a, b;
  for (const auto& [i, j] : search.near) {
    if (i != leafA) a = boxed(pair.a, leafA = i);
    if (j != leafB) b = boxed(pair.b, leafB = j);
    collideVerticesOf(pair, false, a, b, search);
    collideVerticesOf(pair, true, b, a, search);
    collideEdgesOf(pair, a, b, search);
  }
}

// --- candidates --------------------------------------------------------------------------------------------

/// A round surface is this many times thicker than the other.
constexpr double kRound = 2.0;

template <std::size_t N>
SurfacePoint placeOn(std::uint32_t feature, const std::array<std::uint32_t, N>& corners,
                     const Vector3d& weights) {
  SurfacePoint place;
  place.kind = static_cast<FeatureKind>(N - 1);
  place.feature = feature;
  for (std::size_t i = 0; i < 3; ++i) place.points[i] = corners[std::min(i, N - 1)];
  place.weights = weights;
  return place;
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& place, double time) {
  Vector3d position = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    position += place.weights[static_cast<Eigen::Index>(i)] * surface.at(place.points[i], time);
  return position;
}

bool shareVertex(const SurfacePoint& a, const SurfacePoint& b) {
  return std::any_of(a.points.begin(), a.points.end(), [&](std::uint32_t v) {
    return std::find(b.points.begin(), b.points.end(), v) != b.points.end();
  });
}

/// m, of a vertex or edge from a vertex, an edge or, of a vertex, a triangle.
double distanceAtRest(const Points& rest, const SurfacePoint& a, const SurfacePoint& b) {
  if (a.kind == FeatureKind::OnTriangle) return distanceAtRest(rest, b, a);
  const auto corner = [&](const SurfacePoint& place, std::size_t i) {
    return Vector3d(rest.col(place.points[i]));
  };
  if (b.kind == FeatureKind::OnTriangle) {
    const Vector3d weights = nearestBarycentric({corner(b, 0), corner(b, 1), corner(b, 2)}, corner(a, 0));
    return (weights[0] * corner(b, 0) + weights[1] * corner(b, 1) + weights[2] * corner(b, 2) - corner(a, 0))
        .norm();
  }
  // an edge without length is a vertex
  const SegmentPair along = nearestOnSegments(corner(a, 0), corner(a, 1), corner(b, 0), corner(b, 1));
  return (corner(a, 0) + along.a * (corner(a, 1) - corner(a, 0)) - corner(b, 0) -
          along.b * (corner(b, 1) - corner(b, 0)))
      .norm();
}

/// Wherever on them: braces that cross at rest lie in each other for ever, also where they are sheared.
bool areCloseAtRest(const SurfacePair& pair, const SurfacePoint& a, const SurfacePoint& b) {
  return distanceAtRest(pair.a.topology->rest, a, b) <= pair.radiusSum() + pair.margin - pair.farther;
}

}  // namespace

bool isRound(const MovingSurface& surface, const MovingSurface& other) {
  return surface.topology->triangles.empty() && surface.radius > kRound * other.radius;
}

SurfacePoint atVertex(std::uint32_t v) {
  return placeOn(v, std::array<std::uint32_t, 1>{v}, Vector3d::UnitX());
}

SurfacePoint onEdge(const SurfaceTopology& t, std::uint32_t edge, const Eigen::Vector2d& weights) {
  return placeOn(edge, t.edges[edge], {weights[0], weights[1], 0.0});
}

SurfacePoint onTriangle(const SurfaceTopology& t, std::uint32_t triangle, const Vector3d& weights) {
  return placeOn(triangle, t.triangles[triangle], weights);
}

std::uint64_t contactVertex(const SurfacePair& pair, std::uint32_t v, bool ofB) {
  return std::uint64_t{v} * 2 + (ofB && !pair.self ? 1 : 0);
}

void addCandidate(const SurfacePair& pair, ContactCandidate& candidate, ContactSearch& search) {
  SurfaceContact& c = candidate.contact;
  if (pair.self && (shareVertex(c.a, c.b) || areCloseAtRest(pair, c.a, c.b))) return;
  c.gap = c.normal.dot(positionOf(pair.a, c.a, 0.0) - positionOf(pair.b, c.b, 0.0)) - pair.radiusSum();
  c.key = std::uint64_t{candidate.rank} << 60 | std::uint64_t{c.a.feature} << 30 | c.b.feature;
  candidate.place = 0.5 * (positionOf(pair.a, c.a, c.time) + positionOf(pair.b, c.b, c.time));
  search.candidates.push_back(candidate);
}

// --- contacts that say the same ----------------------------------------------------------------------------

namespace {

/// Cosine of the angle between directions that are the same.
constexpr double kSameDirection = 0.995;
/// Share of the features' size within which places are the same.
constexpr double kOneSpot = 1e-3;

using Candidates = std::vector<ContactCandidate>;

bool haveSameDirection(const ContactCandidate& x, const ContactCandidate& y) {
  return x.contact.normal.dot(y.contact.normal) > kSameDirection;
}

template <class Order>
void sortBy(Candidates& candidates, Order&& order) {
  std::sort(candidates.begin(), candidates.end(),
            [&](const ContactCandidate& x, const ContactCandidate& y) { return order(x) < order(y); });
}

void eraseDropped(Candidates& candidates) {
  const auto dropped = [](const ContactCandidate& x) { return x.dropped; };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), dropped), candidates.end());
}

/// Two vertices are each other's contact only where neither has another in that direction.
void reduceVertexPairs(Candidates& candidates) {
  for (ContactCandidate& x : candidates) {
    if (x.vertex != kNoVertex || x.rank != kVertexVertex) continue;
    const std::uint64_t a = std::uint64_t{x.contact.a.feature} * 2,
                        b = std::uint64_t{x.contact.b.feature} * 2 + 1;
    x.dropped = std::any_of(candidates.begin(), candidates.end(), [&](const ContactCandidate& y) {
      return (y.vertex == a || y.vertex == b) && !y.dropped && haveSameDirection(x, y);
    });
  }
}

/// Of each vertex and direction only the contact that comes first stays.
void reduceVertices(Candidates& candidates) {
  sortBy(candidates, [](const ContactCandidate& x) {
    return std::make_tuple(x.vertex, x.contact.time, x.contact.gap, x.contact.key);
  });
  for (std::size_t first = 0, i = 0; i < candidates.size(); ++i) {
    if (candidates[i].vertex == kNoVertex) break;
    if (candidates[i].vertex != candidates[first].vertex) first = i;
    for (std::size_t j = first; j < i && !candidates[i].dropped; ++j)
      candidates[i].dropped = !candidates[j].dropped && haveSameDirection(candidates[i], candidates[j]);
  }
  reduceVertexPairs(candidates);
  eraseDropped(candidates);
}

bool haveSamePlace(const ContactCandidate& x, const ContactCandidate& y) {
  const double near = kOneSpot * std::min(x.scale, y.scale);
  return (x.place - y.place).squaredNorm() <= near * near;
}

/// Sweeps along x.
void reducePlaces(Candidates& candidates) {
  sortBy(candidates, [](const ContactCandidate& x) { return std::make_tuple(x.place.x(), x.contact.key); });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    ContactCandidate& x = candidates[i];
    const double end = x.place.x() + kOneSpot * x.scale;
    for (std::size_t j = i + 1; j < candidates.size() && candidates[j].place.x() <= end; ++j) {
      ContactCandidate& y = candidates[j];
      if (x.dropped || y.dropped || !haveSamePlace(x, y) || !haveSameDirection(x, y)) continue;
      (x.contact.key <= y.contact.key ? y : x).dropped = true;
    }
  }
  eraseDropped(candidates);
}

/// Keeps one of the candidates that push a vertex in the same direction, the one that comes first, and one of
/// those that push in the same direction at the same place. Sorted by key. Reorders the candidates.
void reduceContacts(Candidates& candidates, std::vector<SurfaceContact>& found) {
  reduceVertices(candidates);
  reducePlaces(candidates);
  sortBy(candidates, [](const ContactCandidate& x) { return x.contact.key; });
  found.clear();
  for (const ContactCandidate& x : candidates) found.push_back(x.contact);
}

// --- the search --------------------------------------------------------------------------------------------

void searchNear(const SurfacePair& pair, ContactSearch& search, std::vector<SurfaceContact>& found) {
  search.candidates.clear();
  search.behind.clear();
  collideNearFeatures(pair, search);
  addInsideVertices(pair, search);
  reduceContacts(search.candidates, found);
}

}  // namespace

void findSurfaceContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactSearch& search,
                         std::vector<SurfaceContact>& found) {
  findNearLeaves(a, b, margin, search.waiting, search.near);
  searchNear({a, b, margin, false, 0.0}, search, found);
}

void findSelfContacts(const MovingSurface& surface, double margin, ContactSearch& search,
                      std::vector<SurfaceContact>& found, double farther) {
  findNearLeaves(surface, margin + farther, search.waiting, search.near);
  searchNear({surface, surface, margin + farther, true, farther}, search, found);
}

// --- contacts that are kept --------------------------------------------------------------------------------

namespace {

/// Shares of the margin: by how much the surfaces may have moved against each other since the search, where
/// features begin and end to be nearest; and that and the coming motion together, within which nothing that
/// was not near meets.
constexpr double kMaxMoved = 0.2, kMaxWithMotion = 0.9;

/// Cosine by which a normal may have turned since.
constexpr double kSameNormal = 0.999;

/// m: the longest of the points' ways from `from` to `to`, after `common` is taken off.
double longestDisplacement(const Points& from, const Points& to, const Vector3d& common) {
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
                     const ContactCache& cache) {
  const Vector3d displacement = a.position->col(0) - cache.a.col(0), motion = a.motion->col(0);
  const double moved = longestDisplacement(cache.a, *a.position, displacement) +
                       longestDisplacement(cache.b, *b.position, displacement);
  if (!(moved <= kMaxMoved * margin)) return false;
  return moved + longestMotion(*a.motion, motion) + longestMotion(*b.motion, motion) <=
         kMaxWithMotion * margin;
}

/// Whether the place is on the vertex, within the edge or in the triangle that it was on; the weights are its
/// new ones there.
template <class Weights>
bool moveTo(SurfacePoint& place, const Weights& weights) {
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0.0)) return false;
    place.weights[i] = weights[i];
  }
  return true;
}

Vector3d positionOf(const MovingSurface& surface, const SurfacePoint& place) {
  Vector3d x = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    x += place.weights[static_cast<Eigen::Index>(i)] * surface.position->col(place.points[i]);
  return x;
}

/// False where the two features no longer meet as they did; `normal` is not yet unit, nor of the right sign.
bool moveVertexTriangle(const MovingSurface& mine, SurfacePoint& vertex, const MovingSurface& other,
                        SurfacePoint& triangle, Vector3d& normal) {
  const Vector3d a = other.position->col(triangle.points[0]);
  const Vector3d u = other.position->col(triangle.points[1]) - a;
  const Vector3d v = other.position->col(triangle.points[2]) - a;
  const Vector3d to = mine.position->col(vertex.points[0]) - a;
  normal = u.cross(v);
  const double squared = normal.squaredNorm();
  if (!(squared > 0.0)) return false;
  const double second = normal.dot(to.cross(v)) / squared, third = normal.dot(u.cross(to)) / squared;
  Vector3d weights(1.0 - second - third, second, third);
  if (!moveInto(weights)) return false;
  triangle.weights = weights;
  return true;
}

bool moveEdges(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c, Vector3d& normal) {
  const auto ea = featureOf<2>(a, c.a.points), eb = featureOf<2>(b, c.b.points);
  const auto places = nearestPoints(ea, eb, 0.0);
  normal = (ea.start.col(1) - ea.start.col(0)).cross(eb.start.col(1) - eb.start.col(0));
  return moveTo(c.a, places.a) && moveTo(c.b, places.b);
}

bool moveVertexEdge(const MovingSurface& mine, const SurfacePoint& vertex, const MovingSurface& other,
                    SurfacePoint& edge, Vector3d& normal) {
  const auto v = featureOf<1>(mine, vertex.points);
  const auto places = nearestPoints(v, featureOf<2>(other, edge.points), 0.0);
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

bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactCache& cache) {
  if (cache.topologyA != a.topology || cache.topologyB != b.topology) return false;
  if (cache.a.cols() != a.position->cols() || cache.b.cols() != b.position->cols()) return false;
  if (!haveHardlyMoved(a, b, margin, cache)) return false;
  for (SurfaceContact& c : cache.contacts)
    if (!refresh(a, b, c)) return false;
  return true;
}

void storeContacts(const MovingSurface& a, const MovingSurface& b, const std::vector<SurfaceContact>& found,
                   ContactCache& cache) {
  cache.contacts = found;
  cache.a = *a.position;
  cache.b = *b.position;
  cache.topologyA = a.topology;
  cache.topologyB = b.topology;
}

}  // namespace limber
