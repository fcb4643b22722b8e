// SPDX-License-Identifier: Zlib
#include <limber/soft_body.h>

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/contact_report.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "core/body_measures.h"
#include "core/spring_forces.h"

#include <limber/skin.h>

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

SoftBody::SoftBody(std::unique_ptr<SoftBodyData> data) : data_(std::move(data)) { data_->handle = this; }
SoftBody::~SoftBody() = default;

SoftBodyData& dataOf(const SoftBody& body) { return *body.data_; }

const SpringNetwork& SoftBody::network() const { return *data_->network; }
const SharedNetwork& SoftBody::sharedNetwork() const { return data_->network; }
const SoftBodySettings& SoftBody::settings() const { return data_->settings; }
std::uint32_t SoftBody::pointCount() const {
  return static_cast<std::uint32_t>(data_->network->restPoints.size());
}
bool SoftBody::alive() const { return data_->alive; }

btRigidBody* SoftBody::point(std::uint32_t i) const {
  if (i >= pointCount()) return nullptr;
  if (isSurfaceBody(*data_)) sharePoints(*data_);
  return data_->masses.bodies[i];
}

btRigidBody* SoftBody::surfaceObject() const { return data_->surface.object; }

Eigen::Vector3d SoftBody::position(std::uint32_t i) const {
  readObject(*data_);
  return currentPosition(*data_, i);
}

Eigen::Vector3d SoftBody::velocity(std::uint32_t i) const {
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

std::uint32_t SoftBody::placeCount() const {
  const Skin& skin = data_->network->render.skin;
  return skin.size() > 0 ? static_cast<std::uint32_t>(skin.size()) : pointCount();
}

void SoftBody::writePlaces(float* xyz) const {
  const Skin& skin = data_->network->render.skin;
  if (skin.size() == 0) return writePositions(xyz);
  data_->skinned.resize(std::size_t{3} * pointCount());
  writePositions(data_->skinned.data());
  applySkin(skin, data_->skinned.data(), xyz);
}

void SoftBody::writePlaces(float* xyz, double tickFraction) const {
  const Skin& skin = data_->network->render.skin;
  if (skin.size() == 0) return writePositions(xyz, tickFraction);
  data_->skinned.resize(std::size_t{3} * pointCount());
  writePositions(data_->skinned.data(), tickFraction);
  applySkin(skin, data_->skinned.data(), xyz);
}

void SoftBody::pin(std::uint32_t i) {
  if (point(i) && !pinned(i)) setPinned(*data_, i, true);
}

void SoftBody::movePin(std::uint32_t i, const btVector3& target) {
  if (!pinned(i)) return;
  wake();
  data_->masses.bodies[i]->getWorldTransform().setOrigin(target);
}

void SoftBody::unpin(std::uint32_t i) {
  if (!pinned(i)) return;
  setPinned(*data_, i, false);
  wake();
}

bool SoftBody::pinned(std::uint32_t i) const {
  const PointMass* point = i < pointCount() ? data_->masses.bodies[i] : nullptr;
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

/// The state with what the user has changed since the last tick.
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

PointReference findPoint(const btCollisionObject* object) {
  const PointMass* point = PointMass::from(object);
  if (!point || !point->owner()) return {};
  return {point->owner()->handle, point->index()};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
