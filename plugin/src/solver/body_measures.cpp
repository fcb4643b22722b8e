// SPDX-License-Identifier: Zlib
#include "solver/body_measures.h"

#include <Eigen/Geometry>

#include <cstring>

namespace limber {
namespace {

/// Calls visit(mass, i) for every point that can move.
template <class Visit>
void forEachMass(const PointState& state, Visit visit) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i) {
    const double mass = massOf(state.inverseMass, i);
    if (mass > 0.0) visit(mass, i);
  }
}

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

}  // namespace limber
