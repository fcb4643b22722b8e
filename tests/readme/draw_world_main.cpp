// SPDX-License-Identifier: Zlib
// Runs the README's drawWorld() on a world with a soft and two rigid bodies and looks for all three in its
// picture.
#include "draw_world.cpp"

#include <limber/network_builder.h>

#include <cstdio>
#include <cstdlib>

namespace {

limber::TriangleMesh cubeMesh() {
  limber::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// How many pixels are clearly of the default colours of soft bodies and of rigid ones that move: reddish the
/// first, wood the second.
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
  auto network = limber::buildNetwork(cubeMesh());
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
