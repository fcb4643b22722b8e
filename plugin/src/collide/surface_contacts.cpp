// SPDX-License-Identifier: Zlib
// Finds the contacts of surfaces: tests features that are near each other, removes duplicates, and refreshes
// the contacts of an earlier search.
#include "collide/surface_contacts.h"

#include "collide/feature_contacts.h"

#include <cmath>
#include <tuple>

namespace limber {
namespace {

using Eigen::Vector3d;

// --- features that are near --------------------------------------------------------------------------------

/// An element with the boxes of the features that it owns.
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

/// Whether the vertex is one of the corners of a feature of the same surface: the two are no contact.
template <std::size_t N>
bool isOwnCorner(const SurfacePair& pair, std::uint32_t v, const std::array<std::uint32_t, N>& corners) {
  return pair.self && std::find(corners.begin(), corners.end(), v) != corners.end();
}

/// Tests the vertices that `own` owns with all features of `other`. `ofB`: `own` is an element of surface b.
void collideVerticesOf(const SurfacePair& pair, bool ofB, const BoxedElement& own, const BoxedElement& other,
                       ContactSearch& search) {
  const MovingSurface &ours = ofB ? pair.b : pair.a, &theirs = ofB ? pair.a : pair.b;
  for (const std::uint32_t v : own.element->vertices) {
    if (v == kNoFeature || separation(own.vertexBox(v), other.whole) > pair.margin) continue;
    const SweptBox& box = own.vertexBox(v);
    const NearVertex vertex = nearVertex(ours, v);
    if (other.element->triangle != kNoFeature && !isOwnCorner(pair, v, other.element->corners))
      collideVertexTriangle(pair, ofB, vertex, nearTriangle(theirs, other.element->triangle), search);
    const std::vector<Edge>& edges = theirs.topology->edges;
    for (std::size_t i = 0; i < 3; ++i)
      if (const std::uint32_t edge = other.element->edges[i]; edge != kNoFeature &&
                                                              !isOwnCorner(pair, v, edges[edge]) &&
                                                              separation(box, other.edges[i]) <= pair.margin)
        collideVertexEdge(pair, ofB, vertex, nearEdge(theirs, edge), search);
    for (const std::uint32_t w : other.element->vertices)
      if (!ofB && w != kNoFeature && !(pair.self && v == w) &&
          separation(box, other.vertexBox(w)) <= pair.margin)
        collideVertices(pair, vertex, nearVertex(theirs, w), search);
  }
}

bool isCovered(const SurfacePair& pair, std::uint32_t edgeB) {
  return pair.covered.edges && (*pair.covered.edges)[edgeB];
}

bool bears(const ContactSearch& search, std::uint32_t edgeA, std::uint32_t edgeB) {
  const std::vector<std::uint64_t>& keys = search.bearing;
  return std::binary_search(keys.begin(), keys.end(), keyOf(kEdgeEdge, edgeA, edgeB));
}

void collideEdgesOf(const SurfacePair& pair, const BoxedElement& a, const BoxedElement& b,
                    ContactSearch& search) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t edgeA = a.element->edges[i];
    if (edgeA == kNoFeature || separation(a.edges[i], b.whole) > pair.margin) continue;
    const Edge& ends = pair.a.topology->edges[edgeA];
    for (std::size_t j = 0; j < 3; ++j)
      if (const std::uint32_t edgeB = b.element->edges[j];
          edgeB != kNoFeature && !isOwnCorner(pair, ends[0], pair.b.topology->edges[edgeB]) &&
          !isOwnCorner(pair, ends[1], pair.b.topology->edges[edgeB]) &&
          separation(a.edges[i], b.edges[j]) <= pair.margin)
        if (!bears(search, edgeA, edgeB))
          collideEdges(pair, nearEdge(pair.a, edgeA), nearEdge(pair.b, edgeB), false, search);
  }
}

/// Tests the edges that have borne a load: it may have pushed them through each other by more than the
/// margin between their boxes.
void collideBearingEdges(const SurfacePair& pair, ContactSearch& search) {
  constexpr std::uint32_t kNumber = (1u << 30) - 1;
  for (const std::uint64_t key : search.bearing) {
    const auto edgeA = static_cast<std::uint32_t>(key >> 30) & kNumber,
               edgeB = static_cast<std::uint32_t>(key) & kNumber;
    if (key != keyOf(kEdgeEdge, edgeA, edgeB) || edgeA >= pair.a.topology->edges.size() ||
        edgeB >= pair.b.topology->edges.size() || isCovered(pair, edgeB))
      continue;
    collideEdges(pair, nearEdge(pair.a, edgeA), nearEdge(pair.b, edgeB), true, search);
  }
}

/// Tests the features that the elements of `search.near` own; adds to `search.candidates` and
/// `search.penetrating`.
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

// --- what is apart along the line between the surfaces
// -------------------------------------------------------

// The boxes of large triangles overlap where the triangles are far apart. Most of these are apart along the
// line between the centres of the surfaces, and so are many surfaces whose boxes overlap.

/// Number of points of a surface from which a search costs less than the projection of all of them.
constexpr Eigen::Index kManyPoints = 200;

Vector3d centerOf(const SweptBox& box) { return 0.5 * (box.low + box.high).head<3>(); }

/// Sets the extents of the points, with their motions relative to `common` (m). Returns that of all.
Extent project(const MovingSurface& surface, const Vector3d& direction, const Vector3d& common,
               std::vector<Extent>& points) {
  points.resize(static_cast<std::size_t>(surface.position->cols()));
  Extent all{SweptBox::kEmpty, -SweptBox::kEmpty};
  const double shift = direction.dot(common);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double start = direction.dot(surface.position->col(column));
    const double end = start + direction.dot(surface.motion->col(column)) - shift;
    points[i] = {std::min(start, end), std::max(start, end)};
    all = {std::min(all.low, points[i].low), std::max(all.high, points[i].high)};
  }
  return all;
}

/// The extents of two surfaces along the line between their centres.
class Between {
 public:
  Between(const SurfacePair& pair, ContactSearch& search)
      : pair_(pair), search_(search), distance_(pair.margin + pair.radiusSum()) {
    direction_ = (centerOf(pair.b.boxes->nodes[0]) - centerOf(pair.a.boxes->nodes[0])).stableNormalized();
    const Vector3d common = pair.b.motion->col(0);
    a_ = project(pair.a, direction_, common, search.pointsA);
    b_ = project(pair.b, direction_, common, search.pointsB);
  }

  /// Whether the surfaces, and so their convex hulls, do not come near each other.
  bool areApart() const { return areApart(a_, b_); }

  /// Whether elements of a and b are.
  bool areApart(std::uint32_t elementA, std::uint32_t elementB) const {
    return areApart(extentOf(pair_.a, elementA, search_.pointsA),
                    extentOf(pair_.b, elementB, search_.pointsB));
  }

 private:
  bool areApart(const Extent& a, const Extent& b) const {
    return b.low - a.high > distance_ || a.low - b.high > distance_;
  }

  /// Returns the extent of an element, with the depth to which it pushes out what is behind it.
  Extent extentOf(const MovingSurface& surface, std::uint32_t number,
                  const std::vector<Extent>& points) const {
    const SurfaceTopology& t = *surface.topology;
    const SurfaceElement& element = t.elements[number];
    const auto& [i, j, k] = element.corners;
    Extent extent{std::min({points[i].low, points[j].low, points[k].low}),
                  std::max({points[i].high, points[j].high, points[k].high})};
    if (element.triangle == kNoFeature || !t.oneSided[element.triangle]) return extent;
    const Vector3d first = surface.position->col(i);
    const Vector3d area = (surface.position->col(j) - first).cross(surface.position->col(k) - first);
    const double facing = area.dot(direction_);
    if (facing >= 0.0) extent.low -= t.depthLimit[element.triangle];
    if (facing <= 0.0) extent.high += t.depthLimit[element.triangle];
    return extent;
  }

  const SurfacePair& pair_;
  ContactSearch& search_;
  Vector3d direction_;
  Extent a_, b_;
  double distance_;  ///< m, at which points are not near
};

// --- duplicate contacts ------------------------------------------------------------------------------------

/// Fraction of the feature size within which contact points are the same.
constexpr double kSamePointTolerance = 1e-3;

using Candidates = std::vector<FeatureCandidate>;

bool haveSameDirection(const FeatureCandidate& x, const FeatureCandidate& y) {
  return x.contact.normal.dot(y.contact.normal) > std::max(x.sameDirection, y.sameDirection);
}

template <class Order>
void sortBy(Candidates& candidates, Order&& order) {
  std::sort(candidates.begin(), candidates.end(),
            [&](const FeatureCandidate& x, const FeatureCandidate& y) { return order(x) < order(y); });
}

void eraseDropped(Candidates& candidates) {
  const auto dropped = [](const FeatureCandidate& x) { return x.dropped; };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), dropped), candidates.end());
}

/// Returns whether a vertex has a contact in the direction of x. The candidates are sorted by their vertices.
bool hasInDirectionOf(const FeatureCandidate& x, const Candidates& candidates, std::uint64_t vertex) {
  auto y = std::lower_bound(candidates.begin(), candidates.end(), vertex,
                            [](const FeatureCandidate& c, std::uint64_t v) { return c.vertex < v; });
  for (; y != candidates.end() && y->vertex == vertex; ++y)
    if (!y->dropped && haveSameDirection(x, *y)) return true;
  return false;
}

/// Drops contacts of two vertices if one of the vertices has another contact in the same direction.
void removeDuplicateVertexPairs(Candidates& candidates) {
  for (FeatureCandidate& x : candidates) {
    if (x.vertex != kNoVertex || x.rank != kVertexVertex) continue;
    const std::uint64_t a = std::uint64_t{x.contact.a.feature} * 2,
                        b = std::uint64_t{x.contact.b.feature} * 2 + 1;
    x.dropped = hasInDirectionOf(x, candidates, a) || hasInDirectionOf(x, candidates, b);
  }
}

/// Keeps the earliest contact of each vertex and direction.
void removeDuplicateDirections(Candidates& candidates) {
  sortBy(candidates, [](const FeatureCandidate& x) {
    return std::make_tuple(x.vertex, x.contact.time, x.contact.gap, x.contact.key);
  });
  for (std::size_t first = 0, i = 0; i < candidates.size(); ++i) {
    if (candidates[i].vertex == kNoVertex) break;
    if (candidates[i].vertex != candidates[first].vertex) first = i;
    for (std::size_t j = first; j < i && !candidates[i].dropped; ++j)
      candidates[i].dropped = !candidates[j].dropped && haveSameDirection(candidates[i], candidates[j]);
  }
  removeDuplicateVertexPairs(candidates);
  eraseDropped(candidates);
}

bool haveSamePoint(const FeatureCandidate& x, const FeatureCandidate& y) {
  const double tolerance = kSamePointTolerance * std::min(x.featureSize, y.featureSize);
  return (x.point - y.point).squaredNorm() <= tolerance * tolerance;
}

/// Keeps one of the contacts with the same point and direction. Sweeps along the axis in which they are
/// farthest apart.
void removeDuplicatePoints(Candidates& candidates) {
  Eigen::AlignedBox3d box;
  for (const FeatureCandidate& x : candidates) box.extend(x.point);
  Eigen::Index axis = 0;
  if (!candidates.empty()) box.sizes().maxCoeff(&axis);
  sortBy(candidates,
         [&](const FeatureCandidate& x) { return std::make_tuple(x.point[axis], x.contact.key); });
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    FeatureCandidate& x = candidates[i];
    const double end = x.point[axis] + kSamePointTolerance * x.featureSize;
    for (std::size_t j = i + 1; j < candidates.size() && candidates[j].point[axis] <= end; ++j) {
      FeatureCandidate& y = candidates[j];
      if (x.dropped || y.dropped || !haveSamePoint(x, y) || !haveSameDirection(x, y)) continue;
      (x.contact.key <= y.contact.key ? y : x).dropped = true;
    }
  }
  eraseDropped(candidates);
}

/// Writes to `found` the candidates without duplicates, sorted by key. Reorders the candidates.
void removeDuplicates(Candidates& candidates, std::vector<SurfaceContact>& found) {
  removeDuplicateDirections(candidates);
  removeDuplicatePoints(candidates);
  sortBy(candidates, [](const FeatureCandidate& x) { return x.contact.key; });
  found.clear();
  for (const FeatureCandidate& x : candidates) found.push_back(x.contact);
}

// --- the search --------------------------------------------------------------------------------------------

void finishSearch(const SurfacePair& pair, ContactSearch& search, std::vector<SurfaceContact>& found) {
  collideBearingEdges(pair, search);
  addInsideVertices(pair, search);
  removeDuplicates(search.candidates, found);
}

void searchNear(const SurfacePair& pair, ContactSearch& search, std::vector<SurfaceContact>& found) {
  search.candidates.clear();
  search.penetrating.clear();
  collideNearFeatures(pair, search);
  finishSearch(pair, search, found);
}

/// Fills search.nearA and search.nearB.
void listNear(const SurfacePair& pair, ContactSearch& search) {
  const bool verticesOfA = !pair.covered.vertices;
  const SurfaceBoxes& boxesB = *pair.b.boxes;
  NearFeatures& a = search.nearA;
  listNearFeatures(pair.a, {verticesOfA, true, nullptr}, {boxesB.vertices, boxesB.nodes[0], pair.margin}, a);
  const SweptBox features = merged(a.vertexBoxes.bounds(), a.edgeBoxes.bounds());
  listNearFeatures(pair.b, {true, verticesOfA, pair.covered.edges},
                   {features, merged(features, a.triangleBoxes.bounds()), pair.margin}, search.nearB);
}

/// Whether a vertex is behind a triangle and outside the boxes of what the triangle pushes out: in single
/// precision these are a little larger.
bool isBeyond(const SurfacePair& pair, bool ofB, const NearVertex& vertex, const NearTriangle& triangle,
              const Between* between) {
  const Vector3d from = vertex.feature.start - triangle.feature.start.col(0);
  if (triangle.normal.dot(from) >= 0.0) return false;
  const MovingSurface &own = ofB ? pair.b : pair.a, &other = ofB ? pair.a : pair.b;
  if (separation(own.boxes->points[vertex.vertex], other.boxes->nodes[triangle.leaf]) > pair.margin)
    return true;
  return between && (ofB ? between->areApart(triangle.element, vertex.element)
                         : between->areApart(vertex.element, triangle.element));
}

/// Tests the vertices of one surface with the triangles and edges of the other.
void collideListedVertices(const SurfacePair& pair, bool ofB, const Between* between, ContactSearch& search) {
  const NearFeatures &own = ofB ? search.nearB : search.nearA, &other = ofB ? search.nearA : search.nearB;
  own.vertexBoxes.findNear(other.triangleBoxes, search.near);
  for (const auto& [i, j] : search.near)
    if (!isBeyond(pair, ofB, own.vertices[i], other.triangles[j], between))
      collideVertexTriangle(pair, ofB, own.vertices[i], other.triangles[j], search);
  own.vertexBoxes.findNear(other.edgeBoxes, search.near);
  for (const auto& [i, j] : search.near)
    collideVertexEdge(pair, ofB, own.vertices[i], other.edges[j], search);
}

/// Tests what is near of search.nearA and search.nearB.
void collideListed(const SurfacePair& pair, const Between* between, ContactSearch& search) {
  const NearFeatures &a = search.nearA, &b = search.nearB;
  collideListedVertices(pair, false, between, search);
  collideListedVertices(pair, true, between, search);
  a.vertexBoxes.findNear(b.vertexBoxes, search.near);
  for (const auto& [i, j] : search.near) collideVertices(pair, a.vertices[i], b.vertices[j], search);
  a.edgeBoxes.findNear(b.edgeBoxes, search.near);
  for (const auto& [i, j] : search.near)
    if (!bears(search, a.edges[i].edge, b.edges[j].edge))
      collideEdges(pair, a.edges[i], b.edges[j], false, search);
}

}  // namespace

void findSurfaceContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactSearch& search,
                         std::vector<SurfaceContact>& found, const Covered& covered) {
  found.clear();
  if (a.boxes->nodes.empty() || b.boxes->nodes.empty()) return;
  const SurfacePair pair{a, b, margin, false, 0.0, covered};
  std::optional<Between> between;
  if (std::max(a.position->cols(), b.position->cols()) < kManyPoints) between.emplace(pair, search);
  if (between && between->areApart()) return;
  search.candidates.clear();
  search.penetrating.clear();
  listNear(pair, search);
  collideListed(pair, between ? &*between : nullptr, search);
  finishSearch(pair, search, found);
}

// --- a surface with itself ---------------------------------------------------------------------------------

namespace {

ElementMotion motionOf(const MovingSurface& surface, const SurfaceElement& element) {
  ElementMotion m;
  m.element = &element;
  const auto& corners = element.corners;
  const Points& rest = surface.topology->rest;
  for (const std::uint32_t c : corners) {
    m.box.extend(surface.position->col(c));
    m.start += surface.position->col(c) / 3.0;
    m.motion += surface.motion->col(c) / 3.0;
    m.rest += rest.col(c) / 3.0;
  }
  for (const std::uint32_t c : corners) {
    m.spread = std::max(m.spread, (surface.motion->col(c) - m.motion).norm());
    m.size = std::max(m.size, (rest.col(c) - m.rest).norm());
  }
  const MovingFeature<3> triangle = featureOf<3>(surface, corners);
  m.startNormal = normalOf<3>(triangle.start);
  m.endNormal = normalOf<3>(triangle.at(1.0));
  return m;
}

bool shareCorner(const SurfaceElement& a, const SurfaceElement& b) {
  return std::find_first_of(a.corners.begin(), a.corners.end(), b.corners.begin(), b.corners.end()) !=
         a.corners.end();
}

/// Cosine of the largest angle between two elements, and their least distance relative to that at rest, with
/// which the surface between them is about flat. This tells nothing of elements that are larger than
/// 1 / kLeastDistance of their distance, unless they share a corner: a small part that is folded over a large
/// triangle is about as far from its middle as before.
constexpr double kAboutFlat = 0.5, kAboutUnfolded = 0.9, kLeastDistance = 1.5;

/// Whether the surface between two elements is about flat at the start and the expected end of the tick. So
/// they do not touch: most near elements of a surface are such neighbours. Elements that are not triangles
/// have no normals.
bool staysFlat(const ElementMotion& a, const ElementMotion& b) {
  if (!(a.startNormal.dot(b.startNormal) > kAboutFlat && a.endNormal.dot(b.endNormal) > kAboutFlat))
    return false;
  const double rest = (b.rest - a.rest).norm(), least = kAboutUnfolded * rest;
  const Vector3d start = b.start - a.start;
  return start.norm() > least && (start + b.motion - a.motion).norm() > least &&
         (rest > kLeastDistance * std::max(a.size, b.size) || shareCorner(*a.element, *b.element));
}

/// Returns a lower bound of the distance (m) between points of two elements within the tick, if their
/// relative motion is up to twice as expected. Most near elements are neighbours that move alike.
double leastDistance(const ElementMotion& a, const ElementMotion& b) {
  const double relative = (a.motion - b.motion).norm() + a.spread + b.spread;
  return a.box.exteriorDistance(b.box) - 2.0 * relative;
}

/// Fills search.near with the pairs of elements that may come within `margin` (m) of each other.
/// `leavesOut(a, b)`: which of them do not.
template <class LeavesOut>
void findNearElements(const MovingSurface& surface, double margin, ContactSearch& search,
                      LeavesOut leavesOut) {
  findNearLeaves(surface, surface, margin, search.waiting, search.near);
  const SurfaceTopology& t = *surface.topology;
  search.elements.clear();
  for (const SurfaceElement& element : t.elements) search.elements.push_back(motionOf(surface, element));
  const auto isLeftOut = [&](const LeafPairs::value_type& pair) {
    const ElementMotion &a = search.elements[t.nodes[pair.first].element],
                        &b = search.elements[t.nodes[pair.second].element];
    return staysFlat(a, b) || leavesOut(a, b);
  };
  search.near.erase(std::remove_if(search.near.begin(), search.near.end(), isLeftOut), search.near.end());
}

}  // namespace

void findSelfContacts(const MovingSurface& surface, double margin, ContactSearch& search,
                      std::vector<SurfaceContact>& found) {
  findNearElements(surface, margin, search, [](const ElementMotion&, const ElementMotion&) { return false; });
  searchNear({surface, surface, margin, true, 0.0}, search, found);
}

bool mayTouchItself(const MovingSurface& surface, double margin, double displacement, double others,
                    ContactSearch& search, std::vector<SurfaceContact>& found) {
  constexpr double kUnexpected = 0.25;
  const double extraMargin = kUnexpected * displacement + others;
  const double distance = margin + 2.0 * surface.radius + extraMargin;
  findNearElements(
      surface, margin + extraMargin, search,
      [&](const ElementMotion& a, const ElementMotion& b) { return leastDistance(a, b) > distance; });
  searchNear({surface, surface, margin + extraMargin, true, extraMargin}, search, found);
  return !found.empty();
}

// --- contact cache -----------------------------------------------------------------------------------------

namespace {

/// Fractions of the margin. kMaxMoved limits the relative motion since the search, because other features
/// become the nearest. kMaxWithMotion limits that plus the expected motion, so that features that were not
/// near at the search cannot touch.
constexpr double kMaxMoved = 0.2, kMaxWithMotion = 0.9;

/// Cosine of the largest rotation of a normal since the search.
constexpr double kSameNormal = 0.999;

/// Returns the length (m) of the longest column of `displacements`, relative to `common`.
template <class Displacements>
double longest(const Displacements& displacements, const Vector3d& common) {
  return std::sqrt((displacements.colwise() - common).colwise().squaredNorm().maxCoeff());
}

bool areNearlyUnmoved(const MovingSurface& a, const MovingSurface& b, double margin,
                      const ContactCache& cache) {
  const Vector3d displacement = a.position->col(0) - cache.a.col(0), motion = a.motion->col(0);
  const double moved =
      longest(*a.position - cache.a, displacement) + longest(*b.position - cache.b, displacement);
  return moved <= kMaxMoved * margin &&
         moved + longest(*a.motion, motion) + longest(*b.motion, motion) <= kMaxWithMotion * margin;
}

/// Sets the weights of the point. Returns false if it is no longer in the interior of its feature.
template <class Weights>
bool setWeights(SurfacePoint& point, const Weights& weights) {
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0.0)) return false;
    point.weights[i] = weights[i];
  }
  return true;
}

// The functions below move the two points of a contact to the nearest points of their features at a time of
// the tick, and compute its normal without length and sign. They return false if a nearest point has left its
// feature.

bool updateVertexTriangle(const MovingSurface& own, const SurfacePoint& vertex, const MovingSurface& other,
                          SurfacePoint& triangle, double time, Vector3d& normal) {
  const auto corners = featureOf<3>(other, triangle.points).at(time);
  normal = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
  return projectOnTriangle(corners, own.at(vertex.points[0], time), triangle.weights);
}

bool updateEdges(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c, double time,
                 Vector3d& normal) {
  const auto ea = featureOf<2>(a, c.a.points), eb = featureOf<2>(b, c.b.points);
  const auto nearest = nearestPoints(ea, eb, time);
  const auto xa = ea.at(time), xb = eb.at(time);
  normal = (xa.col(1) - xa.col(0)).cross(xb.col(1) - xb.col(0));
  return setWeights(c.a, nearest.a) && setWeights(c.b, nearest.b);
}

bool updateVertexEdge(const MovingSurface& own, const SurfacePoint& vertex, const MovingSurface& other,
                      SurfacePoint& edge, double time, Vector3d& normal) {
  const auto nearest =
      nearestPoints(featureOf<1>(own, vertex.points), featureOf<2>(other, edge.points), time);
  normal = nearest.offset;
  return setWeights(edge, nearest.b);
}

bool updatePoints(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c, double time,
                  Vector3d& normal) {
  const FeatureKind onA = c.a.kind, onB = c.b.kind;
  if (onB == FeatureKind::OnTriangle) return updateVertexTriangle(a, c.a, b, c.b, time, normal);
  if (onA == FeatureKind::OnTriangle) return updateVertexTriangle(b, c.b, a, c.a, time, normal);
  if (onA == FeatureKind::OnEdge && onB == FeatureKind::OnEdge) return updateEdges(a, b, c, time, normal);
  if (onB == FeatureKind::OnEdge) return updateVertexEdge(a, c.a, b, c.b, time, normal);
  if (onA == FeatureKind::OnEdge) return updateVertexEdge(b, c.b, a, c.a, time, normal);
  normal = a.at(c.a.points[0], time) - b.at(c.b.points[0], time);
  return true;
}

/// Moves the contact to where its features are nearest at a time of the tick. The gap is that of now. Returns
/// false if they no longer touch there, or if the cosine of the normal's rotation is less than `least`.
bool moveTo(double time, const MovingSurface& a, const MovingSurface& b, double least, SurfaceContact& c) {
  Vector3d normal;
  if (!updatePoints(a, b, c, time, normal)) return false;
  const double length = normal.norm();
  if (!(length > 0.0)) return false;
  normal *= (normal.dot(c.normal) < 0.0 ? -1.0 : 1.0) / length;
  if (normal.dot(c.normal) < least) return false;
  c.normal = normal;
  c.gap = normal.dot(positionOf(a, c.a) - positionOf(b, c.b)) - (a.radius + b.radius);
  c.time = 0.0;
  return true;
}

/// Whether the contact is one of edges that a search would leave out.
bool hasFlatEdges(const MovingSurface& a, const MovingSurface& b, const SurfaceContact& c) {
  return c.a.kind == FeatureKind::OnEdge && c.b.kind == FeatureKind::OnEdge &&
         areFlatEdges(a, c.a.feature, b, c.b.feature, c.normal);
}

}  // namespace

bool refreshContacts(const MovingSurface& a, const MovingSurface& b, double margin, ContactCache& cache) {
  if (cache.topologyA != a.topology || cache.topologyB != b.topology) return false;
  if (cache.a.cols() != a.position->cols() || cache.b.cols() != b.position->cols()) return false;
  if (!areNearlyUnmoved(a, b, margin, cache)) return false;
  for (SurfaceContact& c : cache.contacts)
    if (!moveTo(0.0, a, b, kSameNormal, c) || hasFlatEdges(a, b, c)) return false;
  return true;
}

void moveToMiddle(const MovingSurface& a, const MovingSurface& b, SurfaceContact& c) {
  constexpr double kLargestTurn = 0.9;  // cosine
  if (c.time > 0.0 || c.separates) return;
  if (SurfaceContact middle = c; moveTo(0.5, a, b, kLargestTurn, middle)) c = middle;
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
