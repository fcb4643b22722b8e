// SPDX-License-Identifier: Zlib
// Finds the elements of a network, divides the points at which they separate, and gives the springs at these
// points to their copies.

#include "solver/split.h"

#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

namespace limber {

using Eigen::Vector3d;

// --- elements ----------------------------------------------------------------------------------------------

Elements elementsOf(const SpringNetwork& network) {
  const std::size_t points = network.restPoints.size();
  if (!network.tetrahedra.empty())
    return {4, network.tetrahedra, elementsOfPoints(points, network.tetrahedra)};
  Elements e;
  if (!network.surface.empty()) {
    e.corners = 3;
    for (const Triangle& t : network.surface) e.all.push_back({t[0], t[1], t[2], kNoPoint});
    e.around = elementsOfPoints(points, network.surface);
    return e;
  }
  e.corners = 2;
  std::vector<Edge> ends;
  for (const NetworkSpring& s : network.springs)
    if (s.kind == SpringKind::Structural) ends.push_back({s.a, s.b});
  for (const Edge& s : ends) e.all.push_back({s[0], s[1], kNoPoint, kNoPoint});
  e.around = elementsOfPoints(points, ends);
  return e;
}

namespace {

Facet facetWithout(const std::array<std::uint32_t, 4>& element, std::size_t corners, std::size_t leftOut) {
  Facet facet = {kNoPoint, kNoPoint, kNoPoint};
  std::size_t n = 0;
  for (std::size_t c = 0; c < corners; ++c)
    if (c != leftOut) facet[n++] = element[c];
  std::sort(facet.begin(), facet.end());
  return facet;
}

/// Returns all pairs of elements that share a facet, in the order of the facets.
std::vector<ElementPair> elementPairs(const Elements& elements) {
  std::vector<std::pair<Facet, std::uint32_t>> facets;
  facets.reserve(elements.all.size() * elements.corners);
  for (std::uint32_t i = 0; i < elements.all.size(); ++i)
    for (std::size_t c = 0; c < elements.corners; ++c)
      facets.emplace_back(facetWithout(elements.all[i], elements.corners, c), i);
  std::sort(facets.begin(), facets.end());
  std::vector<ElementPair> pairs;
  for (std::size_t i = 0; i < facets.size(); ++i)
    for (std::size_t j = i + 1; j < facets.size() && facets[j].first == facets[i].first; ++j)
      pairs.push_back({facets[i].first, facets[i].second, facets[j].second, false});
  return pairs;
}

Vector3d middleOf(const Separation& s, std::uint32_t element) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t c = 0; c < s.old.corners; ++c) sum += s.request.place(s.old.all[element][c]);
  return sum / static_cast<double>(s.old.corners);
}

void separateNeighbours(Separation& s) {
  for (ElementPair& n : s.neighbours) {
    if (s.request.side[n.a] * s.request.side[n.b] >= 0) continue;
    n.separated = !s.request.within || s.request.within(0.5 * (middleOf(s, n.a) + middleOf(s, n.b)));
  }
}

// --- points ------------------------------------------------------------------------------------------------

/// Returns the length, area or volume of an element at rest.
double measureOf(const Separation& s, std::uint32_t element) {
  const auto& corner = s.old.all[element];
  const std::vector<Vector3d>& x = s.before.restPoints;
  const Vector3d ab = x[corner[1]] - x[corner[0]];
  if (s.old.corners == 2) return ab.norm();
  const Vector3d normal = ab.cross(x[corner[2]] - x[corner[0]]);
  return s.old.corners == 3 ? normal.norm() : std::abs(normal.dot(x[corner[3]] - x[corner[0]]));
}

/// The elements around a point that hold together.
using Fans = std::vector<std::vector<std::uint32_t>>;

/// Returns the fans of a point: the largest first, else in the order of their elements. `pairs` are the
/// neighbours around the point.
Fans fansOf(const Elements& elements, std::uint32_t point, const std::vector<const ElementPair*>& pairs) {
  const std::vector<std::uint32_t>& around = elements.around[point];
  DisjointSets sets(around.size());
  const auto placeOf = [&](std::uint32_t element) {
    return static_cast<std::uint32_t>(std::lower_bound(around.begin(), around.end(), element) -
                                      around.begin());
  };
  for (const ElementPair* n : pairs)
    if (!n->separated) sets.join(placeOf(n->a), placeOf(n->b));
  std::vector<std::vector<std::uint32_t>> byRoot(around.size());
  for (std::uint32_t i = 0; i < around.size(); ++i) byRoot[sets.root(i)].push_back(around[i]);
  Fans fans;
  for (auto& fan : byRoot)
    if (!fan.empty()) fans.push_back(std::move(fan));
  std::stable_sort(fans.begin(), fans.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return fans;
}

/// Gives each fan but the first a copy of the point.
void dividePoint(Separation& s, std::uint32_t point, const Fans& fans) {
  std::vector<double> measure;
  double sum = 0.0;
  for (const auto& fan : fans) {
    measure.push_back(0.0);
    for (const std::uint32_t element : fan) measure.back() += measureOf(s, element);
    sum += measure.back();
  }
  s.copies[point] = {point};
  double rest = 1.0;
  // a sliver still gets a mass
  constexpr double kLeast = 0.05;
  const double equal = 1.0 / static_cast<double>(fans.size());
  for (std::size_t f = 1; f < fans.size(); ++f) {
    const double own = sum > 0.0 ? measure[f] / sum : equal;
    const double share = kLeast * equal + (1.0 - kLeast) * own;
    const auto copy = static_cast<std::uint32_t>(s.points.size());
    s.points.push_back({point, share});
    s.copies[point].push_back(copy);
    rest -= share;
    for (const std::uint32_t element : fans[f])
      std::replace(s.elements[element].begin(), s.elements[element].end(), point, copy);
  }
  s.points[point].share = rest;
}

void dividePoints(Separation& s) {
  const std::size_t count = s.before.restPoints.size();
  std::vector<unsigned char> touched(count, 0);
  for (const ElementPair& n : s.neighbours)
    for (const std::uint32_t point : n.facet)
      if (n.separated && point != kNoPoint) touched[point] = 1;
  std::vector<std::vector<const ElementPair*>> pairs(count);
  for (const ElementPair& n : s.neighbours)
    for (const std::uint32_t point : n.facet)
      if (point != kNoPoint && touched[point]) pairs[point].push_back(&n);
  for (std::uint32_t point = 0; point < count; ++point) {
    if (!touched[point]) continue;
    const Fans fans = fansOf(s.old, point, pairs[point]);
    if (fans.size() > 1) dividePoint(s, point, fans);
  }
}

void splitGroups(const Separation& s, const std::vector<std::uint32_t>& springOf, SpringNetwork& network) {
  for (NamedGroup& group : network.groups) {
    const NamedGroup before = group;
    const auto has = [](const std::vector<std::uint32_t>& members, std::uint32_t i) {
      return std::binary_search(members.begin(), members.end(), i);
    };
    group.points.clear();
    group.springs.clear();
    for (std::uint32_t i = 0; i < s.points.size(); ++i)
      if (has(before.points, s.points[i].from)) group.points.push_back(i);
    for (std::uint32_t i = 0; i < springOf.size(); ++i)
      if (has(before.springs, springOf[i])) group.springs.push_back(i);
  }
}

}  // namespace

std::uint32_t cornerFrom(const Separation& s, std::uint32_t element, std::uint32_t oldPoint) {
  for (std::size_t c = 0; c < s.old.corners; ++c)
    if (s.old.all[element][c] == oldPoint) return s.elements[element][c];
  return kNoPoint;
}

SplitNetwork splitNetwork(const SpringNetwork& network, const Elements& elements,
                          const SplitRequest& request) {
  Separation s{network, elements, request, elementPairs(elements), elements.all, {}, {}};
  const std::size_t count = network.restPoints.size();
  for (std::uint32_t i = 0; i < count; ++i) s.points.push_back({i, 1.0});
  s.copies.resize(count);
  separateNeighbours(s);
  dividePoints(s);
  SplitNetwork result;
  if (s.points.size() == count) return result;
  auto split = std::make_shared<SpringNetwork>(network);
  split->massFractions.clear();
  for (const PointCopy& point : s.points) {
    result.pointOf.push_back(point.from);
    split->massFractions.push_back(network.massFractions[point.from] * point.share);
  }
  for (std::size_t i = count; i < s.points.size(); ++i)
    split->restPoints.push_back(network.restPoints[s.points[i].from]);
  if (elements.corners == 4) split->tetrahedra = s.elements;
  splitSprings(s, *split, result.springOf);
  splitSurface(s, *split);
  splitGroups(s, result.springOf, *split);
  result.network = std::move(split);
  return result;
}

// --- springs -----------------------------------------------------------------------------------------------

namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// A spring of the new network.
struct Part {
  NetworkSpring spring;
  std::uint32_t from;
};

class SpringSplitter {
 public:
  explicit SpringSplitter(const Separation& s) : s_(s), beside_(s.elements.size()) {
    for (const ElementPair& n : s.neighbours) {
      if (n.separated) continue;
      beside_[n.a].push_back(n.b);
      beside_[n.b].push_back(n.a);
    }
  }

  void split(std::uint32_t i, std::vector<Part>& parts) const {
    const NetworkSpring& spring = s_.before.springs[i];
    const bool divided = s_.divided(spring.a) || s_.divided(spring.b);
    if (!divided && (isHollow() ? !isSevered(spring) : !isNearCrack(spring.a))) {
      parts.push_back({spring, i});
      return;
    }
    const std::map<Pair, std::size_t> sides = sidesOf(spring);
    std::size_t sum = 0;
    for (const auto& [ends, count] : sides) sum += count;
    for (const auto& [ends, count] : sides)
      add(spring, i, ends, static_cast<double>(count) / static_cast<double>(sum), parts);
    if (!sides.empty()) return;
    Pair ends;
    if (isHollow() ? divided && findOpposite(spring, ends) : findNear(spring, ends))
      add(spring, i, ends, 1.0, parts);
  }

 private:
  static void add(const NetworkSpring& spring, std::uint32_t from, const Pair& ends, double share,
                  std::vector<Part>& parts) {
    NetworkSpring part = spring;
    part.a = std::min(ends.first, ends.second);
    part.b = std::max(ends.first, ends.second);
    part.stiffnessScale *= share;
    parts.push_back({part, from});
  }

  const std::vector<std::uint32_t>& around(std::uint32_t point) const { return s_.old.around[point]; }

  /// Returns the copies of both ends that elements have in common, with the number of these elements.
  std::map<Pair, std::size_t> sidesOf(const NetworkSpring& spring) const {
    std::map<Pair, std::size_t> sides;
    for (const std::uint32_t e : around(spring.a))
      if (const std::uint32_t b = cornerFrom(s_, e, spring.b); b != kNoPoint)
        ++sides[{cornerFrom(s_, e, spring.a), b}];
    return sides;
  }

  /// Finds the copies of the ends that the fewest facets separate. Springs against bending reach two facets
  /// far.
  bool findNear(const NetworkSpring& spring, Pair& ends) const {
    constexpr int kReach = 2;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> seen;  // elements with the copy of a
    for (const std::uint32_t e : around(spring.a)) seen.emplace_back(e, cornerFrom(s_, e, spring.a));
    std::size_t begin = 0;
    for (int step = 0; step <= kReach; ++step) {
      const std::size_t end = seen.size();
      for (std::size_t i = begin; i < end; ++i)
        if (const std::uint32_t b = cornerFrom(s_, seen[i].first, spring.b); b != kNoPoint) {
          ends = {seen[i].second, b};
          return true;
        }
      for (std::size_t i = begin; i < end; ++i)
        for (const std::uint32_t next : beside_[seen[i].first]) {
          const auto isNext = [&](const auto& element) { return element.first == next; };
          if (std::none_of(seen.begin(), seen.end(), isNext)) seen.emplace_back(next, seen[i].second);
        }
      begin = end;
    }
    return false;
  }

  /// Returns whether a body is held together by its surface and springs through its inside.
  bool isHollow() const { return s_.old.corners == 3 && s_.before.kind == NetworkKind::Solid; }

  /// Returns whether an element around the point has a divided corner.
  bool isNearCrack(std::uint32_t point) const {
    return std::any_of(around(point).begin(), around(point).end(), [&](std::uint32_t e) {
      const auto& corner = s_.old.all[e];
      return std::any_of(corner.begin(), corner.begin() + static_cast<std::ptrdiff_t>(s_.old.corners),
                         [&](std::uint32_t c) { return s_.divided(c); });
    });
  }

  /// Returns the side of a point of the new network: that of its elements which have one.
  int sideOf(std::uint32_t point) const {
    const std::uint32_t from = s_.points[point].from;
    int sum = 0;
    for (const std::uint32_t e : around(from))
      if (cornerFrom(s_, e, from) == point) sum += s_.request.side[e];
    return (sum > 0) - (sum < 0);
  }

  /// Returns whether a brace of a hollow body joins points on both sides of a cut.
  bool isSevered(const NetworkSpring& spring) const {
    if (sideOf(spring.a) * sideOf(spring.b) >= 0 || !sidesOf(spring).empty()) return false;
    return !s_.request.within ||
           s_.request.within(0.5 * (s_.request.place(spring.a) + s_.request.place(spring.b)));
  }

  /// Finds the copies of the ends of a brace inside a hollow body: on the same side, or where the triangles
  /// are nearest to the brace.
  bool findOpposite(const NetworkSpring& spring, Pair& ends) const {
    double best = -1e300;
    bool found = false;
    for (const std::uint32_t a : copiesOf(spring.a))
      for (const std::uint32_t b : copiesOf(spring.b)) {
        if (sideOf(a) * sideOf(b) < 0) continue;
        const double fit = leanOf(a, spring.b) + leanOf(b, spring.a);
        if (fit > best) ends = {a, b};
        best = std::max(best, fit);
        found = true;
      }
    return found;
  }

  std::vector<std::uint32_t> copiesOf(std::uint32_t point) const {
    return s_.divided(point) ? s_.copies[point] : std::vector<std::uint32_t>{point};
  }

  /// Returns how much the triangles of a copy lie towards another point.
  double leanOf(std::uint32_t copy, std::uint32_t towards) const {
    const std::uint32_t from = s_.points[copy].from;
    const std::vector<Vector3d>& x = s_.before.restPoints;
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t e : around(from))
      if (cornerFrom(s_, e, from) == copy)
        for (std::size_t c = 0; c < s_.old.corners; ++c) sum += x[s_.old.all[e][c]] - x[from];
    return sum.stableNormalized().dot((x[towards] - x[from]).stableNormalized());
  }

  const Separation& s_;
  std::vector<std::vector<std::uint32_t>> beside_;  // elements that hold to each element
};

}  // namespace

void splitSprings(const Separation& separation, SpringNetwork& network,
                  std::vector<std::uint32_t>& springOf) {
  const SpringSplitter splitter(separation);
  std::vector<Part> parts;
  for (std::uint32_t i = 0; i < separation.before.springs.size(); ++i) splitter.split(i, parts);
  std::stable_sort(parts.begin(), parts.end(), [](const Part& x, const Part& y) {
    return std::pair(x.spring.a, x.spring.b) < std::pair(y.spring.a, y.spring.b);
  });
  network.springs.clear();
  springOf.clear();
  for (const Part& part : parts) {
    network.springs.push_back(part.spring);
    springOf.push_back(part.from);
  }
}

}  // namespace limber
