// SPDX-License-Identifier: Zlib

// This file implements the user's interface of a soft body, and reads Bullet's queries and manifolds.

#include <limber/soft_body.h>

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/contact_report.h"
#include "bullet/point_masses.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "mesh/closest_points.h"
#include "solver/point_state.h"
#include "solver/springs.h"

#include <limber/contacts.h>
#include <limber/network_builder.h>

#include <cmath>
#include <limits>
#include <string>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

SoftBody::SoftBody(std::unique_ptr<SoftBodyData> data) : data_(std::move(data)) { data_->handle = this; }
SoftBody::~SoftBody() = default;

SoftBodyData& dataOf(const SoftBody& body) { return *body.data_; }

Handle<SoftBody> SoftBody::handle() {
  if (!life_) life_ = std::make_shared<char>();
  return {this, life_};
}

const SpringNetwork& SoftBody::network() const { return *data_->model->network; }
const SharedNetwork& SoftBody::sharedNetwork() const { return data_->model->network; }
const SoftBodySettings& SoftBody::settings() const { return data_->settings; }
std::uint32_t SoftBody::pointCount() const {
  return static_cast<std::uint32_t>(data_->model->network->restPoints.size());
}
bool SoftBody::alive() const { return data_->alive; }

btRigidBody* SoftBody::point(std::uint32_t i) const {
  if (i >= pointCount()) return nullptr;
  if (isSurfaceBody(*data_)) exposePoints(*data_);
  return data_->masses.bodies[i];
}

btRigidBody* SoftBody::surfaceObject() const { return data_->surface.object; }

namespace {

Eigen::Vector3d noVector() { return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()); }

}  // namespace

Eigen::Vector3d SoftBody::position(std::uint32_t i) const {
  if (i >= pointCount()) return noVector();
  readObject(*data_);
  return currentPosition(*data_, i);
}

Eigen::Vector3d SoftBody::velocity(std::uint32_t i) const {
  if (i >= pointCount()) return noVector();
  readObject(*data_);
  return currentVelocity(*data_, i);
}

void SoftBody::writePositions(float* xyz) const {
  readObject(*data_);
  for (std::uint32_t i = 0; i < pointCount(); ++i) {
    const Eigen::Vector3f p = currentPosition(*data_, i).cast<float>();
    for (int axis = 0; axis < 3; ++axis) *xyz++ = p[axis];
  }
}

void SoftBody::writePositions(float* xyz, double tickFraction) const {
  readObject(*data_);
  for (std::uint32_t i = 0; i < pointCount(); ++i) {
    const Eigen::Vector3f p = positionAt(*data_, i, tickFraction).cast<float>();
    for (int axis = 0; axis < 3; ++axis) *xyz++ = p[axis];
  }
}

std::uint32_t SoftBody::skinnedPointCount() const {
  const Skin& skin = data_->model->network->render.skin;
  return skin.size() > 0 ? static_cast<std::uint32_t>(skin.size()) : pointCount();
}

void SoftBody::writeSkinnedPositions(float* xyz) const {
  const Skin& skin = data_->model->network->render.skin;
  if (skin.size() == 0) return writePositions(xyz);
  data_->skinned.resize(std::size_t{3} * pointCount());
  writePositions(data_->skinned.data());
  applySkin(skin, data_->skinned.data(), xyz);
}

void SoftBody::writeSkinnedPositions(float* xyz, double tickFraction) const {
  const Skin& skin = data_->model->network->render.skin;
  if (skin.size() == 0) return writePositions(xyz, tickFraction);
  data_->skinned.resize(std::size_t{3} * pointCount());
  writePositions(data_->skinned.data(), tickFraction);
  applySkin(skin, data_->skinned.data(), xyz);
}

namespace {

Error noPoint(const SoftBody& body, std::uint32_t i) {
  const std::string point = "point " + std::to_string(i);
  if (i < body.pointCount()) return {point + " has been deleted"};
  return {"there is no " + point + ": the body has " + std::to_string(body.pointCount()) + " points"};
}

Error notAlive() { return {"the soft body is disabled, see alive()"}; }

Error notPinned(std::uint32_t i) { return {"point " + std::to_string(i) + " is not pinned"}; }

}  // namespace

Result<void> SoftBody::pin(std::uint32_t i) {
  if (!point(i)) return noPoint(*this, i);
  if (!alive()) return notAlive();
  if (!pinned(i)) setPinned(*data_, i, true);
  return {};
}

Result<void> SoftBody::movePin(std::uint32_t i, const btVector3& target) {
  if (i >= pointCount()) return noPoint(*this, i);
  if (!pinned(i)) return point(i) ? notPinned(i) : noPoint(*this, i);
  if (!alive()) return notAlive();
  if (!toEigen(target).allFinite())
    return Error{"the target of point " + std::to_string(i) + " is not finite"};
  wake();
  data_->masses.bodies[i]->getWorldTransform().setOrigin(target);
  return {};
}

Result<void> SoftBody::unpin(std::uint32_t i) {
  if (i >= pointCount()) return noPoint(*this, i);
  if (!pinned(i)) return notPinned(i);
  setPinned(*data_, i, false);
  wake();
  return {};
}

bool SoftBody::pinned(std::uint32_t i) const {
  const PointMass* point = i < data_->masses.bodies.size() ? data_->masses.bodies[i] : nullptr;
  return point && point->isKinematicObject();
}

std::uint32_t SoftBody::restorations() const { return data_->restorations; }
bool SoftBody::sleeping() const { return data_->asleep; }
void SoftBody::wake() { wakeBody(*data_, false); }

Stepper SoftBody::stepper() const { return data_->stepper; }
double SoftBody::errorPerSecond() const { return data_->errorPerSecond; }
int SoftBody::substeps() const { return data_->substeps; }
double SoftBody::frequencyBound() const { return std::sqrt(data_->frequencySquared); }

const std::vector<SoftContact>& SoftBody::contacts() const { return readReport(*data_); }

namespace {

/// Returns the state, with the user's changes since the last tick.
const PointState& current(SoftBodyData& data) {
  readObject(data);
  absorbOutsideChanges(data);
  return data.state;
}

}  // namespace

double SoftBody::totalMass() const { return limber::totalMass(current(*data_)); }
Eigen::Vector3d SoftBody::centerOfMass() const { return limber::centerOfMass(current(*data_)); }
Eigen::Vector3d SoftBody::linearMomentum() const { return limber::linearMomentum(current(*data_)); }
Eigen::Vector3d SoftBody::angularMomentum() const { return limber::angularMomentum(current(*data_)); }
double SoftBody::kineticEnergy() const { return limber::kineticEnergy(current(*data_)); }
double SoftBody::elasticEnergy() const {
  const Points& position = current(*data_).position;
  return limber::elasticEnergy(data_->springs, position) + volumeEnergy(data_->volumes, position) +
         tetrahedronEnergy(data_->tetrahedra, position);
}
std::uint64_t SoftBody::stateHash() const { return limber::stateHash(current(*data_)); }

// --- results of Bullet's queries ---------------------------------------------------------------------------

PointReference findPoint(const btCollisionObject* object) {
  const PointMass* point = PointMass::from(object);
  if (!point || !point->owner()) return {};
  return {point->owner()->handle, point->index()};
}

namespace {

using CornerColumns = Eigen::Matrix3d;

/// Returns the weights of a and b of the point of the segment that is nearest to p.
Eigen::Vector2d segmentWeights(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  const double t = nearestOnSegment(a, b, p);
  return {1.0 - t, t};
}

/// Returns the weights of the nearest point on the triangle's three sides.
Eigen::Vector3d sideWeights(const CornerColumns& x, const Eigen::Vector3d& p) {
  Eigen::Vector3d best = Eigen::Vector3d::UnitX();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Eigen::Vector2d w = segmentWeights(x.col(i), x.col(j), p);
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    weights[i] = w[0], weights[j] = w[1];
    if ((x * weights - p).squaredNorm() < (x * best - p).squaredNorm()) best = weights;
  }
  return best;
}

Eigen::Vector3d nearestWeights(const CornerColumns& x, const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = x.col(1) - x.col(0), ac = x.col(2) - x.col(0), ap = p - x.col(0);
  const Eigen::Vector3d normal = ab.cross(ac);
  const double size = normal.squaredNorm();
  if (!(size > 0.0)) return sideWeights(x, p);
  const double v = ap.cross(ac).dot(normal) / size, w = ab.cross(ap).dot(normal) / size;
  const Eigen::Vector3d weights(1.0 - v - w, v, w);
  return weights.minCoeff() >= 0.0 ? weights : sideWeights(x, p);
}

CornerColumns cornersOf(const SoftBodyData& body, const SurfaceHit& hit) {
  CornerColumns x;
  for (int i = 0; i < 3; ++i) x.col(i) = body.state.position.col(hit.points[static_cast<std::size_t>(i)]);
  return x;
}

SurfaceHit hitOnTriangle(const SoftBodyData& body, std::size_t triangle, const Eigen::Vector3d& point) {
  SurfaceHit hit;
  hit.body = body.handle;
  hit.triangle = static_cast<std::uint32_t>(triangle);
  const Triangle& corners = body.model->network->surface[triangle];
  hit.points = {corners[0], corners[1], corners[2]};
  const CornerColumns x = cornersOf(body, hit);
  hit.weights = nearestWeights(x, point);
  hit.normal = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).stableNormalized();
  if (body.settings.scale.prod() < 0.0) hit.normal = -hit.normal;
  return hit;
}

SurfaceHit hitOnSpring(const SoftBodyData& body, std::uint32_t index, const Eigen::Vector3d& point) {
  SurfaceHit hit;
  hit.body = body.handle;
  hit.triangle = index;
  const NetworkSpring& spring = body.model->network->springs[index];
  hit.points = {spring.a, spring.b, spring.b};
  const CornerColumns x = cornersOf(body, hit);
  const Eigen::Vector2d w = segmentWeights(x.col(0), x.col(1), point);
  hit.weights = {w[0], w[1], 0.0};
  hit.normal = (point - x * hit.weights).stableNormalized();
  return hit;
}

}  // namespace

SurfaceReference findSurface(const btCollisionObject* object) {
  const SurfaceObject* surface = SurfaceObject::from(object);
  if (!surface || !surface->owner()) return {};
  return {surface->owner()->handle};
}

SurfaceHit surfaceHit(const btCollisionObject* object, int triangleIndex, const btVector3& place) {
  const SurfaceObject* surface = SurfaceObject::from(object);
  if (!surface || !surface->owner() || triangleIndex < 0) return {};
  const SoftBodyData& body = *surface->owner();
  const auto index = static_cast<std::size_t>(triangleIndex);
  if (index < body.model->network->surface.size()) return hitOnTriangle(body, index, toEigen(place));
  const std::vector<std::uint32_t>& springs = body.surface.shape->springs();
  if (index / 4 < springs.size()) return hitOnSpring(body, springs[index / 4], toEigen(place));
  return {};
}

// --- Bullet's manifolds ------------------------------------------------------------------------------------

namespace {

/// Returns the soft body that has the object as its surface or a point, and sets `side` to the contact's
/// point on it.
SoftBody* readSide(const btCollisionObject* object, int index, const btVector3& position, ContactSide& side) {
  if (const PointReference point = findPoint(object); point.body) {
    side.points = {point.index, point.index, point.index};
    side.weights = Eigen::Vector3d::UnitX();
    return point.body;
  }
  const SurfaceHit hit = surfaceHit(object, index, position);
  if (hit.body) {
    side.points = hit.points;
    side.weights = hit.weights;
    if (hit.triangle < hit.body->network().surface.size()) side.triangle = hit.triangle;
  }
  return findSurface(object).body;
}

/// Reverses the contact, for a soft body that is the manifold's second object.
void reverse(SoftContact& c) {
  std::swap(c.side, c.otherSide);
  c.normal = -c.normal;
  c.impulse = -c.impulse;
  c.frictionImpulse = -c.frictionImpulse;
}

}  // namespace

SoftContact readContact(const btPersistentManifold& manifold, int point) {
  SoftContact c;
  if (point < 0 || point >= manifold.getNumContacts()) return c;
  const btManifoldPoint& p = manifold.getContactPoint(point);
  SoftBody* a = readSide(manifold.getBody0(), p.m_index0, p.m_positionWorldOnA, c.side);
  SoftBody* b = readSide(manifold.getBody1(), p.m_index1, p.m_positionWorldOnB, c.otherSide);
  if (!a && !b) return SoftContact();
  c.body = a ? a : b;
  c.otherBody = a ? b : nullptr;
  c.other = a ? manifold.getBody1() : manifold.getBody0();
  c.position = a ? p.m_positionWorldOnA : p.m_positionWorldOnB;
  c.normal = p.m_normalWorldOnB;
  c.distance = double(p.getDistance());
  c.normalImpulse = double(p.m_appliedImpulse);
  c.frictionImpulse = p.m_appliedImpulseLateral1 * p.m_lateralFrictionDir1 +
                      p.m_appliedImpulseLateral2 * p.m_lateralFrictionDir2;
  c.impulse = p.m_appliedImpulse * p.m_normalWorldOnB + c.frictionImpulse;
  if (!a) reverse(c);
  return c;
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
