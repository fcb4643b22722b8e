// SPDX-License-Identifier: Zlib

// This file prepares the rows of an island for the sweeps of contact_solver.cpp. It divides those of a large
// island into sets that several threads sweep at the same time, and numbers their point masses and rigid
// bodies. It adjusts contact points, so that opposite impulses at the two of a row act along one line.

#include "solver/contact_row.h"

#include <Eigen/LU>

#include <numeric>

namespace limber {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
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

// --- opposite impulses along one line ----------------------------------------------------------------------

namespace {

using ConstMap = Eigen::Map<const Vector3d>;

/// Largest share of a point. A contact point that needs a larger one stays in place until the next tick.
constexpr double kMaxShare = 1.25;

/// Largest displacement of a rigid body's contact point, as a share of its moment arm. Contacts over a larger
/// distance act at a point displaced by this much.
constexpr double kMaxArmChange = 0.3;

/// Collinear points: largest ratio of the squares of their extents in the two directions across the normal.
constexpr double kThin = 1e-6;

constexpr std::size_t kMaxRowPoints = 6;

/// The soft points of a row, in the axes of the row.
struct RowPoints {
  std::size_t count = 0;
  std::array<Vector3d, kMaxRowPoints>
      offset;                              ///< m, from the middle of the side: along the normal, then across
  Vector3d separation = Vector3d::Zero();  ///< m, from contact point b to a, likewise
  Matrix2d inverse;                        ///< 1/m^2, of M (see alignContactPoints)

  Vector2d momentArm(std::size_t i) const { return offset[i].tail<2>(); }
};

/// Adds the soft points from `first` to `end`.
void addSide(const IslandConstraints& rows, const ContactConstraint& row, std::uint32_t first,
             std::uint32_t end, const Vector3d& origin, RowPoints& points) {
  const std::size_t start = points.count;
  Vector3d middle = Vector3d::Zero();
  for (std::uint32_t i = first; i < end; ++i) {
    const Vector3d x = inAxes(row, ConstMap(rows.momentArms[i].position) - origin);
    points.separation += rows.points[i].share * x;
    points.offset[points.count++] = x;
    middle += x / double(end - first);
  }
  for (std::size_t i = start; i < points.count; ++i) points.offset[i] -= middle;
}

/// Returns the inverse of m, in which an eigenvalue v below `least` gives v / least^2 instead of 1 / v. Any
/// function f of a symmetric 2 x 2 matrix is the straight line through f at its eigenvalues, middle -+ half.
Matrix2d boundedInverse(const Matrix2d& m, double least) {
  const auto inverted = [&](double value) {
    return value > 0.0 ? std::min(1.0 / value, value / (least * least)) : 0.0;
  };
  const double middle = 0.5 * m.trace(), half = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  const double low = inverted(middle - half), high = inverted(middle + half);
  const double slope = half > 0.0 ? 0.5 * (high - low) / half : 0.0;
  return 0.5 * (low + high) * Matrix2d::Identity() + slope * (m - middle * Matrix2d::Identity());
}

/// Computes the inverse of M, or less where moment arms are shorter than `distance` (m): their impulses would
/// exceed that of the contact.
void invert(RowPoints& points, double distance) {
  Matrix2d m = Matrix2d::Zero();
  for (std::size_t i = 0; i < points.count; ++i) m += points.momentArm(i) * points.momentArm(i).transpose();
  const double least = std::max(distance * distance, kThin * m.trace());
  const double middle = 0.5 * m.trace(), determinant = m.determinant();
  const double smallest = middle - std::sqrt(std::max(0.0, middle * middle - determinant));
  points.inverse = smallest > least ? Matrix2d(m.inverse()) : boundedInverse(m, least);
}

/// Moves the soft contact points together across the normal, as far as kMaxShare allows. `first` is the row's
/// point with which `points` begins.
void moveShares(IslandConstraints& rows, std::uint32_t first, RowPoints& points) {
  const Vector2d correction = points.inverse * points.separation.tail<2>();
  std::array<double, kMaxRowPoints> shares;
  for (std::size_t i = 0; i < points.count; ++i) {
    shares[i] = rows.points[first + i].share - points.momentArm(i).dot(correction);
    if (!(std::abs(shares[i]) <= kMaxShare)) return;
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    points.separation -= points.momentArm(i).dot(correction) * points.offset[i];
    setShare(rows, first + static_cast<std::uint32_t>(i), shares[i]);
  }
}

void setMomentArm(const ContactConstraint& row, const Vector2d& across, MomentArm& momentArm) {
  for (int k = 0; k < 2; ++k) momentArm.across[k] = across[k];
  for (int k = 0; k < 3; ++k) momentArm.response[k] = momentArm.inverseMass[k] * row.axes[0][k];
}

void alignSoft(IslandConstraints& rows, const ContactConstraint& row) {
  const Vector3d origin = ConstMap(rows.momentArms[row.firstPoint].position);
  RowPoints points;
  addSide(rows, row, row.firstPoint, row.firstOfB, origin, points);
  addSide(rows, row, row.firstOfB, row.endPoint, origin, points);
  invert(points, points.separation[0]);
  moveShares(rows, row.firstPoint, points);
  for (std::size_t i = 0; i < points.count; ++i)
    setMomentArm(row, points.separation[0] * (points.inverse * points.momentArm(i)),
                 rows.momentArms[row.firstPoint + i]);
}

void alignRigid(IslandConstraints& rows, const ContactConstraint& row, const Contact& c) {
  const bool softIsA = c.a.kind == ContactPoint::Kind::Soft;
  ConstraintRotation& rotation = rows.rotations[row.firstRotation];
  Vector3d arm = softIsA ? c.b.arm : c.a.arm;
  const Vector3d origin = rotation.body->position + arm;
  RowPoints points;
  if (softIsA)
    addSide(rows, row, row.firstPoint, row.firstOfB, origin, points);
  else
    addSide(rows, row, row.firstOfB, row.endPoint, origin, points);
  invert(points, 0.0);
  moveShares(rows, softIsA ? row.firstPoint : row.firstOfB, points);
  const double sign = softIsA ? -1.0 : 1.0;
  const double maxDistance = kMaxArmChange * arm.norm(), distance = points.separation.norm();
  if (distance > maxDistance) points.separation *= maxDistance / distance;
  for (int k = 0; k < 3; ++k) arm -= sign * points.separation[k] * ConstMap(row.axes[k]);
  for (int k = 0; k < 3; ++k) {
    const Vector3d speeds = sign * arm.cross(ConstMap(row.axes[k]));
    Eigen::Map<Vector3d>(rotation.speeds[k]) = speeds;
    Eigen::Map<Vector3d>(rotation.response[k]) =
        rotation.inverseFactor * (rotation.body->inverseInertia * speeds);
  }
}

/// Returns the mobility of a point that is free along all axes. With its share s, its inverse mass w, and the
/// weights l of its normal speed in the two tangential ones it is  w B^T B,  B = s 1 + n l^T.
Mobility freeMobility(const ConstraintPoint& point, const MomentArm& momentArm) {
  const double along = point.response[0], both = point.share * along;  // s w, s^2 w
  const double w = momentArm.inverseMass ? momentArm.inverseMass[0] : 0.0;
  const double u = momentArm.across[0], v = momentArm.across[1];
  return {both, along * u, along * v, both + w * u * u, w * u * v, both + w * v * v};
}

/// The same for a point that moves more easily along some of the world's axes.
Mobility boundMobility(const ContactConstraint& row, const ConstraintPoint& point,
                       const MomentArm& momentArm) {
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  const Vector3d across(0.0, momentArm.across[0], momentArm.across[1]);
  const Matrix3d changes =
      ConstMap(point.response).asDiagonal() * axes + ConstMap(momentArm.response) * across.transpose();
  return Mobility::from((point.share * axes + axes.col(0) * across.transpose()).transpose() * changes);
}

Mobility momentArmMobility(const IslandConstraints& rows, const ContactConstraint& row) {
  Mobility mobility;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const ConstraintPoint& point = rows.points[i];
    const double* r = point.response;
    const bool isFree = r[0] == r[1] && r[1] == r[2];
    mobility +=
        isFree ? freeMobility(point, rows.momentArms[i]) : boundMobility(row, point, rows.momentArms[i]);
  }
  for (std::uint32_t i = row.firstRotation; i < row.endRotation; ++i)
    mobility += Mobility::from(Eigen::Map<const Matrix3d>(rows.rotations[i].speeds[0]).transpose() *
                               Eigen::Map<const Matrix3d>(rows.rotations[i].response[0]));
  return mobility;
}

}  // namespace

/// Let D = sum s_i x_i be the offset from contact point b to a, with the points' shares s_i (negative on b).
/// Opposite impulses J at both contact points are a couple D x J. With the points' offsets y_i across the
/// normal n from the middle of their side, M = sum y_i y_i^T, and D = d n + T,
///     s_i -= y_i . M^-1 T          moves the contact points until T is 0, and
///     J_i = s_i J + n (l_i . J),   l_i = d M^-1 y_i,
/// balances the remaining couple d n x J with the moment arms of edges and triangles. Neither changes the sum
/// over a side, and both changes are the smallest possible. The relative tangential speed grows by
/// sum l_i (n . v_i): the surfaces touch halfway, and rotate. A rigid body's contact point moves by the rest
/// that soft points cannot correct.
void alignContactPoints(IslandConstraints& rows, std::size_t index) {
  ContactConstraint& row = rows.rows[index];
  if (row.aligned) return;
  row.aligned = true;
  rows.rowNodes[index].knowsSupports = false;
  if (row.couple == Couple::Soft)
    alignSoft(rows, row);
  else
    alignRigid(rows, row, contactOf(rows, index));
  // with masses that are too large the sweeps would diverge
  setMobility(row, momentArmMobility(rows, row));
}

}  // namespace limber
