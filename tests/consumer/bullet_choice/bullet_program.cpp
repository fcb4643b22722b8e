// SPDX-License-Identifier: Zlib
// Drops a sphere with whichever Bullet was chosen, to see that headers and libraries fit together.
#include <btBulletDynamicsCommon.h>

int main() {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btSphereShape sphere(1);
  btRigidBody body(1, nullptr, &sphere, btVector3(1, 1, 1));
  world.addRigidBody(&body);
  for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1) / 60, 0);
  const btScalar height = body.getWorldTransform().getOrigin().y();
  world.removeRigidBody(&body);
  return height < btScalar(-4) && height > btScalar(-6) ? 0 : 1;
}
