// SPDX-License-Identifier: Zlib
#include "bullet/point_masses.h"
#include "bullet/surface_partners.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// m: Bullet's broadphase keeps boxes by so much larger than they are; slower motion it has foreseen.
constexpr btScalar kForeseen = btScalar(0.01);

/// btDiscreteDynamicsWorld has no getter for its list of bodies; a derived class may name the protected
/// member.
struct BodyReader : btDiscreteDynamicsWorld {
  static const btAlignedObjectArray<btRigidBody*>& read(const btDiscreteDynamicsWorld& world) {
    return world.*(&BodyReader::m_nonStaticRigidBodies);
  }
};

/// m, the motion of the centre and a bound of what turning adds to it.
struct Motion {
  btVector3 way;
  btScalar turn;
};

Motion motionOf(const btRigidBody& body, btScalar tick) {
  const btScalar spin = body.getAngularVelocity().length();
  const btVector3 fall = body.getTotalForce() * (body.getInvMass() * tick * tick);
  const btScalar turn =
      spin > 0 ? tick * spin * body.getCollisionShape()->getAngularMotionDisc() : btScalar(0);
  return {tick * body.getLinearVelocity() + fall, turn};
}

/// Meets all bodies whose surface or, if the mover is kinematic, points its box overlaps.
struct BodiesInBox final : btBroadphaseAabbCallback {
  BodiesInBox(btDiscreteDynamicsWorld& w, btCollisionObject& m, const void* s) : world(&w), mover(&m), system(s) {}
  btDiscreteDynamicsWorld* world;
  btCollisionObject* mover;
  const void* system;

  bool process(const btBroadphaseProxy* proxy) override {
    if (SurfaceObject* surface = livingSurface(proxy, system)) {
      meet(*surface->owner(), *surface);
    } else if (isKinematic(*mover)) {
      PointMass* point = PointMass::from(static_cast<btCollisionObject*>(proxy->m_clientObject));
      if (point && point->owner() && point->owner()->system == system && point->owner()->alive)
        meet(*point->owner(), *point);
    }
    return true;
  }

  void meet(SoftBodyData& body, btRigidBody& part) const {
    btBroadphaseProxy *a = part.getBroadphaseHandle(), *b = mover->getBroadphaseHandle();
    if (!mayWake(part, *mover) || !world->getPairCache()->needsBroadphaseCollision(a, b)) return;
    if (!part.isActive()) part.activate(true);
    meetPartner(body, part, *mover);
  }
};

void meetInBox(btDiscreteDynamicsWorld& world, btCollisionObject& mover, const btVector3& low,
               const btVector3& high, btScalar margin, const void* system) {
  BodiesInBox bodies(world, mover, system);
  const btVector3 more(margin, margin, margin);
  world.getBroadphase()->aabbTest(low - more, high + more, bodies);
}

void meetInTheWay(btDiscreteDynamicsWorld& world, btRigidBody& body, btScalar tick, const void* system) {
  const Motion motion = motionOf(body, tick);
  if (motion.way.length() + motion.turn <= kForeseen) return;
  btVector3 low, high;
  body.getCollisionShape()->getAabb(body.getWorldTransform(), low, high);
  btVector3 from = low, to = high;
  from.setMin(low + motion.way), to.setMax(high + motion.way);
  meetInBox(world, body, from, to, motion.turn + kForeseen, system);
}

/// A link of a multibody: its box goes on as it has since the broadphase saw it, at the start of the last tick.
void meetOnwards(btDiscreteDynamicsWorld& world, btCollisionObject& link, const void* system) {
  const btBroadphaseProxy* proxy = link.getBroadphaseHandle();
  btVector3 low, high;
  link.getCollisionShape()->getAabb(link.getWorldTransform(), low, high);
  const btVector3 margin(gContactBreakingThreshold, gContactBreakingThreshold, gContactBreakingThreshold);
  const btVector3 down = low - (proxy->m_aabbMin + margin), up = high - (proxy->m_aabbMax - margin);
  if (btMax(down.length(), up.length()) <= kForeseen) return;
  btVector3 from = low, to = high;
  from.setMin(low + down), to.setMax(high + up);
  meetInBox(world, link, from, to, kForeseen, system);
}

}  // namespace

void collectMovers(btDiscreteDynamicsWorld& world, const KinematicMotions& kinematic, const void* system,
                   btScalar tick) {
  for (const KinematicMotion& motion : kinematic.all())
    if (motion.moves() && motion.object->hasContactResponse())
      meetInBox(world, *motion.object, motion.low, motion.high, kForeseen, system);
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i)
    if (objects[i]->getInternalType() == btCollisionObject::CO_FEATHERSTONE_LINK && objects[i]->isActive() &&
        objects[i]->getBroadphaseHandle() && objects[i]->hasContactResponse())
      meetOnwards(world, *objects[i], system);
  const btAlignedObjectArray<btRigidBody*>& bodies = BodyReader::read(world);
  for (int i = 0; i < bodies.size(); ++i) {
    btRigidBody& body = *bodies[i];
    if (isKinematic(body) || !body.isActive() || PointMass::from(&body)) continue;
    if (body.getBroadphaseHandle() && body.hasContactResponse()) meetInTheWay(world, body, tick, system);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
