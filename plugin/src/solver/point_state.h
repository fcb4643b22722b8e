// SPDX-License-Identifier: Zlib
#pragma once

// The point masses of a body, in arrays; sums over them, and changes of the motion as a whole.

#include <Eigen/Core>

#include <cstdint>

namespace limber {

// --- points ------------------------------------------------------------------------------------------------

/// One column per point mass.
using Points = Eigen::Matrix3Xd;

inline double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

/// The state of a body's point masses, in double so that it is not limited by the host's precision.
/// All arrays are 3 x #points.
struct PointState {
  Points position;      ///< m
  Points velocity;      ///< m/s
  Points acceleration;  ///< m/s^2 from everything but the springs, constant over a tick
  Points inverseMass;   ///< 1/kg per axis; 0 where a point is held
  Points force;         ///< N from the springs at `position`
  Points earlierForce;  ///< N, scratch of the step

  void resize(Eigen::Index points) {
    for (Points* array : {&position, &velocity, &acceleration, &inverseMass, &force, &earlierForce})
      array->setZero(3, points);
  }
};

/// Whether point i is held; one that may move along some axes only is not.
inline bool isHeld(const Points& inverseMass, Eigen::Index i) { return inverseMass.col(i).maxCoeff() == 0.0; }

/// kg; 0 for a point that is held.
inline double massOf(const Points& inverseMass, Eigen::Index i) {
  const double w = inverseMass.col(i).maxCoeff();
  return w > 0.0 ? 1.0 / w : 0.0;
}

// --- points that may be among others -----------------------------------------------------------------------

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

// --- measures of a body ------------------------------------------------------------------------------------

// Sums over the points that are not held (inverse mass above 0), in SI units.
double totalMass(const PointState& state);
Eigen::Vector3d centerOfMass(const PointState& state);
Eigen::Vector3d linearMomentum(const PointState& state);
Eigen::Vector3d angularMomentum(const PointState& state);  ///< about the origin
double kineticEnergy(const PointState& state);

/// FNV-1a over the bits of positions and velocities.
std::uint64_t stateHash(const PointState& state);

// --- what the energy guard changes -------------------------------------------------------------------------

/// Takes `excess` J out of the motion of a free body's points relative to its rigid motion, by scaling
/// it, so that linear and angular momentum stay (the projection of Dinev, Liu, Li, Thomaszewski, Kavan 2018
/// restricted to velocities). A body with held points has no rigid motion of its own: all of it is scaled.
/// Returns what was not there to be taken, J.
double removeKineticEnergy(PointState& state, double excess);

/// kg m^2/s: angular momentum about the centre of mass.
Eigen::Vector3d spinOf(const PointState& state);

/// Turns the whole body so much faster or slower that spinOf(state) becomes `spin`.
void setSpin(PointState& state, const Eigen::Vector3d& spin);

}  // namespace limber
