// SPDX-License-Identifier: Zlib

// This file makes the object and the shape that represent a soft body in Bullet's world. It updates both and
// the body's points in each tick.

#include "bullet/surface_body.h"

#include "bullet/body_in_world.h"
#include "bullet/point_contacts.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- the surface in Bullet's queries -----------------------------------------------------------------------

struct SurfaceShape::Query {
  btTriangleCallback* callback;
  btVector3 low, high;

  void offer(const btVector3& a, const btVector3& b, const btVector3& c, std::size_t index) const {
    btVector3 corners[3] = {a, b, c}, least = a, most = a;
    for (const btVector3& corner : {b, c}) least.setMin(corner), most.setMax(corner);
    if (TestAabbAgainstAabb2(least, most, low, high))
      callback->processTriangle(corners, 0, static_cast<int>(index));
  }
};

SurfaceShape::SurfaceShape(const SpringNetwork& network, bool mirrored, const Points& positions,
                           btScalar radius)
    : mirrored_(mirrored), positions_(&positions) {
  // not CUSTOM_CONCAVE_SHAPE_TYPE: Bullet casts shapes of that type to btSdfCollisionShape
  m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
  setMargin(radius);
  setNetwork(network);
}

void SurfaceShape::setNetwork(const SpringNetwork& network) {
  network_ = &network;
  springs_.clear();
  if (!network.surface.empty()) return;
  for (std::uint32_t s = 0; s < network.springs.size(); ++s)
    if (network.springs[s].kind == SpringKind::Structural) springs_.push_back(s);
}

void SurfaceShape::getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const {
  if (t.getBasis() == pose_.getBasis()) {
    const btVector3 shift = t.getOrigin() - pose_.getOrigin();
    aabbMin = low_ + shift;
    aabbMax = high_ + shift;
  } else {
    // the bounds of the last box, transformed with the object
    btTransformAabb(low_, high_, btScalar(0), t * pose_.inverse(), aabbMin, aabbMax);
  }
}

btVector3 SurfaceShape::local(std::uint32_t point) const {
  const Eigen::Vector3d origin = toEigen(pose_.getOrigin());
  return toBullet(Eigen::Vector3d(positions_->col(point) - origin)) * pose_.getBasis();
}

void SurfaceShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                                       const btVector3& aabbMax) const {
  const btVector3 margin(getMargin(), getMargin(), getMargin());
  const Query query{callback, aabbMin - margin, aabbMax + margin};
  for (std::size_t t = 0; t < network_->surface.size(); ++t) {
    const Triangle& corners = network_->surface[t];
    const std::size_t second = mirrored_ ? 2 : 1;
    query.offer(local(corners[0]), local(corners[second]), local(corners[3 - second]), t);
  }
  if (!springs_.empty()) reportStrips(query);
}

void SurfaceShape::reportStrips(const Query& query) const {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const NetworkSpring& spring = network_->springs[springs_[s]];
    const btVector3 a = local(spring.a), b = local(spring.b), along = b - a;
    if (along.fuzzyZero()) continue;
    btVector3 sides[2];
    btPlaneSpace1(along.normalized(), sides[0], sides[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      const btVector3 side = sides[i] * getMargin();
      query.offer(a - side, b - side, b + side, 4 * s + 2 * i);
      query.offer(a - side, b + side, a + side, 4 * s + 2 * i + 1);
    }
  }
}

// --- the object --------------------------------------------------------------------------------------------

SurfaceObject::SurfaceObject(SoftBodyData* owner)
    : OwnBody(btRigidBodyConstructionInfo(0, nullptr, nullptr)), owner_(owner) {
  keepCollisionFilter();
  // also clears the static flag, which Bullet sets for a mass of 0; this plugin draws soft bodies
  setCollisionFlags(CF_DISABLE_VISUALIZE_OBJECT);
  // if the user adds the object to the world again, the world must not apply gravity to it
  setFlags((getFlags() & ~BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) | BT_DISABLE_WORLD_GRAVITY);
}

/// The application deletes the object if it still has an owner.
SurfaceObject::~SurfaceObject() {
  if (!owner_) return;
  owner_->surface.object = nullptr;
  owner_->alive = false;
}

const char* SurfaceObject::serialize(void* data, btSerializer* serializer) const {
  if (owner_ && owner_->alive) writeChunk(*owner_, *serializer);
  return btRigidBody::serialize(data, serializer);
}

bool SurfaceObject::mayTouch(const btCollisionObject& other) const {
  // that of a surface object is for Bullet's dispatcher
  const SurfaceObject* surface = from(&other);
  return btRigidBody::checkCollideWithOverride(&other) &&
         (surface ? surface->btRigidBody::checkCollideWithOverride(this) : other.checkCollideWith(this));
}

// --- in the world ------------------------------------------------------------------------------------------

namespace {

/// Number of ticks for which a broadphase box has room. An unchanged box costs Bullet nothing; for a changed
/// box it searches its whole tree.
constexpr double kBoxTicks = 4.0;

/// Maximum room, as a fraction of the box. With more, the boxes of bodies side by side would overlap.
constexpr double kMaxBoxRoom = 0.25;

/// Room on every side, as a fraction of the box, for oscillations and for the rounding of Bullet's numbers.
constexpr double kSideRoom = 0.01;

/// Sets the box for the broadphase: the motion of the last and of the coming tick, with room for the next
/// ticks in the direction of the motion. A present box that contains the motion and is not too large is kept.
void setBox(SoftBodyData& body) {
  const SurfaceShape& shape = *body.surface.shape;
  const MotionSums& sums = sumsOf(body);
  Eigen::AlignedBox3d box = body.surface.sweptBounds.box;
  box.extend(Eigen::Vector3d(sums.startLow)).extend(Eigen::Vector3d(sums.startHigh));
  const Eigen::Vector3d size = box.sizes(), largest = kMaxBoxRoom * size;
  const Eigen::Vector3d room =
      (kBoxTicks * body.surface.sweptBounds.displacement).cwiseMin(largest).cwiseMax(-largest);
  const Eigen::AlignedBox3d present(toEigen(shape.low()), toEigen(shape.high()));
  const Eigen::Vector3d unused = present.sizes() - size - 2.0 * room.cwiseAbs();
  if (present.contains(box) && (unused.array() <= 4.0 * kSideRoom * size.array()).all()) return;
  box.extend(box.min() + room.cwiseMin(0.0) - kSideRoom * size);
  box.extend(box.max() + room.cwiseMax(0.0) + kSideRoom * size);
  body.surface.shape->setBox(toBullet(box.min()), toBullet(box.max()));
}

/// Sets the box in the broadphase for these bounds if they are not in it. Returns whether it has changed.
bool extendBox(SoftBodyData& body, const SweptBounds& bounds) {
  SurfaceData& s = body.surface;
  if (s.sweptBounds.box.contains(bounds.box) || !s.object || !s.object->isInWorld()) return false;
  s.sweptBounds = bounds;
  s.sweptBounds.tick = 0.0;
  setBox(body);
  body.world->updateSingleAabb(s.object);
  return true;
}

/// Returns whether the user has disabled the body, or Bullet has because its box was too large.
bool isOutOfSimulation(const SoftBodyData& body) {
  return body.surface.object->getActivationState() == DISABLE_SIMULATION;
}

/// Replaces the gravity of each point when the world's has changed, as the world does for its own bodies.
void updateGravity(SoftBodyData& body) {
  const btVector3 gravity = gravityOf(body);
  if (gravity == body.surface.gravity) return;
  for (PointMass* point : body.masses.bodies)
    if (!(point->getFlags() & BT_DISABLE_WORLD_GRAVITY)) point->setGravity(gravity);
  body.surface.gravity = gravity;
}

/// Sets all accelerations to zero if they are not finite: they would spread to all points.
void restoreAccelerations(SoftBodyData& body) {
  if (body.state.acceleration.cwiseAbs().sum() < kMaxSound) return;
  body.state.acceleration.setZero();
  body.restored = true;
}

void accelerateShared(SoftBodyData& body) {
  updateGravity(body);
  collectForces(body);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const PointMass& point = *body.masses.bodies[i];
    const Eigen::Vector3d gravity =
        toEigen(point.getGravity()).cwiseProduct(toEigen(point.getLinearFactor()));
    body.state.acceleration.col(i) = gravity + double(point.getInvMass()) * body.surface.force.col(i);
    if (body.masses.held[i]) body.state.acceleration.col(i).setZero();
  }
}

/// Applies the damping of the points as Bullet does: it multiplies a body's velocity by (1 - damping)^tick
/// before it moves the body.
void dampPoints(SoftBodyData& body, double tick) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const double damping = double(body.masses.bodies[i]->getLinearDamping());
    if (damping == 0.0 || body.masses.held[i]) continue;
    const Eigen::Vector3d mean = (body.state.position.col(i) - body.masses.startPosition.col(i)) / tick;
    const Eigen::Vector3d change =
        (std::pow(1.0 - damping, tick) - 1.0) * (mean - tick * body.state.acceleration.col(i));
    body.state.velocity.col(i) += change;
    body.state.position.col(i) += tick * change;
  }
}

/// Returns how far (m) the springs may throw a point in a tick that begins with points that have just been
/// let go: other ticks begin with the velocities that the springs have caused so far. At most as far as if
/// the point had the whole elastic energy.
double freedMotionOf(const SoftBodyData& body, double tick) {
  const Points motion = tick * tick * body.state.inverseMass.cwiseProduct(elasticForces(body));
  const double energy = body.volumes.empty() ? std::max(0.0, elasticEnergy(body)) : HUGE_VAL;
  double farthest = 0.0;
  for (Eigen::Index i = 0; i < motion.cols(); ++i) {
    const double most = tick * std::sqrt(2.0 * energy * body.state.inverseMass.col(i).maxCoeff());
    const double length = motion.col(i).norm();
    farthest = std::max(farthest, length > 0.0 ? std::min(length, most) : 0.0);
  }
  return farthest;
}

/// Calls the base class, because btDiscreteDynamicsWorld would move the object.
void addObject(SoftBodyData& body, int group, int mask) {
  SurfaceObject& object = *body.surface.object;
  body.world->btCollisionWorld::addCollisionObject(&object, group, mask);
  object.proxyId = idOf(object);
}

}  // namespace

void addSurface(SoftBodyData& body) {
  initializePointMasses(body);
  SurfaceData& s = body.surface;
  s.object = new SurfaceObject(&body);
  s.shape = std::make_unique<SurfaceShape>(*body.model->network, body.settings.scale.prod() < 0.0,
                                           body.state.position, body.masses.shape->getRadius());
  s.object->setCollisionShape(s.shape.get());
  s.object->setFriction(static_cast<btScalar>(body.settings.friction));
  s.object->setRestitution(static_cast<btScalar>(body.settings.restitution));
  s.object->setSleepingThresholds(static_cast<btScalar>(body.settings.sleepingSpeed),
                                  s.object->getAngularSleepingThreshold());
  writeObject(body);
  s.sweptBounds = sweptBoundsOf(body, 0.0);
  s.gravity = gravityOf(body);
  setBox(body);
  addObject(body, body.settings.collisionGroup, body.settings.collisionMask);
}

void adoptObject(SoftBodyData& body) {
  SurfaceObject& object = *body.surface.object;
  const btBroadphaseProxy proxy = *object.getBroadphaseHandle();
  if (proxy.m_uniqueId == object.proxyId) return;
  body.world->removeRigidBody(&object);
  addObject(body, proxy.m_collisionFilterGroup, proxy.m_collisionFilterMask);
}

void removeSurface(SoftBodyData& body) {
  if (SurfaceObject* object = body.surface.object) {
    object->setOwner(nullptr);
    // the world's destructor removes the broadphase handle: an object without one must not access the world
    if (object->isInWorld() && isElsewhere(*object, *body.world)) {
      // it is left to the user, without the shape, which goes with the body
      static btEmptyShape nothing;
      object->setCollisionShape(&nothing);
    } else {
      if (object->isInWorld()) body.world->removeRigidBody(object);
      delete object;
    }
    body.surface.object = nullptr;
  }
  deletePointMasses(body);
}

void watchSteps(SoftBodyData& body) {
  const std::lock_guard<std::mutex> lock(*body.worldLock);
  if (body.onPointsExposed) body.onPointsExposed();
}

void exposePoints(SoftBodyData& body) {
  if (body.masses.bodies.empty()) {
    // Bullet counts its bodies
    const std::lock_guard<std::mutex> lock(*body.worldLock);
    makePointMasses(body);
  }
  if (body.masses.exposed || !body.alive) return;
  body.masses.exposed = true;
  if (body.surface.force.cols() == 0) body.surface.force.setZero(3, body.state.position.cols());
  // if the body is in no world, the world may no longer exist
  const bool inWorld = anyInWorld(body);
  if (inWorld) body.surface.gravity = gravityOf(body);
  for (PointMass* point : body.masses.bodies) {
    if (body.surface.object) point->setFriction(body.surface.object->getFriction());
    point->setGravity(body.surface.gravity);
    if (body.asleep) point->setActivationState(ISLAND_SLEEPING);
  }
  writePoints(body);
  if (inWorld) watchSteps(body);
}

void collectForces(SoftBodyData& body) {
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    PointMass* point = body.masses.bodies[i];
    if (!point) continue;
    if (isSound(point->getTotalForce()))
      body.surface.force.col(i) += toEigen(point->getTotalForce());
    else
      body.restored = true;
    point->clearForces();
  }
}

void addForce(SoftBodyData& body, std::uint32_t i, const Eigen::Vector3d& force) {
  SurfaceData& s = body.surface;
  if (!isSurfaceBody(body)) {
    if (PointMass* point = body.masses.bodies[i]) point->applyCentralForce(toBullet(force));
    return;
  }
  if (s.newForce.cols() == 0) s.newForce.setZero(3, body.state.position.cols());
  s.newForce.col(i) += force;
  s.hasNewForce = true;
}

void takeForces(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  if (!s.hasNewForce) return;
  if (s.force.cols() == 0) s.force.setZero(3, body.state.position.cols());
  s.force += s.newForce;
  s.newForce.setZero();
  s.hasNewForce = false;
  // the system must detect the end of the step
  if (!s.pushed) watchSteps(body);
  s.pushed = true;
}

void forgetSearches(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  s.motionValid = s.boxesValid = false;
  for (CachedContact& contact : s.contacts) contact.partner = 0;
  for (CachedSearch& search : s.searches) search.partner = nullptr;
}

void gatherSurface(SoftBodyData& body, btScalar tick) {
  SurfaceData& s = body.surface;
  takeForces(body);
  s.motionValid = s.boxesValid = false;
  s.object->keepCollisionFilter();
  readObject(body);
  const bool held = isOutOfSimulation(body);
  if (held) exposePoints(body);
  if (body.masses.exposed) {
    gatherPoints(body, tick, held);
    accelerateShared(body);
    accelerateByObject(body);
    return restoreAccelerations(body);
  }
  body.masses.startPosition = body.state.position;
  const btVector3 gravity = gravityOf(body);
  if (gravity != s.gravity) s.sweptBounds.tick = 0.0;
  s.gravity = gravity;
  const Eigen::Vector3d acceleration = toEigen(gravity);
  for (Eigen::Index i = 0; i < body.state.acceleration.cols(); ++i)
    body.state.acceleration.col(i) = acceleration;
  if (s.force.cols() > 0 && !s.force.isZero(0.0)) {
    body.state.acceleration += body.state.inverseMass.cwiseProduct(s.force);
    s.sweptBounds.tick = 0.0;
  }
  accelerateByObject(body);
  // without forces on the object all accelerations are gravity
  if (s.pushed || !isSound(gravity)) restoreAccelerations(body);
}

bool updateBroadphaseBox(SoftBodyData& body, btScalar tick) {
  SurfaceData& s = body.surface;
  s.freedMotion = std::exchange(s.freed, false) ? freedMotionOf(body, double(tick)) : 0.0;
  const bool isPredicted = s.freedMotion == 0.0 && !body.masses.exposed && s.sweptBounds.tick == double(tick);
  s.presentBounds = isPredicted ? s.sweptBounds : sweptBoundsOf(body, double(tick));
  s.presentBounds.box.min().array() -= s.freedMotion;
  s.presentBounds.box.max().array() += s.freedMotion;
  s.presentBounds.maxDisplacement += s.freedMotion;
  return !isPredicted && extendBox(body, s.presentBounds);
}

void updateQueryBox(SoftBodyData& body) {
  SurfaceData& s = body.surface;
  if (!s.object || !s.object->isInWorld()) return;
  s.sweptBounds = sweptBoundsOf(body, 0.0);
  setBox(body);
  body.world->updateSingleAabb(s.object);
}

void writeBoxToBullet(SoftBodyData& body, btScalar tick) {
  body.surface.sweptBounds = sweptBoundsOf(body, double(tick));
  setBox(body);
}

void finishSurface(SoftBodyData& body, btScalar tick) {
  if (body.masses.exposed) {
    absorbOutsideChanges(body);  // by actions since the tick began
    dampPoints(body, double(tick));
    body.sumsValid = false;
  }
  restoreIfUnsound(body);
  readObject(body, double(tick));
  if (body.masses.exposed) writePoints(body);
  writeObject(body);
}

bool anySurfacePointMoves(SoftBodyData& body, btScalar tick) {
  if (!body.masses.exposed) {
    const double still = double(body.surface.object->getLinearSleepingThreshold() * tick);
    return sumsOf(body).farthest >= still * still;
  }
  return anyPointMoves(body, tick);
}

bool isSurfaceChanged(const SoftBodyData& body) {
  if (isObjectChanged(body)) return true;
  if (!body.masses.exposed) return false;
  if (body.masses.changed) return true;
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i)
    if (isChangedOutside(body, i)) return true;
  return false;
}

void wakeSurface(SoftBodyData& body) {
  const auto wake = [](btRigidBody* object) {
    if (object && object->getActivationState() != ACTIVE_TAG) object->activate(true);
  };
  wake(body.surface.object);
  // the prediction is out of date, and partners were collected only for awake bodies
  body.surface.sweptBounds.tick = 0.0;
  if (!body.masses.exposed) return;
  for (PointMass* point : body.masses.bodies) wake(point);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
