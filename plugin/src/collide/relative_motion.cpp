// SPDX-License-Identifier: Zlib
#include "collide/relative_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Share of the trace of I that is added to its diagonal: points on a line do not tell their turn about it.
constexpr double kRegular = 1e-9;

Vector3d turnOf(const PointColumns& positions, const PointColumns& velocities, const SurfaceMotion& m) {
  Matrix3d second = Matrix3d::Zero();
  Vector3d moment = Vector3d::Zero();
  for (Index i = 0; i < velocities.cols(); ++i) {
    const Vector3d r = positions.col(i) - m.centre;
    second.noalias() += r * r.transpose();
    moment += r.cross(Vector3d(velocities.col(i) - m.mean));
  }
  const double trace = second.trace();
  if (!(trace > 0.0)) return Vector3d::Zero();
  return (Matrix3d::Identity() * (trace * (1.0 + kRegular)) - second).inverse() * moment;
}

}  // namespace

SurfaceMotion fittedMotion(const PointColumns& positions, const PointColumns& velocities) {
  SurfaceMotion m;
  const Index count = velocities.cols();
  if (count == 0) return m;
  for (Index i = 0; i < count; ++i) m.centre += positions.col(i), m.mean += velocities.col(i);
  m.centre /= static_cast<double>(count);
  m.mean /= static_cast<double>(count);
  m.turn = turnOf(positions, velocities, m);
  double radius = 0.0, spread = 0.0, deformation = 0.0;
  for (Index i = 0; i < count; ++i) {
    const Vector3d r = positions.col(i) - m.centre, v = velocities.col(i) - m.mean;
    radius = std::max(radius, r.squaredNorm());
    spread = std::max(spread, v.squaredNorm());
    deformation = std::max(deformation, (v - m.turn.cross(r)).squaredNorm());
  }
  m.radius = std::sqrt(radius);
  m.spread = std::sqrt(spread);
  m.deformation = std::sqrt(deformation);
  return m;
}

SurfaceMotion fittedMotion(const PointView& points, Index count) {
  const Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic> stride(points.pointStride, points.axisStride);
  using Columns = Eigen::Map<const Points, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  return fittedMotion(Columns(points.position, 3, count, stride), Columns(points.velocity, 3, count, stride));
}

RelativeMotion relativeMotion(const SurfaceMotion& a, const SurfaceMotion& b, MotionFrame frame) {
  if (frame == MotionFrame::Still) return {a.mean - b.mean, a.spread + b.spread, 0.0};
  const Vector3d between = a.centre - b.centre;
  const bool atA = frame == MotionFrame::AtA;
  return {a.mean - b.mean - (atA ? b.turn : a.turn).cross(between),
          (a.turn - b.turn).norm() * (atA ? a.radius : b.radius) + a.deformation + b.deformation,
          std::max(a.turn.norm(), b.turn.norm())};
}

MotionFrame calmestFrame(const SurfaceMotion& a, const SurfaceMotion& b, double featureSize) {
  const auto speed = [&](MotionFrame frame) { return relativeMotion(a, b, frame).speed(featureSize); };
  return std::min({MotionFrame::Still, MotionFrame::AtA, MotionFrame::AtB},
                  [&](MotionFrame x, MotionFrame y) { return speed(x) < speed(y); });
}

}  // namespace limber
