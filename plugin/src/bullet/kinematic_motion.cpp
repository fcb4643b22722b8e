// SPDX-License-Identifier: Zlib

// This file finds the objects that may move in a tick and computes the motion of kinematic ones. It also
// collects the objects near soft bodies: those that Bullet's broadphase has paired with them, and those that
// move towards them.

#include "bullet/kinematic_motion.h"

#include "bullet/point_contacts.h"

#include <cmath>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Maximum of the estimated number of ticks in a stepSimulation().
constexpr double kMaxTicks = 100.0;

btTransform interpolate(const btTransform& from, const btTransform& to, btScalar share) {
  return btTransform(from.getRotation().slerp(to.getRotation(), share),
                     from.getOrigin().lerp(to.getOrigin(), share));
}

/// Returns the number of ticks in which Bullet's velocity leads from the start to the target. Bullet computed
/// the velocity for this motion, unless the object has been moved since.
int ticksOf(const KinematicMotion& m, btScalar tick) {
  if (!(m.object->getInterpolationWorldTransform() == m.target)) return 1;
  const double speed = double(m.object->getInterpolationLinearVelocity().length());
  const double spin = double(m.object->getInterpolationAngularVelocity().length());
  const double displacement = double((m.target.getOrigin() - m.start.getOrigin()).length());
  const double rotation = double(m.start.getRotation().angleShortestPath(m.target.getRotation()));
  double ticks = 1.0;
  if (displacement * spin >= rotation * speed && speed > 0.0)
    ticks = displacement / (speed * double(tick));
  else if (spin > 0.0)
    ticks = rotation / (spin * double(tick));
  return static_cast<int>(std::lround(std::min(std::max(ticks, 1.0), kMaxTicks)));
}

/// m, displacement of the middle of the object's shape from one pose to the other.
double displacementOf(const btCollisionObject& object, const btTransform& from, const btTransform& to) {
  btVector3 center;
  btScalar radius;
  object.getCollisionShape()->getBoundingSphere(center, radius);
  return (to(center) - from(center)).length();
}

/// Returns the start pose of an object that is new in the world, or new at its place. Bullet's velocity
/// contains its motion since then, but also a first placement. A displacement of more than half its size in a
/// tick is taken for a placement.
btTransform startOfPlaced(const btCollisionObject& object, btScalar tick) {
  const btTransform& target = object.getWorldTransform();
  btTransform start;
  btTransformUtil::integrateTransform(target, -object.getInterpolationLinearVelocity(),
                                      -object.getInterpolationAngularVelocity(), tick, start);
  return displacementOf(object, start, target) < 0.5 * boundingRadiusOf(object) ? start : target;
}

/// Returns whether Bullet's velocity of an object is zero: the user has placed it with both of its poses, or
/// Bullet does not update it.
bool hasNoVelocity(const btCollisionObject& object) {
  return object.getInterpolationLinearVelocity().isZero() &&
         object.getInterpolationAngularVelocity().isZero();
}

/// Returns whether the object jumps: by more than half its size in a tick, at a speed that no motion has
/// right after a slow one. A controller that warps its character does not say that this is no motion.
/// `lastStart`, `lastEnd`: the poses of the tick before. `slowest`: m/s, see slowestJump().
bool jumps(const KinematicMotion& m, const btTransform& lastStart, const btTransform& lastEnd, double slowest,
           btScalar tick) {
  constexpr double kFaster = 4.0;  // times the last displacement
  const double displacement = displacementOf(*m.object, m.start, m.target) / std::max(m.ticksLeft, 1);
  if (displacement < boundingRadiusOf(*m.object)) return false;
  return isCharacter(*m.object) || (displacement > slowest * double(tick) &&
                                    displacement > kFaster * displacementOf(*m.object, lastStart, lastEnd));
}

/// Returns the speed (m/s) of the slowest jump: 100 m/s, or what a fall reaches in ten seconds, so that
/// worlds of centimetres have a hundred times as much.
double slowestJump(const btDiscreteDynamicsWorld& world) {
  return std::max(100.0, 10.0 * double(world.getGravity().length()));
}

KinematicMotion newMotion(btCollisionObject& object) {
  KinematicMotion motion;
  motion.object = &object;
  motion.id = idOf(object);
  motion.start = motion.end = motion.target = object.getWorldTransform();
  return motion;
}

bool isFollowed(const btCollisionObject& object) {
  return isKinematic(object) && object.getBroadphaseHandle() && !isSoft(&object);
}

/// Returns whether Bullet's velocity leads from the start to the target in m.ticksLeft ticks. Bullet rounds
/// the angles of small rotations.
bool isReachedByVelocity(const KinematicMotion& m, btScalar tick) {
  constexpr double kShare = 0.01, kRounding = 1e-5, kRoundedAngle = 2e-3, kHalfTurn = 3.0;
  const double time = m.ticksLeft * double(tick);
  const Eigen::Vector3d way = time * toEigen(m.object->getInterpolationLinearVelocity()),
                        turn = time * toEigen(m.object->getInterpolationAngularVelocity());
  const Eigen::Vector3d rest = difference(m.target.getOrigin(), m.start.getOrigin()) - way;
  if (rest.norm() > kShare * way.norm() + kRounding * double(m.target.getOrigin().length())) return false;
  const Eigen::Vector3d turned =
      rotationBetween(toEigen(m.start.getRotation()), toEigen(m.target.getRotation()));
  return turn.norm() > kHalfTurn || (turned - turn).norm() < kShare * turn.norm() + kRoundedAngle;
}

/// Starts the motion to a new pose. Where Bullet's velocity does not lead there, the user has placed the
/// object elsewhere, with both of its poses, before its motion in this step.
void startMotion(KinematicMotion& m, const btTransform& lastStart, double slowestJump, btScalar tick) {
  const btTransform lastEnd = m.start;
  // it got to its last target, in fewer ticks than were expected
  if (m.ticksLeft > 0) m.start = m.target;
  m.target = m.object->getWorldTransform();
  m.ticksLeft = m.start == m.target ? 0 : ticksOf(m, tick);
  if (m.ticksLeft == 0) return;
  const bool known = m.object->getInterpolationWorldTransform() == m.target;
  if (known && !isReachedByVelocity(m, tick)) {
    m.start = startOfPlaced(*m.object, tick);
    m.ticksLeft = 1;
  } else if (jumps(m, lastStart, lastEnd, slowestJump, tick)) {
    m.start = m.target;
    m.ticksLeft = 0;
  }
}

void advance(KinematicMotion& m, double slowestJump, btScalar tick) {
  const btTransform lastStart = m.start;
  m.start = m.end;
  if (!(m.object->getWorldTransform() == m.target) || m.ticksLeft < 1)
    startMotion(m, lastStart, slowestJump, tick);
  m.end = m.ticksLeft > 1 ? interpolate(m.start, m.target, btScalar(1) / btScalar(m.ticksLeft)) : m.target;
  m.ticksLeft = std::max(m.ticksLeft - 1, 0);
}

/// Makes the vertical part of a character's motion a placement. A controller steps up and down by tens of
/// centimetres in a tick, to wherever it has found a surface. A body that this motion pushed would be thrown.
void placeVertically(KinematicMotion& m, const btVector3& gravity) {
  if (!isCharacter(*m.object) || gravity.fuzzyZero()) return;
  const btVector3 down = gravity.normalized(), motion = m.end.getOrigin() - m.start.getOrigin();
  m.start.setOrigin(m.start.getOrigin() + motion.dot(down) * down);
}

/// Computes the box of the motion. A rotation also sweeps the region between the end poses, which extends at
/// most radius * (1 - cos(angle / 2)) beyond them.
void fitBox(KinematicMotion& m) {
  const btCollisionShape& shape = *m.object->getCollisionShape();
  btVector3 low, high;
  shape.getAabb(m.start, m.low, m.high);
  if (!m.moves()) return;
  shape.getAabb(m.end, low, high);
  m.low.setMin(low), m.high.setMax(high);
  const btScalar rotation = m.start.getRotation().angleShortestPath(m.end.getRotation());
  if (!(rotation > 0)) return;
  const btScalar bulge = shape.getAngularMotionDisc() * (btScalar(1) - btCos(rotation / 2));
  m.low -= btVector3(bulge, bulge, bulge), m.high += btVector3(bulge, bulge, bulge);
}

}  // namespace

void MovingObjects::find(const btCollisionWorld& world) {
  kinematic.clear(), dynamic.clear(), links.clear();
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    btCollisionObject* object = objects[i];
    if (isFollowed(*object))
      kinematic.push_back(object);
    else if (auto* link = btMultiBodyLinkCollider::upcast(object))
      links.push_back(link);
    else if (btRigidBody* body = object->isActive() ? btRigidBody::upcast(object) : nullptr)
      if (!isStaticOrKinematic(*body) && !isSoft(body)) dynamic.push_back(body);
  }
}

const KinematicMotion* KinematicMotions::lastMotion(const btCollisionObject& object) const {
  const int id = idOf(object);
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
    motions_.back().recordedBetweenSteps = true;
  }
}

void KinematicMotions::follow(const btDiscreteDynamicsWorld& world, const MovingObjects& objects,
                              btScalar tick) {
  std::swap(motions_, last_);
  motions_.clear();
  for (btCollisionObject* found : objects.kinematic) {
    btCollisionObject& object = *found;
    const KinematicMotion* before = lastMotion(object);
    KinematicMotion motion = before ? *before : newMotion(object);
    if (!before)
      motion.end = startOfPlaced(object, tick);
    else if (motion.recordedBetweenSteps && hasNoVelocity(object))
      motion.end = object.getWorldTransform();
    motion.recordedBetweenSteps = false;
    advance(motion, slowestJump(world), tick);
    placeVertically(motion, world.getGravity());
    fitBox(motion);
    motions_.push_back(motion);
  }
}

KinematicMotions::Rewound::Rewound(KinematicMotions& motions) : motions_(&motions) {
  for (KinematicMotion& m : motions.motions_) {
    m.interpolated = m.object->getInterpolationWorldTransform();
    m.object->setWorldTransform(m.start);
    m.object->setInterpolationWorldTransform(m.end);
  }
}

KinematicMotions::Rewound::~Rewound() {
  for (const KinematicMotion& m : motions_->motions_) {
    m.object->setWorldTransform(m.target);
    m.object->setInterpolationWorldTransform(m.interpolated);
  }
}

Eigen::Vector3d spinOf(const btCollisionObject& object, double tick) {
  return rotationBetween(toEigen(object.getWorldTransform().getRotation()),
                         toEigen(object.getInterpolationWorldTransform().getRotation())) /
         tick;
}

SurfaceVelocity surfaceVelocityOf(const btCollisionObject& object, const Eigen::Vector3d& displacement,
                                  const Eigen::Vector3d& normal, double tick) {
  SurfaceVelocity motion{displacement / tick};
  const btTransform &start = object.getWorldTransform(), &end = object.getInterpolationWorldTransform();
  if (!isMoved(object) || start.getBasis() == end.getBasis()) return motion;
  const Eigen::Vector3d spin = spinOf(object, tick);
  const Eigen::Vector3d turned = displacement - difference(end.getOrigin(), start.getOrigin());
  const Eigen::Vector3d change = spin.cross(turned) / tick;
  motion.acceleration = change - normal.dot(change) * normal;
  motion.velocity -= 0.5 * tick * motion.acceleration;
  return motion;
}

// --- objects that the broadphase has found -----------------------------------------------------------------

namespace {

/// Adds a partner, sorted by id, because the order of Bullet's hash table is arbitrary.
void addPartner(SoftBodyData& body, btCollisionObject* partner) {
  auto& partners = body.surface.partners;
  const auto it = std::lower_bound(partners.begin(), partners.end(), partner, hasSmallerId);
  if (it == partners.end() || *it != partner) partners.insert(it, partner);
}

/// Returns the awake body of `system` that has the object as its surface, or also as a point; else nullptr.
SoftBodyData* bodyOf(const btCollisionObject& object, bool alsoPoints, const void* system) {
  SoftBodyData* body = alsoPoints || SurfaceObject::from(&object) ? ownerOf(object) : nullptr;
  return body && body->system == system && body->alive && !body->asleep ? body : nullptr;
}

}  // namespace

void collectPartners(btDiscreteDynamicsWorld& world, const void* system) {
  const btBroadphasePairArray& pairs = world.getPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    auto* a = static_cast<btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject);
    auto* b = static_cast<btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject);
    for (int side = 0; side < 2; ++side, std::swap(a, b))
      if (SoftBodyData* body = bodyOf(*a, false, system)) addPartner(*body, b);
  }
}

bool partnersCover(const SoftBodyData& body, const Eigen::AlignedBox3d& box) {
  const SurfaceShape& shape = *body.surface.shape;
  // the box was rounded, but the broadphase enlarges it by gContactBreakingThreshold on all sides
  const double slack = 0.5 * double(gContactBreakingThreshold);
  return body.surface.sweptBounds.tick > 0.0 &&
         (box.min().array() >= toEigen(shape.low()).array() - slack).all() &&
         (box.max().array() <= toEigen(shape.high()).array() + slack).all();
}

// --- objects that move towards soft bodies -----------------------------------------------------------------

namespace {

/// m, margin of the boxes in Bullet's broadphase. They contain all smaller displacements.
constexpr btScalar kBoxMargin = btScalar(0.01);

/// Adds the mover to all bodies whose surface overlaps the box. A kinematic mover is also added to bodies
/// whose points overlap it.
void addToBodiesIn(btDiscreteDynamicsWorld& world, btCollisionObject& mover, const btVector3& low,
                   const btVector3& high, btScalar margin, const void* system) {
  const btVector3 more(margin, margin, margin);
  forEachObjectIn(world, low - more, high + more, [&](btCollisionObject& object) {
    SoftBodyData* body = bodyOf(object, isKinematic(mover), system);
    if (body && canHit(*body, mover)) addPartner(*body, &mover);
  });
}

void addMovingBody(btDiscreteDynamicsWorld& world, btRigidBody& body, btScalar tick, const void* system) {
  const btVector3 fall = body.getTotalForce() * (body.getInvMass() * tick * tick);
  const btVector3 displacement = tick * body.getLinearVelocity() + fall;
  const btScalar rotation = tick * rotationSpeed(body);
  if (displacement.length() + rotation <= kBoxMargin) return;
  btVector3 low, high;
  body.getCollisionShape()->getAabb(body.getWorldTransform(), low, high);
  low.setMin(low + displacement), high.setMax(high + displacement);
  addToBodiesIn(world, body, low, high, rotation + kBoxMargin, system);
}

/// Returns the velocity (m/s) of a link's centre. `spin` becomes a bound of its angular speed (rad/s).
btVector3 velocityOf(const btMultiBodyLinkCollider& collider, btScalar& spin) {
  const btMultiBody& m = *collider.m_multiBody;
  const btVector3& center = collider.getWorldTransform().getOrigin();
  spin = m.getBaseOmega().length();
  btVector3 velocity = m.getBaseVel() + m.getBaseOmega().cross(center - m.getBasePos());
  for (int i = collider.m_link; i >= 0; i = m.getLink(i).m_parent) {
    const btMultibodyLink& link = m.getLink(i);
    const btTransform& pose = link.m_cachedWorldTransform;
    for (int d = 0; d < link.m_dofCount; ++d) {
      const btScalar rate = m.getJointVelMultiDof(i)[d];
      const btVector3 turn = pose.getBasis() * link.getAxisTop(d) * rate;
      velocity += pose.getBasis() * link.getAxisBottom(d) * rate + turn.cross(center - pose.getOrigin());
      spin += turn.length();
    }
  }
  return velocity;
}

}  // namespace

Eigen::AlignedBox3d boundsOf(const btMultiBodyLinkCollider& link, btScalar tick) {
  const btBroadphaseProxy& found = *link.getBroadphaseHandle();
  const double margin = double(gContactBreakingThreshold);
  Eigen::AlignedBox3d box = boxOf(link);
  const Eigen::Vector3d down = box.min() - (toEigen(found.m_aabbMin).array() + margin).matrix();
  const Eigen::Vector3d up = box.max() - (toEigen(found.m_aabbMax).array() - margin).matrix();
  btScalar spin;
  const btVector3 velocity = velocityOf(link, spin);
  btScalar fall = 0;
  if (link.m_link < 0 && link.m_multiBody->getBaseMass() > btScalar(0))
    fall = link.m_multiBody->getBaseForce().length() / link.m_multiBody->getBaseMass();
  const Eigen::Vector3d displacement = toEigen(tick * velocity);
  const double around =
      double(tick * (spin * link.getCollisionShape()->getAngularMotionDisc() + tick * fall));
  const Eigen::Vector3d low = box.min() + down, high = box.max() + up;
  box.extend(Eigen::Vector3d(box.min() + displacement)).extend(Eigen::Vector3d(box.max() + displacement));
  box = {box.min().array() - around, box.max().array() + around};
  return box.extend(low).extend(high);
}

void collectMovers(btDiscreteDynamicsWorld& world, const MovingObjects& objects,
                   const KinematicMotions& kinematic, const void* system, btScalar tick) {
  for (const KinematicMotion& motion : kinematic.all())
    if (motion.moves()) addToBodiesIn(world, *motion.object, motion.low, motion.high, kBoxMargin, system);
  for (btMultiBodyLinkCollider* link : objects.links) {
    const btBroadphaseProxy* found = link->getBroadphaseHandle();
    if (!found || !link->isActive()) continue;
    const Eigen::AlignedBox3d box = boundsOf(*link, tick);
    if (!Eigen::AlignedBox3d(toEigen(found->m_aabbMin), toEigen(found->m_aabbMax)).contains(box))
      addToBodiesIn(world, *link, toBullet(box.min()), toBullet(box.max()), kBoxMargin, system);
  }
  for (btRigidBody* body : objects.dynamic)
    if (body->getBroadphaseHandle()) addMovingBody(world, *body, tick, system);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
