// SPDX-License-Identifier: Zlib
#include "implicit_shapes.h"

#include "triangle_soup.h"

#include <algorithm>
#include <cmath>

namespace shapes {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Step of the central differences that give the gradient, metres.
constexpr double kGradientStep = 1e-4;

double distanceToLine(const Vector3d& p, const Joint& from, const Joint& to) {
  const Vector3d axis = to.centre - from.centre;
  const double along = std::clamp((p - from.centre).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (p - from.centre - along * axis).norm() - (from.radius + along * (to.radius - from.radius));
}

/// Polynomial smooth minimum (I. Quilez): the lesser one, rounded off where they differ by less than `blend`.
double smoothMin(double a, double b, double blend) {
  const double overlap = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - overlap * overlap * blend / 4.0;
}

/// The rotation by `degrees` in the plane of the axes u and v, from u to v.
Matrix3d rotation(int u, int v, double degrees) {
  const double angle = degrees * kPi / 180.0;
  Matrix3d result = Matrix3d::Identity();
  result(u, u) = result(v, v) = std::cos(angle);
  result(v, u) = std::sin(angle);
  result(u, v) = -result(v, u);
  return result;
}

}  // namespace

Field limb(const std::vector<Joint>& joints) {
  return [joints](const Vector3d& p) {
    double distance = distanceToLine(p, joints[0], joints[1]);
    for (std::size_t i = 2; i < joints.size(); ++i)
      distance = std::min(distance, distanceToLine(p, joints[i - 1], joints[i]));
    return distance;
  };
}

Field ellipsoid(const Vector3d& centre, const Vector3d& radii, const Vector3d& tilt) {
  const Matrix3d toOwn =
      (rotation(0, 1, tilt.z()) * rotation(2, 0, tilt.y()) * rotation(1, 2, tilt.x())).transpose();
  return [=](const Vector3d& p) {
    const Vector3d unit = (toOwn * (p - centre)).cwiseQuotient(radii);
    const double length = unit.norm(), slope = unit.cwiseQuotient(radii).norm();
    return slope > 0.0 ? length * (length - 1.0) / slope : -radii.minCoeff();
  };
}

Field halfSpace(const Vector3d& point, const Vector3d& normal) {
  return [=](const Vector3d& p) { return (p - point).dot(normal); };
}

Field unite(const std::vector<Field>& bodies, double blend) {
  return [=](const Vector3d& p) {
    double distance = bodies[0](p);
    for (std::size_t i = 1; i < bodies.size(); ++i) distance = smoothMin(distance, bodies[i](p), blend);
    return distance;
  };
}

Field intersect(const Field& a, const Field& b, double blend) {
  return [=](const Vector3d& p) { return -smoothMin(-a(p), -b(p), blend); };
}

Field outside(const Field& body) {
  return [=](const Vector3d& p) { return -body(p); };
}

Field mirrorX(const Field& half) {
  return [=](const Vector3d& p) { return half(Vector3d(std::abs(p.x()), p.y(), p.z())); };
}

Vector3d gradient(const Field& field, const Vector3d& p) {
  Vector3d result;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kGradientStep * Vector3d::Unit(axis);
    result[axis] = (field(p + step) - field(p - step)) / (2.0 * kGradientStep);
  }
  return result;
}

Vector3d towardsSurface(const Field& field, const Vector3d& p) {
  const Vector3d slope = gradient(field, p);
  return p - field(p) / slope.squaredNorm() * slope;
}

}  // namespace shapes
