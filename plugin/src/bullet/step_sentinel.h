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
  /// A tick is over, user callbacks included; or a stepSimulation() passes without any tick.
  virtual void afterTickOrEmptyStep() = 0;
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
  /// Does not touch the world: call leave() first if that still exists.
  ~StepSentinel();
  StepSentinel(const StepSentinel&) = delete;
  StepSentinel& operator=(const StepSentinel&) = delete;

  /// In the pre-tick: whether this is the first tick of its stepSimulation().
  bool stepHasBegun();

  /// Takes the body out of the world, which still exists.
  void leave();

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
