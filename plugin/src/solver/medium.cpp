// SPDX-License-Identifier: Zlib
// Applies the drag of a medium to points, and computes the drag and the buoyancy of triangles and segments.

#include "solver/medium.h"

#include "mesh/surface.h"

#include <Eigen/Geometry>

#include <cmath>
#include <type_traits>

namespace limber {

// --- the drag on points ------------------------------------------------------------------------------------

namespace {

/// Adds up the change of the kinetic energy (J) and the momentum (N s) of points that are not held, or
/// nothing.
template <bool kMeasured>
struct MotionChange {
  double energy = 0.0, momentum[3] = {0.0, 0.0, 0.0};

  void add(int axis, double before, double after, double inverseMass) {
    if (!kMeasured || !(inverseMass > 0.0)) return;
    energy += 0.5 * (after - before) * (after + before) / inverseMass;
    momentum[axis] += (after - before) / inverseMass;
  }
};

/// Applies the decay. Returns the change of motion, if `Change` measures it.
template <class Change>
Change applyRate(double keep, const PointView& points, Eigen::Index count) {
  Change change;
  double* v = points.velocity;
  const double* w = points.inverseMass;
  for (Eigen::Index i = 0; i < count; ++i, v += points.pointStride, w += points.pointStride)
    for (int c = 0, at = 0; c < 3; ++c, at += points.axisStride) {
      const double before = v[at];
      v[at] *= w[at] > 0.0 ? keep : 1.0;
      change.add(c, before, v[at], w[at]);
    }
  return change;
}

/// Applies the decay and the terms. `axis`: the axis stride, a constant for bodies in arrays of their own.
template <class Change, class Axis>
Change applyTerms(const PointDrag& drag, double keep, const PointView& points, Eigen::Index count, double dt,
                  Axis axis) {
  Change change;
  const double* t = drag.terms.data();
  double* v = points.velocity;
  const double* w = points.inverseMass;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double s = std::min(dt, t[9]), wx = w[0], wy = w[axis], wz = w[2 * axis];
    const double before[] = {v[0], v[axis], v[2 * axis]};
    const double x = before[0] * (wx > 0.0 ? keep : 1.0), y = before[1] * (wy > 0.0 ? keep : 1.0),
                 z = before[2] * (wz > 0.0 ? keep : 1.0);
    v[0] = x + s * wx * (t[6] - (t[0] * x + t[3] * y + t[5] * z));
    v[axis] = y + s * wy * (t[7] - (t[3] * x + t[1] * y + t[4] * z));
    v[2 * axis] = z + s * wz * (t[8] - (t[5] * x + t[4] * y + t[2] * z));
    for (int c = 0; c < 3; ++c) change.add(c, before[c], v[c * axis], w[c * axis]);
    t += PointDrag::kTerms, v += points.pointStride, w += points.pointStride;
  }
  return change;
}

template <class Change>
Change applyAll(const PointDrag& drag, const PointView& points, Eigen::Index count, double dt) {
  const double keep = drag.rate > 0.0 ? std::exp(-drag.rate * dt) : 1.0;
  if (drag.terms.cols() == 0) return applyRate<Change>(keep, points, count);
  if (points.axisStride == 1)
    return applyTerms<Change>(drag, keep, points, count, dt, std::integral_constant<int, 1>());
  return applyTerms<Change>(drag, keep, points, count, dt, points.axisStride);
}

}  // namespace

void clearDrag(PointDrag& drag, Eigen::Index points) { drag.terms.setZero(PointDrag::kTerms, points); }

void addDrag(PointDrag& drag, Eigen::Index i, double k, const Eigen::Vector3d& n, double c,
             const Eigen::Vector3d& w) {
  double* t = drag.terms.data() + PointDrag::kTerms * i;
  const double along = k * n.dot(w);
  for (int axis = 0; axis < 3; ++axis) {
    t[axis] += k * n[axis] * n[axis] + c;
    t[6 + axis] += along * n[axis] + c * w[axis];
  }
  t[3] += k * n[0] * n[1];
  t[4] += k * n[1] * n[2];
  t[5] += k * n[2] * n[0];
}

double limitDrag(PointDrag& drag, const Points& inverseMass) {
  double fastest = 0.0;
  for (Eigen::Index i = 0; i < drag.terms.cols(); ++i) {
    auto t = drag.terms.col(i);
    // the largest row sum bounds the eigenvalues
    const double xy = std::abs(t[3]), yz = std::abs(t[4]), zx = std::abs(t[5]);
    const double largest = std::max({t[0] + xy + zx, t[1] + xy + yz, t[2] + yz + zx});
    const double rate = largest * inverseMass.col(i).maxCoeff();
    t[9] = rate > 0.0 ? 1.0 / rate : 0.0;
    fastest = std::max(fastest, rate);
  }
  return fastest;
}

// --- air and water -----------------------------------------------------------------------------------------

namespace {

using Eigen::Vector3d;

template <std::size_t N>
Vector3d meanOf(const Points& values, const std::array<std::uint32_t, N>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t corner : corners) sum += values.col(corner);
  return sum / static_cast<double>(N);
}

template <std::size_t N>
Vector3d velocityOf(const Flow& flow, const std::array<std::uint32_t, N>& corners) {
  return flow.velocityAt ? meanOf(*flow.velocityAt, corners) : flow.velocity;
}

/// The part of a triangle that is cut off at one corner by the plane.
struct CutCorner {
  std::size_t corner;  ///< alone on its side of the plane; the others are the next two
  double s, t;         ///< shares of the edges to the next and the last corner that are on its side
};

enum class Side { Dry, Wet, Cut };

/// Returns on which side of the plane a triangle with these depths is. Sets `cut` if it is on both.
Side sideOf(const std::array<double, 3>& depth, CutCorner& cut) {
  const int wet = (depth[0] > 0.0) + (depth[1] > 0.0) + (depth[2] > 0.0);
  if (wet == 0) return Side::Dry;
  if (wet == 3) return Side::Wet;
  for (std::size_t k = 0; k < 3; ++k)
    if ((depth[k] > 0.0) == (wet == 1)) cut.corner = k;
  const double own = depth[cut.corner];
  cut.s = own / (own - depth[(cut.corner + 1) % 3]);
  cut.t = own / (own - depth[(cut.corner + 2) % 3]);
  return Side::Cut;
}

std::array<double, 3> depthsOf(const Triangle& triangle, const Points& position, const WaterPlane& plane) {
  std::array<double, 3> depth;
  for (std::size_t k = 0; k < 3; ++k) depth[k] = plane.depthOf(position.col(triangle[k]));
  return depth;
}

/// Returns the share of a triangle's area below the plane.
double wetShare(const Triangle& triangle, const Points& position, const WaterPlane& plane) {
  if (!plane.isThere()) return 0.0;
  const std::array<double, 3> depth = depthsOf(triangle, position, plane);
  CutCorner cut{};
  const Side side = sideOf(depth, cut);
  if (side != Side::Cut) return side == Side::Wet ? 1.0 : 0.0;
  const double share = cut.s * cut.t;
  return depth[cut.corner] > 0.0 ? share : 1.0 - share;
}

/// Adds the drag of `area` (m^2) of a triangle with the unit normal n.
void addTriangleDrag(const Triangle& corners, const Vector3d& n, double area, const Flow& flow,
                     const Vector3d& velocity, PointDrag& drag) {
  const Vector3d w = velocityOf(flow, corners), u = w - velocity;
  const double speed = u.norm(), across = std::abs(n.dot(u));
  const double share = 0.5 * flow.density * area / 3.0;
  const double pressed = share * (flow.lift * speed + (flow.drag - flow.lift) * across);
  const double c = share * ((flow.drag - flow.lift) * across + flow.friction * speed);
  const double k = pressed - c;
  if (speed > 0.0)
    for (const std::uint32_t corner : corners) addDrag(drag, corner, k, n, c, w);
}

/// The same for a part of a cylinder along the unit vector t.
void addSegmentDrag(const std::array<std::uint32_t, 2>& ends, const Vector3d& t, double frontal,
                    const Flow& flow, const Vector3d& velocity, PointDrag& drag) {
  const Vector3d w = velocityOf(flow, ends), u = w - velocity;
  const double share = 0.5 * flow.density * frontal / 2.0;
  const double across = share * flow.drag * (u - u.dot(t) * t).norm();
  const double along = share * kPi * flow.friction * u.norm();
  if (across + along > 0.0)
    for (const std::uint32_t end : ends) addDrag(drag, end, along - across, t, across, w);
}

/// `sides`: share of the area that counts.
void addTriangles(const std::vector<Triangle>& triangles, double sides, const MovingPoints& points,
                  const Flow& air, const Flow& water, const WaterPlane& plane, PointDrag& drag) {
  for (const Triangle& t : triangles) {
    const Points& x = points.position;
    const Vector3d doubled = Vector3d(x.col(t[1]) - x.col(t[0])).cross(Vector3d(x.col(t[2]) - x.col(t[0])));
    const double size = doubled.norm(), area = 0.5 * sides * size;
    if (!(size > 0.0)) continue;
    const Vector3d n = doubled / size, v = meanOf(points.velocity, t);
    const double wet = wetShare(t, x, plane);
    if (wet < 1.0 && air.acts()) addTriangleDrag(t, n, (1.0 - wet) * area, air, v, drag);
    if (wet > 0.0 && water.acts()) addTriangleDrag(t, n, wet * area, water, v, drag);
  }
}

void addSegments(const WettedParts& parts, double diameter, const MovingPoints& points, const Flow& air,
                 const Flow& water, const WaterPlane& plane, PointDrag& drag) {
  for (const auto& ends : parts.segments) {
    const Vector3d along = points.position.col(ends[1]) - points.position.col(ends[0]);
    const double length = along.norm(), frontal = length * diameter;
    if (!(length > 0.0)) continue;
    const Vector3d t = along / length, v = meanOf(points.velocity, ends);
    double wet = 0.0;
    if (plane.isThere()) {
      const double a = plane.depthOf(points.position.col(ends[0])),
                   b = plane.depthOf(points.position.col(ends[1]));
      wet = a > 0.0 && b > 0.0 ? 1.0 : std::max({a, b, 0.0}) / std::max(std::abs(a - b), 1e-300);
      wet = std::min(wet, 1.0);
    }
    if (wet < 1.0 && air.acts()) addSegmentDrag(ends, t, (1.0 - wet) * frontal, air, v, drag);
    if (wet > 0.0 && water.acts()) addSegmentDrag(ends, t, wet * frontal, water, v, drag);
  }
}

/// Integrals over the triangle below the plane, divided by its area: of the depth times the weight of each
/// corner (m), and of 1.
struct DepthIntegral {
  Vector3d moments;
  double share;
};

/// With the depth d linear in a triangle, the mean of d N_j is (d_j + sum d) / 12. In the part cut off at a
/// corner, d is 0 at the two other corners.
DepthIntegral integrate(const std::array<double, 3>& depth) {
  CutCorner cut{};
  const Side side = sideOf(depth, cut);
  if (side == Side::Dry) return {Vector3d::Zero(), 0.0};
  const Vector3d d(depth[0], depth[1], depth[2]);
  const Vector3d whole = (d.array() + d.sum()).matrix() / 12.0;
  if (side == Side::Wet) return {whole, 1.0};
  const std::size_t k = cut.corner;
  const double share = cut.s * cut.t, scale = share * depth[k] / 12.0;
  Vector3d part;
  part[static_cast<Eigen::Index>(k)] = scale * (4.0 - cut.s - cut.t);
  part[static_cast<Eigen::Index>((k + 1) % 3)] = scale * cut.s;
  part[static_cast<Eigen::Index>((k + 2) % 3)] = scale * cut.t;
  if (depth[k] > 0.0) return {part, share};
  return {whole - part, 1.0 - share};
}

}  // namespace

void addDragOfParts(const WettedParts& parts, double diameter, const MovingPoints& points, const Flow& air,
                    const Flow& water, const WaterPlane& plane, PointDrag& drag) {
  addTriangles(parts.closed, 0.5, points, air, water, plane, drag);
  addTriangles(parts.sheets, 1.0, points, air, water, plane, drag);
  addSegments(parts, diameter, points, air, water, plane, drag);
}

double addBuoyancy(const std::vector<Triangle>& closed, const Points& position, const WaterPlane& plane,
                   Points& force) {
  double planeArea = 0.0;
  for (const Triangle& t : closed) {
    const DepthIntegral integral = integrate(depthsOf(t, position, plane));
    if (integral.share == 0.0) continue;
    const Vector3d area = 0.5 * Vector3d(position.col(t[1]) - position.col(t[0]))
                                    .cross(Vector3d(position.col(t[2]) - position.col(t[0])));
    // the area vectors below the plane and that of the plane inside the surface sum up to zero
    planeArea -= integral.share * area.dot(plane.up);
    for (std::size_t k = 0; k < 3; ++k)
      force.col(t[k]) -= plane.weight * integral.moments[static_cast<Eigen::Index>(k)] * area;
  }
  return planeArea;
}

// --- the drag of a substep ---------------------------------------------------------------------------------

namespace {

/// Computes the drag in air of the middle of the coming interval.
void updateDrag(PointDrag& drag, const PointView& points, Eigen::Index count) {
  DragUpdates& u = drag.updates;
  Points &x = *u.position, &v = *u.velocity;
  x.resize(3, count), v.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    v.col(i) = points.velocityOf(static_cast<std::uint32_t>(i));
    x.col(i) = points.positionOf(static_cast<std::uint32_t>(i)) + 0.5 * u.interval * v.col(i);
  }
  clearDrag(drag, count);
  addDragOfParts(*u.parts, u.diameter, {x, v}, u.air, Flow(), WaterPlane(), drag);
  limitDrag(drag, *u.inverseMass);
  u.since = 0.0;
}

}  // namespace

void startDrag(PointDrag& drag, const PointView& points, Eigen::Index count) {
  drag.work = 0.0;
  drag.impulse.setZero();
  if (drag.updates.interval > 0.0) updateDrag(drag, points, count);
}

void applyDrag(PointDrag& drag, const PointView& points, Eigen::Index count, double dt) {
  if (drag.measured) {
    const auto change = applyAll<MotionChange<true>>(drag, points, count, dt);
    drag.work += change.energy;
    drag.impulse += Eigen::Map<const Eigen::Vector3d>(change.momentum);
  } else {
    applyAll<MotionChange<false>>(drag, points, count, dt);
  }
  DragUpdates& updates = drag.updates;
  if (updates.interval > 0.0 && (updates.since += dt) >= updates.interval) updateDrag(drag, points, count);
}

}  // namespace limber
