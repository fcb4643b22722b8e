#include <limber/limber.h>

#include <cstdio>

int main() {
  // The world you already have.
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
  btRigidBody floor(0, nullptr, &plane);
  world.addRigidBody(&floor);

  // A soft body in it: mesh -> points and springs -> body.
  limber::SoftBodySystem soft(world);
  auto mesh = limber::importMesh("meshes/cube.obj");
  if (!mesh) return std::puts(mesh.error().c_str()), 1;
  auto network = limber::buildNetwork(*mesh);
  if (!network) return std::puts(network.error().c_str()), 1;
  limber::SoftBodySettings settings;
  settings.position = {0, 2, 0};      // m
  settings.extensionStiffness = 800;  // N/m of each spring
  settings.compressionStiffness = 800;
  settings.damping = 1;    // N s/m of each spring
  settings.totalMass = 1;  // kg
  auto body = soft.createBody(*network, settings);
  if (!body) return std::puts(body.error().c_str()), 1;

  // Step as ever; point masses are ordinary rigid bodies.
  (*body)->point(0)->applyCentralImpulse(btVector3(0.1f, 0, 0));
  for (int i = 0; i < 300; ++i) world.stepSimulation(1.f / 60.f);
  std::printf("centre at %.3f m\n", (*body)->centerOfMass().y());
}
