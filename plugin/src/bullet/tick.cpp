// SPDX-License-Identifier: Zlib

// This file runs the stages of a tick in order, before and after Bullet's own part of it: first the stages
// that all systems of a world share, then those of each system.

#include "bullet/point_contacts.h"
#include "bullet/system_impl.h"

#include <limber/grab.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {
namespace {

/// The shared steps of all worlds that have systems.
struct StepList {
  std::mutex mutex;  // worlds may be stepped by several threads
  std::vector<std::pair<const btDynamicsWorld*, std::weak_ptr<void>>> steps;
};

void gatherMovingPairs(SoftBodyData& body, btScalar tick, RigidSurfaces& rigids, SurfaceSearch& search,
                       TickContacts& found) {
  if (isSurfaceBody(body)) return gatherSurfacePairs(body, tick, rigids, search, found);
  for (btRigidBody* partner : body.freePartners) gatherPairs(body, *partner, tick, found);
}

/// Whether there is work for several threads: so many springs, or a body that is divided among them.
bool isMuch(const std::vector<SoftBodyData*>& bodies, std::size_t fromSprings) {
  return springCount(bodies) >= fromSprings ||
         std::any_of(bodies.begin(), bodies.end(),
                     [](const SoftBodyData* body) { return body->springs->division.isDivided(); });
}

}  // namespace

// --- all systems of a world --------------------------------------------------------------------------------

std::shared_ptr<SoftBodySystem::Impl::WorldStep> SoftBodySystem::Impl::WorldStep::of(
    btDiscreteDynamicsWorld& world) {
  // never deleted: a system of static lifetime may be destroyed after other static objects
  static StepList& list = *new StepList;
  const std::lock_guard<std::mutex> lock(list.mutex);
  auto& steps = list.steps;
  const auto isGone = [](const auto& entry) { return entry.second.expired(); };
  steps.erase(std::remove_if(steps.begin(), steps.end(), isGone), steps.end());
  for (const auto& [key, entry] : steps)
    if (key == &world)
      if (auto step = std::static_pointer_cast<WorldStep>(entry.lock())) return step;
  auto step = std::make_shared<WorldStep>();
  step->world = &world;
  steps.emplace_back(&world, step);
  return step;
}

void SoftBodySystem::Impl::WorldStep::updateLiving() {
  living.clear();
  absent.clear();
  springs.clear();
  for (Impl* system : systems) {
    for (auto& body : system->bodies) {
      body->data_->alive = isAlive(*body->data_);
      if (!body->data_->alive) {
        absent.push_back(body->data_.get());
        continue;
      }
      body->data_->inTick = &inTick;
      body->data_->index = static_cast<std::uint32_t>(living.size());
      living.push_back(body->data_.get());
    }
    for (auto& spring : system->springs) springs.push_back(spring.get());
  }
}

/// The broadphase proposes partners, and may have rigid bodies where they were before they were put back,
/// too.
void SoftBodySystem::Impl::WorldStep::updateBoxesAfterRollback() {
  bool any = false;
  for (SoftBodyData* body : living) any = std::exchange(body->rolledBack, false) || any;
  if (any) world->updateAabbs();
}

void SoftBodySystem::Impl::WorldStep::divideBodies() {
  // whatever divides bodies, or lets them tear, makes the groups stale; most worlds have nothing of the kind
  if (!groupsStale && !mayDivide) return;
  mayDivide = false;
  for (Impl* system : systems)
    for (auto& handle : system->bodies) {
      SoftBodyData& body = *handle->data_;
      body.tears.clear();
      body.brokenAnchors.clear();
      if (!body.alive) continue;
      makePendingCuts(body);
      tearBody(body);
      mayDivide = mayDivide || !body.tears.empty() || mayTear(body);
    }
}

void SoftBodySystem::Impl::WorldStep::rebuildGroupsIfNeeded() {
  // those that are back make the groups stale
  for (SoftBodyData* body : absent) isAlive(*body);
  for (const LinkedGroup& group : groups) groupsStale = groupsStale || !isWhole(group);
  groupsStale = updateUsableLinks(*world, living, springs, usableLinks) || groupsStale;
  if (!groupsStale) return;
  updateLiving();
  updateBoxesAfterRollback();
  groups = makeLinkedGroups(*world, living, springs);
  updateUsableLinks(*world, living, springs, usableLinks);
  groupsStale = false;
}

// The stages, in the order in which beforeTick() and afterTick() call them.

void SoftBodySystem::Impl::WorldStep::findAwake(btScalar tick) {
  rebuildGroupsIfNeeded();
  Grab::aimAll(springs);
  for (Impl* system : systems) system->clearForcesOnNewStep();
  objects.find(*world);
  kinematic.follow(*world, objects, tick);
  links.begin(*world);
  for (Impl* system : systems)
    if (system->surroundings.air.windAt)
      for (auto& body : system->bodies)
        if (body->data_->alive && isBlownAwake(*body->data_)) wakeBody(*body->data_, true);
  updateSleep(groups, *world, objects, kinematic, tick, sleepScratch, awake);
  collectPartners(*world, this);
  collectMovers(*world, objects, kinematic, this, tick);
  moving.clear();
  for (const LinkedGroup* group : awake)
    moving.insert(moving.end(), group->bodies.begin(), group->bodies.end());
  parallel.setWorthwhile(isMuch(moving, parallel.fromSprings()));
}

void SoftBodySystem::Impl::WorldStep::read(btScalar tick) {
  readManifolds(*world->getDispatcher());
  const bool hasFields = std::any_of(systems.begin(), systems.end(),
                                     [](const Impl* system) { return !system->surroundings.fields.empty(); });
  // the boxes depend on the fields, and Bullet's broadphase is for one thread; else one pass is the cheapest
  const bool boxesLater = hasFields || parallel.isOn();
  bool changed = false;
  parallel.forEach(awake.size(), [&](std::size_t g) {
    gatherBodies(*awake[g], tick);
    if (!hasFields) surroundBodies(*awake[g], tick);
    if (!boxesLater) changed = updateBroadphaseBoxes(*awake[g], tick) || changed;
  });
  if (hasFields) {
    for (SoftBodyData* body : moving) applyFields(*body, double(tick));
    parallel.forEach(awake.size(), [&](std::size_t g) { surroundBodies(*awake[g], tick); });
  }
  if (boxesLater)
    for (LinkedGroup* group : awake) changed = updateBroadphaseBoxes(*group, tick) || changed;
  if (changed) collectPartners(*world, this);
}

void SoftBodySystem::Impl::WorldStep::collide(btScalar tick) {
  pairs.clear(double(tick));
  rigidSurfaces.clear();
  // links of multibodies are numbered in the order in which they are found
  const Parallel inOrder;
  (parallel.isOn() && !objects.links.empty() ? inOrder : parallel).forEach(awake.size(), [&](std::size_t g) {
    gatherGroup(*awake[g], tick);
  });
  shareSoftPartners(awake);
  if (parallel.isOn()) heldPairs.gather(moving, tick, rigidSurfaces, searches, parallel);
  searches.with([&](SurfaceSearch& search) {
    for (std::size_t i = 0; i < moving.size(); ++i)
      if (!parallel.isOn() || !heldPairs.take(i, pairs))
        gatherMovingPairs(*moving[i], tick, rigidSurfaces, search, pairs);
  });
  if (living.size() > 1) gatherPointPairs(awake, tick, pairs);
  searches.with([&](SurfaceSearch& search) { addStoppedPairs(*world->getDispatcher(), pairs, search); });
  filterContacts();
  profile.rigidParts = rigidSurfaces.size();
}

void SoftBodySystem::Impl::WorldStep::filterContacts() {
  if (std::none_of(systems.begin(), systems.end(), [](const Impl* system) { return bool(system->filter); }))
    return;
  for (SoftBodyData* body : moving)
    if (isFiltered(*body)) filterPlanes(*body, body->contacts, &pairs);
  filterPairs(pairs, newIndex);
}

void SoftBodySystem::Impl::WorldStep::findIslands(btScalar tick) {
  warmStart(pairs);
  addLinkedRigids(awake, pairs);
  links.addJoints(pairs);
  gatherRigidContacts(*world, objects, tick, manifolds, pairs);
  makeIslands(awake, pairs, tick, islands);
}

void SoftBodySystem::Impl::WorldStep::keepBudgets(btScalar tick) {
  parallel.forEach(awake.size(), [&](std::size_t g) { keepBudget(*awake[g], double(tick)); });
}

/// Groups in no island choose when they are stepped.
void SoftBodySystem::Impl::WorldStep::choose(btScalar tick) {
  parallel.forEach(awake.size(), [&](std::size_t g) {
    if (awake[g]->inIsland) chooseStepping(*awake[g], double(tick));
  });
}

void SoftBodySystem::Impl::WorldStep::step(btScalar tick) {
  // points with unexpectedly large displacements search for more contacts during the step
  const KinematicMotions::Rewound rewound(kinematic);
  lone.step(awake, double(tick), parallel, profile);
  LapTimer timer;
  stepIslands(islands, pairs, double(tick), searches, lock, parallel);
  profile.stepMs += timer.lap();
}

void SoftBodySystem::Impl::WorldStep::write(btScalar tick) {
  for (Island& island : islands) writeIslandToBullet(island, pairs, tick);
  links.applyImpulses(pairs);
  reportRigidContacts(pairs);
  storeImpulses(moving, pairs);
  parallel.inBlocks(awake.size(), [&](std::size_t begin, std::size_t end) {
    TickProfile work;
    for (std::size_t g = begin; g < end; ++g)
      if (awake[g]->inIsland) writeGroup(*awake[g], tick, work);
    const std::lock_guard<std::mutex> guard(lock);
    profile += work;
  });
  for (const Island& island : islands) numberIsland(island.softBodies);
  profile.awakeBodies = moving.size();
  profile.islands = islands.count;
  profile.contacts += pairs.contacts.size();
  disableDrives(pairs, disabledDrives);
  for (Impl* system : systems) system->surroundings.time += double(tick);
}

void SoftBodySystem::Impl::WorldStep::beforeTick(btScalar tick) {
  profile = TickProfile();
  for (Impl* system : systems) system->hideManifolds();
  // drives are still disabled if afterTick() was not called for the last tick
  enableDrives(*world, disabledDrives);
  links.finishMotions();
  // a tick of length zero moves nothing and would cause a division by zero
  if (!(tick > btScalar(0))) return;
  divideBodies();
  inTick = true;
  LapTimer timer;
  findAwake(tick);
  {
    const KinematicMotions::Rewound rewound(kinematic);
    read(tick);
    profile.readMs = timer.lap();
    collide(tick);
    profile.searchMs = timer.lap();
    keepBudgets(tick);
    profile.chooseMs = timer.lap();
    findIslands(tick);
    profile.islandsMs = timer.lap();
    choose(tick);
    profile.chooseMs += timer.lap();
  }
  disableBulletResponse(*world->getDispatcher());
  step(tick);
  timer.lap();
  write(tick);
  profile.writeMs += timer.lap();
}

void SoftBodySystem::Impl::WorldStep::takeLink(SpringConstraint& spring, const LinkSpring& link) {
  const double limit = spring.settings_.breakForce;
  spring.broken_ = limit > 0.0 && std::abs(link.force) > limit;
  spring.force_ = spring.broken_ ? 0.0 : link.force;
  if (spring.broken_) brokenSprings.push_back(spring.handle());
  if (spring.target_) (spring.a_.body ? spring.b_ : spring.a_).pivot = *spring.target_;
  spring.target_.reset();
}

/// Removes the anchors that held more than they can.
void SoftBodySystem::Impl::WorldStep::takeAnchors(LinkedGroup& group, double tick) {
  for (const LinkAnchor& link : group.step.links.anchors) {
    SoftBodyData& body = *group.bodies[link.point.body];
    const auto anchor = findAnchor(body, link.point.point);
    if (anchor == body.anchors.end()) continue;
    anchor->force = toBullet(link.impulse / tick);
    const double force = link.impulse.norm() / tick;
    if (!(anchor->breakForce > 0.0 && force > anchor->breakForce)) continue;
    body.brokenAnchors.push_back({body.handle, anchor->point, anchor->body, force});
    body.anchors.erase(anchor);
    body.surface.freed = true;
    groupsStale = true;
  }
}

void SoftBodySystem::Impl::WorldStep::restoreBulletState() {
  restoreBreakingThresholds(*world->getDispatcher());
  enableDrives(*world, disabledDrives);
  links.finishMotions();
}

void SoftBodySystem::Impl::WorldStep::afterTick(btScalar tick) {
  restoreBulletState();
  inTick = false;
  brokenSprings.clear();
  if (!(tick > btScalar(0))) return;
  LapTimer timer;
  parallel.forEach(awake.size(), [&](std::size_t g) {
    if (!awake[g]->hasWorldPoints) readGroupFromBullet(*awake[g], tick);
  });
  for (LinkedGroup* group : awake) {
    if (group->hasWorldPoints) readGroupFromBullet(*group, tick);
    for (std::size_t i = 0; i < group->springs.size(); ++i) {
      takeLink(*group->springs[i], group->step.links.springs[i]);
      if (!group->springs[i]->broken()) continue;
      for (SoftBodyData* body : group->bodies) body->surface.freed = true;
    }
    takeAnchors(*group, double(tick));
  }
  for (const Island& island : islands) readIslandFromBullet(island, pairs, *world, tick);
  reportJoints(*world, pairs, tick);
  reportContacts(moving, pairs, *world, double(tick), parallel);
  anyRestored =
      std::any_of(living.begin(), living.end(), [](const SoftBodyData* body) { return body->restored; });
  profile.readBackMs = timer.lap();
}

// --- one system --------------------------------------------------------------------------------------------

void SoftBodySystem::Impl::beforeTick(btScalar tick) {
  // the hook may have been kept because nothing proved that the world still existed
  unhookIfIdle(true);
  if (!hook || (step->stepped && step->stepped != this)) return;
  step->stepped = this;
  step->beforeTick(tick);
}

void SoftBodySystem::Impl::afterTick(btScalar tick) {
  if (step->stepped) step->afterTick(tick);
  step->stepped = nullptr;
  warnAboutRestored();
  if (tick > btScalar(0)) notifyListener();
}

void SoftBodySystem::Impl::warnAboutRestored() {
  if (!step->anyRestored) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    SoftBodyData& body = *bodies[i]->data_;
    if (!std::exchange(body.restored, false) || body.restorations++ > 0) continue;
    warn("soft body " + std::to_string(i) +
         " was given a position, velocity or force that is not finite, or got one: it was put back to where "
         "it was before, see SoftBody::restorations()");
  }
}

// Forces on point masses outside the world act in all ticks of one stepSimulation(), like Bullet's forces.

void SoftBodySystem::Impl::watchSteps() {
  if (stepBoundary) return;
  stepBoundary = std::make_unique<StepBoundary>(*world, [this] { collectAppliedForces(); });
  // the boundary may be created inside a step, which must not count as a new one
  stepBoundary->stepHasEnded();
}

void SoftBodySystem::Impl::clearForcesOnNewStep() {
  // there are no forces before the boundary exists
  if (!stepBoundary || !stepBoundary->stepHasEnded()) return;
  for (auto& body : bodies) {
    SurfaceData& surface = body->data_->surface;
    surface.force.setZero();
    surface.objectForce.setZero();
    surface.objectTorque.setZero();
  }
}

/// Collects the forces applied so far. If this step ends without a further tick, they are lost, as for
/// Bullet's bodies. They are not lost if the user called synchronizeMotionStates() before a step.
void SoftBodySystem::Impl::collectAppliedForces() {
  clearForcesOnNewStep();
  for (auto& body : bodies) {
    if (!isSurfaceBody(*body->data_)) continue;
    takeForces(*body->data_);
    if (body->data_->surface.object) takeObjectForces(*body->data_);
    if (body->data_->masses.exposed) collectForces(*body->data_);
  }
}

void SoftBodySystem::Impl::tickMissed() {
  hideManifolds();
  if (overwritten) return;
  overwritten = true;
  warn(
      "the world's pre-tick callback was overwritten after soft bodies were added: springs are not stepped. "
      "Set yours before the first soft body, or call SoftBodySystem::rehook().");
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
