// SPDX-License-Identifier: Zlib

// This file adds, changes and removes the springs of a system, and holds points of soft bodies for users by
// springs that they move.

#include "bullet/system_impl.h"

#include <limber/grab.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- springs -----------------------------------------------------------------------------------------------

bool isValidPivot(const btVector3& place) {
  constexpr double kMaxPivotDistance = 1e6;  // m, a larger one would require far too many substeps
  const Eigen::Vector3d p = toEigen(place);
  return p.norm() <= kMaxPivotDistance;
}

namespace {

/// Returns the reason why a link of the systems with this step cannot be attached to a body; empty if it can.
std::string whyNotHeld(const btRigidBody* body, const btCollisionWorld& world, const void* step) {
  if (SurfaceObject::from(body))
    return "a surface object cannot be held: hold on to a point mass of that soft body, SoftBody::point(i)";
  const PointMass* point = PointMass::from(body);
  if (point && (!point->owner() || point->owner()->system != step))
    return "the point mass belongs to a soft body in another world";
  if (body && !point && isElsewhere(*body, world)) return "the rigid body is in another world";
  return {};
}

Error foreignSpring() { return {"the spring is not, or no longer, one of this system"}; }

bool isSame(const SpringSettings& a, const SpringSettings& b) {
  return a.restLength == b.restLength && a.stiffness == b.stiffness && a.damping == b.damping &&
         a.action == b.action && a.breakForce == b.breakForce;
}

}  // namespace

Result<SpringConstraint*> SoftBodySystem::addSpring(const SpringEnd& a, const SpringEnd& b,
                                                    const SpringSettings& settings) {
  if (Result<void> valid = validate(settings); !valid) return Error{valid.error()};
  if (!a.body && !b.body) return Error{"a spring needs a body at one of its ends"};
  for (const SpringEnd& end : {a, b}) {
    if (std::string reason = whyNotHeld(end.body, *impl_->world, impl_->step.get()); !reason.empty())
      return Error{reason};
    if (!isValidPivot(end.pivot)) return Error{"a pivot of the spring is not finite, or farther than 1e6"};
    if (PointMass::from(end.body) && !end.pivot.isZero())
      return Error{"the pivot of a spring on a point mass must be 0"};
  }
  if (a.body == b.body && (PointMass::from(a.body) || (a.pivot - b.pivot).length2() == btScalar(0)))
    return Error{"both ends of the spring are the same place of one body"};
  impl_->hookUp();
  impl_->springs.push_back(std::unique_ptr<SpringConstraint>(new SpringConstraint(a, b, settings)));
  SpringConstraint* spring = impl_->springs.back().get();
  if (!settings.restLength) spring->settings_.restLength = double(spring->length());
  for (btRigidBody* end : {a.body, b.body})
    if (end) end->activate();
  impl_->step->groupsStale = true;
  return spring;
}

Handle<SpringConstraint> SpringConstraint::handle() {
  if (!life_) life_ = std::make_shared<char>();
  return {this, life_};
}

/// Wakes what a spring holds. The user may have deleted a rigid body, so only those in the world are
/// accessed.
void SoftBodySystem::Impl::wakeEnds(const SpringConstraint& spring, const btRigidBody* butNot) const {
  if (!worldAlive()) return;
  const btCollisionObjectArray& objects = world->getCollisionObjectArray();
  for (btRigidBody* end : {spring.endA().body, spring.endB().body}) {
    if (!end || end == butNot) continue;
    if (SoftBody* body = ownerOf(*end)) body->wake();
    if (objects.findLinearSearch(end) < objects.size()) end->activate();
  }
}

void SoftBodySystem::Impl::freeEnds(const SpringConstraint& spring) const {
  if (!worldAlive()) return;
  for (const btRigidBody* end : {spring.endA().body, spring.endB().body})
    if (SoftBody* body = end ? ownerOf(*end) : nullptr) body->data_->surface.freed = true;
}

/// Returns the body of any system that has this point, which need not exist; nullptr if none has.
SoftBody* SoftBodySystem::Impl::ownerOf(const btRigidBody& point) const {
  for (const Impl* system : step->systems)
    for (const auto& body : system->bodies) {
      const std::vector<PointMass*>& points = body->data_->masses.bodies;
      if (std::find(points.begin(), points.end(), &point) != points.end()) return body.get();
    }
  return nullptr;
}

Result<void> SoftBodySystem::changeSpring(SpringConstraint* spring, const SpringSettings& settings) {
  if (findOwner(impl_->springs, spring) == impl_->springs.end()) return foreignSpring();
  if (Result<void> valid = validate(settings); !valid) return valid;
  SpringSettings now = settings;
  if (!now.restLength) now.restLength = spring->settings_.restLength;
  if (!spring->broken_ && isSame(now, spring->settings_)) return {};
  spring->settings_ = now;
  spring->broken_ = false;
  impl_->wakeEnds(*spring, nullptr);
  impl_->step->groupsStale = true;
  return {};
}

Result<void> SoftBodySystem::moveSpring(SpringConstraint* spring, const btVector3& pivot) {
  if (findOwner(impl_->springs, spring) == impl_->springs.end()) return foreignSpring();
  if (spring->a_.body && spring->b_.body) return Error{"both ends of the spring are on bodies"};
  if (!(pivot.length2() <= btScalar(1e12))) return Error{"the pivot is not finite, or farther than 1e6 m"};
  (spring->a_.body ? spring->b_ : spring->a_).pivot = pivot;
  spring->target_.reset();
  return {};
}

Result<void> SoftBodySystem::removeSpring(SpringConstraint* spring) {
  const auto found = findOwner(impl_->springs, spring);
  if (found == impl_->springs.end()) return foreignSpring();
  impl_->step->forgetGroups();
  impl_->freeEnds(*spring);
  impl_->wakeEnds(*spring, nullptr);
  impl_->springs.erase(found);
  impl_->unhookIfIdle(impl_->worldAlive());
  return {};
}

/// Removes the springs on a body from all systems: a system may have springs on another's points.
void SoftBodySystem::Impl::dropSprings(const btRigidBody& body) {
  const auto isOn = [&](const auto& s) {
    if (s->endA().body != &body && s->endB().body != &body) return false;
    freeEnds(*s);
    wakeEnds(*s, &body);
    return true;
  };
  step->forgetGroups();
  for (Impl* system : step->systems) {
    SpringList& all = system->springs;
    all.erase(std::remove_if(all.begin(), all.end(), isOn), all.end());
  }
}

// --- grabs -------------------------------------------------------------------------------------------------

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
