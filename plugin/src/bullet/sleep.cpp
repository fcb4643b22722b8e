// SPDX-License-Identifier: Zlib

// This file puts groups to sleep and wakes them.

#include "bullet/body_in_world.h"
#include "bullet/linked_group.h"
#include "bullet/point_contacts.h"

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// Calls visit(body) for all Bullet bodies of the group that can sleep.
template <class Visit>
void forEachMember(LinkedGroup& group, Visit visit) {
  for (SoftBodyData* body : group.bodies) {
    if (body->surface.object) visit(*body->surface.object);
    if (!body->masses.exposed) continue;
    for (PointMass* point : body->masses.bodies)
      if (point) visit(*point);
  }
  for (RigidPartner& partner : group.rigids)
    if (!partner.body->isStaticOrKinematicObject()) visit(*partner.body);
}

template <class Test>
bool anyMember(LinkedGroup& group, Test test) {
  bool found = false;
  forEachMember(group, [&](btRigidBody& body) { found = found || test(body); });
  return found;
}

bool isFast(const btRigidBody& body) {
  const btScalar linear = body.getLinearSleepingThreshold(), angular = body.getAngularSleepingThreshold();
  return body.getLinearVelocity().length2() >= linear * linear ||
         body.getAngularVelocity().length2() >= angular * angular;
}

/// `lastTick`: s, in which the soft bodies have moved to where they are.
bool movesTooFast(LinkedGroup& group, btScalar lastTick) {
  for (SoftBodyData* body : group.bodies)
    if (movesTooFast(*body, lastTick)) return true;
  for (const RigidPartner& partner : group.rigids)
    if (!isStatic(*partner.body) && isFast(*partner.body)) return true;
  return anyMember(group,
                   [](btRigidBody& body) { return body.getActivationState() == DISABLE_DEACTIVATION; });
}

bool isChanged(const SoftBodyData* body) { return isSurfaceBody(*body) && isSurfaceChanged(*body); }

void wakeGroup(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) wakeBody(*body, true);
  for (RigidPartner& partner : group.rigids)
    if (!partner.body->isActive() && !partner.body->isStaticOrKinematicObject()) wakeInStep(*partner.body);
  group.asleep = false;
  group.calmTime = 0.0;
}

/// Puts the group to sleep. Sets all velocities to zero, because they have been small for seconds.
void sleepGroup(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies) {
    body->state.velocity.setZero();
    body->sumsValid = false;
    body->storedImpulses.clear();
    body->report.fresh = false;
    dropObjectForces(*body);
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

bool isActive(const btRigidBody& body) { return body.isActive(); }

/// Returns the calm time (s) after a tick. A fast tick subtracts the length of several ticks. So a pile may
/// sleep although a point slips now and then, and what begins to move does not fall asleep. One very long
/// tick does not put a body to sleep: it may have been released at its start.
double calmTimeAfter(btScalar tick, bool isFast, double calmTime) {
  constexpr double kSubtracted = 6.0;
  return isFast ? std::max(0.0, calmTime - kSubtracted * double(tick))
                : calmTime + std::min(double(tick), 0.5 * double(gDeactivationTime));
}

/// s, the calm time after which a group is quiet. It sleeps once nothing awake has touched or held it for the
/// rest of gDeactivationTime: what was its support may have gone, and it needs time to begin to fall.
double quietTime() { return double(gDeactivationTime) - std::min(0.25, 0.5 * double(gDeactivationTime)); }

/// Puts surfaces back to sleep that Bullet's islands have woken, by WANTS_DEACTIVATION: see stirTouched().
void ignoreIslands(LinkedGroup& group) {
  for (SoftBodyData* body : group.bodies)
    if (SurfaceObject* surface = body->surface.object;
        surface && surface->getActivationState() == WANTS_DEACTIVATION)
      surface->setActivationState(ISLAND_SLEEPING);
}

bool isAsleep(const btRigidBody& body) { return body.getActivationState() == ISLAND_SLEEPING; }

bool isPutToSleep(const SoftBodyData& body) {
  if (isSurfaceBody(body)) return isAsleep(*body.surface.object);
  const std::vector<PointMass*>& points = body.masses.bodies;
  return std::all_of(points.begin(), points.end(), [](PointMass* p) { return p && isAsleep(*p); });
}

/// Returns whether the user has put all members to sleep. Bullet does so only after gDeactivationTime.
bool isPutToSleep(const LinkedGroup& group) {
  if (group.asleep || group.bodies.empty() || group.calmTime > double(gDeactivationTime)) return false;
  return std::all_of(group.bodies.begin(), group.bodies.end(),
                     [](const SoftBodyData* body) { return isPutToSleep(*body); }) &&
         std::all_of(group.rigids.begin(), group.rigids.end(), [](const RigidPartner& partner) {
           return partner.body->isStaticOrKinematicObject() || isAsleep(*partner.body);
         });
}

/// Woken by the user, put to sleep, or kept awake; otherwise its calm time goes on.
void updateCalmTime(LinkedGroup& group, btScalar tick, btScalar lastTick) {
  // wake() resets the calm time of a body that is awake
  for (const SoftBodyData* body : group.bodies) group.calmTime = std::min(group.calmTime, body->calmTime);
  if (isPutToSleep(group)) sleepGroup(group);
  if (group.asleep) ignoreIslands(group);
  if (group.asleep && !anyMember(group, isActive) &&
      std::none_of(group.bodies.begin(), group.bodies.end(), isChanged)) {
    for (SoftBodyData* body : group.bodies) dropObjectForces(*body);
    return;
  }
  if (group.asleep)
    for (SoftBodyData* body : group.bodies)
      if (isChanged(body)) wakeNeighbours(*body, true);
  if (group.asleep || anyMember(group, isAsleep)) wakeGroup(group);
  const bool sleepIsOff = gDisableDeactivation || gDeactivationTime == btScalar(0);
  group.calmTime = sleepIsOff ? 0.0 : calmTimeAfter(tick, movesTooFast(group, lastTick), group.calmTime);
  forEachMember(group, [](btRigidBody& body) { body.setDeactivationTime(0); });
  for (SoftBodyData* body : group.bodies)
    if (body->surface.object)
      body->surface.object->setDeactivationTime(static_cast<btScalar>(group.calmTime));
}

bool wantsSleep(const LinkedGroup& group) { return !group.asleep && group.calmTime > quietTime(); }

// Bullet's islands decide for point masses in the world and for rigid members of groups.

void markIsland(const btRigidBody& body, SleepScratch& s) {
  const int tag = body.getIslandTag();
  if (tag >= 0 && static_cast<std::size_t>(tag) < s.islands.size())
    s.islands[static_cast<std::size_t>(tag)] = 1;
}

bool inMarkedIsland(const btRigidBody& body, const SleepScratch& s) {
  const int tag = body.getIslandTag();
  return tag >= 0 && static_cast<std::size_t>(tag) < s.islands.size() &&
         s.islands[static_cast<std::size_t>(tag)];
}

bool isIslandMarked(LinkedGroup& group, const SleepScratch& s) {
  return anyMember(group, [&](const btRigidBody& member) {
    return !SurfaceObject::from(&member) && inMarkedIsland(member, s);
  });
}

// For surfaces boxes around the motion of the coming tick decide. Those in Bullet's broadphase, and with them
// its islands, have room for several ticks: they depend on a past that a restored world does not have.

bool isQuiet(const LinkedGroup& group) { return group.asleep || wantsSleep(group); }

void addBoxes(LinkedGroup& group, double tick, std::vector<SleepBox>& boxes) {
  for (SoftBodyData* body : group.bodies) {
    const double fall = tick * tick * double(body->world->getGravity().length());
    boxes.push_back({sweptBoundsOf(*body, tick, fall).box, body->surface.object, body, &group});
  }
}

void addAwake(const btRigidBody& body, double tick, SleepScratch& s) {
  markIsland(body, s);
  if (body.mergesSimulationIslands()) s.awake.push_back({boundsOf(body, tick), &body, nullptr, nullptr});
}

void addAwake(LinkedGroup& group, double tick, SleepScratch& s) {
  addBoxes(group, tick, s.awake);
  for (const RigidPartner& partner : group.rigids)
    if (!partner.body->isStaticOrKinematicObject()) addAwake(*partner.body, tick, s);
  forEachMember(group, [&](const btRigidBody& member) { markIsland(member, s); });
}

void addOthersAwake(const std::vector<LinkedGroup>& groups, const MovingObjects& objects,
                    const KinematicMotions& kinematic, double tick, SleepScratch& s) {
  s.partners.clear();
  for (const LinkedGroup& group : groups)
    for (const RigidPartner& partner : group.rigids) s.partners.push_back(partner.body);
  std::sort(s.partners.begin(), s.partners.end(), std::less<>());
  s.calm.clear();
  for (btRigidBody* body : objects.dynamic) {
    if (std::binary_search(s.partners.begin(), s.partners.end(), body, std::less<>())) continue;
    if (body->wantsSleeping())
      s.calm.push_back(body);
    else
      addAwake(*body, tick, s);
  }
  for (const btMultiBodyLinkCollider* link : objects.links)
    if (link->isActive() && link->getActivationState() != WANTS_DEACTIVATION && link->getBroadphaseHandle())
      s.awake.push_back({boundsOf(*link, btScalar(tick)), link, nullptr, nullptr});
  for (const KinematicMotion& m : kinematic.all())
    if (m.moves() || m.object->isActive())
      s.awake.push_back({{toEigen(m.low), toEigen(m.high)}, m.object, nullptr, nullptr});
}

/// Wakes a sleeping group, and keeps a quiet one awake.
void stir(LinkedGroup& group, double tick, SleepScratch& s) {
  if (group.asleep)
    wakeGroup(group);
  else
    group.calmTime = quietTime();
  addAwake(group, tick, s);
}

/// Bullet's islands decide for contacts of point masses with dynamic bodies.
bool mayTouch(const SoftBodyData& body, const SleepBox& awake) {
  if (!awake.object || !canHit(body, *awake.object)) return false;
  if (isSurfaceBody(body)) return true;
  if (!isKinematic(*awake.object)) return false;
  const double size = 4.0 / 3.0 * radiusOf(body);
  const Eigen::AlignedBox3d reach(awake.box.min().array() - size, awake.box.max().array() + size);
  for (std::uint32_t i = 0; i < pointCount(body); ++i)
    if (reach.contains(body.state.position.col(i)) && canHit(body, i, *awake.object)) return true;
  return false;
}

/// Stirs the groups that want to sleep in one of Bullet's islands that stays awake. Adds the rigid bodies
/// that want to as well: Bullet does not let them. Returns whether there are any.
bool stirInIslands(std::vector<LinkedGroup>& groups, double tick, SleepScratch& s) {
  bool any = false;
  for (LinkedGroup& group : groups) {
    if (group.asleep || !wantsSleep(group) || !isIslandMarked(group, s)) continue;
    stir(group, tick, s);
    any = true;
  }
  for (const btRigidBody*& body : s.calm) {
    if (!body || !inMarkedIsland(*body, s)) continue;
    addAwake(*std::exchange(body, nullptr), tick, s);
    any = true;
  }
  return any;
}

/// Stirs the quiet groups that something awake may touch in the coming tick.
void stirTouched(const SleepBox& awake, double tick, SleepScratch& s) {
  const auto isBefore = [](const SleepBox& box, double x) { return box.box.min().x() < x; };
  auto it = std::lower_bound(s.quiet.begin(), s.quiet.end(), awake.box.min().x() - s.widest, isBefore);
  for (; it != s.quiet.end() && it->box.min().x() <= awake.box.max().x(); ++it)
    if (isQuiet(*it->group) && it->box.intersects(awake.box) && mayTouch(*it->body, awake))
      stir(*it->group, tick, s);
}

void listQuiet(std::vector<LinkedGroup>& groups, double tick, SleepScratch& s) {
  s.quiet.clear();
  s.widest = 0.0;
  for (LinkedGroup& group : groups)
    if (isQuiet(group)) addBoxes(group, tick, s.quiet);
  std::sort(s.quiet.begin(), s.quiet.end(),
            [](const SleepBox& a, const SleepBox& b) { return a.box.min().x() < b.box.min().x(); });
  for (const SleepBox& box : s.quiet) s.widest = std::max(s.widest, box.box.sizes().x());
}

/// Stirs sleeping groups that a moving kinematic object holds by a spring or anchor.
void stirHeld(std::vector<LinkedGroup>& groups, const KinematicMotions& kinematic, double tick,
              SleepScratch& s) {
  s.holders.clear();
  for (const KinematicMotion& m : kinematic.all())
    if (m.moves()) s.holders.push_back(m.object);
  if (s.holders.empty()) return;
  std::sort(s.holders.begin(), s.holders.end(), std::less<>());
  const auto moves = [&](const RigidPartner& partner) {
    return std::binary_search(s.holders.begin(), s.holders.end(), partner.body, std::less<>());
  };
  for (LinkedGroup& group : groups)
    if (group.asleep && std::any_of(group.rigids.begin(), group.rigids.end(), moves)) stir(group, tick, s);
}

/// Returns whether something joined to this body must stay awake.
bool isRestless(const btRigidBody& body, const SleepScratch& s) {
  if (const SurfaceObject* surface = SurfaceObject::from(&body)) {
    const auto isIts = [&](const SleepBox& quiet) {
      return quiet.object == surface && isQuiet(*quiet.group);
    };
    return std::none_of(s.quiet.begin(), s.quiet.end(), isIts);
  }
  if (isStaticOrKinematic(body))
    return std::binary_search(s.holders.begin(), s.holders.end(), &body, std::less<>());
  return body.isActive() && !const_cast<btRigidBody&>(body).wantsSleeping();
}

/// Wakes a sleeping rigid body that something dynamic and awake is joined to. Returns whether it did.
bool wakeBeside(btRigidBody& body, const btRigidBody& awake) {
  if (!isSleepingBody(body) || isStaticOrKinematic(awake)) return false;
  wakeInStep(body);
  return true;
}

/// Stirs quiet groups whose surface objects Bullet's constraints join to something awake, and wakes rigid
/// bodies between such groups. Returns whether there are any.
bool stirJoined(btDiscreteDynamicsWorld& world, double tick, SleepScratch& s) {
  bool any = false;
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    btRigidBody *a = &joint.getRigidBodyA(), *b = &joint.getRigidBodyB();
    if (!joint.isEnabled()) continue;
    for (const auto& [end, other] : {std::pair(a, b), std::pair(b, a)}) {
      if (isRestless(*end, s) || !isRestless(*other, s)) continue;
      if (!SurfaceObject::from(end)) {
        any = wakeBeside(*end, *other) || any;
        continue;
      }
      const auto isIts = [&](const SleepBox& quiet) { return quiet.object == end; };
      stir(*std::find_if(s.quiet.begin(), s.quiet.end(), isIts)->group, tick, s);
      any = true;
    }
  }
  return any;
}

/// Stirs all groups that something awake touches or holds, and those that these touch.
void stirQuiet(std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world, const MovingObjects& objects,
               const KinematicMotions& kinematic, double tick, SleepScratch& s) {
  s.awake.clear();
  addOthersAwake(groups, objects, kinematic, tick, s);
  for (LinkedGroup& group : groups)
    if (!isQuiet(group)) addAwake(group, tick, s);
  stirHeld(groups, kinematic, tick, s);
  if (s.awake.empty() && s.calm.empty() && std::none_of(groups.begin(), groups.end(), wantsSleep)) return;
  listQuiet(groups, tick, s);
  std::size_t next = 0;
  do
    for (; next < s.awake.size(); ++next) stirTouched(SleepBox(s.awake[next]), tick, s);
  while (stirInIslands(groups, tick, s) || stirJoined(world, tick, s));
}

/// Puts the groups to sleep that have been calm and left alone for long enough. Those in one of Bullet's
/// islands sleep together, or Bullet would wake the first.
void sleepTogether(std::vector<LinkedGroup>& groups, SleepScratch& s) {
  const auto isDue = [](const LinkedGroup& group) {
    return !group.asleep && group.calmTime > double(gDeactivationTime);
  };
  for (LinkedGroup& group : groups)
    if (!group.asleep && !isDue(group))
      forEachMember(group, [&](const btRigidBody& member) { markIsland(member, s); });
  for (LinkedGroup& group : groups) {
    if (!isDue(group)) continue;
    if (isIslandMarked(group, s))
      group.calmTime = double(gDeactivationTime);
    else
      sleepGroup(group);
  }
}

}  // namespace

void updateSleep(std::vector<LinkedGroup>& groups, btDiscreteDynamicsWorld& world,
                 const MovingObjects& objects, const KinematicMotions& kinematic, btScalar tick,
                 SleepScratch& scratch, AwakeGroups& awake) {
  scratch.islands.assign(static_cast<std::size_t>(world.getNumCollisionObjects()), 0);
  bool anyQuiet = false;
  for (LinkedGroup& group : groups) {
    updateCalmTime(group, tick, scratch.lastTick > btScalar(0) ? scratch.lastTick : tick);
    anyQuiet = anyQuiet || isQuiet(group);
  }
  scratch.lastTick = tick;
  if (anyQuiet) stirQuiet(groups, world, objects, kinematic, double(tick), scratch);
  if (anyQuiet) sleepTogether(groups, scratch);
  awake.clear();
  for (LinkedGroup& group : groups) {
    for (SoftBodyData* body : group.bodies) body->calmTime = group.calmTime;
    if (!group.asleep) awake.push_back(&group);
  }
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
