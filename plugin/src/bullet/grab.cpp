// SPDX-License-Identifier: Zlib

// This file holds points of soft bodies for users, by springs that they move.

#include <limber/grab.h>

#include "bullet/system_impl.h"
#include "mesh/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// m. A spring acts and damps only along its line. Three long ones along the axes act as one that pulls to
/// the place and damps motion in all directions.
constexpr btScalar kSpringLength = 50;

/// m, largest stretch of the springs of a limited pull: little beside their length, and much beside what the
/// point moves in a tick.
constexpr double kLongestPull = 2.0;

btVector3 axisOf(int i) { return btVector3(i == 0, i == 1, i == 2); }

bool belongsTo(const SoftBodySystem& system, const SoftBody* body) {
  for (std::size_t i = 0; i < system.bodyCount(); ++i)
    if (system.body(i) == body) return body != nullptr;
  return false;
}

}  // namespace

/// A place to which three springs pull a point, one along each axis, to a place far away.
struct GrabPull {
  Handle<SoftBody> body;
  std::uint32_t point = 0;
  std::array<Handle<SpringConstraint>, 3> springs;
  double stiffness = 0.0, damping = 0.0, maxForce = 0.0;  ///< of the unlimited pull
  btVector3 place = btVector3(0, 0, 0), velocity = btVector3(0, 0, 0);

  bool holds() const { return body && body->alive() && springs[0] && springs[1] && springs[2]; }
};

void Grab::mark(SpringConstraint& spring, const std::shared_ptr<GrabPull>& pull) { spring.grab_ = pull; }

void Grab::aim(GrabPull& pull) {
  const btVector3 from = toBullet(pull.body->position(pull.point)), way = pull.place - from;
  double stiffness = pull.stiffness, damping = pull.damping;
  const double distance = double(way.length());
  if (pull.maxForce > 0.0 && distance * stiffness > pull.maxForce) {
    // the spring that pulls with the force F at the distance d has the stiffness F / d
    damping *= std::sqrt(pull.maxForce / (distance * stiffness));
    stiffness = pull.maxForce / std::min(distance, kLongestPull);
  }
  btVector3 stretch = way + static_cast<btScalar>(damping / stiffness) * pull.velocity;
  if (pull.maxForce > 0.0 && double(stretch.length()) * stiffness > pull.maxForce)
    stretch *= static_cast<btScalar>(pull.maxForce / stiffness) / stretch.length();
  for (int i = 0; i < 3; ++i) {
    SpringConstraint& spring = *pull.springs[static_cast<std::size_t>(i)];
    spring.settings_.stiffness = stiffness;
    spring.settings_.damping = damping;
    spring.b_.pivot = from + (stretch[i] + kSpringLength) * axisOf(i);
  }
}

void Grab::aimAll(const std::vector<SpringConstraint*>& springs) {
  for (const SpringConstraint* spring : springs) {
    GrabPull* pull = spring->grab_.get();
    if (pull && pull->springs[0].get() == spring && pull->holds()) aim(*pull);
  }
}

Grab::Grab(Grab&& other) noexcept { *this = std::move(other); }

Grab& Grab::operator=(Grab&& other) noexcept {
  if (this == &other) return *this;
  release();
  system_ = std::exchange(other.system_, nullptr);
  pull_ = std::exchange(other.pull_, nullptr);
  return *this;
}

bool Grab::holds() const { return pull_ && pull_->holds(); }

SoftBody* Grab::body() const { return pull_ ? pull_->body.get() : nullptr; }

std::uint32_t Grab::point() const { return pull_ ? pull_->point : 0; }

void Grab::moveTo(const btVector3& place, const btVector3& velocity) {
  if (!holds() || !isFinite(place) || !isFinite(velocity)) return;
  pull_->place = place;
  pull_->velocity = velocity;
  aim(*pull_);
  pull_->body->wake();
}

void Grab::release() {
  if (!pull_) return;
  for (Handle<SpringConstraint>& spring : pull_->springs)
    if (spring) system_->removeSpring(spring.get());
  pull_.reset();
}

btVector3 Grab::force() const {
  btVector3 sum(0, 0, 0);
  for (int i = 0; holds() && i < 3; ++i) {
    const SpringConstraint& spring = *pull_->springs[static_cast<std::size_t>(i)];
    const double force = spring.force() - spring.settings().damping * pull_->body->velocity(pull_->point)[i];
    sum += static_cast<btScalar>(force) * axisOf(i);
  }
  return sum;
}

Result<Grab> grab(SoftBodySystem& system, SoftBody* body, std::uint32_t i, const GrabSettings& settings) {
  if (!belongsTo(system, body)) return Error{"the soft body is not, or no longer, one of this system"};
  if (!(settings.frequency >= 0.01 && settings.frequency <= 1000.0))
    return Error{mustBe("frequency", settings.frequency, "from 0.01 to 1000 Hz")};
  if (!(settings.maxForce >= 0.0)) return Error{mustBe("maxForce", settings.maxForce, "0 or more")};
  if (!body->alive()) return notAlive();
  if (!body->point(i)) return Error{"there is no point " + std::to_string(i)};
  if (body->pinned(i)) return Error{"the point is pinned"};
  const double omega = 2.0 * kPi * settings.frequency, mass = body->totalMass();
  Grab held;
  held.system_ = &system;
  held.pull_ = std::make_shared<GrabPull>();
  GrabPull& pull = *held.pull_;
  pull = {body->handle(), i, {}, mass * omega * omega, 2.0 * mass * omega, settings.maxForce};
  pull.place = toBullet(body->position(i));
  SpringSettings spring;
  spring.restLength = double(kSpringLength);
  spring.stiffness = pull.stiffness;
  spring.damping = pull.damping;
  for (int axis = 0; axis < 3; ++axis) {
    const btVector3 end = pull.place + kSpringLength * axisOf(axis);
    Result<SpringConstraint*> added = system.addSpring({body->point(i)}, {nullptr, end}, spring);
    if (!added) return Error{added.error()};
    Grab::mark(**added, held.pull_);
    pull.springs[static_cast<std::size_t>(axis)] = (*added)->handle();
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
