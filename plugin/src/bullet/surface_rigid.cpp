// SPDX-License-Identifier: Zlib

// This file makes the surface object a rigid body for its user. The object has the mass, inertia and motion
// of the points, and changes of the object move the points.

#include "bullet/body_in_world.h"
#include "bullet/point_contacts.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Minimum inertia about an axis, as a fraction of the trace of the inertia tensor. About an axis with less,
/// such as the line of a rope, a torque causes less rotation the smaller the inertia is, and none if it is 0.
/// Bullet stores the rotation rates about all axes in one vector of floats. The rounding error of a very fast
/// rotation would be an impulse about the other axes.
constexpr double kMinInertia = 1e-5;

/// Number of iterations for the rotation of a body: one that rotates little in a tick, and any.
constexpr int kRotationSteps = 4, kManyRotationSteps = 200;

/// Minimum determinant of the inertia tensor of a round body, as a fraction of the cube of the trace. Its
/// principal inertias are then larger than 4 times this fraction of the trace.
constexpr double kRoundBody = 1e-3;

/// Sets the inverse inertia: x / (x^2 + least^2) for each principal inertia x. If no x is small, this is the
/// reciprocal of x with a relative error below 1e-5.
void setInertia(RigidFit& fit, const Matrix3d& inertia) {
  const double trace = inertia.trace(), least = kMinInertia * trace;
  if (!(trace > 0.0)) return;
  if (inertia.determinant() > kRoundBody * trace * trace * trace) {
    fit.inverseInertia = inertia.inverse();
    fit.factor = fit.inverseInertia.llt().matrixL();
    return;
  }
  const SymmetricParts3 principal = symmetricParts3(inertia);
  const Eigen::Array3d x = principal.values.array().max(0.0);
  fit.factor = principal.vectors * (x / (x.square() + least * least)).sqrt().matrix().asDiagonal();
  fit.inverseInertia = fit.factor * fit.factor.transpose();
}

/// Fits a rigid body to sums over offsets d from the point `from`. About the centre c, the second moments are
/// smaller by M c c^T, and the angular momentum by c x (sum m v).
RigidFit fitRigid(const MotionSums& s, const Vector3d& from) {
  RigidFit fit;
  fit.mass = s.mass;
  if (!(fit.mass > 0.0)) {
    fit.center = from + Vector3d(s.meanOffset);
    return fit;
  }
  const Vector3d moment(s.moment), momentum(s.momentum), c = moment / fit.mass;
  const double* m = s.second;
  Matrix3d second;
  second << m[0], m[3], m[5], m[3], m[1], m[4], m[5], m[4], m[2];
  const double rounding = 1e-12 * second.trace();
  second -= moment * c.transpose();
  // a single free point has none
  if (second.trace() > rounding) setInertia(fit, second.trace() * Matrix3d::Identity() - second);
  fit.center = from + c;
  fit.velocity = momentum / fit.mass;
  fit.spin = fit.inverseInertia * (Vector3d(s.angular) - c.cross(momentum));
  return fit;
}

/// Whether a symmetric matrix is positive definite, by its leading minors.
bool isPositive(const Matrix3d& m) {
  return m(0, 0) > 0.0 && m(0, 0) * m(1, 1) > m(1, 0) * m(1, 0) && m.determinant() > 0.0;
}

/// Rotates the object's frame with the body: returns the rotation R that brings the network's rest shape
/// nearest to the points, which have the moments M. It is also defined for ropes and cloths.
///
/// It maximises tr(R^T M) by Newton's method. For R turned by the vector t this is, with B = M R^T and its
/// symmetric part S,
///     tr B + t . g - t . (tr B - S) t / 2,   g = sum over the axes k of  R_k x M_k.
/// Where the matrix is not positive, far from the maximum or in a mirrored body, t = g / |tr B| goes uphill
/// (Mueller, Bender, Chentanez, Macklin, A robust method to extract the rotational part of deformations,
/// 2016). That alone leaves a third of a cube's angle: a frame that lags feeds energy into angular springs.
Eigen::Quaterniond follow(const Matrix3d& moments, double meanSquare, Eigen::Quaterniond q, int steps) {
  const double least = 1e-9 * meanSquare;
  for (int step = 0; step < steps; ++step) {
    const Matrix3d r = q.toRotationMatrix(), b = moments * r.transpose();
    const Vector3d gradient(b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1));
    const Matrix3d curvature = (b.trace() + least) * Matrix3d::Identity() - 0.5 * (b + b.transpose());
    Vector3d turn = isPositive(curvature) ? Vector3d(curvature.inverse() * gradient)
                                          : Vector3d(gradient / (std::abs(b.trace()) + least));
    const double angle = turn.norm();
    if (!(angle > 1e-9) || !std::isfinite(angle)) break;
    turn *= std::min(1.0, 1.0 / angle);
    // (1, turn / 2) is this rotation to second order; the next iteration corrects the rest
    q = (Eigen::Quaterniond(1.0, 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z()) * q).normalized();
  }
  return q;
}

btMatrix3x3 matrixToBullet(const Matrix3d& m) {
  const auto at = [&](int row, int column) { return static_cast<btScalar>(m(row, column)); };
  return btMatrix3x3(at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2), at(2, 0), at(2, 1),
                     at(2, 2));
}

/// Writes mass and inertia to the object. Bullet computes its inverse inertia tensor as B D B^T, with its
/// basis B and a diagonal D. With the factor F in place of B, and D = 1, the result is the tensor F F^T.
void writeInertia(btRigidBody& object, const RigidFit& fit, const btMatrix3x3& basis) {
  if (object.getMass() != static_cast<btScalar>(fit.mass)) {
    const int flags = object.getCollisionFlags();
    object.setMassProps(static_cast<btScalar>(fit.mass), btVector3(1, 1, 1));
    // if all points are held, the mass is 0, but the object must not become static
    object.setCollisionFlags(flags);
  }
  object.setInvInertiaDiagLocal(btVector3(1, 1, 1));
  object.getWorldTransform().setBasis(matrixToBullet(fit.factor));
  object.updateInertiaTensor();
  object.getWorldTransform().setBasis(basis);
  const btMatrix3x3 local = basis.transpose() * object.getInvInertiaTensorWorld() * basis;
  object.setInvInertiaDiagLocal(btVector3(local[0][0], local[1][1], local[2][2]));
}

void leave(SoftBodyData& body) {
  const btRigidBody& object = *body.surface.object;
  body.surface.left = {object.getWorldTransform(), object.getLinearVelocity(), object.getAngularVelocity()};
}

bool isMotionFinite(const btRigidBody& object) {
  const btTransform& pose = object.getWorldTransform();
  return isFinite(object.getLinearVelocity()) && isFinite(object.getAngularVelocity()) &&
         isFinite(pose.getOrigin()) && isFinite(pose.getBasis()[0]) && isFinite(pose.getBasis()[1]) &&
         isFinite(pose.getBasis()[2]);
}

void undo(SoftBodyData& body) {
  btRigidBody& object = *body.surface.object;
  object.setWorldTransform(body.surface.left.pose);
  object.setLinearVelocity(body.surface.left.velocity);
  object.setAngularVelocity(body.surface.left.spin);
}

bool isPinned(const SoftBodyData& body, Eigen::Index i) {
  if (body.masses.bodies.empty()) return false;
  const PointMass* point = body.masses.bodies[static_cast<std::size_t>(i)];
  return !point || point->isKinematicObject();
}

void moveObject(SoftBodyData& body, const btTransform& pose) {
  const btTransform& left = body.surface.left.pose;
  const Eigen::Quaterniond turn = toEigen(pose.getRotation()) * toEigen(left.getRotation()).conjugate();
  moveRigidly(body, turn, toEigen(left.getOrigin()), toEigen(pose.getOrigin()), false);
  body.surface.shape->setPose(pose);
}

/// Changes a point's position and velocity, along the axes along which it moves.
void shift(PointState& s, Eigen::Index i, const Vector3d& displacement, const Vector3d& change) {
  const auto moves = s.inverseMass.col(i).array() > 0.0;
  s.position.col(i) += moves.select(displacement, 0.0).matrix();
  s.velocity.col(i) += moves.select(change, 0.0).matrix();
}

void pushBy(SoftBodyData& body, const Vector3d& velocity, const Vector3d& spin) {
  PointState& s = body.state;
  const Vector3d center = centerOfMass(s);
  forEachMass(s, [&](double, Eigen::Index i) {
    shift(s, i, Vector3d::Zero(), velocity + spin.cross(Vector3d(s.position.col(i) - center)));
  });
}

/// Changes velocity and spin of the body, which had the spin `before`, at the start of a tick of `tick`
/// seconds that it has already gone through. It then is where a rigid body would be: turned by exp(tick
/// (before + spin)) instead of exp(tick before). Displacements in proportion to the spin would stretch it by
/// (tick spin)^2 / 2.
void pushFromStart(SoftBodyData& body, const Vector3d& velocity, const Vector3d& spin, const Vector3d& before,
                   double tick) {
  PointState& s = body.state;
  const RigidFit fit = fitRigid(body);
  const Eigen::Quaterniond turn = rotationBy(tick * (before + spin)) * rotationBy(-tick * before);
  forEachMass(s, [&](double, Eigen::Index i) {
    const Vector3d arm = s.position.col(i) - fit.center, turned = turn * arm;
    const Vector3d own = s.velocity.col(i) - fit.velocity - fit.spin.cross(arm);
    const Vector3d moved = fit.velocity + velocity + (fit.spin + spin).cross(turned) + turn * own;
    shift(s, i, tick * velocity + turned - arm, moved - s.velocity.col(i));
  });
}

/// Writes the change to the exposed points that are not pinned, also to those that the user holds.
void writeShared(SoftBodyData& body) {
  if (!body.masses.exposed) return;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    if (isPinned(body, static_cast<Eigen::Index>(i))) continue;
    writePoint(body, i);
    remember(body.masses, i);
  }
}

}  // namespace

RigidFit fitRigid(SoftBodyData& body) { return fitRigid(sumsOf(body), body.state.position.col(0)); }

const Eigen::Quaterniond& followRotation(SoftBodyData& body) {
  const MotionSums& sums = sumsOf(body);
  // the frame of a body with Collision::Points is not updated in each tick
  const int steps = isSurfaceBody(body) ? kRotationSteps : kManyRotationSteps;
  return body.surface.frame =
             follow(Matrix3d(sums.moments), body.model->rest.meanSquare, body.surface.frame, steps);
}

void moveRigidly(SoftBodyData& body, const Eigen::Quaterniond& turn, const Vector3d& from, const Vector3d& to,
                 bool withPins) {
  PointState& s = body.state;
  const RigidFit fit = fitRigid(body);
  const Matrix3d r = turn.toRotationMatrix();
  for (Eigen::Index i = 0; i < s.position.cols(); ++i) {
    if (!isPinned(body, i)) {
      const Vector3d arm = s.position.col(i) - fit.center;
      const Vector3d own = s.velocity.col(i) - fit.velocity - fit.spin.cross(arm);
      s.velocity.col(i) = fit.velocity + fit.spin.cross(r * arm) + r * own;
    } else if (!withPins) {
      continue;
    }
    s.position.col(i) = to + r * (s.position.col(i) - from);
    body.masses.startPosition.col(i) = to + r * (body.masses.startPosition.col(i) - from);
  }
  body.surface.frame = (turn * body.surface.frame).normalized();
}

void writeObject(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  btRigidBody& object = *s.object;
  const RigidFit fit = fitRigid(body);
  followRotation(body);
  const btTransform pose(matrixToBullet(s.frame.toRotationMatrix()), toBullet(fit.center));
  object.setWorldTransform(pose);
  object.setInterpolationWorldTransform(pose);
  object.setLinearVelocity(toBullet(fit.velocity));
  object.setAngularVelocity(toBullet(fit.spin));
  object.setInterpolationLinearVelocity(object.getLinearVelocity());
  object.setInterpolationAngularVelocity(object.getAngularVelocity());
  writeInertia(object, fit, pose.getBasis());
  s.shape->setPose(pose);
  leave(body);
}

bool isObjectChanged(const SoftBodyData& body) {
  const btRigidBody* object = body.surface.object;
  const LeftObject& left = body.surface.left;
  return object && (object->getLinearVelocity() != left.velocity ||
                    object->getAngularVelocity() != left.spin || !(object->getWorldTransform() == left.pose));
}

void readObject(SoftBodyData& body, double tick) {
  if (!isObjectChanged(body)) return;
  btRigidBody& object = *body.surface.object;
  if (!isMotionFinite(object)) {
    body.restored = true;
    return undo(body);
  }
  absorbOutsideChanges(body);
  const LeftObject left = body.surface.left;
  // an awake body keeps what rests on it awake
  if (body.asleep) wakeNeighbours(body, false);
  if (!(object.getWorldTransform() == left.pose)) {
    moveObject(body, object.getWorldTransform());
    body.surface.overlapTicks = SurfaceData::kOverlapTicks;
  }
  const Vector3d velocity = difference(object.getLinearVelocity(), left.velocity);
  const Vector3d spin = difference(object.getAngularVelocity(), left.spin);
  // a constraint has acted at the start of the tick
  if (tick > 0.0)
    pushFromStart(body, velocity, spin, toEigen(left.spin), tick);
  else
    pushBy(body, velocity, spin);
  body.sumsValid = false;
  leave(body);
  writeShared(body);
  // the prediction is out of date
  body.surface.sweptBounds.tick = 0.0;
  if (body.asleep) object.activate(true);
}

void takeObjectForces(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  btRigidBody& object = *s.object;
  if (object.getTotalForce().isZero() && object.getTotalTorque().isZero()) return;
  if (isFinite(object.getTotalForce()) && isFinite(object.getTotalTorque())) {
    s.objectForce += toEigen(object.getTotalForce());
    s.objectTorque += toEigen(object.getTotalTorque());
  } else {
    body.restored = true;
  }
  object.clearForces();
  // the system must detect the end of the step
  if (!s.pushed) watchSteps(body);
  s.pushed = true;
}

void accelerateByObject(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  takeObjectForces(body);
  if (s.objectForce.isZero(0.0) && s.objectTorque.isZero(0.0)) return;
  s.sweptBounds.tick = 0.0;
  const RigidFit fit = fitRigid(body);
  if (!(fit.mass > 0.0)) return;
  const Vector3d linear = s.objectForce / fit.mass;
  const Vector3d angular = fit.inverseInertia * s.objectTorque;
  forEachMass(body.state, [&](double, Eigen::Index i) {
    body.state.acceleration.col(i) +=
        linear + angular.cross(Vector3d(body.state.position.col(i) - fit.center));
  });
}

void dropObjectForces(SoftBodyData& body) {
  btRigidBody* object = body.surface.object;
  if (object && (!object->getTotalForce().isZero() || !object->getTotalTorque().isZero()))
    object->clearForces();
}

void offerMotion(SoftBodyData& body, const Vector3d& velocity, const Vector3d& spin) {
  body.surface.object->setLinearVelocity(toBullet(velocity));
  body.surface.object->setAngularVelocity(toBullet(spin));
  leave(body);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
