// SPDX-License-Identifier: Zlib

// This header declares what a system is made of, and the step that all systems of a world share.

#pragma once

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "bullet/kinematic_motion.h"
#include "bullet/linked_group.h"
#include "bullet/surface_gather.h"
#include "bullet/tick_contacts.h"
#include "bullet/tick_hook.h"

#include <limber/soft_body_system.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Where SoftBodySystem's warnings go unless the user wants them elsewhere.
void warnOnStandardError(const std::string& text);

/// What a SoftBodySystem is made of; soft_body_system.cpp has what users call, tick.cpp the
/// tick.
struct SoftBodySystem::Impl final : TickListener, StepListener {
  struct WorldStep;

  Impl(btDiscreteDynamicsWorld& w, Hook h);
  ~Impl() override;

  void beforeTick(btScalar tick) override;
  void afterTick(btScalar tick) override;
  void tickMissed() override;
  void debugDraw(btIDebugDraw& drawer) override;
  void motionStatesRequested() override;

  void hookUp();
  void unhookIfIdle(bool alive);
  bool detach(SoftBody* softBody, std::uint32_t i);
  void forget(const btRigidBody& body);
  void dropSprings(const btRigidBody& body);
  void dropSpringsOfOthers();  ///< on points of this system
  bool worldAlive() const;
  void watchSteps();
  void clearForcesOnNewStep();
  void warnAboutRestored();
  void notifyListener();
  void hideManifolds();
  void destroyNow(SoftBody* body);
  void destroyPending();
  void endPairsOf(SoftBody* body);

  btDiscreteDynamicsWorld* world;
  Hook hookKind;
  TickHook* hook = nullptr;
  bool overwritten = false;
  std::function<void(const std::string&)> warn = warnOnStandardError;

  std::shared_ptr<WorldStep> step;
  std::vector<std::unique_ptr<SoftBody>> bodies;
  SpringList springs;
  SharedModels models;
  std::unique_ptr<StepBoundary> stepBoundary;  // while point masses outside the world are in the user's hands
  ContactEvents events;
  bool showsManifolds = false;
  std::vector<StrongestContacts> strongest;   // scratch of reportManifold
  std::vector<SoftBody*> pendingDestruction;  // to be destroyed once the listener has been told
};

/// The step of all systems of one world: their bodies touch each other, and Bullet's contacts are read and
/// reported once. The first system whose tick begins steps all.
struct SoftBodySystem::Impl::WorldStep {
  /// The one that the world's systems share.
  static std::shared_ptr<WorldStep> of(btDiscreteDynamicsWorld& world);

  void beforeTick(btScalar tick);
  void afterTick(btScalar tick);
  /// Groups hold pointers to bodies and springs: whoever removes one calls this first.
  void forgetGroups();
  /// Whether a system's listener is being called: bodies of all must then stay where they are.
  bool callsListeners() const;
  void rebuildGroupsIfNeeded();
  void gatherGroups(btScalar tick);
  void gatherPartners(SoftBodyData& body, btScalar tick);
  void gatherIslands(btScalar tick);
  void stepGroups(btScalar tick);
  void writeGroupsToBullet(btScalar tick);
  void updateLiving();
  /// Manifolds, motors and springs that Bullet's solver was to leave alone in a tick.
  void restoreBulletState();

  btDiscreteDynamicsWorld* world = nullptr;
  std::vector<Impl*> systems;     // in the order of their creation
  const Impl* stepped = nullptr;  // the system that has begun the present tick; nullptr between ticks
  std::vector<LinkedGroup> groups;
  StepPlan plan;
  KinematicMotions kinematic;
  MultiBodyLinks links;
  TickContacts pairs;  // contacts in which more than one body moves
  Islands islands;     // what they couple
  RigidManifolds manifolds;
  std::vector<DisabledDrives> disabledDrives;
  ShapeCache shapes;
  RigidSurfaces rigidSurfaces{shapes};
  SurfaceSearch search;
  std::vector<SoftBodyData*> living;       // the bodies in the groups
  std::vector<SpringConstraint*> springs;  // of all systems
  std::vector<unsigned char> usableLinks;  // see updateUsableLinks()
  bool groupsStale = true;
  std::vector<unsigned char> bulletIslands;  // scratch of updateSleep
  TickProfile profile;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
