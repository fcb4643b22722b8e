// SPDX-License-Identifier: Zlib
#include "bullet/group_sleep.h"

#include "bullet/body_in_world.h"
#include "bullet/kinematic_motion.h"
#include "bullet/surface_body.h"

#include <algorithm>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Calls visit(body) for all Bullet bodies of the group that can sleep.
template <class Visit>
void forEachMember(TickGroup& group, Visit visit) {
  for (SoftBodyData* body : group.bodies) {
    if (body->surface.object) visit(*body->surface.object);
    if (!body->masses.shared) continue;
    for (PointMass* point : body->masses.bodies)
      if (point) visit(*point);
  }
  for (RigidPartner& partner : group.rigids)
    if (!partner.body->isStaticOrKinematicObject()) visit(*partner.body);
}

template <class Test>
bool anyMember(TickGroup& group, Test test) {
  bool found = false;
  forEachMember(group, [&](btRigidBody& body) { found = found || test(body); });
  return found;
}

bool isFast(const btRigidBody& body) {
  const btScalar linear = body.getLinearSleepingThreshold(), angular = body.getAngularSleepingThreshold();
  return body.getLinearVelocity().length2() > linear * linear ||
         body.getAngularVelocity().length2() > angular * angular;
}

bool isRestless(TickGroup& group, btScalar tick) {
  for (const SoftBodyData* body : group.bodies)
    if (isRestless(*body, tick)) return true;
  for (const RigidPartner& partner : group.rigids)
    if (!isStatic(*partner.body) && isFast(*partner.body)) return true;
  return anyMember(group,
                   [](btRigidBody& body) { return body.getActivationState() == DISABLE_DEACTIVATION; });
}

bool isChanged(const TickGroup& group) {
  return std::any_of(group.bodies.begin(), group.bodies.end(), [](const SoftBodyData* body) {
    return isSurfaceBody(*body) && isSurfaceChanged(*body);
  });
}

void wakeGroup(TickGroup& group) {
  for (SoftBodyData* body : group.bodies) wakeBody(*body, true);
  for (RigidPartner& partner : group.rigids) {
    btRigidBody& rigid = *partner.body;
    if (rigid.isActive() || rigid.isStaticOrKinematicObject()) continue;
    rigid.activate(true);
    rigid.applyGravity();
  }
  group.asleep = false;
  group.calmTime = 0.0;
}

/// All velocities go to zero: what was calm for seconds stands still.
void sleepGroup(TickGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->state.velocity.setZero();
    body->asleep = true;
    body->substeps = 0;
    body->surface.partners.clear();
    body->surface.left.velocity = body->surface.left.spin = btVector3(0, 0, 0);
    std::fill(body->masses.leftVelocity.begin(), body->masses.leftVelocity.end(), btVector3(0, 0, 0));
  }
  forEachMember(group, [](btRigidBody& body) {
    body.setLinearVelocity(btVector3(0, 0, 0));
    body.setAngularVelocity(btVector3(0, 0, 0));
    body.setInterpolationLinearVelocity(btVector3(0, 0, 0));
    body.setActivationState(ISLAND_SLEEPING);
  });
  group.asleep = true;
}

bool sleepIsOff() { return gDisableDeactivation || gDeactivationTime == btScalar(0); }

/// Woken from outside (a contact, the user), or kept awake; otherwise its calm time goes on.
void updateCalmTime(TickGroup& group, btScalar tick) {
  // wake() on a body that is awake starts its calm time anew
  for (const SoftBodyData* body : group.bodies) group.calmTime = std::min(group.calmTime, body->calmTime);
  if (group.asleep && !anyMember(group, [](btRigidBody& body) { return body.isActive(); }) &&
      !isChanged(group))
    return;
  if (group.asleep || anyMember(group, [](btRigidBody& body) {
        return !body.isActive() && body.getActivationState() == ISLAND_SLEEPING;
      }))
    wakeGroup(group);
  group.calmTime = sleepIsOff() || isRestless(group, tick) ? 0.0 : group.calmTime + double(tick);
  forEachMember(group, [](btRigidBody& body) { body.setDeactivationTime(0); });
  for (SoftBodyData* body : group.bodies)
    if (body->surface.object)
      body->surface.object->setDeactivationTime(static_cast<btScalar>(group.calmTime));
}

void rememberCalmTime(const TickGroup& group) {
  for (SoftBodyData* body : group.bodies) body->calmTime = group.calmTime;
}

bool wantsSleep(const TickGroup& group) {
  return !group.asleep && group.calmTime > double(gDeactivationTime);
}

void markIsland(const btRigidBody& body, std::vector<unsigned char>& islands) {
  const int tag = body.getIslandTag();
  if (tag >= 0 && static_cast<std::size_t>(tag) < islands.size()) islands[static_cast<std::size_t>(tag)] = 1;
}

bool inMarkedIsland(const btRigidBody& body, const std::vector<unsigned char>& islands) {
  const int tag = body.getIslandTag();
  return tag >= 0 && static_cast<std::size_t>(tag) < islands.size() && islands[static_cast<std::size_t>(tag)];
}

/// Whether the body is the surface of a soft body in one of these groups, which are all of one system.
bool isOwnSurface(const std::vector<TickGroup>& groups, const btRigidBody* body) {
  const SurfaceObject* surface = SurfaceObject::from(body);
  if (!surface || !surface->owner()) return false;
  for (const TickGroup& group : groups)
    if (!group.bodies.empty()) return group.bodies[0]->system == surface->owner()->system;
  return false;
}

/// Marks the islands of the last tick that hold something awake which is not a member of any group.
void markOthersAwake(const std::vector<TickGroup>& groups, btDiscreteDynamicsWorld& world,
                     std::vector<unsigned char>& islands) {
  const auto isPartner = [&](const btRigidBody* body) {
    for (const TickGroup& group : groups)
      for (const RigidPartner& partner : group.rigids)
        if (partner.body == body) return true;
    return false;
  };
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  islands.assign(static_cast<std::size_t>(objects.size()), 0);
  for (int i = 0; i < objects.size(); ++i) {
    btRigidBody* body = btRigidBody::upcast(objects[i]);
    if (!body || PointMass::from(body) || isOwnSurface(groups, body) || body->isStaticOrKinematicObject() ||
        isPartner(body))
      continue;
    if (body->isActive() && !body->wantsSleeping()) markIsland(*body, islands);
  }
}

/// A group in contact with something awake stays awake, and then so do its own islands.
void settleCandidates(std::vector<TickGroup>& groups, std::vector<unsigned char>& islands) {
  const auto markGroup = [&](TickGroup& group) {
    forEachMember(group, [&](btRigidBody& body) { markIsland(body, islands); });
  };
  for (TickGroup& group : groups)
    if (!group.asleep && !wantsSleep(group)) markGroup(group);
  for (bool changed = true; changed;) {
    changed = false;
    for (TickGroup& group : groups) {
      if (!wantsSleep(group)) continue;
      if (!anyMember(group, [&](btRigidBody& body) { return inMarkedIsland(body, islands); })) continue;
      group.calmTime = double(gDeactivationTime);
      markGroup(group);
      changed = true;
    }
  }
}

}  // namespace

void updateSleep(std::vector<TickGroup>& groups, btDiscreteDynamicsWorld& world, btScalar tick,
                 std::vector<unsigned char>& islands) {
  bool candidates = false;
  for (TickGroup& group : groups) {
    updateCalmTime(group, tick);
    rememberCalmTime(group);
    candidates = candidates || wantsSleep(group);
  }
  if (!candidates) return;
  markOthersAwake(groups, world, islands);
  settleCandidates(groups, islands);
  for (TickGroup& group : groups)
    if (wantsSleep(group)) sleepGroup(group);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
