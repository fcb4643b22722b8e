// SPDX-License-Identifier: Zlib
#include "bullet/point_mass.h"
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

/// Meets all surfaces that a mover's box overlaps.
struct SurfacesInBox final : btBroadphaseAabbCallback {
  SurfacesInBox(btRigidBody& b, const void* s) : mover(&b), system(s) {}
  btRigidBody* mover;
  const void* system;

  bool process(const btBroadphaseProxy* proxy) override {
    const btBroadphaseProxy* own = mover->getBroadphaseHandle();
    const bool may = (proxy->m_collisionFilterGroup & own->m_collisionFilterMask) &&
                     (own->m_collisionFilterGroup & proxy->m_collisionFilterMask);
    SurfaceObject* surface = may ? livingSurface(proxy, system) : nullptr;
    if (!surface) return true;
    if (!surface->isActive()) surface->activate(true);
    meetPartner(*surface, *mover);
    return true;
  }
};

void meetInTheWay(btDiscreteDynamicsWorld& world, btRigidBody& body, const Motion& motion,
                  const void* system) {
  btVector3 low, high;
  body.getCollisionShape()->getAabb(body.getWorldTransform(), low, high);
  const btVector3 more(motion.turn + kForeseen, motion.turn + kForeseen, motion.turn + kForeseen);
  // a kinematic body is already where it will be
  const btVector3 way = body.isKinematicObject() ? -motion.way : motion.way;
  btVector3 from = low, to = high;
  from.setMin(low + way), to.setMax(high + way);
  SurfacesInBox surfaces(body, system);
  world.getBroadphase()->aabbTest(from - more, to + more, surfaces);
}

}  // namespace

void collectMovers(btDiscreteDynamicsWorld& world, const void* system, btScalar tick) {
  const btAlignedObjectArray<btRigidBody*>& bodies = BodyReader::read(world);
  for (int i = 0; i < bodies.size(); ++i) {
    btRigidBody& body = *bodies[i];
    if (!body.isActive() || PointMass::from(&body) || !body.hasContactResponse()) continue;
    if (!body.getBroadphaseHandle()) continue;
    const Motion motion = motionOf(body, tick);
    if (motion.way.length() + motion.turn > kForeseen) meetInTheWay(world, body, motion, system);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
