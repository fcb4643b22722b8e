// SPDX-License-Identifier: Zlib
#include "core/energy_guard.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace limber {
namespace {

double massOf(const PointState& state, Eigen::Index i) {
  const double w = state.inverseMass.col(i).maxCoeff();
  return w > 0.0 ? 1.0 / w : 0.0;
}

struct RigidMotion {
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  omega = Eigen::Vector3d::Zero();

  Eigen::Vector3d at(const Eigen::Vector3d& x) const { return velocity + omega.cross(x - center); }
};

/// The rigid motion with the same momenta; zero if anything is held.
RigidMotion rigidMotion(const PointState& state) {
  RigidMotion rigid;
  if ((state.inverseMass.array() == 0.0).any()) return rigid;
  double mass = 0.0;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    mass += massOf(state, i);
    rigid.center += massOf(state, i) * state.position.col(i);
    rigid.velocity += massOf(state, i) * state.velocity.col(i);
  }
  rigid.center /= mass;
  rigid.velocity /= mass;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d r = state.position.col(i) - rigid.center;
    inertia += massOf(state, i) * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    spin += massOf(state, i) * r.cross(Eigen::Vector3d(state.velocity.col(i)));
  }
  // all points on a line have no inertia about it, and no spin either
  rigid.omega = inertia.completeOrthogonalDecomposition().solve(spin);
  return rigid;
}

}  // namespace

double removeKineticEnergy(PointState& state, double excess) {
  const RigidMotion rigid = rigidMotion(state);
  double internal = 0.0;
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const Eigen::Vector3d own = state.velocity.col(i) - rigid.at(state.position.col(i));
    internal += 0.5 * massOf(state, i) * own.squaredNorm();
  }
  if (!(internal > 0.0)) return excess;
  const double scale = std::sqrt(std::max(0.0, 1.0 - excess / internal));
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    if (massOf(state, i) == 0.0) continue;
    const Eigen::Vector3d motion = rigid.at(state.position.col(i));
    state.velocity.col(i) = motion + scale * (state.velocity.col(i) - motion);
  }
  return std::max(0.0, excess - internal);
}

}  // namespace limber
