// SPDX-License-Identifier: Zlib
#include "collide/surface.h"

#include <cmath>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Sorts elements along the longest side of the box of their centres. A full sort, not nth_element: the tree
/// does not depend on the standard library.
void sortAlongBox(std::uint32_t* begin, std::uint32_t* end, const std::vector<Vector3d>& centres) {
  Eigen::AlignedBox3d box;
  std::for_each(begin, end, [&](std::uint32_t i) { box.extend(centres[i]); });
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  std::sort(begin, end, [&](std::uint32_t i, std::uint32_t j) {
    const double x = centres[i][axis], y = centres[j][axis];
    return x != y ? x < y : i < j;
  });
}

SweptBox pointBox(const MovingSurface& surface, Eigen::Index point) {
  Eigen::Array4d start, motion;
  start << surface.position->col(point), 0.0;
  motion << surface.motion->col(point), 0.0;
  const Eigen::Array4d end = start + motion, radius(surface.radius, surface.radius, surface.radius, 0.0);
  return {start.min(end) - radius, start.max(end) + radius};
}

SweptBox elementBox(const MovingSurface& surface, const SurfaceElement& element,
                    const std::vector<SweptBox>& points) {
  const auto& [a, b, c] = element.corners;
  SweptBox box = merged(merged(points[a], points[b]), points[c]);
  const std::uint32_t triangle = element.triangle;
  if (triangle == kNoFeature || !surface.topology->oneSided[triangle]) return box;
  const Vector3d first = surface.position->col(a);
  const Vector3d area = (surface.position->col(b) - first).cross(surface.position->col(c) - first);
  const double length = area.norm();
  if (length == 0.0) return box;
  Eigen::Array4d depth(area.x(), area.y(), area.z(), 0.0);
  depth *= surface.topology->depthLimit[triangle] / length;
  box.low -= depth.max(0.0);
  box.high -= depth.min(0.0);
  return box;
}

bool isLeaf(const SurfaceNode& node) { return node.element != kNoFeature; }

double sizeOf(const SweptBox& box) { return (box.high - box.low).maxCoeff(); }

/// m^2
double squaredDistance(const SweptBox& box, const Eigen::Array4d& point) {
  return (box.low - point).max(point - box.high).max(0.0).matrix().squaredNorm();
}

/// Replaces a pair of nodes by the pairs with the children of the larger node.
void descend(const MovingSurface& a, const MovingSurface& b, std::uint32_t i, std::uint32_t j,
             LeafPairs& waiting) {
  const SurfaceNode &na = a.topology->nodes[i], &nb = b.topology->nodes[j];
  if (isLeaf(nb) || (!isLeaf(na) && sizeOf(a.boxes->nodes[i]) >= sizeOf(b.boxes->nodes[j]))) {
    waiting.emplace_back(na.child + 1, j);
    waiting.emplace_back(na.child, j);
  } else {
    waiting.emplace_back(i, nb.child + 1);
    waiting.emplace_back(i, nb.child);
  }
}

/// Replaces a pair of equal nodes by the pairs of its children.
void descendIntoOne(const SurfaceNode& node, LeafPairs& waiting) {
  if (isLeaf(node)) return;
  waiting.emplace_back(node.child + 1, node.child + 1);
  waiting.emplace_back(node.child, node.child + 1);
  waiting.emplace_back(node.child, node.child);
}

/// Calls visit(i, j) for the pairs of leaves within `margin` of each other, until it returns false.
template <class Visit>
void forEachNear(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                 Visit visit) {
  const bool self = &a == &b;
  const std::vector<SurfaceNode>&nodesA = a.topology->nodes, &nodesB = b.topology->nodes;
  waiting.clear();
  if (!nodesA.empty() && !nodesB.empty()) waiting.emplace_back(0, 0);
  while (!waiting.empty()) {
    const auto [i, j] = waiting.back();
    waiting.pop_back();
    if (self && i == j) {
      descendIntoOne(nodesA[i], waiting);
    } else if (separation(a.boxes->nodes[i], b.boxes->nodes[j]) <= margin) {
      if (!isLeaf(nodesA[i]) || !isLeaf(nodesB[j]))
        descend(a, b, i, j, waiting);
      else if (!visit(i, j))
        return;
    }
  }
}

/// Returns the sum of the normals around a vertex or an edge or of a triangle (where no weight is 0), each
/// weighted with its angle there. With it the sign of the distance is the same for all triangles that share
/// the nearest point (Baerentzen, Aanaes 2005).
Vector3d pseudonormal(const MovingSurface& surface, std::uint32_t triangle, const Vector3d& barycentric) {
  const SurfaceTopology& t = *surface.topology;
  const Triangle& corners = t.triangles[triangle];
  Eigen::Index largest = 0;
  barycentric.maxCoeff(&largest);
  const std::uint32_t anchor = corners[static_cast<std::size_t>(largest)];
  const bool atVertex = (barycentric.array() > 0.0).count() == 1;
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t* i = t.trianglesAround.begin(anchor); i != t.trianglesAround.end(anchor); ++i) {
    const Triangle& other = t.triangles[*i];
    const auto find = [&](std::uint32_t v) { return std::find(other.begin(), other.end(), v); };
    bool around = true;
    for (std::size_t k = 0; k < 3; ++k)
      around =
          around && (barycentric[static_cast<Eigen::Index>(k)] <= 0.0 || find(corners[k]) != other.end());
    if (!around) continue;
    const auto feature = featureOf<3>(surface, other);
    const auto k = static_cast<Eigen::Index>(find(anchor) - other.begin());
    const Vector3d u = feature.start.col((k + 1) % 3) - feature.start.col(k);
    const Vector3d v = feature.start.col((k + 2) % 3) - feature.start.col(k);
    const double angle = atVertex ? std::atan2(u.cross(v).norm(), u.dot(v)) : 1.0;
    sum += angle * normalOf<3>(feature.start);
  }
  return sum;
}

}  // namespace

std::vector<SurfaceNode> makeSurfaceTree(const Points& rest, const std::vector<SurfaceElement>& elements) {
  struct Range {
    std::size_t node, first, end;
  };
  if (elements.empty()) return {};
  std::vector<Vector3d> centres;
  centres.reserve(elements.size());
  for (const SurfaceElement& e : elements)
    centres.push_back((rest.col(e.corners[0]) + rest.col(e.corners[1]) + rest.col(e.corners[2])) / 3.0);
  std::vector<std::uint32_t> order(elements.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<SurfaceNode> nodes(1);
  std::vector<Range> waiting{{0, 0, elements.size()}};
  while (!waiting.empty()) {
    const auto [node, first, end] = waiting.back();
    waiting.pop_back();
    if (end - first == 1) {
      nodes[node].element = order[first];
      continue;
    }
    sortAlongBox(order.data() + first, order.data() + end, centres);
    const std::size_t child = nodes.size(), middle = first + (end - first) / 2;
    nodes[node].child = static_cast<std::uint32_t>(child);
    nodes.resize(child + 2);
    waiting.push_back({child + 1, middle, end});
    waiting.push_back({child, first, middle});
  }
  return nodes;
}

SweptBox sweptBounds(const MovingSurface& surface) {
  SweptBox box;
  Eigen::Array3d low = box.low.head<3>(), high = box.high.head<3>();
  for (const std::uint32_t v : surface.topology->vertices) {
    const Eigen::Array3d start = surface.position->col(v), end = start + surface.motion->col(v).array();
    low = low.min(start).min(end);
    high = high.max(start).max(end);
  }
  box.low << low - surface.radius, 0.0;
  box.high << high + surface.radius, 0.0;
  return box;
}

void fitBoxes(const MovingSurface& surface, SurfaceBoxes& boxes) {
  const SurfaceTopology& t = *surface.topology;
  boxes.points.resize(static_cast<std::size_t>(surface.position->cols()));
  for (std::size_t i = 0; i < boxes.points.size(); ++i)
    boxes.points[i] = pointBox(surface, static_cast<Eigen::Index>(i));
  boxes.vertices = SweptBox();
  for (const std::uint32_t v : t.vertices) boxes.vertices = merged(boxes.vertices, boxes.points[v]);
  boxes.nodes.resize(t.nodes.size());
  for (std::size_t i = t.nodes.size(); i-- > 0;) {
    const SurfaceNode& node = t.nodes[i];
    boxes.nodes[i] = isLeaf(node) ? elementBox(surface, t.elements[node.element], boxes.points)
                                  : merged(boxes.nodes[node.child], boxes.nodes[node.child + 1]);
  }
}

void findNearLeaves(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting,
                    LeafPairs& near) {
  const bool self = &a == &b;
  near.clear();
  forEachNear(a, b, margin, waiting, [&](std::uint32_t i, std::uint32_t j) {
    near.push_back(self ? LeafPairs::value_type(std::minmax(i, j)) : LeafPairs::value_type(i, j));
    return true;
  });
}

bool areLeavesNear(const MovingSurface& a, const MovingSurface& b, double margin, LeafPairs& waiting) {
  bool found = false;
  forEachNear(a, b, margin, waiting, [&](std::uint32_t, std::uint32_t) {
    found = true;
    return false;
  });
  return found;
}

NearestOnSurface nearestOnSurface(const MovingSurface& surface, const Vector3d& point, double within) {
  const SurfaceTopology& t = *surface.topology;
  const std::vector<SweptBox>& boxes = surface.boxes->nodes;
  Eigen::Array4d point4;
  point4 << point, 0.0;
  NearestOnSurface nearest;
  double best = within * within;
  std::array<std::uint32_t, kNodeStack> stack{};
  std::size_t waiting = boxes.empty() ? 0 : 1;
  while (waiting > 0) {
    const std::uint32_t i = stack[--waiting];
    if (squaredDistance(boxes[i], point4) > best) continue;
    const SurfaceNode& node = t.nodes[i];
    if (!isLeaf(node)) {
      const bool firstIsNearer =
          squaredDistance(boxes[node.child], point4) <= squaredDistance(boxes[node.child + 1], point4);
      stack[waiting++] = firstIsNearer ? node.child + 1 : node.child;
      stack[waiting++] = firstIsNearer ? node.child : node.child + 1;
      continue;
    }
    const std::uint32_t triangle = t.elements[node.element].triangle;
    if (triangle == kNoFeature) continue;
    const auto corners = featureOf<3>(surface, t.triangles[triangle]).start;
    const Vector3d weights = nearestBarycentric({corners.col(0), corners.col(1), corners.col(2)}, point);
    const double squared = (corners * weights - point).squaredNorm();
    if (squared > best || (squared == best && triangle > nearest.triangle)) continue;
    best = squared;
    nearest.triangle = triangle;
    nearest.barycentric = weights;
  }
  if (nearest.triangle == kNoFeature) return nearest;
  const Vector3d away =
      point - featureOf<3>(surface, t.triangles[nearest.triangle]).start * nearest.barycentric;
  nearest.distance = std::sqrt(best);
  nearest.behind = away.dot(pseudonormal(surface, nearest.triangle, nearest.barycentric)) < 0.0;
  return nearest;
}

}  // namespace limber
