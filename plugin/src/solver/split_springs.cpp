// SPDX-License-Identifier: Zlib

// This file gives the springs at divided points to the copies of these points.

#include "solver/split_parts.h"

#include <algorithm>
#include <map>
#include <utility>

namespace limber {

using Eigen::Vector3d;

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

  std::pair<const std::uint32_t*, const std::uint32_t*> around(std::uint32_t point) const {
    const std::uint32_t* all = s_.old.around.data();
    return {all + s_.old.firstOf[point], all + s_.old.firstOf[point + 1]};
  }

  /// Returns the copies of both ends that elements have in common, with the number of these elements.
  std::map<Pair, std::size_t> sidesOf(const NetworkSpring& spring) const {
    std::map<Pair, std::size_t> sides;
    const auto [first, last] = around(spring.a);
    for (const std::uint32_t* e = first; e != last; ++e)
      if (const std::uint32_t b = cornerFrom(s_, *e, spring.b); b != kNoPoint)
        ++sides[{cornerFrom(s_, *e, spring.a), b}];
    return sides;
  }

  /// Finds the copies of the ends that the fewest facets separate. Springs against bending reach two facets
  /// far.
  bool findNear(const NetworkSpring& spring, Pair& ends) const {
    constexpr int kReach = 2;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> seen;  // elements with the copy of a
    const auto [first, last] = around(spring.a);
    for (const std::uint32_t* e = first; e != last; ++e) seen.emplace_back(*e, cornerFrom(s_, *e, spring.a));
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
    const auto [first, last] = around(point);
    return std::any_of(first, last, [&](std::uint32_t e) {
      const auto& corner = s_.old.all[e];
      return std::any_of(corner.begin(), corner.begin() + static_cast<std::ptrdiff_t>(s_.old.corners),
                         [&](std::uint32_t c) { return s_.divided(c); });
    });
  }

  /// Returns the side of a point of the new network: that of its elements which have one.
  int sideOf(std::uint32_t point) const {
    const std::uint32_t from = s_.points[point].from;
    const auto [first, last] = around(from);
    int sum = 0;
    for (const std::uint32_t* e = first; e != last; ++e)
      if (cornerFrom(s_, *e, from) == point) sum += s_.request.side[*e];
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
    const auto [first, last] = around(from);
    Vector3d sum = Vector3d::Zero();
    for (const std::uint32_t* e = first; e != last; ++e)
      if (cornerFrom(s_, *e, from) == copy)
        for (std::size_t c = 0; c < s_.old.corners; ++c) sum += x[s_.old.all[*e][c]] - x[from];
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
