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

  // A soft body in it: mesh -> points and springs -> material -> body.
  limber::SoftBodySystem soft(world);
  auto mesh = limber::importMesh("meshes/teapot.obj");
  if (!mesh) return std::puts(mesh.error().c_str()), 1;
  auto cooked = limber::cook(*mesh);
  if (!cooked) return std::puts(cooked.error().c_str()), 1;
  limber::SoftBodySettings settings;
  settings.position = {0, 2, 0};  // m
  auto rubber = limber::withMaterial(*cooked->bodies[0], limber::Material::rubber(), settings);
  if (!rubber) return std::puts(rubber.error().c_str()), 1;
  auto body = soft.createBody(cooked->bodies[0], *rubber);
  if (!body) return std::puts(body.error().c_str()), 1;

  // Step as ever; point masses are ordinary rigid bodies.
  (*body)->point(0)->applyCentralImpulse(btVector3(0.1f, 0, 0));
  for (int i = 0; i < 300; ++i) world.stepSimulation(1.f / 60.f);
  std::printf("centre at %.3f m\n", (*body)->centerOfMass().y());
}
