// SPDX-License-Identifier: Zlib
#include "solver/coincident_points.h"

#include <cstdint>

namespace limber {
namespace {

/// Of the rest length: closer counts as one place, and farther apart they are put.
constexpr double kSamePlace = 1e-9;
constexpr double kApart = 1e-6;

/// -1 to 1, the same for the same input on every machine (the mixing step of SplitMix64; Steele, Lea, Flood
/// 2014).
double scatter(std::uint64_t seed) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15u + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * (2.0 / 9007199254740992.0) - 1.0;
}

Eigen::Vector3d directionOf(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t seed = (std::uint64_t{a} << 32 | b) * 3;
  const Eigen::Vector3d d(scatter(seed), scatter(seed + 1), scatter(seed + 2));
  return d.norm() > 0.0 ? Eigen::Vector3d(d.normalized()) : Eigen::Vector3d::UnitX();
}

}  // namespace

void separateCoincident(const SpringArrays& springs, PointState& state) {
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = springs.a[s], b = springs.b[s];
    const double length = springs.restLength[s];
    if ((state.position.col(b) - state.position.col(a)).norm() >= kSamePlace * length) continue;
    const Eigen::Vector3d wa = state.inverseMass.col(a), wb = state.inverseMass.col(b);
    const double sum = (wa + wb).maxCoeff();
    if (!(sum > 0.0)) continue;
    const Eigen::Vector3d apart = kApart * length / sum * directionOf(a, b);
    state.position.col(a) -= wa.cwiseProduct(apart);
    state.position.col(b) += wb.cwiseProduct(apart);
  }
}

}  // namespace limber
