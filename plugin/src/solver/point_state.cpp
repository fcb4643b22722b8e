// SPDX-License-Identifier: Zlib
// Computes sums over the point masses of a body and changes its motion as a whole.
#include "solver/point_state.h"

#include "mesh/linear_algebra.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstring>

namespace limber {
namespace {

// --- measures of a body ------------------------------------------------------------------------------------

std::uint64_t addBits(std::uint64_t hash, const Points& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values.data() + i, sizeof bits);
    for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 1099511628211ull;
  }
  return hash;
}

}  // namespace

double totalMass(const PointState& state) {
  double sum = 0.0;
  forEachMass(state, [&](double m, Eigen::Index) { sum += m; });
  return sum;
}

Eigen::Vector3d centerOfMass(const PointState& state) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  forEachMass(state, [&](double m, Eigen::Index i) { sum += m * state.position.col(i); });
  const double mass = totalMass(state);
  return mass > 0.0 ? Eigen::Vector3d(sum / mass) : Eigen::Vector3d(state.position.rowwise().mean());
}

Eigen::Vector3d linearMomentum(const PointState& state) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  forEachMass(state, [&](double m, Eigen::Index i) { sum += m * state.velocity.col(i); });
  return sum;
}

Eigen::Vector3d angularMomentum(const PointState& state) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  forEachMass(state, [&](double m, Eigen::Index i) {
    const Eigen::Vector3d x = state.position.col(i), v = state.velocity.col(i);
    sum += m * x.cross(v);
  });
  return sum;
}

double kineticEnergy(const PointState& state) {
  double sum = 0.0;
  forEachMass(state, [&](double m, Eigen::Index i) { sum += 0.5 * m * state.velocity.col(i).squaredNorm(); });
  return sum;
}

std::uint64_t stateHash(const PointState& state) {
  return addBits(addBits(14695981039346656037ull, state.position), state.velocity);
}

// --- corrections of the motion -----------------------------------------------------------------------------

namespace {

/// Mass, the centre of mass and its velocity, and the angular momentum and inertia about it.
struct BodyMoments {
  double mass = 0.0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  spin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();

  /// Returns the angular velocity (rad/s). Uses the pseudoinverse: points on a line have neither inertia nor
  /// angular momentum about that line.
  Eigen::Vector3d turnFor(const Eigen::Vector3d& angularMomentum) const {
    return pseudoInverse(inertia) * angularMomentum;
  }
};

BodyMoments momentsOf(const PointState& state) {
  BodyMoments m;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    m.mass += massOf(state.inverseMass, i);
    m.center += massOf(state.inverseMass, i) * state.position.col(i);
    m.velocity += massOf(state.inverseMass, i) * state.velocity.col(i);
  }
  if (!(m.mass > 0.0)) return m;
  m.center /= m.mass;
  m.velocity /= m.mass;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d r = state.position.col(i) - m.center;
    m.inertia +=
        massOf(state.inverseMass, i) * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    m.spin += massOf(state.inverseMass, i) * r.cross(Eigen::Vector3d(state.velocity.col(i) - m.velocity));
  }
  return m;
}

}  // namespace

double removeKineticEnergy(PointState& state, double excess) {
  // the rigid motion with the same linear and angular momentum; none if a point is held on any axis
  const bool isFree = !(state.inverseMass.array() == 0.0).any();
  const BodyMoments rigid = isFree ? momentsOf(state) : BodyMoments();
  const Eigen::Vector3d omega = rigid.turnFor(rigid.spin);
  const auto rigidVelocity = [&](Eigen::Index i) -> Eigen::Vector3d {
    return rigid.velocity + omega.cross(Eigen::Vector3d(state.position.col(i) - rigid.center));
  };
  double internal = 0.0;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d own = state.velocity.col(i) - rigidVelocity(i);
    internal += 0.5 * massOf(state.inverseMass, i) * own.squaredNorm();
  }
  if (!(internal > 0.0)) return excess;
  const double scale = std::sqrt(std::max(0.0, 1.0 - excess / internal));
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    if (massOf(state.inverseMass, i) == 0.0) continue;
    const Eigen::Vector3d motion = rigidVelocity(i);
    state.velocity.col(i) = motion + scale * (state.velocity.col(i) - motion);
  }
  return std::max(0.0, excess - internal);
}

Eigen::Vector3d spinOf(const PointState& state) { return momentsOf(state).spin; }

void setSpin(PointState& state, const Eigen::Vector3d& spin) {
  const BodyMoments m = momentsOf(state);
  const Eigen::Vector3d omega = m.turnFor(spin - m.spin);
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    state.velocity.col(i) += omega.cross(Eigen::Vector3d(state.position.col(i) - m.center));
}

}  // namespace limber
