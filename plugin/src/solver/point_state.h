// SPDX-License-Identifier: Zlib
#pragma once

// Arrays of the point masses of a body, sums over them, and changes of the body's motion as a whole;
// constants that bodies share, and numbers for SIMD registers.

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace limber {

// --- points ------------------------------------------------------------------------------------------------

/// One column per point mass.
using Points = Eigen::Matrix3Xd;

inline double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

/// The state of a body's point masses. It is in double, independent of the precision of Bullet's numbers.
/// All arrays are 3 x #points.
struct PointState {
  Points position;      ///< m
  Points velocity;      ///< m/s
  Points acceleration;  ///< m/s^2, due to everything except springs, constant over a tick
  Points inverseMass;   ///< 1/kg per axis; 0 along axes on which a point is held
  Points force;         ///< N, of the springs at `position`; empty until a step needs it
  Points earlierForce;  ///< N, scratch of the step; empty until a step needs it

  void resize(Eigen::Index points) {
    for (Points* array : {&position, &velocity, &acceleration, &inverseMass}) array->setZero(3, points);
  }

  void allocateForces() {
    if (force.cols() == position.cols()) return;
    force.setZero(3, position.cols());
    earlierForce.setZero(3, position.cols());
  }
};

/// Whether point i is held along all axes.
inline bool isHeld(const Points& inverseMass, Eigen::Index i) { return inverseMass.col(i).maxCoeff() == 0.0; }

/// Returns the mass (kg) of point i; 0 if it is held.
inline double massOf(const Points& inverseMass, Eigen::Index i) {
  const double w = inverseMass.col(i).maxCoeff();
  return w > 0.0 ? 1.0 / w : 0.0;
}

/// Calls visit(mass, i) for every point that can move.
template <class Visit>
void forEachMass(const PointState& state, Visit visit) {
  for (Eigen::Index i = 0; i < state.position.cols(); ++i)
    if (const double mass = massOf(state.inverseMass, i); mass > 0.0) visit(mass, i);
}

// --- views of points ---------------------------------------------------------------------------------------

/// The points of one body in its own array or in an array of several bodies: coordinate c of point i is at
/// [i pointStride + c axisStride].
struct PointView {
  using Column = Eigen::Map<Eigen::Vector3d, 0, Eigen::InnerStride<>>;
  using ConstColumn = Eigen::Map<const Eigen::Vector3d, 0, Eigen::InnerStride<>>;

  double* position;           ///< m
  double* velocity;           ///< m/s
  const double* inverseMass;  ///< 1/kg
  int axisStride, pointStride;
  double* force = nullptr;         ///< N; nullptr, as the next one, if the step does not share its forces
  double* earlierForce = nullptr;  ///< N, scratch of the step

  ConstColumn positionOf(std::uint32_t i) const { return ConstColumn(position + at(i), step()); }
  Column velocityOf(std::uint32_t i) const { return Column(velocity + at(i), step()); }
  ConstColumn inverseMassOf(std::uint32_t i) const { return ConstColumn(inverseMass + at(i), step()); }
  Column forceOf(std::uint32_t i) const { return Column(force + at(i), step()); }

 private:
  Eigen::InnerStride<> step() const { return Eigen::InnerStride<>(axisStride); }
  std::ptrdiff_t at(std::uint32_t i) const { return std::ptrdiff_t{i} * pointStride; }
};

inline PointView viewOf(PointState& state) {
  return {state.position.data(), state.velocity.data(),    state.inverseMass.data(), 1, 3,
          state.force.data(),    state.earlierForce.data()};
}

// --- measures of a body ------------------------------------------------------------------------------------

// Sums over the points that are not held (inverse mass above 0), in SI units.
double totalMass(const PointState& state);
Eigen::Vector3d centerOfMass(const PointState& state);
Eigen::Vector3d linearMomentum(const PointState& state);
Eigen::Vector3d angularMomentum(const PointState& state);  ///< about the origin
double kineticEnergy(const PointState& state);

/// Returns the FNV-1a hash of the bits of positions and velocities.
std::uint64_t stateHash(const PointState& state);

// --- corrections of the motion -----------------------------------------------------------------------------

/// Removes the kinetic energy `excess` (J) from the motion of a free body's points relative to its rigid
/// motion. Scales that relative motion, so that linear and angular momentum do not change (the projection of
/// Dinev, Liu, Li, Thomaszewski, Kavan 2018, restricted to velocities). For a body with held points it scales
/// the whole motion. Returns the energy (J) that could not be removed.
double removeKineticEnergy(PointState& state, double excess);

/// Returns the angular momentum (kg m^2/s) about the centre of mass.
Eigen::Vector3d spinOf(const PointState& state);

/// Adds a rigid rotation about the centre of mass to the velocities, so that spinOf(state) becomes `spin`.
void setSpin(PointState& state, const Eigen::Vector3d& spin);

// --- numbers for registers ---------------------------------------------------------------------------------

/// 64 bytes: an array of these has the alignment of the registers of every instruction set.
struct alignas(64) CacheLine {
  double value[8];
};

using AlignedNumbers = std::vector<CacheLine>;

inline double* numbers(AlignedNumbers& array) { return array.front().value; }

/// Makes room for `count` numbers; never shrinks. New numbers are 0.
inline void reserveNumbers(AlignedNumbers& array, std::size_t count) {
  if (array.size() * 8 < count) array.resize((count + 7) / 8, CacheLine{});
}

// --- shared constants --------------------------------------------------------------------------------------

/// Constants that several bodies share, for example the springs of equal bodies. Copies are cheap.
template <class Constants>
class SharedConstants {
 public:
  /// Default constants, which all default objects share.
  SharedConstants() {
    static const auto none = std::make_shared<const Constants>();
    constants_ = none;
  }
  explicit SharedConstants(Constants constants)
      : constants_(std::make_shared<const Constants>(std::move(constants))) {}

  const Constants& operator*() const { return *constants_; }
  const Constants* operator->() const { return constants_.get(); }

 private:
  std::shared_ptr<const Constants> constants_;
};

/// Objects that bodies share, each made once. One lives as long as a body uses it. Any thread may call get().
template <class T>
class SharedObjects {
 public:
  /// Returns the object for which isWanted(object), or what make() returns.
  template <class IsWanted, class Make>
  std::shared_ptr<const T> get(IsWanted isWanted, Make make) {
    const std::lock_guard<std::mutex> guard(lock_);
    const auto isGone = [](const std::weak_ptr<const T>& known) { return known.expired(); };
    known_.erase(std::remove_if(known_.begin(), known_.end(), isGone), known_.end());
    for (const std::weak_ptr<const T>& known : known_)
      if (auto object = known.lock(); object && isWanted(*object)) return object;
    auto made = std::make_shared<const T>(make());
    known_.push_back(made);
    return made;
  }

 private:
  std::mutex lock_;
  std::vector<std::weak_ptr<const T>> known_;
};

}  // namespace limber
