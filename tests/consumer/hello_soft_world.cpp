// SPDX-License-Identifier: Zlib
// A program that used Bullet before it met Limber: its world is built and torn down in the manner of Bullet's
// HelloWorld, with a pre-tick callback and user info of its own. Everything that Limber asks for is in
// unitCube() and addSoftCube(). Exit status 0: both the old and the new part behave.
#include <limber/limber.h>

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <memory>

namespace {

// --- the soft part ---

// Corner i has bit 0 of i along x, bit 1 along y, bit 2 along z.
limber::TriangleMesh unitCube() {
  limber::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5);
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

limber::SoftBody* addSoftCube(limber::SoftBodySystem& soft) {
  limber::Result<limber::SharedNetwork> network = limber::buildNetwork(unitCube());
  if (!network) {
    std::fprintf(stderr, "network: %s\n", network.error().c_str());
    return nullptr;
  }
  limber::SoftBodySettings settings;
  settings.position = {2.0, 3.0, 0.0};
  settings.damping = 10.0;
  limber::Result<limber::SoftBody*> body = soft.createBody(*network, settings);
  if (!body) std::fprintf(stderr, "body: %s\n", body.error().c_str());
  return body ? *body : nullptr;
}

// --- the program as it was ---

struct Game {
  int ticks = 0;
};

void beforeTick(btDynamicsWorld* world, btScalar) { ++static_cast<Game*>(world->getWorldUserInfo())->ticks; }

btRigidBody* addBox(btDynamicsWorld* world, btCollisionShape* shape, btScalar mass,
                    const btVector3& position) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape->calculateLocalInertia(mass, inertia);
  btTransform start(btQuaternion::getIdentity(), position);
  auto* body = new btRigidBody(mass, new btDefaultMotionState(start), shape, inertia);
  world->addRigidBody(body);
  return body;
}

// Deletes whatever is in the world, soft points included: this program does not know whose they are.
void deleteAllObjects(btDynamicsWorld* world) {
  for (int i = world->getNumCollisionObjects() - 1; i >= 0; --i) {
    btCollisionObject* object = world->getCollisionObjectArray()[i];
    btRigidBody* body = btRigidBody::upcast(object);
    if (body && body->getMotionState()) delete body->getMotionState();
    world->removeCollisionObject(object);
    delete object;
  }
}

bool check(bool holds, const char* what) {
  std::printf("%-6s %s\n", holds ? "ok" : "FAILED", what);
  return holds;
}

}  // namespace

int main() {
  auto* configuration = new btDefaultCollisionConfiguration;
  auto* dispatcher = new btCollisionDispatcher(configuration);
  auto* broadphase = new btDbvtBroadphase;
  auto* solver = new btSequentialImpulseConstraintSolver;
  auto* world = new btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration);
  world->setGravity(btVector3(0, -10, 0));

  Game game;
  world->setInternalTickCallback(beforeTick, &game, true);

  auto* groundShape = new btBoxShape(btVector3(50, 1, 50));
  auto* crateShape = new btBoxShape(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
  addBox(world, groundShape, 0, btVector3(0, -1, 0));
  const btRigidBody* crate = addBox(world, crateShape, 1, btVector3(0, 3, 0));

  limber::SoftBodySystem soft(*world);
  const limber::SoftBody* cube = addSoftCube(soft);
  if (!cube) return 1;

  const int ticks = 240;  // 4 s
  for (int i = 0; i < ticks; ++i) world->stepSimulation(btScalar(1) / 60, 0, btScalar(1) / 60);

  const double crateHeight = crate->getWorldTransform().getOrigin().y();
  const double cubeHeight = cube->centerOfMass().y();
  std::printf("crate at %.3f m, soft cube at %.3f m\n", crateHeight, cubeHeight);
  bool good = check(std::abs(crateHeight - 0.5) < 0.05, "the crate lies on the ground");
  good &= check(std::abs(cubeHeight - 0.5) < 0.1, "the soft cube lies on the ground");
  good &= check(game.ticks == ticks, "the program's own callback came every tick");
  good &= check(world->getWorldUserInfo() == &game, "the program's user info is its own");

  deleteAllObjects(world);
  delete world;
  delete solver;
  delete broadphase;
  delete dispatcher;
  delete configuration;
  delete crateShape;
  delete groundShape;
  return good ? 0 : 1;
}  // the SoftBodySystem ends here, after the world it lived in
