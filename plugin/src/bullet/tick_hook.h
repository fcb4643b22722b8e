// SPDX-License-Identifier: Zlib

// These classes inform a system of the ticks of a world, the end of its stepSimulation() calls, and its
// clock.

#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Adds 1 during its lifetime, also if a user's callback throws.
class During {
 public:
  explicit During(int& count) : count_(count) { ++count_; }
  ~During() { --count_; }
  During(const During&) = delete;
  During& operator=(const During&) = delete;

 private:
  int& count_;
};

// --- ticks -------------------------------------------------------------------------------------------------

/// A listener for a world's ticks.
class TickListener {
 public:
  virtual ~TickListener() = default;
  virtual void beforeTick(btScalar tick) = 0;  ///< before Bullet predicts, collides and solves
  virtual void afterTick(btScalar tick) = 0;   ///< after Bullet has moved its bodies
  virtual void tickMissed() = 0;               ///< a tick passed without beforeTick: the hook was overwritten
  virtual void debugDraw(btIDebugDraw& drawer) = 0;  ///< the world draws itself
};

/// The only class that uses a world's pre-tick callback.
///
/// A world has one slot for it, and one user info pointer for both its callbacks. The hook takes the slot,
/// calls the previous callback, and does not change the user info. A list of all hooks maps a world to its
/// hook. The hook is also an action, of which a world may have many, to be called at the end of each tick.
///
/// Nothing reports the end of a world. A hook whose world may be gone is not removed: it stays in the list
/// without listeners. If the world still exists, its next tick calls the hook, which then removes itself. A
/// hook that loses its last listener while it calls listeners also removes itself at the start of the next
/// tick.
class TickHook final : public btActionInterface {
 public:
  /// Adds a listener to the world's hook, which is installed if necessary. If `pretick` is false the slot is
  /// not used: the listener is called only at the end of ticks. `known`: the world is that of the earlier
  /// listeners, and not one at the address of their deleted world.
  static TickHook& listen(btDynamicsWorld& world, TickListener& listener, bool pretick, bool known);

  /// Removes a listener. Removal of the last one restores the world. `worldAlive` is whether the world may be
  /// accessed.
  void leave(TickListener& listener, bool worldAlive);

  /// Returns whether the world's slot still contains this hook.
  bool inPlace() const;

  /// Takes the slot (again), and calls its previous callback first in each tick.
  void takeSlot();

  void updateAction(btCollisionWorld* world, btScalar tick) override;
  void debugDraw(btIDebugDraw* drawer) override;

 private:
  explicit TickHook(btDynamicsWorld& world) : world_(&world) {}
  static void preTick(btDynamicsWorld* world, btScalar tick);
  void beforeTick(btScalar tick);
  void detachIfUnused();
  template <class Call>
  void callEach(Call call);

  struct Entry {
    TickListener* listener;  ///< nullptr: was removed during the calls
    bool pretick;            ///< is called before ticks, too
  };

  btDynamicsWorld* world_;
  btInternalTickCallback previous_ = nullptr;
  std::vector<Entry> listeners_;
  int calls_ = 0;  // active ones: during them, listeners and callbacks may be added and removed, and destroy
                   // each other
  int ticks_ = 0;  // active ones, 0 or 1
  bool sawTick_ = false;
};

// --- steps -------------------------------------------------------------------------------------------------

/// Detects the end of a stepSimulation(). Bullet has no callback at its start or end. It clears the forces on
/// all bodies at the end, and updates the motion states of those that are awake after every tick (or once if
/// there is none). So a body without shape, mass or collisions stays awake in the world with a force on it:
/// when the force is gone, a step has ended.
///
/// The application may delete the body and its motion state; every tick then counts as a new step.
class StepBoundary {
 public:
  /// Calls motionStatesRequested() when motion states are updated: after each tick, with user callbacks; in a
  /// stepSimulation() without any tick; or when the user synchronises them between steps.
  StepBoundary(btDiscreteDynamicsWorld& world, std::function<void()> motionStatesRequested);
  ~StepBoundary();
  StepBoundary(const StepBoundary&) = delete;
  StepBoundary& operator=(const StepBoundary&) = delete;

  /// Returns whether an object is the body of a StepBoundary.
  static bool isOne(const btCollisionObject* object);

  /// Returns whether a stepSimulation() has ended since the last call.
  bool stepHasEnded();

  /// Returns whether the body is in the world, which therefore still exists: the destructor of a world
  /// removes the broadphase handle of every body.
  bool isInWorld() const;

 private:
  struct Body;
  struct State;

  btDiscreteDynamicsWorld* world_;
  std::function<void()> motionStatesRequested_;
  btEmptyShape shape_;
  Body* body_;
  State* state_;
};

// --- clock -------------------------------------------------------------------------------------------------

/// See SoftBodySystem::tickFraction().
double tickFraction(const btDiscreteDynamicsWorld& world);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
