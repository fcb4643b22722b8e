// SPDX-License-Identifier: Zlib
// Runs drawWorld() of render/README.md on a world with a soft and two rigid bodies and looks for all three in
// its picture.
#include "draw_world.cpp"

#include <limber/network_builder.h>

#include <cstdio>
#include <cstdlib>

namespace {

/// How many pixels are of the default colours of soft bodies and of rigid ones that move: both have more red
/// than blue.
int countReddish(const limber::render::Image& image) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) count += image.rgba[i] > image.rgba[i + 2] + 40;
  return count;
}

}  // namespace

int main() {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
  btRigidBody floor(0, nullptr, &plane);
  world.addRigidBody(&floor);
  btSphereShape ball(0.4f);
  btRigidBody rigid(1, nullptr, &ball, btVector3(0.1f, 0.1f, 0.1f));
  rigid.getWorldTransform().setOrigin(btVector3(1.2f, 0.5f, 0));
  world.addRigidBody(&rigid);

  limber::SoftBodySystem soft(world);
  auto network = limber::buildCloth();
  limber::SoftBodySettings settings;
  settings.position = {0, 1, 0};
  if (!network || !soft.createBody(*network, settings)) return EXIT_FAILURE;
  drawWorld(world, soft);

  const int pixels = countReddish(limber::render::readPng("world.png"));
  std::printf("%d pixels of bodies\n", pixels);
  world.removeRigidBody(&rigid);
  world.removeRigidBody(&floor);
  return pixels > 10000 ? EXIT_SUCCESS : EXIT_FAILURE;
}
