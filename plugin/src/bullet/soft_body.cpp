// SPDX-License-Identifier: Zlib

// This file implements the user's interface of a soft body, and reads the results of Bullet's queries.

#include <limber/soft_body.h>

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "mesh/surface.h"

#include <limber/network_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>

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
bool SoftBody::alive() const { return isAlive(*data_); }
const std::string& SoftBody::name() const { return data_->name; }
void SoftBody::setName(std::string name) { data_->name = std::move(name); }
void* SoftBody::userPointer() const { return data_->userPointer; }
void SoftBody::setUserPointer(void* pointer) { data_->userPointer = pointer; }
int SoftBody::userIndex() const { return data_->userIndex; }
void SoftBody::setUserIndex(int index) { data_->userIndex = index; }

btRigidBody* SoftBody::point(std::uint32_t i) const {
  if (i >= pointCount()) return nullptr;
  if (isSurfaceBody(*data_)) exposePoints(*data_);
  return data_->masses.bodies[i];
}

btRigidBody* SoftBody::surfaceObject() const { return data_->surface.object; }

namespace {

Eigen::Vector3d noVector() { return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()); }

Error noPoint(const SoftBody& body, std::uint32_t i) {
  const std::string point = "point " + std::to_string(i);
  if (i < body.pointCount()) return {point + " has been deleted"};
  return {"there is no " + point + ": the body has " + std::to_string(body.pointCount()) + " points"};
}

Error notPinned(std::uint32_t i) { return {"point " + std::to_string(i) + " is not pinned"}; }

/// Writes positionOf(i) for all points.
template <class PositionOf>
void writeEach(const SoftBodyData& body, PositionOf positionOf, float* xyz) {
  for (std::uint32_t i = 0; i < pointCount(body); ++i) {
    const Eigen::Vector3f p = positionOf(i).template cast<float>();
    xyz = std::copy(p.data(), p.data() + 3, xyz);
  }
}

/// Writes the vertices of the skin. writePoints(xyz) writes the points.
template <class WritePoints>
void writeSkin(SoftBodyData& body, WritePoints writePoints, float* xyz) {
  const Skin& skin = body.model->network->render.skin;
  if (skin.size() == 0) return writePoints(xyz);
  body.skinned.resize(std::size_t{3} * pointCount(body));
  writePoints(body.skinned.data());
  applySkin(skin, body.skinned.data(), xyz);
}

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
  writeEach(
      *data_, [&](std::uint32_t i) { return currentPosition(*data_, i); }, xyz);
}

void SoftBody::writePositions(float* xyz, double tickFraction) const {
  readObject(*data_);
  writeEach(
      *data_, [&](std::uint32_t i) { return positionAt(*data_, i, tickFraction); }, xyz);
}

std::uint32_t SoftBody::skinnedPointCount() const {
  const Skin& skin = data_->model->network->render.skin;
  return skin.size() > 0 ? static_cast<std::uint32_t>(skin.size()) : pointCount();
}

void SoftBody::writeSkinnedPositions(float* xyz) const {
  writeSkin(
      *data_, [&](float* points) { writePositions(points); }, xyz);
}

void SoftBody::writeSkinnedPositions(float* xyz, double tickFraction) const {
  writeSkin(
      *data_, [&](float* points) { writePositions(points, tickFraction); }, xyz);
}

TriangleMesh SoftBody::surfaceMesh() const {
  const SpringNetwork& net = network();
  const bool drawn = !net.render.triangles.empty();
  std::vector<float> xyz(std::size_t{3} * (drawn ? skinnedPointCount() : pointCount()));
  drawn ? writeSkinnedPositions(xyz.data()) : writePositions(xyz.data());
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < xyz.size(); i += 3) points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  TriangleMesh mesh;
  mesh.triangles = drawn ? net.render.triangles : net.surface;
  if (settings().scale.prod() < 0.0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  if (mesh.triangles.empty()) return {};
  std::vector<std::uint32_t> followed = net.render.vertexToPoint;
  if (!drawn)
    for (std::uint32_t i = 0; i < points.size(); ++i) followed.push_back(i);
  std::vector<Triangle> ofPoints = mesh.triangles;
  for (Triangle& t : ofPoints)
    for (std::uint32_t& corner : t) corner = followed[corner];
  const std::vector<Eigen::Vector3d> normals = vertexNormals(points, ofPoints);
  for (const std::uint32_t point : followed) {
    mesh.positions.push_back(point == kNoPoint ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : points[point]);
    mesh.normals.push_back(point == kNoPoint ? Eigen::Vector3f(0, 0, 1)
                                             : normals[point].cast<float>().eval());
  }
  if (drawn) mesh.uvs = net.render.uvs;
  return mesh;
}

Result<void> SoftBody::exportMesh(const std::string& file) const {
  const TriangleMesh mesh = surfaceMesh();
  if (mesh.triangles.empty()) return Error{file + ": the body has no surface; exportSprings() writes ropes"};
  return saveMesh(mesh, file);
}

Result<void> SoftBody::exportSprings(const std::string& file) const {
  std::vector<Eigen::Vector3d> points;
  for (std::uint32_t i = 0; i < pointCount(); ++i) points.push_back(position(i));
  return saveSprings(network(), points, file);
}

Result<void> SoftBody::pin(std::uint32_t i) {
  if (!point(i)) return noPoint(*this, i);
  if (!alive()) return notAlive();
  if (pinned(i)) return {};
  readFromBullet(*data_);
  setPinned(*data_, i, true);
  return {};
}

Result<void> SoftBody::movePin(std::uint32_t i, const btVector3& target) {
  if (i >= pointCount()) return noPoint(*this, i);
  if (!pinned(i)) return point(i) ? notPinned(i) : noPoint(*this, i);
  if (!alive()) return notAlive();
  if (!toEigen(target).allFinite())
    return Error{"the target of point " + std::to_string(i) + " is not finite"};
  if (toEigen(target).cwiseAbs().maxCoeff() > kMaxCoordinate)
    return Error{"the target of point " + std::to_string(i) + " has a coordinate beyond 2e6"};
  wake();
  data_->masses.bodies[i]->getWorldTransform().setOrigin(target);
  return {};
}

Result<void> SoftBody::unpin(std::uint32_t i) {
  if (i >= pointCount()) return noPoint(*this, i);
  if (!pinned(i)) return point(i) ? notPinned(i) : noPoint(*this, i);
  if (!alive()) return notAlive();
  readFromBullet(*data_);
  const btVector3& place = data_->masses.bodies[i]->getWorldTransform().getOrigin();
  if (place != data_->masses.leftPosition[i]) data_->state.position.col(i) = toEigen(place);  // it was moved
  setPinned(*data_, i, false);
  wake();
  return {};
}

bool SoftBody::pinned(std::uint32_t i) const {
  const PointMass* point = i < data_->masses.bodies.size() ? data_->masses.bodies[i] : nullptr;
  return point && point->isKinematicObject();
}

bool SoftBody::attached(std::uint32_t i) const { return isAttached(*data_, i); }

btVector3 SoftBody::anchorForce(std::uint32_t i) const {
  const auto anchor = findAnchor(*data_, i);
  return anchor != data_->anchors.end() ? anchor->force : btVector3(0, 0, 0);
}

std::uint32_t SoftBody::restorations() const { return data_->restorations; }
bool SoftBody::sleeping() const { return data_->asleep; }
void SoftBody::wake() { wakeBody(*data_, false); }
void SoftBody::sleep() {
  data_->calmTime = 0.0;
  if (data_->surface.object) data_->surface.object->setActivationState(ISLAND_SLEEPING);
  for (PointMass* point : data_->masses.bodies)
    if (point) point->setActivationState(ISLAND_SLEEPING);
}

Stepper SoftBody::stepper() const { return data_->stepper; }
double SoftBody::softening() const { return data_->softening ? data_->softening->share : 1.0; }
double SoftBody::errorPerSecond() const { return data_->errorPerSecond; }
int SoftBody::substeps() const { return data_->substeps; }
int SoftBody::island() const { return data_->asleep ? -1 : data_->island; }
double SoftBody::frequencyBound() const { return std::sqrt(data_->frequencySquared); }

const std::vector<SoftContact>& SoftBody::contacts() const { return readReport(*data_); }

namespace {

/// Returns the state, with the user's changes since the last tick.
const PointState& current(SoftBodyData& data) {
  readObject(data);
  absorbOutsideChanges(data);
  return data.state;
}

/// Returns the force (N) of springs, dampers and volumes on point i.
Eigen::Vector3d innerForce(const SoftBodyData& body, const PointState& state, std::uint32_t i) {
  const SpringArrays& springs = body.springs;
  Eigen::Vector3d force = elasticForces(body).col(i);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const std::uint32_t a = springs->a[s], b = springs->b[s];
    if (a != i && b != i) continue;
    const SpringPull pull = springPull(state.position.col(b) - state.position.col(a), springs->restLength[s],
                                       springs->extensionStiffness[s], springs->compressionStiffness[s]);
    const Eigen::Vector3d opening = state.velocity.col(a == i ? b : a) - state.velocity.col(i);
    force += springs->damping[s] * pull.direction.dot(opening) * pull.direction;
  }
  return force;
}

}  // namespace

btVector3 SoftBody::pinForce(std::uint32_t i) const {
  if (!pinned(i) || !alive()) return btVector3(0, 0, 0);
  const btVector3 weight = data_->masses.bodies[i]->massBeforePin * gravityOf(*data_);
  return -toBullet(innerForce(*data_, current(*data_), i)) - weight;
}

double SoftBody::totalMass() const { return limber::totalMass(current(*data_)); }
Eigen::Vector3d SoftBody::centerOfMass() const { return limber::centerOfMass(current(*data_)); }
Eigen::Vector3d SoftBody::linearMomentum() const { return limber::linearMomentum(current(*data_)); }
Eigen::Vector3d SoftBody::angularMomentum() const { return limber::angularMomentum(current(*data_)); }
double SoftBody::kineticEnergy() const { return limber::kineticEnergy(current(*data_)); }
double SoftBody::elasticEnergy() const {
  current(*data_);
  return limber::elasticEnergy(*data_);
}
double SoftBody::volume() const {
  const Points& x = current(*data_).position;
  const Eigen::Vector3d from = x.col(0);
  double sum = 0.0;
  for (const Triangle& t : data_->model->parts.closed)
    sum += (x.col(t[0]) - from).dot((x.col(t[1]) - from).cross(x.col(t[2]) - from));
  return sum / 6.0;
}
std::vector<std::uint32_t> SoftBody::brokenSprings() const {
  std::vector<std::uint32_t> broken;
  const SpringConstants* own = data_->springs.yielded.get();
  for (std::size_t i = 0; own && i < data_->springs.size(); ++i)
    if (isBroken(data_->springs, i)) broken.push_back(own->division.order[i]);
  std::sort(broken.begin(), broken.end());
  return broken;
}
std::uint64_t SoftBody::stateHash() const { return limber::stateHash(current(*data_)); }

// --- results of Bullet's queries ---------------------------------------------------------------------------

PointReference findPoint(const btCollisionObject* object) {
  const PointMass* point = PointMass::from(object);
  if (!point || !point->owner()) return {};
  return {point->owner()->handle, point->index()};
}

namespace {

/// Returns a hit with the corners `points`, and sets `x` to their positions (columns).
SurfaceHit hitOn(const SoftBodyData& body, std::size_t triangle, const std::array<std::uint32_t, 3>& points,
                 Eigen::Matrix3d& x) {
  SurfaceHit hit;
  hit.body = body.handle;
  hit.triangle = static_cast<std::uint32_t>(triangle);
  hit.points = points;
  for (std::size_t i = 0; i < 3; ++i)
    x.col(static_cast<Eigen::Index>(i)) = body.state.position.col(points[i]);
  return hit;
}

SurfaceHit hitOnTriangle(const SoftBodyData& body, std::size_t triangle, const Eigen::Vector3d& point) {
  const Triangle& corners = body.model->network->surface[triangle];
  Eigen::Matrix3d x;
  SurfaceHit hit = hitOn(body, triangle, corners, x);
  hit.weights = nearestBarycentric({x.col(0), x.col(1), x.col(2)}, point);
  hit.normal = (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)).stableNormalized();
  if (body.settings.scale.prod() < 0.0) hit.normal = -hit.normal;
  return hit;
}

SurfaceHit hitOnSpring(const SoftBodyData& body, std::uint32_t index, const Eigen::Vector3d& point) {
  const NetworkSpring& spring = body.model->network->springs[index];
  Eigen::Matrix3d x;
  SurfaceHit hit = hitOn(body, index, {spring.a, spring.b, spring.b}, x);
  const double t = nearestOnSegment(x.col(0), x.col(1), point);
  hit.weights = {1.0 - t, t, 0.0};
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
  if (!surface || !surface->owner() || triangleIndex < 0 || !isFinite(place)) return {};
  const SoftBodyData& body = *surface->owner();
  const auto index = static_cast<std::size_t>(triangleIndex);
  if (index < body.model->network->surface.size()) return hitOnTriangle(body, index, toEigen(place));
  const std::vector<std::uint32_t>& springs = body.surface.shape->springs();
  if (index / 4 < springs.size()) return hitOnSpring(body, springs[index / 4], toEigen(place));
  return {};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
