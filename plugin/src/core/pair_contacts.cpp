// SPDX-License-Identifier: Zlib
#include "core/pair_contacts.h"

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// As in contact_rows.cpp.
constexpr double kRecovery = 0.2;

constexpr int kMostSweeps = 32;

Vector3d velocityAt(const LinkedBodies& bodies, const SurfacePlace& place) {
  if (place.kind == SurfacePlace::Kind::World) return place.velocity;
  if (place.kind == SurfacePlace::Kind::Rigid) return bodies.rigids[place.body].velocityAt(place.arm);
  const Points& velocity = bodies.points[place.body]->velocity;
  Vector3d sum = place.weight[0] * velocity.col(place.point[0]);
  for (std::uint32_t i = 1; i < place.count; ++i) sum += place.weight[i] * velocity.col(place.point[i]);
  return sum;
}

void push(LinkedBodies& bodies, const SurfacePlace& place, const Vector3d& impulse) {
  if (place.kind == SurfacePlace::Kind::Rigid) {
    bodies.rigids[place.body].applyImpulse(impulse, place.arm);
  } else if (place.kind == SurfacePlace::Kind::Soft) {
    PointState& p = *bodies.points[place.body];
    for (std::uint32_t i = 0; i < place.count; ++i)
      p.velocity.col(place.point[i]) +=
          place.weight[i] * impulse.cwiseProduct(p.inverseMass.col(place.point[i]));
  }
}

/// The velocity change there per impulse there, 3 x 3.
Matrix3d mobility(const LinkedBodies& bodies, const SurfacePlace& place) {
  Matrix3d m = Matrix3d::Zero();
  if (place.kind == SurfacePlace::Kind::Soft) {
    const PointState& p = *bodies.points[place.body];
    for (std::uint32_t i = 0; i < place.count; ++i)
      m.diagonal() += place.weight[i] * place.weight[i] * p.inverseMass.col(place.point[i]);
  } else if (place.kind == SurfacePlace::Kind::Rigid) {
    const RigidState& rigid = bodies.rigids[place.body];
    const Vector3d& r = place.arm;
    Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    m = -cross * rigid.inverseInertia() * cross;
    m.diagonal() += rigid.inverseMass;
  }
  return m;
}

void bear(LinkedBodies& bodies, PairContact& c, const Vector3d& impulse) {
  push(bodies, c.a, impulse);
  push(bodies, c.b, -impulse);
  c.impulse += impulse;
}

/// Brings the speed along the normal up to `target`, with the sum of the impulses so far 0 or more, and
/// friction within its cone. Returns the largest change of velocity.
double solveContact(LinkedBodies& bodies, PairContact& c, PairContact::Bearing& sum, double target) {
  if (c.mass == 0.0) return 0.0;
  const Vector3d relative = velocityAt(bodies, c.a) - velocityAt(bodies, c.b);
  const double speed = c.normal.dot(relative);
  const double along = std::max(0.0, sum.along + (target - speed) * c.mass);
  Vector3d across = Vector3d::Zero();
  if (c.friction > 0.0 && along > 0.0) {
    across = sum.across - c.acrossMass * (relative - speed * c.normal);
    const double most = c.friction * along, squared = across.squaredNorm();
    if (squared > most * most) across *= most / std::sqrt(squared);
  }
  const Vector3d change = (along - sum.along) * c.normal + across - sum.across;
  if (change.isZero(0.0)) return 0.0;
  sum.along = along;
  sum.across = across;
  bear(bodies, c, change);
  return change.norm() / c.mass;
}

/// The largest eigenvalue of a symmetric matrix between directions across n: with s half the trace and d the
/// determinant of its 2 x 2 part  s + sqrt(s^2 - d).
double largestAcross(const Matrix3d& m, const Vector3d& n) {
  const Vector3d t = n.unitOrthogonal(), u = n.cross(t);
  const double tt = t.dot(m * t), uu = u.dot(m * u), tu = t.dot(m * u), half = 0.5 * (tt + uu);
  return half + std::sqrt(std::max(0.0, half * half - (tt * uu - tu * tu)));
}

double targetOf(const PairContact& c, double dt) {
  return c.gap >= 0.0 ? -c.gap / dt : std::min(-kRecovery * c.gap / dt, c.recoverySpeed);
}

/// What the last substep bore is about what this one will.
void warmStart(LinkedBodies& bodies, PairContact& c, const PairContact::Bearing& sum) {
  if (sum.along > 0.0) bear(bodies, c, sum.along * c.normal + sum.across);
}

}  // namespace

void preparePairs(std::vector<PairContact>& contacts, const LinkedBodies& bodies) {
  for (PairContact& c : contacts) {
    const Matrix3d m = mobility(bodies, c.a) + mobility(bodies, c.b);
    const double along = c.normal.dot(m * c.normal), across = largestAcross(m, c.normal);
    c.mass = along > 0.0 ? 1.0 / along : 0.0;
    c.acrossMass = across > 0.0 ? 1.0 / across : 0.0;
    c.impulse.setZero();
  }
}

int stopPairs(std::vector<PairContact>& contacts, LinkedBodies& bodies, double dt, double tolerance) {
  for (PairContact& c : contacts) warmStart(bodies, c, c.stopping);
  int sweep = 0;
  for (double largest = HUGE_VAL; largest > tolerance && sweep < kMostSweeps; ++sweep) {
    largest = 0.0;
    for (PairContact& c : contacts)
      largest = std::max(largest, solveContact(bodies, c, c.stopping, targetOf(c, dt)));
  }
  return sweep;
}

void movePairs(std::vector<PairContact>& contacts, const LinkedBodies& bodies, double dt) {
  for (PairContact& c : contacts)
    c.gap += dt * c.normal.dot(velocityAt(bodies, c.a) - velocityAt(bodies, c.b));
}

int settlePairs(std::vector<PairContact>& contacts, LinkedBodies& bodies, double tolerance) {
  for (PairContact& c : contacts) {
    if (c.stopping.along == 0.0) c.settling = {};
    warmStart(bodies, c, c.settling);
  }
  int sweep = 0;
  for (double largest = HUGE_VAL; largest > tolerance && sweep < kMostSweeps; ++sweep) {
    largest = 0.0;
    for (PairContact& c : contacts)
      if (c.stopping.along > 0.0) largest = std::max(largest, solveContact(bodies, c, c.settling, 0.0));
  }
  return sweep;
}

}  // namespace limber
