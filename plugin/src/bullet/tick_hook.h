// SPDX-License-Identifier: Zlib

// These classes tell a system of the world's time: its ticks, the ends of its stepSimulation() calls, and its
// clock.

#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- ticks -------------------------------------------------------------------------------------------------

/// Somebody who wants to know of a world's ticks.
class TickListener {
 public:
  virtual ~TickListener() = default;
  virtual void beforeTick(btScalar tick) = 0;  ///< before Bullet predicts, collides and solves
  virtual void afterTick(btScalar tick) = 0;   ///< after Bullet has moved its bodies
  virtual void tickMissed() = 0;  ///< a tick has passed without beforeTick: the hook was overwritten
  virtual void debugDraw(btIDebugDraw& drawer) = 0;  ///< the world draws itself
};

/// The only class that touches a world's pre-tick callback.
///
/// A world has one slot for it and one user info pointer for both its callbacks. We take the slot, call
/// whoever was there first, and leave the user info alone, so we find our way from the world by a list of
/// hooks. As an action (of which a world may have many) the hook also learns of the end of each tick.
///
/// When a world is gone nobody tells us, so a hook whose world may be gone is not removed: it stays in the
/// list without listeners. If the world does live, its next tick calls the hook, which then leaves. A hook
/// that loses its last listener while it calls them leaves at the next tick's begin, too.
class TickHook final : public btActionInterface {
 public:
  /// Adds a listener to the world's hook, which is put in place if need be. `pretick` false leaves the slot
  /// alone: the listener learns of the ends of ticks only.
  static TickHook& listen(btDynamicsWorld& world, TickListener& listener, bool pretick);

  /// Stops telling a listener. With the last one the world is left as it was found; `worldAlive` says whether
  /// it can be touched at all.
  void leave(TickListener& listener, bool worldAlive);

  /// Whether the world's slot is still ours.
  bool inPlace() const;

  /// Takes the slot (again), calling first whoever holds it now.
  void takeSlot();

  void updateAction(btCollisionWorld* world, btScalar tick) override;
  void debugDraw(btIDebugDraw* drawer) override;

 private:
  explicit TickHook(btDynamicsWorld& world) : world_(&world) {}
  static void preTick(btDynamicsWorld* world, btScalar tick);
  void beforeTick(btScalar tick);
  void releaseSlot();
  bool hasListeners() const;
  void detach();
  void detachIfUnused();
  template <class Call>
  void callEach(const std::vector<TickListener*>& listeners, Call call);

  btDynamicsWorld* world_;
  btInternalTickCallback previous_ = nullptr;
  // nullptr: has left while they were being called
  std::vector<TickListener*> pretickListeners_;
  std::vector<TickListener*> actionListeners_;
  int calls_ = 0;  // that go on: listeners and callbacks may come, leave, and destroy each other meanwhile
  bool inTick_ = false;
  bool sawTick_ = false;
};

// --- steps -------------------------------------------------------------------------------------------------

/// Somebody who keeps forces of bodies that are outside the world as Bullet keeps those inside.
class StepListener {
 public:
  virtual ~StepListener() = default;
  /// Motion states are brought up to date: after each tick, user callbacks included; in a stepSimulation()
  /// that passes without any tick; or because the user asks for it between steps.
  virtual void motionStatesRequested() = 0;
};

/// Tells one stepSimulation() from the next. Bullet calls nobody at its begin or end, but it clears the
/// forces on all bodies at the end, and asks the motion states of those that are awake after every tick (and
/// once if there is none). So a body without shape or mass, which meets nothing, stays awake in the world
/// with a force on it: once that is gone, a step has ended.
///
/// The application may delete body and motion state as any other's; every tick then counts as a new step.
class StepBoundary {
 public:
  StepBoundary(btDiscreteDynamicsWorld& world, StepListener& listener);
  ~StepBoundary();
  StepBoundary(const StepBoundary&) = delete;
  StepBoundary& operator=(const StepBoundary&) = delete;

  /// Whether an object is the body of one.
  static bool isOne(const btCollisionObject* object);

  /// Whether a stepSimulation() has ended since the last call.
  bool stepHasEnded();

  /// Whether it is in the world, which therefore still exists: a world that is deleted takes the broadphase
  /// handle of every body in it.
  bool isInWorld() const;

 private:
  class Body;
  class State;

  btDiscreteDynamicsWorld* world_;
  StepListener* listener_;
  btEmptyShape shape_;
  Body* body_;
  State* state_;
};

// --- clock -------------------------------------------------------------------------------------------------

/// See SoftBodySystem::tickFraction().
double tickFraction(const btDiscreteDynamicsWorld& world);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
