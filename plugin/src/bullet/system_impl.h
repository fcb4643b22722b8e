// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet/cluster.h"
#include "bullet/contact_events.h"
#include "bullet/rigid_contacts.h"
#include "bullet/shared_topologies.h"
#include "bullet/shown_contacts.h"
#include "bullet/step_plan.h"
#include "bullet/step_sentinel.h"
#include "bullet/surface_gather.h"
#include "bullet/tick_group.h"
#include "bullet/tick_hook.h"

#include <limber/soft_body_system.h>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Where SoftBodySystem's warnings go unless the user wants them elsewhere.
void warnOnStandardError(const std::string& text);

/// What a SoftBodySystem is made of; soft_body_system.cpp has what users call, system_tick.cpp the tick.
struct SoftBodySystem::Impl final : TickListener, StepListener {
  Impl(btDiscreteDynamicsWorld& w, Hook h) : world(&w), hookKind(h) {}

  void beforeTick(btScalar tick) override;
  void afterTick(btScalar tick) override;
  void tickMissed() override;
  void debugDraw(btIDebugDraw& drawer) override;
  void afterTickOrEmptyStep() override;

  void hookUp();
  void unhookIfIdle(bool alive);
  bool detach(SoftBody* softBody, std::uint32_t i);
  void forget(const btRigidBody& body);
  void dropSprings(const btRigidBody& body);
  void forgetGroups();
  bool worldAlive() const;
  void watchSteps();
  void stopWatching(bool alive);
  void beginStepOfForces();
  void rebuildGroupsIfNeeded();
  void gatherGroups(btScalar tick);
  void gatherPartners(SoftBodyData& body, btScalar tick);
  void gatherClusters(btScalar tick);
  void stepGroups(btScalar tick);
  void handOverGroups(btScalar tick);
  void updateLiving();
  void tellOfContacts();
  void hideManifolds();
  void destroyNow(SoftBody* body);
  void endPairsOf(SoftBody* body);

  btDiscreteDynamicsWorld* world;
  Hook hookKind;
  TickHook* hook = nullptr;
  bool overwritten = false;
  std::function<void(const std::string&)> warn = warnOnStandardError;

  std::vector<std::unique_ptr<SoftBody>> bodies;
  SpringList springs;
  std::vector<TickGroup> groups;
  StepPlan plan;
  TickContacts pairs;  // contacts in which more than one body moves
  Clusters clusters;   // what they couple
  RigidManifolds manifolds;
  SharedTopologies topologies;
  ShapeCache shapes;
  RigidSurfaces rigidSurfaces{shapes};
  SurfaceSearch search;
  std::vector<SoftBodyData*> living;  // the bodies in the groups
  std::size_t usableLinks = 0;        // springs and anchors in the groups
  bool groupsStale = false;
  std::vector<unsigned char> islands;      // scratch of updateSleep
  std::unique_ptr<StepSentinel> sentinel;  // while point masses outside the world are in the user's hands
  ContactEvents events;
  bool showsManifolds = false;
  std::vector<StrongestContacts> strongest;  // scratch of showContacts
  std::vector<SoftBody*> doomed;             // to be destroyed once the listener has been told
  TickProfile profile;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
