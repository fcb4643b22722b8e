// SPDX-License-Identifier: Zlib

// This file implements what users change of a living body: its settings, its place and motion, and the forces
// on it.

#include "bullet/body_in_world.h"

#include <Eigen/LU>

#include <set>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
using Eigen::Matrix3d;
using Eigen::Vector3d;

// --- the present state -------------------------------------------------------------------------------------

void readFromBullet(SoftBodyData& body) {
  readObject(body);
  absorbOutsideChanges(body);
}

double elasticEnergy(const SoftBodyData& body) {
  const Points& position = body.state.position;
  return elasticEnergy(body.springs, position) + volumeEnergy(body.volumes, position) +
         tetrahedronEnergy(body.tetrahedra, position);
}

Points elasticForces(const SoftBodyData& body) {
  PointState state = body.state;
  SpringArrays springs = body.springs;
  if (springs.yielded) springs.yielded = std::make_shared<SpringConstants>(*springs.yielded);
  VolumeArrays volumes = body.volumes;
  TetrahedronVolumes tetrahedra = body.tetrahedra;
  SolverBody copy{&state, &springs, nullptr};
  if (!volumes.empty()) copy.volumes = &volumes;
  if (!tetrahedra.empty()) copy.tetrahedra = &tetrahedra;
  computeElasticForces(copy);
  return state.force;
}

void writeToBullet(SoftBodyData& body, bool pinsMoved) {
  body.sumsValid = false;
  // the prediction is out of date
  body.surface.sweptBounds.tick = 0.0;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const bool written = body.masses.held[i] ? pinsMoved : !body.masses.inFlight;
    if (!body.masses.exposed || !written) continue;
    writePoint(body, i);
    remember(body.masses, i);
  }
  if (body.surface.object) writeObject(body);
}

namespace {

Result<void> checkMotion(const char* name, const btVector3& v) {
  if (!isFinite(v)) return Error{std::string(name) + " is not finite"};
  if (toEigen(v).norm() > kMaxPointSpeed) return Error{std::string(name) + " is beyond 1e6"};
  return {};
}

Result<void> checkPush(const char* name, const btVector3& v) {
  return isSound(v) ? Result<void>() : Error{std::string(name) + " is not finite, or beyond 1e18"};
}

/// The place of a body as a whole: its centre of mass, and the rotation that brings the rest shape nearest to
/// the points. Pinned points count.
struct Placement {
  Vector3d center;
  Eigen::Quaterniond rotation;
};

Placement placementOf(SoftBodyData& body) {
  return {body.state.position.col(0) + Vector3d(sumsOf(body).meanOffset), followRotation(body)};
}

double massOfPoint(const SoftBodyData& body, Eigen::Index i) { return massOf(body.state.inverseMass, i); }

// --- the whole body moves ----------------------------------------------------------------------------------

/// Discards what refers to the motion so far.
void forgetPath(SoftBodyData& body) {
  forgetMotion(body);
  body.surface.contacts.clear();
  body.surface.overlapTicks = SurfaceData::kOverlapTicks;
  body.masses.startPosition = body.state.position;
  body.masses.placed = true;
  body.energyLimit = EnergyLimit();
  body.rateHistory = RateHistory();
}

Placement placementOf(const btTransform& transform) {
  return {toEigen(transform.getOrigin()), toEigen(transform.getRotation())};
}

Result<void> checkTransform(const btTransform& transform) {
  const btMatrix3x3& basis = transform.getBasis();
  if (!isFinite(transform.getOrigin())) return Error{"the transform's origin is not finite"};
  if (toEigen(transform.getOrigin()).cwiseAbs().maxCoeff() > kMaxCoordinate / 2)
    return Error{"the transform's origin has a coordinate beyond 1e6"};
  if (!(std::abs(double(basis.determinant()) - 1.0) < 1e-3))
    return Error{"the transform's basis is no rotation"};
  return {};
}

/// Puts the points at the rest shape, at rest.
void placeAtRest(SoftBodyData& body, const Placement& at) {
  const Points rest = scaledRest(*body.model->network, body.settings.scale);
  const Vector3d center = centerOfMass(*body.model, rest);
  body.state.position = (at.rotation.toRotationMatrix() * (rest.colwise() - center)).colwise() + at.center;
  body.state.velocity.setZero();
}

Result<void> resetBody(SoftBodyData& body, const Placement* at) {
  if (!isAlive(body)) return notAlive();
  readFromBullet(body);
  wakeNeighbours(body, false);
  // springs that have neither yielded nor broken
  body.springs.yielded.reset();
  body.springs.broken = 0;
  forgetConstants(body);
  if (at)
    placeAtRest(body, *at);
  else
    placeAsCreated(body);
  body.surface.frame = at ? at->rotation : body.settings.rotation.normalized();
  for (Eigen::Index i = 0; i < body.state.velocity.cols(); ++i)
    if (body.masses.held[static_cast<std::size_t>(i)]) body.state.velocity.col(i).setZero();
  forgetPath(body);
  writeToBullet(body, true);
  updateQueryBoxes(body);
  wakeBody(body, false);
  return {};
}

/// Takes the springs for which isGone(spring) is true from the network and its groups.
template <class Test>
void removeSprings(SpringNetwork& network, Test isGone) {
  constexpr std::uint32_t kGone = 0xffffffffu;
  std::vector<std::uint32_t> newIndex;
  std::vector<NetworkSpring> kept;
  for (const NetworkSpring& spring : network.springs) {
    const bool gone = isGone(spring);
    newIndex.push_back(gone ? kGone : static_cast<std::uint32_t>(kept.size()));
    if (!gone) kept.push_back(spring);
  }
  network.springs = std::move(kept);
  for (NamedGroup& group : network.groups) {
    for (std::uint32_t& spring : group.springs) spring = newIndex[spring];
    group.springs.erase(std::remove(group.springs.begin(), group.springs.end(), kGone), group.springs.end());
  }
}

}  // namespace

Result<SharedNetwork> SoftBody::presentNetwork() const {
  readFromBullet(*data_);
  SpringNetwork shape = network();
  const Placement at = placementOf(*data_);
  for (std::uint32_t i = 0; i < pointCount(); ++i)
    shape.restPoints[i] = (at.rotation.conjugate() * (data_->state.position.col(i) - at.center))
                              .cwiseQuotient(settings().scale);
  std::set<std::pair<std::uint32_t, std::uint32_t>> broken;
  for (std::size_t i = 0; data_->springs.broken > 0 && i < data_->springs.size(); ++i)
    if (isBroken(data_->springs, i)) broken.emplace(std::minmax(data_->springs->a[i], data_->springs->b[i]));
  removeSprings(shape, [&](const NetworkSpring& s) { return broken.count({s.a, s.b}) > 0; });
  if (Result<void> valid = validate(shape); !valid) return Error{valid.error()};
  return std::make_shared<const SpringNetwork>(std::move(shape));
}

btTransform SoftBody::transform() const {
  readFromBullet(*data_);
  const Placement at = placementOf(*data_);
  return btTransform(toBullet(at.rotation), toBullet(at.center));
}

Result<void> SoftBody::setTransform(const btTransform& transform) {
  if (!alive()) return notAlive();
  if (Result<void> valid = checkTransform(transform); !valid) return valid;
  readFromBullet(*data_);
  const Placement from = placementOf(*data_), to = placementOf(transform);
  wakeNeighbours(*data_, false);
  moveRigidly(*data_, to.rotation * from.rotation.conjugate(), from.center, to.center, true);
  forgetPath(*data_);
  writeToBullet(*data_, true);
  updateQueryBoxes(*data_);
  wake();
  return {};
}

Result<void> SoftBody::setVelocity(const btVector3& linear, const btVector3& angular) {
  if (!alive()) return notAlive();
  if (Result<void> valid = checkMotion("the velocity", linear); !valid) return valid;
  if (Result<void> valid = checkMotion("the angular velocity", angular); !valid) return valid;
  readFromBullet(*data_);
  const Vector3d center = placementOf(*data_).center;
  PointState& s = data_->state;
  for (Eigen::Index i = 0; i < s.position.cols(); ++i)
    if (!isHeld(s.inverseMass, i))
      s.velocity.col(i) = toEigen(linear) + toEigen(angular).cross(s.position.col(i) - center);
  forgetMotion(*data_);
  writeToBullet(*data_);
  wake();
  return {};
}

Result<void> SoftBody::reset() { return resetBody(*data_, nullptr); }

Result<void> SoftBody::reset(const btTransform& transform) {
  if (Result<void> valid = checkTransform(transform); !valid) return valid;
  const Placement at = placementOf(transform);
  return resetBody(*data_, &at);
}

Result<void> SoftBody::teleportPin(std::uint32_t i, const btVector3& target) {
  if (Result<void> moved = movePin(i, target); !moved) return moved;
  readFromBullet(*data_);
  data_->state.position.col(i) = data_->masses.startPosition.col(i) = toEigen(target);
  data_->state.velocity.col(i).setZero();
  writePoint(*data_, i);
  remember(data_->masses, i);
  writeToBullet(*data_);
  updateQueryBoxes(*data_);
  return {};
}

// --- forces and impulses -----------------------------------------------------------------------------------

namespace {

/// Applies pushOf(i) to each point i: as a force (N) in the coming step, or as an impulse (N s) now. The
/// state must be up to date.
template <class Push>
void pushAll(SoftBodyData& body, Push pushOf, bool asForce) {
  for (Eigen::Index i = 0; i < body.state.position.cols(); ++i) {
    const Vector3d push = pushOf(i);
    if (push.isZero(0.0)) continue;
    if (asForce)
      addForce(body, static_cast<std::uint32_t>(i), push);
    else
      body.state.velocity.col(i) += body.state.inverseMass.col(i).cwiseProduct(push);
  }
  if (!asForce) writeToBullet(body);
  wakeBody(body, false);
}

Result<void> pushBody(SoftBodyData& body, const btVector3& push, bool asForce) {
  if (!isAlive(body)) return notAlive();
  if (Result<void> valid = checkPush(asForce ? "the force" : "the impulse", push); !valid) return valid;
  readFromBullet(body);
  const double mass = totalMass(body.state);
  if (!(mass > 0.0)) return {};
  const Vector3d perMass = toEigen(push) / mass;
  pushAll(
      body, [&](Eigen::Index i) -> Vector3d { return massOfPoint(body, i) * perMass; }, asForce);
  return {};
}

Result<void> turnBody(SoftBodyData& body, const btVector3& torque, bool asForce) {
  if (!isAlive(body)) return notAlive();
  if (Result<void> valid = checkPush("the torque", torque); !valid) return valid;
  readFromBullet(body);
  const RigidFit fit = fitRigid(body);
  const Vector3d change = fit.inverseInertia * toEigen(torque);
  const auto pushOf = [&](Eigen::Index i) -> Vector3d {
    return massOfPoint(body, i) * change.cross(Vector3d(body.state.position.col(i) - fit.center));
  };
  pushAll(body, pushOf, asForce);
  return {};
}

Result<void> pushPlace(SoftBodyData& body, const btVector3& push, const SurfaceHit& place, bool asForce) {
  if (!isAlive(body)) return notAlive();
  if (Result<void> valid = checkPush(asForce ? "the force" : "the impulse", push); !valid) return valid;
  if (place.body != body.handle) return Error{"the hit is not on this soft body"};
  for (const std::uint32_t point : place.points)
    if (point >= pointCount(body)) return Error{"there is no point " + std::to_string(point)};
  if (!place.weights.allFinite()) return Error{"the weights of the hit are not finite"};
  readFromBullet(body);
  const auto pushOf = [&](Eigen::Index i) -> Vector3d {
    double weight = 0.0;
    for (Eigen::Index corner = 0; corner < 3; ++corner)
      if (place.points[static_cast<std::size_t>(corner)] == i) weight += place.weights[corner];
    return weight * toEigen(push);
  };
  pushAll(body, pushOf, asForce);
  return {};
}

SurfaceHit placeOf(const SoftBody& body, std::uint32_t point) {
  SurfaceHit place;
  place.body = const_cast<SoftBody*>(&body);
  place.points = {point, point, point};
  place.weights = Vector3d::UnitX();
  return place;
}

}  // namespace

Result<void> SoftBody::applyForce(const btVector3& force) { return pushBody(*data_, force, true); }
Result<void> SoftBody::applyForce(const btVector3& force, std::uint32_t i) {
  return pushPlace(*data_, force, placeOf(*this, i), true);
}
Result<void> SoftBody::applyForce(const btVector3& force, const SurfaceHit& place) {
  return pushPlace(*data_, force, place, true);
}
Result<void> SoftBody::applyTorque(const btVector3& torque) { return turnBody(*data_, torque, true); }

Result<void> SoftBody::applyImpulse(const btVector3& impulse) { return pushBody(*data_, impulse, false); }
Result<void> SoftBody::applyImpulse(const btVector3& impulse, std::uint32_t i) {
  return pushPlace(*data_, impulse, placeOf(*this, i), false);
}
Result<void> SoftBody::applyImpulse(const btVector3& impulse, const SurfaceHit& place) {
  return pushPlace(*data_, impulse, place, false);
}
Result<void> SoftBody::applyTorqueImpulse(const btVector3& impulse) {
  return turnBody(*data_, impulse, false);
}

Result<void> SoftBody::applyBlast(const btVector3& center, btScalar radius, btScalar speed) {
  if (!alive()) return notAlive();
  if (!isFinite(center)) return Error{"the centre of the blast is not finite"};
  if (!(radius > btScalar(0)) || !std::isfinite(double(radius)))
    return Error{"the radius of the blast is not above 0"};
  if (!(std::abs(double(speed)) <= kMaxPointSpeed)) return Error{"the speed of the blast is not within 1e6"};
  readFromBullet(*data_);
  const auto pushOf = [&](Eigen::Index i) -> Vector3d {
    const Vector3d arm = data_->state.position.col(i) - toEigen(center);
    const double share = 1.0 - arm.norm() / double(radius);
    if (!(share > 0.0)) return Vector3d::Zero();
    return massOfPoint(*data_, i) * double(speed) * share * arm.stableNormalized();
  };
  pushAll(*data_, pushOf, false);
  return {};
}

// --- settings ----------------------------------------------------------------------------------------------

namespace {

/// Calls visit(i, place) with the places (m) to which a scaling of the present shape, about the centre of
/// mass along the body's own axes, brings the points. Held and attached points stay.
template <class Visit>
void forEachScaled(SoftBodyData& body, const Vector3d& ratio, Visit visit) {
  const Placement at = placementOf(body);
  const Matrix3d r = at.rotation.toRotationMatrix(), scaling = r * ratio.asDiagonal() * r.transpose();
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    if (body.masses.held[i] || isAttached(body, i)) continue;
    visit(i, Vector3d(at.center + scaling * (body.state.position.col(i) - at.center)));
  }
}

Result<void> checkScaled(SoftBodyData& body, const Vector3d& ratio) {
  std::string reason;
  forEachScaled(body, ratio, [&](std::uint32_t i, const Vector3d& place) {
    if (reason.empty()) reason = checkPlace(i, place);
  });
  if (!reason.empty()) return Error{"settings: " + reason};
  return {};
}

/// Springs that have yielded keep the strain of that; broken ones stay broken.
void carrySprings(const SoftBodyData& body, SpringArrays& springs) {
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const double before = body.springs.original->restLength[i];
    if (before > 0.0) springs.yielded->restLength[i] *= body.springs->restLength[i] / before;
    if (isBroken(body.springs, i)) breakSpring(springs, i);
  }
}

/// Gives points the masses of the model. Points whose mass the user has set keep it.
void changeMasses(SoftBodyData& body, const BodyModel& before) {
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    const double was = before.masses[i], now = body.model->masses[i];
    if (was == now) continue;
    PointMass* point = i < body.masses.bodies.size() ? body.masses.bodies[i] : nullptr;
    if (!point) {
      body.state.inverseMass.col(i).setConstant(inverseOf(now));
    } else if (point->massBeforePin == static_cast<btScalar>(was)) {
      point->massBeforePin = static_cast<btScalar>(now);
    }
    // the inertia follows when the point is read
    if (point && point->getInvMass() == btScalar(1) / static_cast<btScalar>(was))
      point->setMassProps(static_cast<btScalar>(now), btVector3(0, 0, 0));
  }
  absorbOutsideChanges(body);
}

/// Calls visit(object) for the Bullet objects that have the body's material and filter.
template <class Visit>
void forEachObject(const SoftBodyData& body, Visit visit) {
  if (body.surface.object) visit(*body.surface.object);
  for (PointMass* point : body.masses.bodies)
    if (point) visit(static_cast<btRigidBody&>(*point));
}

/// Applies settings that Bullet's objects hold, where they have changed: the user may have set others.
void changeObjects(SoftBodyData& body, const SoftBodySettings& before) {
  const SoftBodySettings& s = body.settings;
  const bool newFilter = s.collisionGroup != before.collisionGroup || s.collisionMask != before.collisionMask;
  forEachObject(body, [&](btRigidBody& object) {
    if (s.friction != before.friction) object.setFriction(static_cast<btScalar>(s.friction));
    if (s.restitution != before.restitution) object.setRestitution(static_cast<btScalar>(s.restitution));
    if (s.sleepingSpeed != before.sleepingSpeed)
      object.setSleepingThresholds(static_cast<btScalar>(s.sleepingSpeed),
                                   object.getAngularSleepingThreshold());
    if (!isSurfaceBody(body) && s.gravityFactor != before.gravityFactor &&
        (object.getFlags() & BT_DISABLE_WORLD_GRAVITY) == 0)
      object.setGravity(gravityOf(body));
    if (!newFilter || !object.isInWorld()) return;
    object.getBroadphaseHandle()->m_collisionFilterGroup = s.collisionGroup;
    object.getBroadphaseHandle()->m_collisionFilterMask = s.collisionMask;
    body.world->refreshBroadphaseProxy(&object);
  });
}

void changeRadius(SoftBodyData& body) {
  const auto radius = static_cast<btScalar>(pointRadius(*body.model->network, body.settings));
  if (radius == body.masses.shape->getRadius()) return;
  body.masses.shape->setUnscaledRadius(radius);
  if (body.surface.shape) body.surface.shape->setMargin(radius);
}

/// Returns whether what lies on the body may then have nothing below it.
bool mayLetGo(const SoftBodySettings& before, const SoftBodySettings& after) {
  return after.scale != before.scale || after.hollow != before.hollow ||
         after.pointRadius != before.pointRadius || after.collisionGroup != before.collisionGroup ||
         after.collisionMask != before.collisionMask;
}

}  // namespace

Result<void> checkChange(SoftBodyData& body, const SoftBodySettings& s) {
  if (!isAlive(body)) return notAlive();
  if (Result<void> valid = validate(s); !valid) return Error{"settings: " + valid.error()};
  if (s.collision != body.settings.collision)
    return Error{"settings: collision cannot change while the body lives"};
  for (int i = 0; i < 3; ++i)
    if ((s.scale[i] < 0.0) != (body.settings.scale[i] < 0.0))
      return Error{std::string("settings: scale.") + "xyz"[i] +
                   " cannot change its sign while the body lives"};
  if (s.scale == body.settings.scale) return {};
  return checkScaled(body, s.scale.cwiseQuotient(body.settings.scale));
}

void takeConstants(SoftBodyData& body, const std::function<void(SpringArrays&)>& carry) {
  SpringArrays springs = body.model->springs;
  springs.revision = body.springs.revision + 1;
  if (body.springs.yielded) {
    springs.yielded = std::make_shared<SpringConstants>(*springs.original);
    carry(springs);
  }
  body.springs = std::move(springs);
  body.volumes = body.model->volumes;
  body.tetrahedra = body.model->tetrahedra;
  forgetConstants(body);
}

void forgetConstants(SoftBodyData& body) {
  body.springs.original = body.model->springs.original;
  body.volumes.constants = body.model->volumes.constants;
  body.tetrahedra.constants = body.model->tetrahedra.constants;
  ++body.springs.revision;
  body.springs.preparedFor = 0.0;
  body.softening.reset();
  body.springBatches.reset();
  body.implicit.reset();
  body.frequencyStale = true;
  // groups have pointers to these
  *body.groupsStale = true;
}

Result<void> changeSettings(SoftBodyData& body, const SoftBodySettings& settings) {
  if (Result<void> valid = checkChange(body, settings); !valid) return valid;
  auto model = body.models->of(body.model->network, settings);
  if (!model) return Error{model.error()};
  readFromBullet(body);
  const SoftBodySettings before = std::exchange(body.settings, settings);
  body.settings.position = before.position;
  body.settings.rotation = before.rotation;
  body.settings.linearVelocity = before.linearVelocity;
  body.settings.angularVelocity = before.angularVelocity;
  if (settings.scale != before.scale)
    forEachScaled(body, settings.scale.cwiseQuotient(before.scale),
                  [&](std::uint32_t i, const Vector3d& place) { body.state.position.col(i) = place; });
  const std::shared_ptr<const BodyModel> old = std::exchange(body.model, *model);
  if (old != body.model) {
    takeConstants(body, [&](SpringArrays& springs) { carrySprings(body, springs); });
    changeMasses(body, *old);
    body.size *= std::cbrt(std::abs(settings.scale.prod() / before.scale.prod()));
  }
  changeRadius(body);
  changeObjects(body, before);
  forgetMotion(body);
  forgetSearches(body);
  body.masses.placed = true;
  body.surface.overlapTicks = SurfaceData::kOverlapTicks;
  writeToBullet(body);
  updateQueryBoxes(body);
  wakeBody(body, false);
  *body.groupsStale = true;
  return {};
}

Result<void> SoftBody::change(const SoftBodySettings& settings) {
  if (Result<void> valid = checkChange(*data_, settings); !valid) return valid;
  if (mayLetGo(data_->settings, settings)) wakeNeighbours(*data_, false);
  return changeSettings(*data_, settings);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
