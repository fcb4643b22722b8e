// SPDX-License-Identifier: Zlib

// This header declares the data of a system, and the step that all systems of a world share.

#pragma once

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "bullet/linked_group.h"
#include "bullet/tick_hook.h"

#include <algorithm>
#include <functional>
#include <string>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Default output of SoftBodySystem's warnings.
void warnOnStandardError(const std::string& text);

/// Returns whether a place in a body's coordinates may be the end of a spring or anchor.
bool isValidPivot(const btVector3& place);

/// Returns the entry of a list that owns the object, or the list's end.
template <class Owners, class Object>
auto findOwner(Owners& owners, const Object* object) {
  return std::find_if(owners.begin(), owners.end(), [&](const auto& owner) { return owner.get() == object; });
}

/// The implementation of SoftBodySystem. The user's functions are in soft_body_system.cpp, the tick is in
/// tick.cpp.
struct LIMBER_HIDDEN SoftBodySystem::Impl final : TickListener {
  struct WorldStep;

  Impl(btDiscreteDynamicsWorld& w, Hook h);
  ~Impl() override;

  void beforeTick(btScalar tick) override;
  void afterTick(btScalar tick) override;
  void tickMissed() override;
  void debugDraw(btIDebugDraw& drawer) override;

  void hookUp();
  void unhookIfIdle(bool alive);
  /// The errors of attach().
  Result<void> checkAttachment(const SoftBody* softBody, const Anchor& anchor) const;
  /// Adds anchors to one rigid body, or none of them.
  Result<void> attach(SoftBody* softBody, std::vector<Anchor> anchors);
  bool detach(SoftBody* softBody, std::uint32_t i);
  void forget(const btRigidBody& body);
  void dropSprings(const btRigidBody& body);
  void wakeEnds(const SpringConstraint& spring, const btRigidBody* butNot) const;
  void freeEnds(const SpringConstraint& spring) const;  ///< notes that it no longer holds soft bodies
  SoftBody* ownerOf(const btRigidBody& point) const;
  bool worldAlive() const;
  void watchSteps();
  void clearForcesOnNewStep();
  void collectAppliedForces();
  void warnAboutRestored();
  void notifyListener();
  void hideManifolds();
  void destroyNow(SoftBody* body);
  bool owns(const SoftBody* body) const;
  void wakeAll();
  std::vector<SpringConstraint*> savedSprings() const;  // without those of grabs
  void dropFields(const SoftBodyData& body);
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
  std::unique_ptr<StepBoundary> stepBoundary;  // exists while users access point masses outside the world
  ContactEvents events;
  ContactFilter filter;
  Surroundings surroundings;
  bool showsManifolds = false;
  std::vector<const SoftContact*> strongest;  // scratch of reportManifold
};

/// The step of all systems of one world. Their bodies touch each other, and Bullet's contacts are read and
/// reported once. The first system whose tick begins steps all of them.
struct LIMBER_HIDDEN SoftBodySystem::Impl::WorldStep {
  /// Returns the step that the world's systems share.
  static std::shared_ptr<WorldStep> of(btDiscreteDynamicsWorld& world);

  void beforeTick(btScalar tick);
  void afterTick(btScalar tick);
  /// Removes the groups. They point to bodies and springs, so call this before one of those is removed.
  void forgetGroups();
  /// Returns whether a system's listener is being called: no body of any system may then be destroyed.
  bool callsListeners() const;
  bool owns(const SoftBody* body) const;  ///< whether the body belongs to one of the systems
  void rebuildGroupsIfNeeded();
  void findAwake(btScalar tick);
  void read(btScalar tick);
  void collide(btScalar tick);
  void filterContacts();
  void keepBudgets(btScalar tick);
  void findIslands(btScalar tick);
  void choose(btScalar tick);
  void step(btScalar tick);
  void write(btScalar tick);
  void updateLiving();
  void updateBoxesAfterRollback();
  void takeLink(SpringConstraint& spring, const LinkSpring& link);
  void takeAnchors(LinkedGroup& group, double tick);
  /// Tears and cuts bodies.
  void divideBodies();
  /// Restores the manifolds, motors and springs that were hidden from Bullet's solver in a tick.
  void restoreBulletState();
  void addPending(SoftBody* body);
  void destroyPending();

  btDiscreteDynamicsWorld* world = nullptr;
  std::vector<Impl*> systems;     // in the order of their creation
  const Impl* stepped = nullptr;  // the system that has begun the present tick; nullptr between ticks
  std::vector<LinkedGroup> groups;
  AwakeGroups awake;  // in this tick
  Parallel parallel;  // runs the stages that it is passed to, or that say so
  std::mutex lock;    // SoftBodyData::worldLock
  LoneGroups lone;
  MovingObjects objects;
  KinematicMotions kinematic;
  MultiBodyLinks links;
  TickContacts pairs;  // contacts in which more than one body moves
  Islands islands;     // sets of bodies that `pairs` couple
  RigidManifolds manifolds;
  std::vector<DisabledDrives> disabledDrives;
  ShapeCache shapes;
  RigidSurfaces rigidSurfaces{shapes};
  ScratchPool<SurfaceSearch> searches;
  HeldPairs heldPairs;
  std::vector<std::uint32_t> newIndex;        // scratch of filterPairs()
  std::vector<SoftBodyData*> living;          // the bodies in the groups
  std::vector<SoftBodyData*> absent;          // the application has removed them, and may put them back
  std::vector<SoftBodyData*> moving;          // those of the awake groups
  std::vector<SoftBody*> pendingDestruction;  // of all systems, destroyed after the listener's call
  std::vector<SpringConstraint*> springs;     // of all systems
  std::vector<Handle<SpringConstraint>> brokenSprings;  // in the last tick
  std::vector<unsigned char> usableLinks;               // see updateUsableLinks()
  bool groupsStale = true;
  bool mayDivide = true;     // a body may tear, or was cut at the start of the last tick
  bool inTick = false;       // from the time when bodies are read to the end of the tick
  bool anyRestored = false;  // a body was restored in this tick
  SleepScratch sleepScratch;
  TickProfile profile;
};

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
