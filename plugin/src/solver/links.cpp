// SPDX-License-Identifier: Zlib
// Moves rigid bodies, and computes the forces and impulses of springs and anchors between bodies.
#include "solver/links.h"

#include "mesh/linear_algebra.h"
#include "solver/springs.h"

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

namespace limber {

// --- rigid bodies ------------------------------------------------------------------------------------------

void RigidState::kick(double dt) {
  velocity += dt * (acceleration + force.cwiseProduct(inverseMass));
  angularVelocity += dt * (angularAcceleration + inverseInertia * torque);
}

void RigidState::drift(double dt) {
  position += dt * velocity;
  if (!gyroscopic) {
    rotation = rotationAfter(dt);
    return turn();
  }
  const Eigen::Vector3d momentum = angularMomentum();
  rotation = rotationAfter(dt);
  angularVelocity = rotation * (rotation.conjugate() * momentum).cwiseProduct(inverseInertiaLocal);
  turn();
}

Eigen::Vector3d RigidState::angularMomentum() const {
  return rotation * (rotation.conjugate() * angularVelocity).cwiseQuotient(inverseInertiaLocal);
}

// Free rotation has the kinetic energy  sum L_k^2 / (2 I_k),  with the angular momentum L along the principal
// axes. With the middle one, m, of the three 1/I it is
//     m |L|^2 / 2  +  sum over the two other axes of  (1/I_k - m) L_k^2 / 2,
// three terms with exact motions: a turn about L, which commutes with the other two, and turns about the
// principal axes k by dt (1/I_k - m) L_k. Half a turn about one, a whole about the other, half about the
// first: second order, reversible and symplectic, so that the energy swings and does not drift; exact for
// bodies with two equal moments. (Dullweber, Leimkuhler, McLachlan: Symplectic splitting methods for rigid
// body molecular dynamics, 1997)
Eigen::Quaterniond RigidState::rotationAfter(double dt) const {
  if (!gyroscopic) return (rotationBy(dt * angularVelocity) * rotation).normalized();
  Eigen::Vector3d own = (rotation.conjugate() * angularVelocity).cwiseQuotient(inverseInertiaLocal);
  const Eigen::Vector3d momentum = rotation * own;
  std::array<int, 3> axes = {0, 1, 2};
  std::sort(axes.begin(), axes.end(),
            [&](int a, int b) { return inverseInertiaLocal[a] < inverseInertiaLocal[b]; });
  const double middle = inverseInertiaLocal[axes[1]];
  Eigen::Quaterniond turned = rotation;
  const auto turnAbout = [&](int axis, double time) {
    const double half = 0.5 * time * (inverseInertiaLocal[axis] - middle) * own[axis];
    const double cosine = std::cos(half), sine = std::sin(half);
    Eigen::Quaterniond turn(cosine, 0.0, 0.0, 0.0);
    turn.coeffs()[axis] = sine;
    turned = turned * turn;
    // the momentum stays, so it turns back in the body
    double &x = own[(axis + 1) % 3], &y = own[(axis + 2) % 3];
    const double along = cosine * cosine - sine * sine, across = 2.0 * sine * cosine, before = x;
    x = along * before + across * y, y = along * y - across * before;
  };
  turnAbout(axes[0], 0.5 * dt);
  turnAbout(axes[2], dt);
  turnAbout(axes[0], 0.5 * dt);
  return (rotationBy(dt * middle * momentum) * turned).normalized();
}

void RigidState::turn() {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  inverseInertia = angularFactor.asDiagonal() * (r * inverseInertiaLocal.asDiagonal() * r.transpose());
}

Eigen::Quaterniond rotationBy(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  // sin(x/2)/x by its series where dividing by x would lose digits
  const double ratio = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  const Eigen::Vector3d axis = ratio * v;
  return Eigen::Quaterniond(std::cos(0.5 * angle), axis.x(), axis.y(), axis.z());
}

Eigen::Vector3d rotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  Eigen::Quaterniond q = to * from.conjugate();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  const double ratio = sine < 1e-8 ? 2.0 : 2.0 * std::atan2(sine, q.w()) / sine;
  return ratio * q.vec();
}

// --- soft bodies as a whole --------------------------------------------------------------------------------

namespace {

/// Minimum inertia about an axis, as a fraction of the trace of the inertia tensor.
constexpr double kMinInertia = 1e-5;

/// Minimum determinant of the inertia tensor of a round body, as a fraction of the cube of the trace. Its
/// principal inertias are then larger than 4 times this fraction of the trace.
constexpr double kRoundBody = 1e-3;

/// Returns the inverse with principal inertias of at least the minimum.
Eigen::Matrix3d boundedInverse(const Eigen::Matrix3d& inertia) {
  const double trace = inertia.trace();
  if (inertia.determinant() > kRoundBody * trace * trace * trace) return inertia.inverse();
  const SymmetricParts3 principal = symmetricParts3(inertia);
  const Eigen::Array3d inverse = principal.values.array().max(kMinInertia * trace).inverse();
  return principal.vectors * inverse.matrix().asDiagonal() * principal.vectors.transpose();
}

/// Lists the points with their offsets from point 0 in place of moment arms.
void listPoints(LinkedBodies& bodies, BodyFrame& frame) {
  const PointView& points = bodies.views[frame.body];
  const auto count = static_cast<std::uint32_t>(bodies.points[frame.body]->position.cols());
  frame.begin = static_cast<std::uint32_t>(bodies.framePoints.size());
  for (std::uint32_t i = 0; i < count; ++i)
    if (const double inverse = points.inverseMassOf(i).maxCoeff(); inverse > 0.0)
      bodies.framePoints.push_back({i, 1.0 / inverse, points.positionOf(i) - points.positionOf(0)});
  frame.end = static_cast<std::uint32_t>(bodies.framePoints.size());
}

void fitPlace(LinkedBodies& bodies, BodyFrame& frame) {
  RigidState& rigid = bodies.rigids[frame.rigid];
  double mass = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::uint32_t k = frame.begin; k < frame.end; ++k) {
    const FramePoint& p = bodies.framePoints[k];
    mass += p.mass;
    moment += p.mass * p.arm;
    second += p.mass * p.arm * p.arm.transpose();
  }
  rigid.inverseMass.setZero();
  rigid.inverseInertia.setZero();
  frame.inertia.setZero();
  if (mass == 0.0) return;
  const Eigen::Vector3d center = moment / mass;
  for (std::uint32_t k = frame.begin; k < frame.end; ++k) bodies.framePoints[k].arm -= center;
  rigid.position = bodies.views[frame.body].positionOf(0) + center;
  rigid.inverseMass.setConstant(1.0 / mass);
  const double rounding = 1e-12 * second.trace();
  second -= moment * center.transpose();
  // a single free point has none
  if (!(second.trace() > rounding)) return;
  frame.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  rigid.inverseInertia = boundedInverse(frame.inertia);
}

}  // namespace

void fitFrames(LinkedBodies& bodies) {
  bodies.framePoints.clear();
  for (BodyFrame& frame : bodies.frames) {
    listPoints(bodies, frame);
    fitPlace(bodies, frame);
  }
  fitFrameVelocities(bodies);
}

void fitFrameVelocities(LinkedBodies& bodies) {
  for (BodyFrame& frame : bodies.frames) {
    RigidState& rigid = bodies.rigids[frame.rigid];
    const PointView& points = bodies.views[frame.body];
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular = momentum;
    for (std::uint32_t k = frame.begin; k < frame.end; ++k) {
      const FramePoint& p = bodies.framePoints[k];
      const Eigen::Vector3d own = p.mass * points.velocityOf(p.point);
      momentum += own;
      angular += p.arm.cross(own);
    }
    frame.velocity = rigid.velocity = rigid.inverseMass.cwiseProduct(momentum);
    rigid.angularVelocity += rigid.inverseInertia * (angular - frame.inertia * rigid.angularVelocity);
    frame.spin = rigid.angularVelocity;
  }
}

void pushFrames(LinkedBodies& bodies) {
  for (BodyFrame& frame : bodies.frames) {
    const RigidState& rigid = bodies.rigids[frame.rigid];
    const PointView& points = bodies.views[frame.body];
    const Eigen::Vector3d velocity = rigid.velocity - frame.velocity;
    const Eigen::Vector3d spin = rigid.angularVelocity - frame.spin;
    if (velocity.isZero(0.0) && spin.isZero(0.0)) continue;
    for (std::uint32_t k = frame.begin; k < frame.end; ++k) {
      const FramePoint& p = bodies.framePoints[k];
      const auto moves = points.inverseMassOf(p.point).array() > 0.0;
      points.velocityOf(p.point) += moves.select(velocity + spin.cross(p.arm), 0.0).matrix();
    }
    frame.velocity = rigid.velocity, frame.spin = rigid.angularVelocity;
  }
}

// --- links -------------------------------------------------------------------------------------------------

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d arm(const LinkedBodies& bodies, const LinkEnd& end) {
  return bodies.rigids[end.body].rotation * end.pivot;
}

/// Returns the points of the body at an end of kind Point.
PointView pointsAt(const LinkedBodies& bodies, const LinkEnd& end) {
  return bodies.views.empty() ? viewOf(*bodies.points[end.body]) : bodies.views[end.body];
}

/// Returns the world position (m) of an end. In this file, so that the loops over links have it inline.
inline Vector3d positionAt(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return end.pivot;
  if (end.kind == LinkEnd::Kind::Point) return pointsAt(bodies, end).positionOf(end.point);
  return bodies.rigids[end.body].position + arm(bodies, end);
}

Vector3d endVelocity(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return end.velocity;
  if (end.kind == LinkEnd::Kind::Point) return pointsAt(bodies, end).velocityOf(end.point);
  return bodies.rigids[end.body].velocityAt(arm(bodies, end));
}

void applyImpulse(LinkedBodies& bodies, const LinkEnd& end, const Vector3d& impulse) {
  if (end.kind == LinkEnd::Kind::Point) {
    const PointView points = pointsAt(bodies, end);
    points.velocityOf(end.point) += impulse.cwiseProduct(points.inverseMassOf(end.point));
  } else if (end.kind == LinkEnd::Kind::Rigid) {
    bodies.rigids[end.body].applyImpulse(impulse, arm(bodies, end));
  }
}

void addForce(LinkedBodies& bodies, const LinkEnd& end, const Vector3d& force) {
  if (end.kind == LinkEnd::Kind::Point) {
    pointsAt(bodies, end).forceOf(end.point) += force;
  } else if (end.kind == LinkEnd::Kind::Rigid) {
    RigidState& rigid = bodies.rigids[end.body];
    rigid.force += force;
    rigid.torque += arm(bodies, end).cross(force);
  }
}

/// 3 x 3: the velocity change at the end per impulse there.
Matrix3d mobility(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return Matrix3d::Zero();
  if (end.kind == LinkEnd::Kind::Point) return pointsAt(bodies, end).inverseMassOf(end.point).asDiagonal();
  return bodies.rigids[end.body].mobilityAt(arm(bodies, end));
}

/// 1/kg: n . mobility n, for a unit vector n.
double mobilityAlong(const LinkedBodies& bodies, const LinkEnd& end, const Vector3d& n) {
  if (end.kind == LinkEnd::Kind::World) return 0.0;
  if (end.kind == LinkEnd::Kind::Point) {
    const Vector3d response = pointsAt(bodies, end).inverseMassOf(end.point).cwiseProduct(n);
    return n.dot(response);
  }
  const RigidState& rigid = bodies.rigids[end.body];
  const Vector3d turn = arm(bodies, end).cross(n);
  return n.dot(rigid.inverseMass.cwiseProduct(n)) + turn.dot(rigid.inverseInertia * turn);
}

/// Returns an upper bound of the mobility in any direction and at any rotation.
double mobilityBound(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return 0.0;
  if (end.kind == LinkEnd::Kind::Point) return pointsAt(bodies, end).inverseMassOf(end.point).maxCoeff();
  const RigidState& rigid = bodies.rigids[end.body];
  return rigid.inverseMass.maxCoeff() + end.pivot.squaredNorm() * rigid.inverseInertiaLocal.maxCoeff();
}

double stiffest(const LinkSpring& s) { return std::max(s.extensionStiffness, s.compressionStiffness); }

/// Returns the stiffness sum at an end.
double& sumOf(LinkedBodies& bodies, const LinkEnd& end) {
  const bool rigid = end.kind == LinkEnd::Kind::Rigid;
  return bodies.stiffnessSums[rigid ? end.body : bodies.firstOfPoints[end.body] + end.point];
}

/// Sets all stiffness sums to 0.
void clearSums(LinkedBodies& bodies) {
  std::size_t count = bodies.rigids.size();
  bodies.firstOfPoints.clear();
  for (const PointState* points : bodies.points) {
    bodies.firstOfPoints.push_back(count);
    count += static_cast<std::size_t>(points->position.cols());
  }
  bodies.stiffnessSums.assign(count, 0.0);
}

/// Whether a link of this squared length (m^2) has no force. Most of those that limit a distance are slack,
/// and this takes no square root.
bool isSlack(const LinkSpring& s, double squaredLength) {
  const double square = s.restLength * s.restLength;
  return (s.extensionStiffness == 0.0 && squaredLength >= square) ||
         (s.compressionStiffness == 0.0 && squaredLength <= square);
}

/// Adds to both ends the share of kernel::crossingForce() of a spring that has passed its rest length in a
/// substep of dt seconds, from the length `earlier` (m) to the offset `d` (m) of its ends.
void addCrossing(LinkedBodies& bodies, const LinkSpring& s, double earlier, const Vector3d& d, double dt,
                 double share) {
  const double length = d.norm();
  if (!(length > 0.0)) return;
  const Vector3d n = d / length;
  const double w = mobilityAlong(bodies, s.a, n) + mobilityAlong(bodies, s.b, n);
  const double force = share * kernel::crossingForce(earlier - s.restLength, length - s.restLength,
                                                     s.extensionStiffness - s.compressionStiffness,
                                                     kernel::kCrossingLoss * dt * dt * w);
  addForce(bodies, s.a, force * n);
  addForce(bodies, s.b, -force * n);
}

void dampLink(LinkedBodies& bodies, const LinkSpring& s, double dt) {
  const Vector3d& n = s.direction;
  const double w = mobilityAlong(bodies, s.a, n) + mobilityAlong(bodies, s.b, n);
  const double speed = n.dot(endVelocity(bodies, s.b) - endVelocity(bodies, s.a));
  const Vector3d impulse = dampingImpulse(s.damping, w, dt) * speed * n;
  applyImpulse(bodies, s.a, impulse);
  applyImpulse(bodies, s.b, -impulse);
}

}  // namespace

Vector3d endPosition(const LinkedBodies& bodies, const LinkEnd& end) { return positionAt(bodies, end); }

void addLinkForces(LinkedBodies& bodies, double dt, double crossing) {
  bodies.taut.clear();
  bodies.taut.reserve(bodies.springs.capacity());
  for (std::size_t i = 0; i < bodies.springs.size(); ++i) {
    LinkSpring& s = bodies.springs[i];
    const Vector3d d = positionAt(bodies, s.b) - positionAt(bodies, s.a);
    const double earlier = std::exchange(s.squaredLength, d.squaredNorm()),
                 rest = s.restLength * s.restLength;
    if (s.extensionStiffness != s.compressionStiffness && crossing > 0.0 &&
        (earlier < rest) != (s.squaredLength < rest))
      addCrossing(bodies, s, std::sqrt(earlier), d, dt, crossing);
    s.force = 0.0;
    if (isSlack(s, s.squaredLength)) continue;
    const SpringPull pull = springPull(d, s.restLength, s.extensionStiffness, s.compressionStiffness);
    s.direction = pull.direction;
    s.force = pull.force;
    bodies.taut.push_back(static_cast<std::uint32_t>(i));
    addForce(bodies, s.a, pull.force * pull.direction);
    addForce(bodies, s.b, -pull.force * pull.direction);
  }
}

void driftLinks(LinkedBodies& bodies, double dt) {
  for (LinkSpring& s : bodies.springs)
    for (LinkEnd* end : {&s.a, &s.b})
      if (end->kind == LinkEnd::Kind::World) end->pivot += dt * end->velocity;
}

void sumAnchorImpulses(LinkedBodies& bodies) {
  for (LinkAnchor& anchor : bodies.anchors) anchor.impulse += anchor.positionImpulse + anchor.velocityImpulse;
}

void dampLinks(LinkedBodies& bodies, double dt, bool forward) {
  const std::size_t count = bodies.taut.size();
  for (std::size_t i = 0; i < count; ++i) {
    const LinkSpring& s = bodies.springs[bodies.taut[forward ? i : count - 1 - i]];
    if (s.damping > 0.0) dampLink(bodies, s, dt);
  }
}

double linkFrequencyBoundSquared(LinkedBodies& bodies) {
  if (bodies.springs.empty()) return 0.0;
  clearSums(bodies);
  // points in the world do not move: springs that end there are independent of each other
  const auto forEachMovingEnd = [&](const LinkSpring& s, auto visit) {
    for (const LinkEnd* end : {&s.a, &s.b})
      if (end->kind != LinkEnd::Kind::World)
        visit(sumOf(bodies, *end), std::sqrt(mobilityBound(bodies, *end)));
  };
  for (const LinkSpring& s : bodies.springs)
    forEachMovingEnd(s, [&](double& sum, double share) { sum += stiffest(s) * share; });
  double bound = 0.0;
  for (const LinkSpring& s : bodies.springs) {
    double row = 0.0;
    forEachMovingEnd(s, [&](double sum, double share) { row += share * sum; });
    bound = std::max(bound, row);
  }
  return bound;
}

// --- anchors -----------------------------------------------------------------------------------------------

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Share of the cube of a mobility's trace: with a larger determinant its cofactors lose few digits.
constexpr double kMinDeterminant = 1e-6;

/// Returns the inverse of a mobility, with 0 along an axis along which both sides are held.
Matrix3d inverseMobility(const Matrix3d& mobility) {
  const double size = mobility.trace();
  const bool isRegular = mobility.determinant() > kMinDeterminant * size * size * size;
  return isRegular ? Matrix3d(mobility.inverse()) : pseudoInverse(mobility);
}

/// Share of an error that is removed per tick, as in Bullet's joints (btContactSolverInfo::m_erp).
constexpr double kRecoveryPerTick = 0.2;

/// Largest share of an error that is removed per substep.
constexpr double kRecoveryPerSubstep = 0.2;

/// m/s; slower errors come from solves and rounding, and may be removed at once.
constexpr double kSlowRecovery = 1e-3;

/// The sweeps of joinVelocities() end when no velocity error exceeds this (m/s), or after the largest number.
constexpr double kAnchorTolerance = 1e-10;
constexpr int kAnchorSweeps = 50;

const RigidState& bodyOf(const LinkedBodies& bodies, const LinkAnchor& anchor) {
  return bodies.rigids[anchor.pivot.body];
}

/// 1/kg per axis, of the anchor's point.
Vector3d inverseMassOf(const LinkedBodies& bodies, const LinkAnchor& anchor) {
  return pointsAt(bodies, anchor.point).inverseMassOf(anchor.point.point);
}

/// Whether the anchor can be solved together with others on its body.
bool isShared(const LinkedBodies& bodies, const LinkAnchor& anchor) {
  return !anchor.held && inverseMassOf(bodies, anchor).minCoeff() > 0.0;
}

LinkAnchor& anchorAt(LinkedBodies& bodies, std::uint32_t place) {
  return bodies.anchors[bodies.anchorOrder[place]];
}

/// Sets `anchorOrder` and `anchorSets`.
void divideAnchors(LinkedBodies& bodies) {
  const auto keyOf = [&](std::uint32_t i) {
    const LinkAnchor& anchor = bodies.anchors[i];
    return std::tuple(anchor.pivot.body, !isShared(bodies, anchor), i);
  };
  bodies.anchorSets.clear();
  bodies.anchorOrder.resize(bodies.anchors.size());
  std::iota(bodies.anchorOrder.begin(), bodies.anchorOrder.end(), 0u);
  std::sort(bodies.anchorOrder.begin(), bodies.anchorOrder.end(),
            [&](std::uint32_t a, std::uint32_t b) { return keyOf(a) < keyOf(b); });
  for (std::uint32_t k = 0; k < bodies.anchorOrder.size(); ++k) {
    const LinkAnchor& anchor = anchorAt(bodies, k);
    const bool joins = k > 0 && isShared(bodies, anchor) && isShared(bodies, anchorAt(bodies, k - 1)) &&
                       anchorAt(bodies, k - 1).pivot.body == anchor.pivot.body;
    if (!joins) bodies.anchorSets.emplace_back().begin = k;
    bodies.anchorSets.back().end = k + 1;
  }
}

/// Sets `solve` as  S = (1 + W A)^-1 W  with  A = sum J^T m J,  which is regular where the body's inverse
/// masses and inertia W = diag(w, V) are not. With the blocks P (diagonal), Q^T, Q and R of A and
/// s = w / (1 + w P):
///     S_22 = (1 + V (R - Q s Q^T))^-1 V,  S_12 = -s Q^T S_22,  S_21 = -S_22 Q s,  S_11 = s (1 - Q^T S_21).
void updateSet(LinkedBodies& bodies, AnchorSet& set) {
  Vector3d p = Vector3d::Zero();
  Matrix3d q = Matrix3d::Zero(), r = Matrix3d::Zero();
  for (std::uint32_t k = set.begin; k < set.end; ++k) {
    const LinkAnchor& anchor = anchorAt(bodies, k);
    const Vector3d mass = inverseMassOf(bodies, anchor).cwiseInverse();
    const Matrix3d cross = crossMatrix(anchor.arm), coupling = cross * mass.asDiagonal();
    p += mass;
    q += coupling;
    r -= coupling * cross;
  }
  const RigidState& rigid = bodyOf(bodies, anchorAt(bodies, set.begin));
  const Vector3d s = (rigid.inverseMass.array() / (1.0 + rigid.inverseMass.array() * p.array())).matrix();
  const Matrix3d coupled = q * s.asDiagonal();
  const Matrix3d turn = Matrix3d::Identity() + rigid.inverseInertia * (r - coupled * q.transpose());
  const Matrix3d angular = turn.inverse() * rigid.inverseInertia, mixed = -(angular * coupled);
  set.solve.topLeftCorner<3, 3>() = s.asDiagonal() * (Matrix3d::Identity() - q.transpose() * mixed);
  set.solve.topRightCorner<3, 3>() = -(coupled.transpose() * angular);
  set.solve.bottomLeftCorner<3, 3>() = mixed;
  set.solve.bottomRightCorner<3, 3>() = angular;
}

/// Sets the velocity errors of a set.
void findErrors(LinkedBodies& bodies, const AnchorSet& set, double dt) {
  const RigidState& rigid = bodyOf(bodies, anchorAt(bodies, set.begin));
  const bool drifts = dt != 0.0 && !anchorAt(bodies, set.begin).held;
  const Matrix3d turned = drifts ? rigid.rotationAfter(dt).toRotationMatrix() : Matrix3d();
  for (std::uint32_t k = set.begin; k < set.end; ++k) {
    LinkAnchor& anchor = anchorAt(bodies, k);
    const Vector3d velocity = endVelocity(bodies, anchor.point);
    if (dt == 0.0) {
      anchor.error = velocity - (anchor.held ? anchor.speed : rigid.velocityAt(anchor.arm));
      continue;
    }
    const Vector3d pivot = drifts
                               ? Vector3d(rigid.position + dt * rigid.velocity + turned * anchor.pivot.pivot)
                               : anchor.drifted;
    anchor.error = (positionAt(bodies, anchor.point) + dt * velocity - pivot - anchor.apart) / dt;
  }
}

}  // namespace

void prepareAnchors(LinkedBodies& bodies) {
  for (LinkAnchor& anchor : bodies.anchors) {
    const RigidState& rigid = bodyOf(bodies, anchor);
    anchor.held = rigid.inverseMass.isZero(0.0) && rigid.inverseInertia.isZero(0.0);
    if (anchor.held) anchor.mass = inverseMobility(mobility(bodies, anchor.point));
    anchor.impulse.setZero();
  }
  divideAnchors(bodies);
}

void updateAnchors(LinkedBodies& bodies) {
  for (LinkAnchor& anchor : bodies.anchors) {
    anchor.arm = arm(bodies, anchor.pivot);
    if (anchor.held) anchor.speed = bodyOf(bodies, anchor).velocityAt(anchor.arm);
  }
  for (AnchorSet& set : bodies.anchorSets) {
    LinkAnchor& anchor = anchorAt(bodies, set.begin);
    if (!set.isSingle())
      updateSet(bodies, set);
    else if (!anchor.held)
      anchor.mass = inverseMobility(mobility(bodies, anchor.point) + mobility(bodies, anchor.pivot));
  }
}

void aimAnchors(LinkedBodies& bodies, double dt, double tick) {
  for (LinkAnchor& anchor : bodies.anchors) {
    const RigidState& rigid = bodyOf(bodies, anchor);
    const Vector3d error = positionAt(bodies, anchor.point) - (rigid.position + anchor.arm);
    const double size = error.norm(), minCorrection = kSlowRecovery * dt;
    const double share = std::max(kRecoveryPerTick * dt / tick, size > 0.0 ? minCorrection / size : 0.0);
    // a held body follows its prescribed motion, and the point follows the body
    const bool held = rigid.inverseMass.isZero(0.0);
    anchor.apart = (1.0 - (held ? 1.0 : std::min(share, kRecoveryPerSubstep))) * error;
    if (anchor.held)
      anchor.drifted =
          rigid.position + dt * rigid.velocity + rotationBy(dt * rigid.angularVelocity) * anchor.arm;
  }
}

void findChanges(LinkedBodies& bodies, const AnchorSet& set, double dt) {
  findErrors(bodies, set, dt);
  if (set.isSingle()) {
    LinkAnchor& anchor = anchorAt(bodies, set.begin);
    anchor.change = -(anchor.mass * anchor.error);
    return;
  }
  Vector6d sum = Vector6d::Zero();
  for (std::uint32_t k = set.begin; k < set.end; ++k) {
    const LinkAnchor& anchor = anchorAt(bodies, k);
    const Vector3d f = anchor.error.cwiseQuotient(inverseMassOf(bodies, anchor));
    sum.head<3>() -= f;
    sum.tail<3>() -= anchor.arm.cross(f);
  }
  const Vector6d u = set.solve * sum;
  for (std::uint32_t k = set.begin; k < set.end; ++k) {
    LinkAnchor& anchor = anchorAt(bodies, k);
    const Vector3d at = u.head<3>() + Vector3d(u.tail<3>()).cross(anchor.arm);
    anchor.change = -(anchor.error + at).cwiseQuotient(inverseMassOf(bodies, anchor));
  }
}

void applyImpulse(LinkedBodies& bodies, const LinkAnchor& anchor, const Vector3d& impulse) {
  applyImpulse(bodies, anchor.point, impulse);
  if (!anchor.held) bodies.rigids[anchor.pivot.body].applyImpulse(-impulse, anchor.arm);
}

void joinVelocities(LinkedBodies& bodies) {
  updateAnchors(bodies);
  for (int sweep = 0; sweep < kAnchorSweeps && !bodies.anchors.empty(); ++sweep) {
    double largest = 0.0;
    for (const AnchorSet& set : bodies.anchorSets) {
      findChanges(bodies, set, 0.0);
      for (std::uint32_t k = set.begin; k < set.end; ++k) {
        LinkAnchor& anchor = anchorAt(bodies, k);
        applyImpulse(bodies, anchor, anchor.change);
        anchor.impulse += anchor.change;
        largest = std::max(largest, anchor.error.norm());
      }
    }
    if (largest <= kAnchorTolerance) return;
  }
}

double elasticEnergy(const LinkedBodies& bodies) {
  double energy = 0.0;
  for (const LinkSpring& s : bodies.springs) {
    const double stretch = (endPosition(bodies, s.b) - endPosition(bodies, s.a)).norm() - s.restLength;
    energy += 0.5 * stretch * stretch * (stretch > 0.0 ? s.extensionStiffness : s.compressionStiffness);
  }
  return energy;
}

}  // namespace limber
