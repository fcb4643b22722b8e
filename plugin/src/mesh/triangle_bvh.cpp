// SPDX-License-Identifier: Zlib
// Builds the tree of boxes over the triangles of a surface and uses it for queries about rays, distances and
// insides.

#include "mesh/triangle_bvh.h"

namespace limber {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr std::uint32_t kLeafTriangles = 4;
/// Size of the stack of nodes to visit: one waits per level, and halving makes at most 32 levels.
constexpr std::size_t kBvhStack = 40;
/// A node is far at a distance of this many radii. The error of winding numbers is then some hundredths
/// (Barill et al. 2018 use 2).
constexpr double kFarRadii = 2.5;
/// Barycentric margin within which a line through an edge intersects both triangles, so that no line
/// passes between them.
constexpr double kEdgeMargin = 1e-9;
/// The same where crossings only cut a segment into pieces, which are then tested one by one. An additional
/// crossing does no harm, a missed one does.
constexpr double kCutMargin = 1e-6;
/// Barycentric coordinates, and fractions of a segment, beyond this pass through; below it they only touch.
constexpr double kInsideMargin = 1e-6;
/// Fraction of a chord at each end that staysInside() ignores.
constexpr double kEndFraction = 0.01;
/// Largest number of samples of a piece that runs along the surface.
constexpr int kMaxSamples = 16;

struct Span {
  double from, to;
};

/// Returns whether the line is inside the box somewhere between `span.from` and `span.to`, both in lengths of
/// `direction`.
bool overlapsBox(const AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction, Span span) {
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) return false;
      continue;
    }
    const double t0 = (box.min()[axis] - origin[axis]) / direction[axis];
    const double t1 = (box.max()[axis] - origin[axis]) / direction[axis];
    span.from = std::max(span.from, std::min(t0, t1));
    span.to = std::min(span.to, std::max(t0, t1));
  }
  return span.from <= span.to;
}

}  // namespace

TriangleBvh::TriangleBvh(const std::vector<Vector3d>& points, const std::vector<Triangle>& triangles)
    : order_(triangles.size()) {
  corners_.reserve(triangles.size());
  for (const Triangle& t : triangles) corners_.push_back(cornersOf(points, t));
  std::iota(order_.begin(), order_.end(), 0u);
  if (triangles.empty()) return;
  const auto count = static_cast<std::uint32_t>(triangles.size());
  margin_ = kCutMargin * boxOf(0, count).diagonal().norm();
  nodes_.reserve(triangles.size());
  nodes_.emplace_back();
  build(0, 0, count);
}

AlignedBox3d TriangleBvh::boxOf(std::uint32_t first, std::uint32_t count) const {
  AlignedBox3d box;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const Vector3d& corner : corners_[order_[i]]) box.extend(corner);
  }
  return AlignedBox3d(box.min().array() - margin_, box.max().array() + margin_);
}

/// Computes the dipole about the centre of area, where the quadrupole of a flat patch is smallest.
void TriangleBvh::setDipole(Node& node, std::uint32_t first, std::uint32_t count) const {
  double area = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (std::uint32_t i = first; i < first + count; ++i) {
    const TriangleCorners& t = corners_[order_[i]];
    const Vector3d vector = areaVector(t);
    node.areaNormal += vector;
    area += vector.norm();
    moment += vector.norm() / 3.0 * (t[0] + t[1] + t[2]);
  }
  node.centre = area > 0.0 ? Vector3d(moment / area) : Vector3d(node.box.center());
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const Vector3d& corner : corners_[order_[i]])
      node.radius = std::max(node.radius, (corner - node.centre).norm());
  }
}

/// Halves the triangles at the median of their centroids along the longest side of the box.
void TriangleBvh::build(std::uint32_t node, std::uint32_t first, std::uint32_t count) {
  nodes_[node].box = boxOf(first, count);
  setDipole(nodes_[node], first, count);
  const auto begin = order_.begin() + first;
  if (count <= kLeafTriangles) {
    nodes_[node].first = first;
    nodes_[node].count = count;
    std::sort(begin, begin + count);  // makes sums independent of the order that nth_element leaves
    return;
  }
  Eigen::Index axis = 0;
  nodes_[node].box.sizes().maxCoeff(&axis);
  const auto key = [&](std::uint32_t i) {
    return corners_[i][0][axis] + corners_[i][1][axis] + corners_[i][2][axis];
  };
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t i, std::uint32_t j) {
    return key(i) != key(j) ? key(i) < key(j) : i < j;
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = children;
  nodes_.resize(nodes_.size() + 2);
  build(children, first, count / 2);
  build(children + 1, first + count / 2, count - count / 2);
}

/// Visits the nodes that `enters` returns true for, and calls `visit` with the triangles of the leaves among
/// them. Of two children, `prefersSecond(inner node)` decides which one is visited first.
template <class Enters, class PrefersSecond, class Visit>
void TriangleBvh::traverse(Enters enters, PrefersSecond prefersSecond, Visit visit) const {
  std::array<std::uint32_t, kBvhStack> stack{};
  std::size_t size = nodes_.empty() ? 0 : 1;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if (!enters(node)) continue;
    if (node.count == 0) {
      const std::uint32_t second = prefersSecond(node) ? 1 : 0;
      stack[size++] = node.first + 1 - second;
      stack[size++] = node.first + second;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(order_[i]);
  }
}

/// Calls `visit` with each triangle that the segment from a (0) to b (1) intersects and the fraction of the
/// intersection. Barycentric coordinates down to -`margin` count.
template <class Visit>
void TriangleBvh::forEachCrossing(const Vector3d& a, const Vector3d& b, double margin, Visit visit) const {
  traverse(
      [&](const Node& node) {
        return overlapsBox(node.box, a, b - a, {0.0, 1.0});
      },
      [](const Node&) { return false; },
      [&](std::uint32_t triangle) {
        const auto hit = intersectLine(corners_[triangle], a, b - a, margin);
        if (hit) visit(triangle, hit->along);
      });
}

TriangleHit TriangleBvh::firstHit(const Vector3d& origin, const Vector3d& direction, double from,
                                  double to) const {
  TriangleHit hit;
  hit.distance = to;
  traverse(
      [&](const Node& node) {
        return overlapsBox(node.box, origin, direction, {from, hit.distance});
      },
      [&](const Node& node) {
        return direction.dot(nodes_[node.first + 1].centre - nodes_[node.first].centre) < 0.0;
      },
      [&](std::uint32_t triangle) {
        const auto found = intersectLine(corners_[triangle], origin, direction, kEdgeMargin);
        if (!found || found->along < from || found->along > hit.distance) return;
        if (found->along == hit.distance && triangle > hit.triangle) return;
        hit = {triangle, found->along, origin + found->along * direction, found->barycentric};
      });
  if (!hit) hit.distance = 0.0;
  return hit;
}

bool TriangleBvh::isPierced(const Vector3d& a, const Vector3d& b,
                            const std::function<bool(std::uint32_t)>& accepts) const {
  bool pierced = false;
  forEachCrossing(a, b, -kInsideMargin, [&](std::uint32_t triangle, double along) {
    pierced = pierced || (along > kInsideMargin && along < 1.0 - kInsideMargin && accepts(triangle));
  });
  return pierced;
}

TriangleHit TriangleBvh::nearestWithin(const Vector3d& position, double distance,
                                       const Vector3d& normal) const {
  struct Waiting {
    std::uint32_t node;
    double squared;  ///< m^2, of the distance of its box
  };
  const auto waiting = [&](std::uint32_t node) -> Waiting {
    const AlignedBox3d& box = nodes_[node].box;
    return {node, (box.min() - position).cwiseMax(position - box.max()).cwiseMax(0.0).squaredNorm()};
  };
  TriangleHit hit;
  double best = distance * distance;
  const auto visit = [&](std::uint32_t triangle) {
    const TriangleCorners& t = corners_[triangle];
    if (areaVector(t).dot(normal) < 0.0) return;
    const Vector3d barycentric = nearestBarycentric(t, position), foot = pointAt(t, barycentric);
    const double squared = (foot - position).squaredNorm();
    if (squared > best || (squared == best && triangle > hit.triangle)) return;
    best = squared;
    hit = {triangle, std::sqrt(squared), foot, barycentric};
  };
  std::array<Waiting, kBvhStack> stack;
  std::size_t size = 0;
  if (!nodes_.empty()) stack[size++] = waiting(0);
  while (size > 0) {
    const Waiting next = stack[--size];
    if (next.squared > best) continue;
    const Node& node = nodes_[next.node];
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(order_[i]);
    if (node.count > 0) continue;
    const Waiting first = waiting(node.first), second = waiting(node.first + 1);
    const bool secondIsNearer = first.squared > second.squared;
    stack[size++] = secondIsNearer ? first : second;
    stack[size++] = secondIsNearer ? second : first;
  }
  return hit;
}

double TriangleBvh::windingNumber(const Vector3d& position) const {
  double angle = 0.0;
  const auto entersNearNodes = [&](const Node& node) {
    const Vector3d offset = node.centre - position;
    const double distance = offset.norm();
    const bool isFar = distance > kFarRadii * node.radius;
    if (isFar) angle += offset.dot(node.areaNormal) / (distance * distance * distance);
    return !isFar;
  };
  traverse(
      entersNearNodes, [](const Node&) { return false; },
      [&](std::uint32_t triangle) { angle += solidAngle(corners_[triangle], position); });
  return angle / (4.0 * kPi);
}

/// The crossings cut the segment into pieces. A closed surface has each piece wholly on one side, so one
/// sample per piece would be enough. Three samples also detect most paths through a hole. More are used where
/// the piece runs along the surface, in a flat face, where rounding decides which crossings are found.
bool TriangleBvh::staysInside(const Vector3d& a, const Vector3d& b, double tolerance) const {
  const Vector3d from = a + kEndFraction * (b - a), to = b + kEndFraction * (a - b);
  const double length = (to - from).norm(), nearDistance = std::max(tolerance, margin_);
  std::vector<double> cuts{1.0};
  forEachCrossing(from, to, kCutMargin, [&](std::uint32_t, double along) {
    if (along > 0.0 && along < 1.0) cuts.push_back(along);
  });
  std::sort(cuts.begin(), cuts.end());
  double begin = 0.0;
  for (const double end : cuts) {
    const double pieceLength = (end - begin) * length;
    if (pieceLength > nearDistance) {
      const auto at = [&](double fraction) -> Vector3d {
        return from + (begin + fraction * (end - begin)) * (to - from);
      };
      const bool alongSurface = bool(nearestWithin(at(0.5), nearDistance));
      const int samplesByLength = static_cast<int>(std::min(pieceLength / nearDistance, double(kMaxSamples)));
      const int samples = alongSurface ? std::max(samplesByLength, 3) : 3;
      for (int i = 0; i < samples; ++i) {
        const Vector3d sample = at((i + 0.5) / samples);
        if (!nearestWithin(sample, nearDistance) && !inside(sample)) return false;
      }
    }
    begin = end;
  }
  return true;
}

}  // namespace limber
