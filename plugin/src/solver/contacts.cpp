// SPDX-License-Identifier: Zlib
// Prepares the rows of contacts and joints, and updates them to the motion of the bodies in the substeps.
#include "solver/contacts.h"

#include "mesh/surface.h"
#include "solver/contact_row.h"

#include <Eigen/LU>

namespace limber {
namespace {

/// The same as kSoftness, for friction.
constexpr double kFrictionSoftness = 0.05;

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Map = Eigen::Map<Vector3d>;
using ConstMap = Eigen::Map<const Vector3d>;

void addPoint(IslandConstraints& rows, double* velocity, const Vector3d& inverseMass, double share) {
  const Vector3d response = share * inverseMass;
  rows.points.push_back({velocity, share, {response[0], response[1], response[2]}});
  rows.momentArms.push_back({});
}

void setSpeeds(ConstraintRotation& rotation, const ContactConstraint& row, const Vector3d& arm) {
  for (int k = 0; k < 3; ++k) Map(rotation.speeds[k]) = arm.cross(ConstMap(row.axes[k]));
}

constexpr double kNoInverseMass[3] = {0.0, 0.0, 0.0};

/// Finds the points that are anchored to immovable bodies. Contacts must not push them: the anchor would
/// cancel each push in the next sweep.
void findAnchored(IslandConstraints& rows, const LinkedBodies& bodies) {
  rows.anchored.clear();
  for (const LinkAnchor& anchor : bodies.anchors)
    if (anchor.held) rows.anchored.emplace_back(anchor.point.body, anchor.point.point);
  std::sort(rows.anchored.begin(), rows.anchored.end());
}

/// 1/kg per axis.
const double* inverseMassOf(const IslandConstraints& rows, const PointView& view, std::uint32_t body,
                            std::uint32_t point) {
  const bool anchored =
      std::binary_search(rows.anchored.begin(), rows.anchored.end(), std::pair(body, point));
  return anchored ? kNoInverseMass : view.inverseMassOf(point).data();
}

/// Returns whether joints act on the side's soft body as a whole.
bool isFramed(const LinkedBodies& bodies, const ContactPoint& side) {
  return side.kind == ContactPoint::Kind::Soft &&
         std::any_of(bodies.frames.begin(), bodies.frames.end(),
                     [&](const BodyFrame& frame) { return frame.body == side.body; });
}

/// Makes room for all scaled masses: rows point to them.
void reserveScaledMasses(IslandConstraints& rows) {
  std::size_t count = 0;
  for (const Contact& c : rows.contacts)
    for (const ContactPoint* side : {&c.a, &c.b}) count += side->massFactor != 1.0 ? side->count : 0;
  rows.scaledMasses.clear();
  rows.scaledMasses.reserve(count);
}

/// Adds one side of a contact; `sign` is 1 for a and -1 for b.
void addContactPoint(IslandConstraints& rows, ContactConstraint& row, LinkedBodies& bodies,
                     const ContactPoint& side, double sign) {
  row.surfaceSpeeds +=
      ContactVector::from(inAxes(row, sign * (side.velocity + rows.time * side.acceleration)));
  if (side.kind == ContactPoint::Kind::World) return;
  if (side.kind == ContactPoint::Kind::Soft) {
    const PointView& view = bodies.views[side.body];
    for (std::uint32_t i = 0; i < side.count; ++i) {
      const double* inverseMass = inverseMassOf(rows, view, side.body, side.point[i]);
      if (side.massFactor != 1.0)
        inverseMass = rows.scaledMasses.emplace_back(ConstMap(inverseMass) / side.massFactor).data();
      addPoint(rows, view.velocityOf(side.point[i]).data(), ConstMap(inverseMass), sign * side.weight[i]);
      rows.momentArms.back().position = view.positionOf(side.point[i]).data();
      rows.momentArms.back().inverseMass = inverseMass;
    }
  } else {
    RigidState& rigid = bodies.rigids[side.body];
    addPoint(rows, rigid.velocity.data(), rigid.inverseMass / side.massFactor, sign);
    rows.rotations.push_back({&rigid, 0, 1.0 / side.massFactor, {}, {}});
    setSpeeds(rows.rotations.back(), row, sign * side.arm);
  }
}

ContactVector inAxes(const ContactConstraint& row, const ContactImpulse& impulse) {
  const Vector3d across = inAxes(row, impulse.across);
  return {impulse.along, across[1], across[2]};
}

ContactImpulse impulseOfVector(const ContactConstraint& row, const ContactVector& v) {
  return {v.n, v.u * ConstMap(row.axes[1]) + v.v * ConstMap(row.axes[2])};
}

Couple coupleOf(const Contact& c) {
  using Kind = ContactPoint::Kind;
  if (c.a.kind == Kind::Soft && c.b.kind == Kind::Soft)
    return c.a.count + c.b.count > 2 ? Couple::Soft : Couple::None;
  const bool both = c.a.kind != Kind::World && c.b.kind != Kind::World;
  return both && c.a.kind != c.b.kind ? Couple::Rigid : Couple::None;
}

void setAxes(ContactConstraint& row, const Vector3d& normal) {
  const Vector3d tangent = normal.unitOrthogonal();
  Matrix3d axes;
  axes << normal, tangent, normal.cross(tangent);
  for (int k = 0; k < 3; ++k) Map(row.axes[k]) = axes.col(k);
}

/// 1/kg, 3 x 3: the change of the relative velocity of a contact's two points per impulse there.
Matrix3d mobilityOf(const IslandConstraints& rows, const ContactConstraint& row, const Contact& c,
                    const LinkedBodies& bodies) {
  Matrix3d m = Matrix3d::Zero();
  for (const ContactPoint* side : {&c.a, &c.b})
    if (side->kind == ContactPoint::Kind::Rigid)
      m += bodies.rigids[side->body].mobilityAt(side->arm) / side->massFactor;
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i)
    if (const double* inverseMass = rows.momentArms[i].inverseMass)
      m.diagonal() += rows.points[i].share * rows.points[i].share * ConstMap(inverseMass);
  return m;
}

void disable(ContactConstraint& row) { row.mass = row.mobility = 0.0; }

/// Least sum of the weights of the free corners of an edge or triangle.
constexpr double kMinFreeWeight = 0.02;

/// One side of a contact: its corners, or what is static or kinematic.
struct ContactCorners {
  std::uint32_t first, end;  ///< into `points`; empty: static or kinematic
  double sign;
  double free = 0.0;    ///< sum of the weights of corners that can move
  bool pinned = false;  ///< one cannot
  double height = 0.0;  ///< m along the normal, of the point in contact
};

bool isPinned(const IslandConstraints& rows, std::uint32_t i) {
  const double* inverseMass = rows.momentArms[i].inverseMass;
  return inverseMass && ConstMap(inverseMass).isZero(0.0);
}

double heightOf(const IslandConstraints& rows, const ContactConstraint& row, std::uint32_t i) {
  const double* position = rows.momentArms[i].position;
  return position ? ConstMap(row.axes[0]).dot(ConstMap(position)) : 0.0;
}

ContactCorners cornersOf(const IslandConstraints& rows, const ContactConstraint& row, std::uint32_t first,
                         std::uint32_t end, double sign) {
  ContactCorners side{first, end, sign};
  for (std::uint32_t i = first; i < end; ++i) {
    side.height += sign * rows.points[i].share * heightOf(rows, row, i);
    if (isPinned(rows, i))
      side.pinned = true;
    else
      side.free += sign * rows.points[i].share;
  }
  return side;
}

/// A corner that cannot be moved.
struct PinnedCorner {
  double weight;
  double height = 0.0;  ///< m, above the point in contact
  Vector3d velocity;    ///< m/s, along the row's axes
};

template <class Visit>
void forEachPinned(const IslandConstraints& rows, const ContactConstraint& row, const ContactCorners& side,
                   Visit visit) {
  const Vector3d surface(row.surfaceSpeeds.n, row.surfaceSpeeds.u, row.surfaceSpeeds.v);
  if (side.first == side.end) visit(PinnedCorner{1.0, 0.0, side.sign * surface});
  for (std::uint32_t i = side.first; i < side.end; ++i)
    if (isPinned(rows, i))
      visit(PinnedCorner{side.sign * rows.points[i].share, heightOf(rows, row, i) - side.height,
                         inAxes(row, ConstMap(rows.points[i].velocity))});
}

/// Excludes the overlap of pinned corners from the gap, because no impulse can remove it. The overlap falls
/// linearly from d at a pinned corner to 0 at a free one. To remove it at a point where the free corner has a
/// small weight e, that corner would have to move by d / e. So each free corner removes only its own overlap,
/// and likewise stops only its own approach and sliding. A contact with less than kMinFreeWeight on the free
/// corners of either side is disabled. Pins take up angular momentum, so no couple is balanced.
void excludePinned(IslandConstraints& rows, ContactConstraint& row) {
  row.pinned = 0.0;
  if (row.firstRotation != row.endRotation) return;
  const ContactCorners a = cornersOf(rows, row, row.firstPoint, row.firstOfB, 1.0);
  const ContactCorners b = cornersOf(rows, row, row.firstOfB, row.endPoint, -1.0);
  if (a.pinned || b.pinned) row.couple = Couple::None;
  if (std::max(a.free, b.free) < kMinFreeWeight) return disable(row);
  Vector3d speeds = Vector3d::Zero();
  forEachPinned(rows, row, a, [&](const PinnedCorner& ofA) {
    forEachPinned(rows, row, b, [&](const PinnedCorner& ofB) {
      const double weight = ofA.weight * ofB.weight;
      const Vector3d speed = ofA.velocity - ofB.velocity;
      row.pinned += weight * std::min(0.0, row.gap + ofA.height - ofB.height);
      speeds += weight * Vector3d(std::min(0.0, speed.x()), speed.y(), speed.z());
    });
  });
  row.gap -= row.pinned;
  row.surfaceSpeeds += ContactVector::from(-speeds);
}

void prepareRow(IslandConstraints& rows, ContactConstraint& row, const Contact& c, LinkedBodies& bodies) {
  setAxes(row, c.normal);
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  row.surfaceSpeeds = ContactVector();
  row.firstPoint = static_cast<std::uint32_t>(rows.points.size());
  row.firstRotation = static_cast<std::uint32_t>(rows.rotations.size());
  addContactPoint(rows, row, bodies, c.a, 1.0);
  row.firstOfB = static_cast<std::uint32_t>(rows.points.size());
  addContactPoint(rows, row, bodies, c.b, -1.0);
  row.endPoint = static_cast<std::uint32_t>(rows.points.size());
  row.endRotation = static_cast<std::uint32_t>(rows.rotations.size());
  setMobility(row, Mobility::from(axes.transpose() * mobilityOf(rows, row, c, bodies) * axes));
  if (c.ended) row.mass = row.mobility = 0.0;
  row.couple = coupleOf(c);
  row.gap = c.gap;
  row.ofPoint = isOfPoint(c);
  row.rigidA = c.a.kind == ContactPoint::Kind::Rigid;
  row.restitutes = c.restitution > 0.0;
  row.recoverySpeed = c.recoverySpeed;
  row.workFactor = recoveryWorkFactor(c, !bodies.anchors.empty(), isFramed(bodies, c.a));
  excludePinned(rows, row);
  row.aligned = row.couple == Couple::None;
  row.friction = c.friction;
  row.positionImpulse = inAxes(row, c.positionImpulse);
  row.velocityImpulse = inAxes(row, c.velocityImpulse);
  row.impulse = ContactVector();
  row.bounces = false;
  row.beside = ContactConstraint::kNoRow;
}

/// Adds the row's impulse since the last change of its normal to the impulse of the contact.
void flushImpulse(Contact& c, ContactConstraint& row) {
  const Vector3d normal = ConstMap(row.axes[0]);
  c.impulse.add(row.impulse.n * normal + impulseOfVector(row, row.impulse).across, normal, row.impulse.n);
  row.impulse = ContactVector();
}

/// Sets a new normal. The impulses remain as warm start if the new normal is close to the old one.
void setNormal(Contact& c, ContactConstraint& row, const Vector3d& normal) {
  constexpr double kSameSurfaceCosine = 0.9;
  flushImpulse(c, row);
  if (normal.dot(ConstMap(row.axes[0])) < kSameSurfaceCosine)
    row.positionImpulse = row.velocityImpulse = ContactVector();
  setAxes(row, normal);
}

/// Moves the contact to another plane, with `weights` as the shares of its points.
void moveRow(IslandConstraints& rows, std::size_t index, const Vector3d& normal, double gap,
             const double* weights) {
  ContactConstraint& row = rows.rows[index];
  Contact& contact = contactOf(rows, index);
  setNormal(contact, row, normal);
  const Vector3d beltSpeeds = inAxes(row, contact.b.velocity);
  row.surfaceSpeeds = {0.0, 0.0 - beltSpeeds[1], 0.0 - beltSpeeds[2]};
  row.gap = gap;
  Vector3d mobility = Vector3d::Zero();
  for (std::uint32_t i = row.firstPoint; i < row.endPoint; ++i) {
    const double share = weights[i - row.firstPoint];
    setShare(rows, i, share);
    mobility += share * share * ConstMap(rows.momentArms[i].inverseMass);
  }
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  setMobility(row, Mobility::from(axes.transpose() * mobility.asDiagonal() * axes));
  excludePinned(rows, row);
}

void followPlane(IslandConstraints& rows, std::size_t index) {
  const ContactConstraint& row = rows.rows[index];
  const PlaneContact& held = *contactOf(rows, index).held;
  if (held.away) return disable(rows.rows[index]);
  const double fullWeight = 1.0;
  const ConstMap x(rows.momentArms[row.firstPoint].position);
  moveRow(rows, index, held.normal, held.normal.dot(x - held.touch), &fullWeight);
}

/// The point of a soft feature that is nearest to held corners. `offset` leads there from the corners;
/// `normal` has the direction of the contact.
struct NearestFeature {
  std::array<double, 3> weights{};
  Vector3d offset, normal;
  bool inside = false;  ///< the nearest points are inside both features, not at their ends
};

NearestFeature nearestEdge(const Vector3d& a, const Vector3d& b, const HeldCorners& held) {
  const bool isEdge = held.count == 2;
  const Vector3d edge = isEdge ? Vector3d(held.at[1] - held.at[0]) : Vector3d::Zero();
  const SegmentPair along = isEdge ? nearestOnSegments(a, b, held.at[0], held.at[1])
                                   : SegmentPair{nearestOnSegment(a, b, held.at[0]), 0.5};
  const Vector3d offset = a + along.a * (b - a) - held.at[0] - along.b * edge;
  return {{1.0 - along.a, along.a, 0.0},
          offset,
          isEdge ? Vector3d((b - a).cross(edge)) : offset,
          along.a > 0.0 && along.a < 1.0 && along.b > 0.0 && along.b < 1.0};
}

/// Share of its size by which a triangle carries a corner beyond its edges. Between two triangles in one
/// plane there is no other contact, and the next search finds the corner on the second one.
constexpr double kBeyondEdge = 0.01;

NearestFeature nearestTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                               const HeldCorners& held) {
  const Vector3d weights = nearestBarycentric({a, b, c}, held.at[0]), normal = (b - a).cross(c - a);
  const Vector3d offset = weights[0] * a + weights[1] * b + weights[2] * c - held.at[0];
  const double beyond = normal.cross(offset).squaredNorm(),
               squaredSize = (b - a).squaredNorm() + (c - a).squaredNorm();
  return {{weights[0], weights[1], weights[2]},
          offset,
          normal,
          beyond <= kBeyondEdge * kBeyondEdge * squaredSize * normal.squaredNorm()};
}

void followCorners(IslandConstraints& rows, std::size_t index) {
  ContactConstraint& row = rows.rows[index];
  const HeldCorners& held = contactOf(rows, index).corners;
  const std::uint32_t count = row.endPoint - row.firstPoint;
  std::array<Vector3d, 3> x{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  for (std::uint32_t i = 0; i < count; ++i) x[i] = ConstMap(rows.momentArms[row.firstPoint + i].position);
  const NearestFeature f =
      count == 3 ? nearestTriangle(x[0], x[1], x[2], held) : nearestEdge(x[0], x[1], held);
  const double length = f.normal.norm();
  if (!f.inside || !(length > 0.0)) return disable(row);
  const double side = f.normal.dot(ConstMap(row.axes[0])) < 0.0 ? -1.0 : 1.0;
  const Vector3d normal = side / length * f.normal;
  double gap = normal.dot(f.offset) - held.radiusSum;
  if (held.maxDepth > 0.0) {
    const RoundSupport support{held.radiusSum, held.maxDepth};
    gap += allowedDepth(sagging(x, f.weights.data(), support), support);
  }
  moveRow(rows, index, normal, gap, f.weights.data());
}

/// Uses the plane at the time when the spheres are nearest. The plane between their present positions would
/// stop points that pass each other.
void followSpheres(IslandConstraints& rows, std::size_t index, double dt) {
  ContactConstraint& row = rows.rows[index];
  const double radiusSum = contactOf(rows, index).spheres;
  const std::uint32_t a = row.firstPoint, b = row.firstOfB;
  const Vector3d offset = ConstMap(rows.momentArms[a].position) - ConstMap(rows.momentArms[b].position);
  const Vector3d velocity = ConstMap(rows.points[a].velocity) - ConstMap(rows.points[b].velocity);
  const Vector3d nearest = offsetWhenNearest(offset, velocity, dt, radiusSum);
  const double length = nearest.norm();
  if (!(length > 0.0)) return disable(row);
  const Vector3d normal = nearest / length;
  const double weights[] = {1.0, -1.0};
  moveRow(rows, index, normal, normal.dot(offset) - radiusSum, weights);
}

/// Returns the weights of the point of a soft feature (1 to 3 points) that is nearest to p.
std::array<double, 3> nearestWeights(const std::array<Vector3d, 3>& x, std::uint32_t count,
                                     const Vector3d& p) {
  if (count == 1) return {1.0, 0.0, 0.0};
  if (count == 2) {
    const double along = nearestOnSegment(x[0], x[1], p);
    return {1.0 - along, along, 0.0};
  }
  const Vector3d weights = nearestBarycentric(x, p);
  return {weights[0], weights[1], weights[2]};
}

/// Moves the contact to where the soft feature and the ball are nearest. The plane of the start of the tick
/// would let the faces of a soft body that rolls on balls overlap with them, and it would gain the energy of
/// removing that in each tick. A ball whose centre is behind the feature keeps its plane.
void followBall(IslandConstraints& rows, std::size_t index, const LinkedBodies& bodies) {
  ContactConstraint& row = rows.rows[index];
  Contact& contact = contactOf(rows, index);
  const Vector3d& centre = bodies.rigids[contact.b.body].position;
  std::array<Vector3d, 3> x{centre, centre, centre};
  const std::uint32_t count = row.firstOfB - row.firstPoint;
  for (std::uint32_t i = 0; i < count; ++i) x[i] = ConstMap(rows.momentArms[row.firstPoint + i].position);
  const std::array<double, 3> weights = nearestWeights(x, count, centre);
  Vector3d offset = -centre;
  for (std::uint32_t i = 0; i < count; ++i) offset += weights[i] * x[i];
  if (!(offset.dot(ConstMap(row.axes[0])) > 0.0)) return;
  setNormal(contact, row, offset.normalized());
  contact.b.arm = contact.spheres * ConstMap(row.axes[0]);
  for (std::uint32_t i = 0; i < count; ++i) setShare(rows, row.firstPoint + i, weights[i]);
  setSpeeds(rows.rotations[row.firstRotation], row, -contact.b.arm);
  row.surfaceSpeeds = ContactVector::from(inAxes(row, contact.a.velocity - contact.b.velocity));
  const double gap = offset.norm() - contact.spheres;
  row.closing += std::max(0.0, row.gap - gap);
  row.gap = gap;
  const Eigen::Map<const Matrix3d> axes(row.axes[0]);  // its columns
  setMobility(row, Mobility::from(axes.transpose() * mobilityOf(rows, row, contact, bodies) * axes));
}

void prepareJoint(JointConstraint& j, const LinkedBodies& bodies) {
  double mobility = 0.0;
  forEachSide(
      bodies.rigids, j, [&](const RigidState& rigid, const Vector3d& linear, const Vector3d& angular) {
        mobility +=
            linear.dot(linear.cwiseProduct(rigid.inverseMass)) + angular.dot(rigid.inverseInertia * angular);
      });
  j.softness = j.yielding * mobility;
  j.mass = mobility > 0.0 ? 1.0 / (mobility + j.softness) : 0.0;
}

Eigen::Quaterniond rotationOf(std::uint32_t side, const LinkedBodies& bodies) {
  return side != JointConstraint::kHeld ? bodies.rigids[side].rotation : Eigen::Quaterniond::Identity();
}

/// Returns the acceleration (m/s^2) of a pivot towards the centre about which it turns.
Vector3d centripetal(std::uint32_t side, const LinkedBodies& bodies, const Vector3d& arm) {
  if (side == JointConstraint::kHeld) return Vector3d::Zero();
  const Vector3d& spin = bodies.rigids[side].angularVelocity;
  return spin.cross(spin.cross(arm));
}

/// Returns the arm of the first body's side. The row is the rate of  n . (pivot of b - pivot of a)  with an n
/// that turns with a, so the arm reaches to the pivot of b, which slides along a in some joints. The forces
/// then act along one line, and conserve angular momentum.
Vector3d firstArm(const JointConstraint& j, const LinkedBodies& bodies, const Vector3d& armB,
                  JointPivots pivots) {
  const bool isPair = j.a != JointConstraint::kHeld && j.b != JointConstraint::kHeld;
  if (pivots == JointPivots::Own || !isPair || !j.local.opposite)
    return rotationOf(j.a, bodies) * j.local.armA;
  return bodies.rigids[j.b].position + armB - bodies.rigids[j.a].position;
}

/// Turns a row along n. The angular parts of a linear row are  r x n,  with the pivot at r from the centre of
/// mass, and what is left of them. The axis of the first body counts for both, except where each has its own.
void turn(JointConstraint& j, const LinkedBodies& bodies, double dt, JointPivots pivots) {
  const Eigen::Quaterniond a = rotationOf(j.a, bodies), b = rotationOf(j.b, bodies);
  const Vector3d n = a * j.local.axis, armB = b * j.local.armB, armA = firstArm(j, bodies, armB, pivots);
  const Vector3d angularA = a * j.local.angularA;
  j.linearA = n, j.linearB = j.local.opposite ? Vector3d(-n) : b * j.local.axisB;
  j.angularA = armA.cross(n) + angularA;
  j.angularB =
      armB.cross(j.linearB) + (j.local.shared ? Vector3d(-angularA) : Vector3d(b * j.local.angularB));
  j.curve =
      0.5 * dt * (n.dot(centripetal(j.a, bodies, armA)) + j.linearB.dot(centripetal(j.b, bodies, armB)));
}

JointAxes localAxes(const JointConstraint& j, const LinkedBodies& bodies) {
  constexpr double kRounding = 1e-6;
  const Eigen::Quaterniond a = rotationOf(j.a, bodies).conjugate(), b = rotationOf(j.b, bodies).conjugate();
  const Vector3d angularA = j.angularA - j.armA.cross(j.linearA),
                 angularB = j.angularB - j.armB.cross(j.linearB);
  const auto areOpposite = [](const Vector3d& x, const Vector3d& y) {
    return (x + y).norm() <= kRounding * x.norm();
  };
  return {a * j.linearA,
          b * j.linearB,
          a * j.armA,
          b * j.armB,
          a * angularA,
          b * angularB,
          areOpposite(angularA, angularB),
          areOpposite(j.linearA, j.linearB)};
}

/// Sets the inverse of the symmetric mobility (1/kg) between the tangents, and that of its larger eigenvalue.
void setTangentialMasses(ContactConstraint& row, double uu, double uv, double vv) {
  const double determinant = uu * vv - uv * uv;
  const double scale = determinant > 0.0 ? 1.0 / determinant : 0.0;
  row.acrossMass[0] = scale * vv, row.acrossMass[1] = -scale * uv, row.acrossMass[2] = scale * uu;
  const double largest = 0.5 * (uu + vv) + std::sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv);
  row.slidingMass = determinant > 0.0 ? 1.0 / largest : 0.0;
}

/// Whether followContacts() updates the contact.
bool follows(const Contact& c) {
  if (c.ended) return false;
  return c.held || c.corners.count > 0 || c.spheres > 0.0;
}

void listFollowing(IslandConstraints& rows) {
  rows.following.clear();
  for (RowSet& set : rows.sets) {
    set.following.begin = static_cast<std::uint32_t>(rows.following.size());
    for (std::uint32_t i = set.begin; i < set.end; ++i)
      if (follows(contactOf(rows, i))) rows.following.push_back(i);
    set.following.end = static_cast<std::uint32_t>(rows.following.size());
  }
}

/// Updates a contact of `following`.
void follow(IslandConstraints& rows, std::size_t i, const LinkedBodies& bodies, double dt) {
  const Contact& c = contactOf(rows, i);
  if (c.held)
    followPlane(rows, i);
  else if (c.corners.count > 0)
    followCorners(rows, i);
  else if (c.b.kind == ContactPoint::Kind::Rigid)
    followBall(rows, i, bodies);
  else
    followSpheres(rows, i, dt);
}

}  // namespace

double sagging(const std::array<Vector3d, 3>& corners, const double* weights, const RoundSupport& support) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    sum += weights[i] * weights[j] * (corners[i] - corners[j]).squaredNorm();
  }
  return 0.5 * sum / support.radius;
}

double allowedDepth(double sagging, const RoundSupport& support) {
  return std::max(0.0, std::min(sagging, 2.0 * support.maxDepth - sagging));
}

void setMobility(ContactConstraint& row, const Mobility& m) {
  row.mobility = m.nn;
  row.mass = m.nn > 0.0 ? 1.0 / m.nn : 0.0;
  row.acrossAlong[0] = m.nu;
  row.acrossAlong[1] = m.nv;
  row.acrossSoftness = kFrictionSoftness * 0.5 * (m.uu + m.vv);
  setTangentialMasses(row, m.uu + row.acrossSoftness, m.uv, m.vv + row.acrossSoftness);
}

void prepareConstraints(IslandConstraints& rows, LinkedBodies& bodies) {
  rows.points.clear();
  rows.momentArms.clear();
  rows.rotations.clear();
  rows.rows.resize(rows.contacts.size());
  findAnchored(rows, bodies);
  reserveScaledMasses(rows);
  divideRows(rows, bodies);
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    prepareRow(rows, rows.rows[i], contactOf(rows, i), bodies);
  rows.restitutes = false;
  for (ContactConstraint& row : rows.rows)
    if (row.restitutes) rows.restitutes = true, keepVelocity(rows, row);
  listFollowing(rows);
  numberNodes(rows, bodies);
  for (JointConstraint& j : rows.joints) prepareJoint(j, bodies);
  listBlock(rows.joints, rows.block);
  rows.pressed = std::any_of(rows.contacts.begin(), rows.contacts.end(), [&](const Contact& c) {
    const bool asWhole = c.a.kind == ContactPoint::Kind::Rigid || isFramed(bodies, c.a);
    return asWhole && c.b.kind == ContactPoint::Kind::World;
  });
  rows.turns = std::any_of(rows.contacts.begin(), rows.contacts.end(), [](const Contact& c) {
    return !c.a.acceleration.isZero(0.0) || !c.b.acceleration.isZero(0.0);
  });
}

void startTurning(IslandConstraints& rows, const LinkedBodies& bodies) {
  for (JointConstraint& j : rows.joints) j.local = localAxes(j, bodies);
}

void turnJoints(IslandConstraints& rows, const LinkedBodies& bodies, double dt, JointPivots pivots) {
  for (JointConstraint& j : rows.joints) {
    if (j.contact != JointConstraint::kHeld) continue;
    turn(j, bodies, dt, pivots);
    prepareJoint(j, bodies);
  }
}

void turnSurfaces(IslandConstraints& rows, double time) {
  for (std::size_t i = 0; rows.turns && i < rows.rows.size(); ++i) {
    const Contact& c = contactOf(rows, i);
    rows.rows[i].surfaceSpeeds +=
        ContactVector::from(inAxes(rows.rows[i], (time - rows.time) * (c.a.acceleration - c.b.acceleration)));
  }
  rows.time = time;
}

Eigen::Vector3d offsetWhenNearest(const Vector3d& offset, const Vector3d& velocity, double dt,
                                  double radiusSum) {
  // time of |offset + t velocity| = radiusSum, or of the minimum
  const double a = velocity.squaredNorm(), b = offset.dot(velocity),
               c = offset.squaredNorm() - radiusSum * radiusSum;
  if (c <= 0.0 || b >= 0.0) return offset;
  const double root = b * b - a * c;
  const double time = root > 0.0 ? c / (std::sqrt(root) - b) : -b / a;
  return offset + std::min(time, dt) * velocity;
}

void followContacts(IslandConstraints& rows, const LinkedBodies& bodies, Team& team, double dt) {
  if (rows.following.empty()) return;
  forEachSet(rows, team, [&](const RowSet& set) {
    for (std::uint32_t k = set.following.begin; k < set.following.end; ++k) {
      // a bounce ends along the normal along which it began: by then the point has left the surface
      const bool isBouncing = dt == 0.0 && rows.rows[rows.following[k]].bounces;
      if (!isBouncing) follow(rows, rows.following[k], bodies, dt);
    }
  });
}

void updateGaps(IslandConstraints& rows, Team& team, double dt) {
  forEachRow(rows, team, [&](std::size_t i) {
    ContactConstraint& row = rows.rows[i];
    row.gap += dt * speedAlong(rows, row);
    row.aligned = row.couple == Couple::None;
  });
}

void finishConstraints(IslandConstraints& rows) {
  for (std::size_t i = 0; i < rows.contacts.size(); ++i) {
    Contact& c = contactOf(rows, i);
    ContactConstraint& row = rows.rows[i];
    c.gap = row.gap + row.pinned;
    flushImpulse(c, row);
    c.positionImpulse = impulseOfVector(row, row.positionImpulse);
    c.velocityImpulse = impulseOfVector(row, row.velocityImpulse);
  }
}

}  // namespace limber
