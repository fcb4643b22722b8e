// SPDX-License-Identifier: Zlib
// Worlds other than btDiscreteDynamicsWorld.
#include "support/soft_world.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>

namespace limber::test {
namespace {

/// A soft cube on the floor with a box on it, and next to it a pile of boxes that only Bullet's solver steps.
struct Heap {
  SoftBody* cube;
  btRigidBody* box;
};

Heap addHeap(BulletWorld& bullet, SoftBodySystem& system) {
  bullet.addBoxFloor();
  SoftBodySettings s = settingsAt({0, 0.6, 0});
  s.pointRadius = 0.02;
  s.damping = 5.0;
  Heap heap{*system.createBody(closedCubeNetwork(), s), nullptr};
  heap.box = bullet.addBox(vec(0.6, 0.1, 0.6), 0.5, vec(0, 1.3, 0));
  for (int i = 0; i < 3; ++i) bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(3, 0.3 + 0.5 * i, 0));
  return heap;
}

TEST(WorldKinds, aMultiThreadedWorldDoesAsAPlainOne) {
  // the task scheduler that every build of Bullet has
  btSetTaskScheduler(btGetSequentialTaskScheduler());
  BulletWorld plain, threaded;
  btCollisionDispatcherMt dispatcher(&threaded.configuration);
  btConstraintSolverPoolMt pool(2);
  btSequentialImpulseConstraintSolverMt solver;
  threaded.world = std::make_unique<btDiscreteDynamicsWorldMt>(&dispatcher, &threaded.broadphase, &pool,
                                                               &solver, &threaded.configuration);
  threaded.world->setGravity(plain.world->getGravity());
  {
    SoftBodySystem plainSystem(*plain.world), threadedSystem(*threaded.world);
    const Heap expected = addHeap(plain, plainSystem), heap = addHeap(threaded, threadedSystem);
    plain.simulate(3.0);
    threaded.simulate(3.0);
    // the equilibrium does not depend on the solver's order of constraints
    EXPECT_NEAR(heap.cube->centerOfMass().y(), expected.cube->centerOfMass().y(), 1e-4);
    EXPECT_NEAR(heap.box->getCenterOfMassPosition().y(), expected.box->getCenterOfMassPosition().y(), 1e-4);
    EXPECT_GT(heap.box->getCenterOfMassPosition().y(), 1.0) << "the box lies on the cube";
  }
  for (const auto& body : threaded.bodies) threaded.world->removeRigidBody(body.get());
  threaded.bodies.clear();
  threaded.world.reset();
}

}  // namespace
}  // namespace limber::test
