// SPDX-License-Identifier: Zlib
#include "bullet/kinematic_motion.h"

#include "bullet/soft_body_data.h"

#include <algorithm>
#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// More ticks than this in a stepSimulation() are not believed.
constexpr double kMaxTicks = 100.0;

/// The share of the way from one pose to another.
btTransform between(const btTransform& from, const btTransform& to, btScalar share) {
  return btTransform(from.getRotation().slerp(to.getRotation(), share),
                     from.getOrigin().lerp(to.getOrigin(), share));
}

/// In how many ticks Bullet's velocity leads from the start to where the object has been told to be. Bullet
/// worked the velocity out for just that, unless the object has been moved since.
int ticksOf(const KinematicMotion& m, btScalar tick) {
  if (!(m.object->getInterpolationWorldTransform() == m.told)) return 1;
  const double speed = double(m.object->getInterpolationLinearVelocity().length());
  const double spin = double(m.object->getInterpolationAngularVelocity().length());
  const double way = double((m.told.getOrigin() - m.start.getOrigin()).length());
  const double turn = double(m.start.getRotation().angleShortestPath(m.told.getRotation()));
  double ticks = 1.0;
  if (way * spin >= turn * speed && speed > 0.0) ticks = way / (speed * double(tick));
  else if (spin > 0.0) ticks = turn / (spin * double(tick));
  return static_cast<int>(std::lround(std::min(std::max(ticks, 1.0), kMaxTicks)));
}

/// Of an object that is new in the world. Bullet's velocity tells how it has moved since it was made, but also that it
/// was made elsewhere: what has come farther than half its size in a tick was put there.
btTransform startOfNew(const btCollisionObject& object, btScalar tick) {
  const btTransform& told = object.getWorldTransform();
  btTransform start;
  btTransformUtil::integrateTransform(told, -object.getInterpolationLinearVelocity(),
                                      -object.getInterpolationAngularVelocity(), tick, start);
  btVector3 center;
  btScalar radius;
  object.getCollisionShape()->getBoundingSphere(center, radius);
  return (start(center) - told(center)).length2() < btScalar(0.25) * radius * radius ? start : told;
}

/// Whether Bullet knows of no motion that has led it where it is: its user has put it there.
bool isPutThere(const btCollisionObject& object) {
  return object.getInterpolationLinearVelocity().isZero() && object.getInterpolationAngularVelocity().isZero();
}

KinematicMotion newMotion(btCollisionObject& object) {
  KinematicMotion motion;
  motion.object = &object;
  motion.id = object.getBroadphaseHandle()->m_uniqueId;
  motion.told = motion.end = object.getWorldTransform();
  return motion;
}

bool isFollowed(const btCollisionObject& object) {
  return isKinematic(object) && object.getBroadphaseHandle() && !isSoft(&object);
}

void advance(KinematicMotion& m, btScalar tick) {
  const btTransform& pose = m.object->getWorldTransform();
  m.start = m.end;
  if (!(pose == m.told) || m.ticksLeft < 1) {
    m.told = pose;
    m.ticksLeft = m.start == pose ? 0 : ticksOf(m, tick);
  }
  m.end = m.ticksLeft > 1 ? between(m.start, m.told, btScalar(1) / btScalar(m.ticksLeft)) : m.told;
  m.ticksLeft = std::max(m.ticksLeft - 1, 0);
}

/// Also around what a turn sweeps between its ends: at most this part of the angle's chord off it.
void fitBox(KinematicMotion& m) {
  const btCollisionShape& shape = *m.object->getCollisionShape();
  btVector3 low, high;
  shape.getAabb(m.start, m.low, m.high);
  if (!m.moves()) return;
  shape.getAabb(m.end, low, high);
  m.low.setMin(low), m.high.setMax(high);
  const btScalar turn = m.start.getRotation().angleShortestPath(m.end.getRotation());
  if (!(turn > 0)) return;
  const btScalar bulge = shape.getAngularMotionDisc() * (btScalar(1) - btCos(turn / 2));
  m.low -= btVector3(bulge, bulge, bulge), m.high += btVector3(bulge, bulge, bulge);
}

}  // namespace

const KinematicMotion* KinematicMotions::known(const btCollisionObject& object) const {
  const int id = object.getBroadphaseHandle()->m_uniqueId;
  const auto isThis = [&](const KinematicMotion& m) { return m.object == &object && m.id == id; };
  // the list's order changes only when an object leaves the world
  const std::size_t guess = motions_.size();
  if (guess < last_.size() && isThis(last_[guess])) return &last_[guess];
  const auto it = std::find_if(last_.begin(), last_.end(), isThis);
  return it == last_.end() ? nullptr : &*it;
}

void KinematicMotions::start(const btCollisionWorld& world) {
  motions_.clear();
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    if (!isFollowed(*objects[i])) continue;
    motions_.push_back(newMotion(*objects[i]));
    motions_.back().seenBetweenSteps = true;
  }
}

void KinematicMotions::follow(const btCollisionWorld& world, btScalar tick) {
  std::swap(motions_, last_);
  motions_.clear();
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    btCollisionObject& object = *objects[i];
    if (!isFollowed(object)) continue;
    const KinematicMotion* before = known(object);
    KinematicMotion motion = before ? *before : newMotion(object);
    if (!before) motion.end = startOfNew(object, tick);
    else if (motion.seenBetweenSteps && isPutThere(object)) motion.end = object.getWorldTransform();
    motion.seenBetweenSteps = false;
    advance(motion, tick);
    fitBox(motion);
    motions_.push_back(motion);
  }
}

KinematicMotions::Rewound::Rewound(const KinematicMotions& motions) : motions_(&motions) {
  for (const KinematicMotion& m : motions.motions_) {
    const_cast<KinematicMotion&>(m).interpolated = m.object->getInterpolationWorldTransform();
    m.object->setWorldTransform(m.start);
    m.object->setInterpolationWorldTransform(m.end);
  }
}

KinematicMotions::Rewound::~Rewound() {
  for (const KinematicMotion& m : motions_->motions_) {
    m.object->setWorldTransform(m.told);
    m.object->setInterpolationWorldTransform(m.interpolated);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
