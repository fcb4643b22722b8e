// SPDX-License-Identifier: Zlib

// This file holds points of soft bodies for users, by springs that they move.

#include <limber/grab.h>

#include "bullet/system_impl.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

constexpr double kTwoPi = 6.283185307179586;

/// m. A spring acts and damps only along its line. Three long ones along the axes act as one that pulls to
/// the place and damps motion in all directions.
constexpr btScalar kSpringLength = 50;

/// m, largest stretch of the springs of a limited pull: little beside their length, and much beside what the
/// point moves in a tick.
constexpr double kLongestPull = 2.0;

btVector3 axisOf(int i) { return btVector3(i == 0, i == 1, i == 2); }

btVector3 positionOfPoint(const SoftBody& body, std::uint32_t i) {
  const Eigen::Vector3d x = body.position(i);
  return btVector3(static_cast<btScalar>(x[0]), static_cast<btScalar>(x[1]), static_cast<btScalar>(x[2]));
}

bool isFinitePlace(const btVector3& v) {
  return std::isfinite(double(v.x())) && std::isfinite(double(v.y())) && std::isfinite(double(v.z()));
}

bool belongsTo(const SoftBodySystem& system, const SoftBody* body) {
  for (std::size_t i = 0; i < system.bodyCount(); ++i)
    if (system.body(i) == body) return body != nullptr;
  return false;
}

}  // namespace

Result<void> SoftBodySystem::moveSpring(SpringConstraint* spring, const btVector3& pivot) {
  const auto isThis = [&](const auto& entry) { return entry.get() == spring; };
  if (std::none_of(impl_->springs.begin(), impl_->springs.end(), isThis))
    return Error{"the spring is not, or no longer, one of this system"};
  if (spring->a_.body && spring->b_.body) return Error{"both ends of the spring are on bodies"};
  if (!(pivot.length2() <= btScalar(1e12))) return Error{"the pivot is not finite, or farther than 1e6 m"};
  (spring->a_.body ? spring->b_ : spring->a_).pivot = pivot;
  spring->target_.reset();
  return {};
}

// --- grabs -------------------------------------------------------------------------------------------------

Grab::Grab(Grab&& other) noexcept { *this = std::move(other); }

Grab& Grab::operator=(Grab&& other) noexcept {
  if (this == &other) return *this;
  release();
  system_ = std::exchange(other.system_, nullptr);
  body_ = std::exchange(other.body_, {});
  point_ = other.point_;
  springs_ = std::exchange(other.springs_, {});
  stiffness_ = other.stiffness_;
  damping_ = other.damping_;
  maxForce_ = other.maxForce_;
  return *this;
}

bool Grab::holds() const { return body_ && body_->alive() && springs_[0] && springs_[1] && springs_[2]; }

void Grab::moveTo(const btVector3& place, const btVector3& velocity) {
  if (!holds() || !isFinitePlace(place) || !isFinitePlace(velocity)) return;
  const btVector3 from = positionOfPoint(*body_, point_);
  double stiffness = stiffness_, damping = damping_;
  const double distance = double((place - from).length());
  if (maxForce_ > 0.0 && distance * stiffness_ > maxForce_) {
    // the spring that pulls with the force F at the distance d has the stiffness F / d
    damping *= std::sqrt(maxForce_ / (distance * stiffness_));
    stiffness = maxForce_ / std::min(distance, kLongestPull);
  }
  btVector3 pull = place - from + static_cast<btScalar>(damping / stiffness) * velocity;
  if (maxForce_ > 0.0 && double(pull.length()) * stiffness > maxForce_)
    pull *= static_cast<btScalar>(maxForce_ / stiffness) / pull.length();
  for (int i = 0; i < 3; ++i) {
    SpringConstraint* spring = springs_[static_cast<std::size_t>(i)].get();
    spring->settings_.stiffness = stiffness;
    spring->settings_.damping = damping;
    system_->moveSpring(spring, from + pull + kSpringLength * axisOf(i));
  }
  body_->wake();
}

void Grab::release() {
  for (Handle<SpringConstraint>& spring : springs_)
    if (spring) system_->removeSpring(spring.get());
  springs_ = {};
  body_ = {};
}

btVector3 Grab::force() const {
  btVector3 sum(0, 0, 0);
  for (int i = 0; holds() && i < 3; ++i) {
    const SpringConstraint& spring = *springs_[static_cast<std::size_t>(i)];
    const double force = spring.force() - spring.settings().damping * body_->velocity(point_)[i];
    sum += static_cast<btScalar>(force) * axisOf(i);
  }
  return sum;
}

void Grab::mark(SpringConstraint& spring) { spring.ofGrab_ = true; }

Result<Grab> grab(SoftBodySystem& system, SoftBody* body, std::uint32_t i, const GrabSettings& settings) {
  if (!belongsTo(system, body)) return Error{"the soft body is not, or no longer, one of this system"};
  if (!(settings.frequency >= 0.01 && settings.frequency <= 1000.0))
    return Error{"the frequency of a grab must be from 0.01 to 1000 Hz"};
  if (!(settings.maxForce >= 0.0)) return Error{"the largest force of a grab must be 0 or more"};
  if (!body->point(i)) return Error{"the soft body has no such point"};
  if (body->pinned(i)) return Error{"the point is pinned"};
  const double omega = kTwoPi * settings.frequency;
  Grab held;
  held.system_ = &system;
  held.body_ = body->handle();
  held.point_ = i;
  held.stiffness_ = body->totalMass() * omega * omega;
  held.damping_ = 2.0 * body->totalMass() * omega;
  held.maxForce_ = settings.maxForce;
  SpringSettings spring;
  spring.restLength = double(kSpringLength);
  spring.stiffness = held.stiffness_;
  spring.damping = held.damping_;
  for (int axis = 0; axis < 3; ++axis) {
    const btVector3 end = positionOfPoint(*body, i) + kSpringLength * axisOf(axis);
    Result<SpringConstraint*> added = system.addSpring({body->point(i)}, {nullptr, end}, spring);
    if (!added) return Error{added.error()};
    Grab::mark(**added);
    held.springs_[static_cast<std::size_t>(axis)] = (*added)->handle();
  }
  return held;
}

Result<Grab> grab(SoftBodySystem& system, const SurfaceHit& hit, const GrabSettings& settings) {
  if (!hit.body) return Error{"there is no soft body at the hit"};
  Eigen::Index nearest = 0;
  hit.weights.maxCoeff(&nearest);
  return grab(system, hit.body, hit.points[static_cast<std::size_t>(nearest)], settings);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
