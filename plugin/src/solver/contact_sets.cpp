// SPDX-License-Identifier: Zlib
// Divides the rows of a large island into sets that several threads sweep at the same time, and numbers the
// point masses and rigid bodies of the rows.
#include "solver/contact_row.h"

#include <numeric>

namespace limber {
namespace {

using Eigen::Vector3d;

/// Number of rows that make a slab worth its share of the loops of a sweep, and the largest number of slabs:
/// thinner ones have too many rows across their boundaries.
constexpr std::size_t kRowsPerSlab = 400;
constexpr std::size_t kMaxRowSlabs = 8;

/// Returns a position (m) in the body. Soft bodies come first.
Vector3d placeOf(const LinkedBodies& bodies, std::size_t body) {
  if (body >= bodies.points.size()) return bodies.rigids[body - bodies.points.size()].position;
  return bodies.views[body].positionOf(0);
}

/// Counts the rows of each body.
void weigh(IslandConstraints& rows, const LinkedBodies& bodies) {
  rows.weights.assign(bodies.points.size() + bodies.rigids.size(), 0);
  for (const Contact& c : rows.contacts) {
    const RowBodies of = bodiesOf(c, bodies);
    ++rows.weights[of.a];
    if (of.b != of.a) ++rows.weights[of.b];
  }
}

/// Returns the axis along which the bodies with rows are spread most.
Eigen::Index longestAxis(const IslandConstraints& rows, const LinkedBodies& bodies) {
  Eigen::AlignedBox3d box;
  for (std::size_t b = 0; b < rows.weights.size(); ++b)
    if (rows.weights[b] > 0) box.extend(placeOf(bodies, b));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  return axis;
}

/// Sets rows.slabs: the bodies along an axis, in slabs with about as many rows each.
void cutSlabs(IslandConstraints& rows, const LinkedBodies& bodies, std::size_t slabs) {
  const Eigen::Index axis = longestAxis(rows, bodies);
  std::vector<std::uint32_t>& order = rows.byPlace;
  order.resize(rows.weights.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(placeOf(bodies, a)[axis], a) < std::pair(placeOf(bodies, b)[axis], b);
  });
  const std::size_t total = std::accumulate(rows.weights.begin(), rows.weights.end(), std::size_t{0});
  rows.slabs.resize(order.size());
  std::size_t sum = 0;
  for (const std::uint32_t body : order) {
    // by the middle of the body's rows
    rows.slabs[body] = static_cast<std::uint32_t>((2 * sum + rows.weights[body]) * slabs / (2 * total));
    sum += rows.weights[body];
  }
}

/// Numbers of sets: the slabs, then the boundaries between slabs 0 and 1, 2 and 3, ..., then those between 1
/// and 2, 3 and 4, ..., then all rows between slabs that are no neighbours.
std::size_t setOf(const IslandConstraints& rows, const Contact& c, const LinkedBodies& bodies,
                  std::size_t slabs) {
  const RowBodies of = bodiesOf(c, bodies);
  const auto [low, high] = std::minmax(rows.slabs[of.a], rows.slabs[of.b]);
  if (low == high) return low;
  if (high > low + 1) return 2 * slabs - 1;
  return slabs + low / 2 + (low % 2 == 0 ? 0 : slabs / 2);
}

/// Sorts the contacts by their sets, and within a set by their numbers.
void sortIntoSets(IslandConstraints& rows, const LinkedBodies& bodies, std::size_t slabs) {
  for (const Contact& c : rows.contacts) ++rows.sets[setOf(rows, c, bodies, slabs)].end;
  std::uint32_t begin = 0;
  for (RowSet& set : rows.sets) {
    const std::uint32_t count = set.end;
    set.begin = set.end = begin;
    begin += count;
  }
  for (std::uint32_t i = 0; i < rows.contacts.size(); ++i)
    rows.order[rows.sets[setOf(rows, rows.contacts[i], bodies, slabs)].end++] = i;
}

void makeOneSet(IslandConstraints& rows) {
  rows.sets.assign(1, RowSet());
  rows.sets[0].end = static_cast<std::uint32_t>(rows.contacts.size());
  rows.phases.assign(1, Range{0, 1});
  std::iota(rows.order.begin(), rows.order.end(), 0u);
}

void makeSets(IslandConstraints& rows, const LinkedBodies& bodies, std::size_t slabs) {
  const auto inside = static_cast<std::uint32_t>(slabs), odd = inside + inside / 2, rest = 2 * inside - 1;
  rows.sets.assign(2 * slabs, RowSet());
  rows.phases.assign({{0, inside}, {inside, odd}, {odd, rest}, {rest, rest + 1}});
  weigh(rows, bodies);
  cutSlabs(rows, bodies, slabs);
  sortIntoSets(rows, bodies, slabs);
}

}  // namespace

void divideRows(IslandConstraints& rows, const LinkedBodies& bodies) {
  const std::size_t count = rows.contacts.size(), bodyCount = bodies.points.size() + bodies.rigids.size();
  for (std::vector<std::uint32_t>* list : {&rows.order, &rows.active, &rows.swept}) {
    list->reserve(rows.contacts.capacity());
    list->resize(count);
  }
  std::size_t slabs = 1;
  if (rows.joints.empty() && bodies.anchors.empty())
    while (2 * slabs <= std::min(kMaxRowSlabs, bodyCount) && 2 * slabs * kRowsPerSlab <= count) slabs *= 2;
  if (slabs == 1)
    makeOneSet(rows);
  else
    makeSets(rows, bodies, slabs);
}

// --- nodes -------------------------------------------------------------------------------------------------

namespace {

/// Returns the number of the node with this velocity, a new one if it is not in the table yet.
std::uint32_t nodeWith(const double* velocity, IslandConstraints& rows) {
  auto& table = rows.nodeTable;
  const std::size_t mask = table.size() - 1;
  std::size_t place = reinterpret_cast<std::uintptr_t>(velocity) / sizeof(double) * 0x9E3779B97F4A7C15u >> 20;
  while (table[place & mask].first && table[place & mask].first != velocity) ++place;
  auto& [key, node] = table[place & mask];
  if (!key) {
    key = velocity;
    node = static_cast<std::uint32_t>(rows.nodes.size());
    rows.nodes.push_back({});
  }
  return node;
}

bool isOpposite(const IslandConstraints& rows, const ContactConstraint& row, std::uint32_t point,
                std::uint32_t support) {
  const double *n = row.axes[0], share = rows.points[point].share;
  const double cosine = along(rows.rows[support].axes[0], {n[0], n[1], n[2]});
  return share * cosine < -kOpposite * std::abs(share);
}

/// Sets `supportOf`, and `beside` of the rows.
void findSupports(IslandConstraints& rows) {
  constexpr std::uint32_t kNone = ConstraintNode::kNoSupport;
  std::vector<std::uint32_t>& ofNode = rows.weights;
  ofNode.assign(rows.nodes.size(), kNone);
  for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
    ContactConstraint& row = rows.rows[i];
    if (!isOfPoint(contactOf(rows, i)) || row.mass == 0.0) continue;
    std::uint32_t& other = ofNode[rows.nodeOf[row.firstPoint]];
    row.beside = other;
    if (other != kNone && rows.rows[other].beside == kNone) rows.rows[other].beside = i;
    other = i;
  }
  rows.supportOf.assign(rows.points.size(), kNone);
  rows.supported.resize(rows.points.size());
  for (std::uint32_t i = 0; i < rows.rows.size(); ++i) {
    const ContactConstraint& row = rows.rows[i];
    if (contactOf(rows, i).b.kind == ContactPoint::Kind::World) continue;
    for (std::uint32_t p = row.firstPoint; p < row.endPoint; ++p) {
      const std::uint32_t support = ofNode[rows.nodeOf[p]];
      if (support == kNone || !isOpposite(rows, row, p, support)) continue;
      rows.supportOf[p] = support;
      rows.rowNodes[i].isSupported = true;
    }
  }
}

}  // namespace

void numberNodes(IslandConstraints& rows, const LinkedBodies& bodies) {
  std::size_t size = 16;
  while (size < 2 * rows.points.size()) size *= 2;
  rows.nodeTable.assign(size, {nullptr, 0});
  rows.nodes.clear();
  rows.nodeOf.clear();
  for (const ConstraintPoint& p : rows.points) rows.nodeOf.push_back(nodeWith(p.velocity, rows));
  for (ConstraintRotation& r : rows.rotations) r.node = nodeWith(r.body->velocity.data(), rows);
  rows.rowNodes.clear();
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const RowBodies of = bodiesOf(contactOf(rows, i), bodies);
    rows.rowNodes.push_back(
        {of.a, of.b, rows.rows[i].firstPoint, rows.rows[i].endPoint, false, false, false, false});
  }
  findSupports(rows);
  rows.changedIn.resize(bodies.points.size() + bodies.rigids.size());
}

}  // namespace limber
