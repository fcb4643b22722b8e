// SPDX-License-Identifier: Zlib
#include "core/links.h"

#include "core/spring_damping.h"
#include "core/spring_forces.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Anchors on one rigid body disturb each other; Gauss-Seidel over them ends when no velocity changes by more
/// than this (m/s), or after the cap.
constexpr double kAnchorTolerance = 1e-10;
constexpr int kAnchorSweeps = 50;

Vector3d arm(const LinkedBodies& bodies, const LinkEnd& end) {
  return bodies.rigids[end.body].rotation * end.pivot;
}

Vector3d endVelocity(const LinkedBodies& bodies, const LinkEnd& end) {
  switch (end.kind) {
    case LinkEnd::Kind::Point:
      return bodies.points[end.body]->velocity.col(end.point);
    case LinkEnd::Kind::Rigid:
      return bodies.rigids[end.body].velocityAt(arm(bodies, end));
    case LinkEnd::Kind::World:
      break;
  }
  return Vector3d::Zero();
}

void applyImpulse(LinkedBodies& bodies, const LinkEnd& end, const Vector3d& impulse) {
  if (end.kind == LinkEnd::Kind::Point) {
    PointState& p = *bodies.points[end.body];
    p.velocity.col(end.point) += impulse.cwiseProduct(p.inverseMass.col(end.point));
  } else if (end.kind == LinkEnd::Kind::Rigid) {
    bodies.rigids[end.body].applyImpulse(impulse, arm(bodies, end));
  }
}

void addForce(LinkedBodies& bodies, const LinkEnd& end, const Vector3d& force) {
  if (end.kind == LinkEnd::Kind::Point) {
    bodies.points[end.body]->force.col(end.point) += force;
  } else if (end.kind == LinkEnd::Kind::Rigid) {
    RigidState& rigid = bodies.rigids[end.body];
    rigid.force += force;
    rigid.torque += arm(bodies, end).cross(force);
  }
}

/// The velocity change at the end per impulse there, 3 x 3.
Matrix3d mobility(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return Matrix3d::Zero();
  if (end.kind == LinkEnd::Kind::Point)
    return bodies.points[end.body]->inverseMass.col(end.point).asDiagonal();
  const RigidState& rigid = bodies.rigids[end.body];
  const Vector3d r = arm(bodies, end);
  Matrix3d cross;
  cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  Matrix3d m = -cross * rigid.inverseInertia * cross;
  m.diagonal() += rigid.inverseMass;
  return m;
}

/// An upper bound of the mobility in any direction and at any rotation.
double mobilityBound(const LinkedBodies& bodies, const LinkEnd& end) {
  if (end.kind == LinkEnd::Kind::World) return 0.0;
  if (end.kind == LinkEnd::Kind::Point) return bodies.points[end.body]->inverseMass.col(end.point).maxCoeff();
  const RigidState& rigid = bodies.rigids[end.body];
  return rigid.inverseMass.maxCoeff() + end.pivot.squaredNorm() * rigid.inverseInertiaLocal.maxCoeff();
}

bool onOneNode(const LinkEnd& a, const LinkEnd& b) {
  return a.kind == b.kind && a.body == b.body && (a.kind != LinkEnd::Kind::Point || a.point == b.point);
}

void dampLink(LinkedBodies& bodies, const LinkSpring& s, double dt) {
  const Vector3d& n = s.direction;
  const double w = n.dot((mobility(bodies, s.a) + mobility(bodies, s.b)) * n);
  const double speed = n.dot(endVelocity(bodies, s.b) - endVelocity(bodies, s.a));
  const Vector3d impulse = dampingImpulse(s.damping, w, dt) * speed * n;
  applyImpulse(bodies, s.a, impulse);
  applyImpulse(bodies, s.b, -impulse);
}

/// Where the end will be after drifting for dt, as drift() does it.
Vector3d driftedPosition(const LinkedBodies& bodies, const LinkEnd& end, double dt) {
  if (end.kind != LinkEnd::Kind::Rigid) return endPosition(bodies, end) + dt * endVelocity(bodies, end);
  const RigidState& rigid = bodies.rigids[end.body];
  return rigid.position + dt * rigid.velocity + rotationBy(dt * rigid.angularVelocity) * arm(bodies, end);
}

/// One anchor's impulse; returns the velocity error it removed.
double solveAnchor(LinkedBodies& bodies, const LinkAnchor& anchor, double dt) {
  const Matrix3d k = mobility(bodies, anchor.point) + mobility(bodies, anchor.pivot);
  Vector3d error = endVelocity(bodies, anchor.point) - endVelocity(bodies, anchor.pivot);
  if (dt > 0.0)
    error = (driftedPosition(bodies, anchor.point, dt) - driftedPosition(bodies, anchor.pivot, dt)) / dt;
  // where both sides are held along an axis nothing can be done there
  const Vector3d impulse = k.fullPivLu().solve(-error);
  if (!impulse.allFinite()) return 0.0;
  applyImpulse(bodies, anchor.point, impulse);
  applyImpulse(bodies, anchor.pivot, -impulse);
  return (k * impulse).norm();
}

}  // namespace

Vector3d endPosition(const LinkedBodies& bodies, const LinkEnd& end) {
  switch (end.kind) {
    case LinkEnd::Kind::Point:
      return bodies.points[end.body]->position.col(end.point);
    case LinkEnd::Kind::Rigid:
      return bodies.rigids[end.body].position + arm(bodies, end);
    case LinkEnd::Kind::World:
      break;
  }
  return end.pivot;
}

void addLinkForces(LinkedBodies& bodies) {
  for (LinkSpring& s : bodies.springs) {
    const Vector3d d = endPosition(bodies, s.b) - endPosition(bodies, s.a);
    const SpringPull pull = springPull(d, s.restLength, s.extensionStiffness, s.compressionStiffness);
    s.direction = pull.direction;
    s.force = pull.force;
    addForce(bodies, s.a, pull.force * pull.direction);
    addForce(bodies, s.b, -pull.force * pull.direction);
  }
}

void dampLinks(LinkedBodies& bodies, double dt, bool forward) {
  const auto damp = [&](const LinkSpring& s) {
    if (s.damping > 0.0) dampLink(bodies, s, dt);
  };
  if (forward)
    std::for_each(bodies.springs.begin(), bodies.springs.end(), damp);
  else
    std::for_each(bodies.springs.rbegin(), bodies.springs.rend(), damp);
}

double linkFrequencyBoundSquared(const LinkedBodies& bodies) {
  double bound = 0.0;
  const auto stiffness = [](const LinkSpring& s) {
    return std::max(s.extensionStiffness, s.compressionStiffness);
  };
  for (const LinkSpring& s : bodies.springs) {
    double row = 0.0;
    for (const LinkEnd* mine : {&s.a, &s.b})
      for (const LinkSpring& t : bodies.springs)
        for (const LinkEnd* other : {&t.a, &t.b})
          if (onOneNode(*mine, *other))
            row += stiffness(t) * std::sqrt(mobilityBound(bodies, *mine) * mobilityBound(bodies, *other));
    bound = std::max(bound, row);
  }
  return bound;
}

void solveAnchors(LinkedBodies& bodies, double dt) {
  if (bodies.anchors.empty()) return;
  for (int sweep = 0; sweep < kAnchorSweeps; ++sweep) {
    double largest = 0.0;
    for (const LinkAnchor& anchor : bodies.anchors)
      largest = std::max(largest, solveAnchor(bodies, anchor, dt));
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
