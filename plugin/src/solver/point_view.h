// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

#include <cstdint>

namespace limber {

/// The points of one body in an array of its own, or among others: coordinate c of point i is at
/// [i pointStride + c axisStride].
struct PointView {
  using Column = Eigen::Map<Eigen::Vector3d, 0, Eigen::InnerStride<>>;
  using ConstColumn = Eigen::Map<const Eigen::Vector3d, 0, Eigen::InnerStride<>>;

  double* position;           ///< m
  double* velocity;           ///< m/s
  const double* inverseMass;  ///< 1/kg
  int axisStride, pointStride;

  ConstColumn positionOf(std::uint32_t i) const { return ConstColumn(position + at(i), step()); }
  Column velocityOf(std::uint32_t i) const { return Column(velocity + at(i), step()); }
  ConstColumn inverseMassOf(std::uint32_t i) const { return ConstColumn(inverseMass + at(i), step()); }

 private:
  Eigen::InnerStride<> step() const { return Eigen::InnerStride<>(axisStride); }
  std::ptrdiff_t at(std::uint32_t i) const { return std::ptrdiff_t{i} * pointStride; }
};

inline PointView viewOf(PointState& state) {
  return {state.position.data(), state.velocity.data(), state.inverseMass.data(), 1, 3};
}

}  // namespace limber
