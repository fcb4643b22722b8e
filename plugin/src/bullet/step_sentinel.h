// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Somebody who keeps forces of bodies that are outside the world as Bullet keeps those inside.
class StepListener {
 public:
  virtual ~StepListener() = default;
  /// Motion states are brought up to date: after each tick, user callbacks included; in a stepSimulation()
  /// that passes without any tick; or because the user asks for it between steps.
  virtual void motionStatesAsked() = 0;
};

/// Tells one stepSimulation() from the next. Bullet calls nobody at its begin or end, but it clears the
/// forces on all bodies at the end, and asks the motion states of those that are awake after every tick (and
/// once if there is none). So a body without shape or mass, which meets nothing, stays awake in the world
/// with a force on it: once that is gone, a step has ended.
///
/// The application may delete body and motion state as any other's; every tick then counts as a new step.
class StepSentinel {
 public:
  StepSentinel(btDiscreteDynamicsWorld& world, StepListener& listener);
  ~StepSentinel();
  StepSentinel(const StepSentinel&) = delete;
  StepSentinel& operator=(const StepSentinel&) = delete;

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

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
