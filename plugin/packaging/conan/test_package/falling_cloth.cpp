// SPDX-License-Identifier: Zlib
#include <limber/limber.h>

#include <cstdio>

int main() {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  limber::SoftBodySystem soft(world);
  auto cloth = limber::buildCloth();
  if (!cloth) return std::puts(cloth.error().c_str()), 1;
  auto body = soft.createBody(*cloth, {});
  if (!body) return std::puts(body.error().c_str()), 1;
  for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1) / 60);
  return (*body)->centerOfMass().y() < -1.0 ? 0 : 1;
}
