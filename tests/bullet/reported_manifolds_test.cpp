// SPDX-License-Identifier: Zlib
// Contacts of surfaces as manifolds in Bullet's dispatcher: correct, without effect on the simulation, and
// never with objects that have left the world.
#include "support/soft_world.h"

namespace limber::test {
namespace {

SoftBody* addReportedCube(SoftBodySystem& system, double height, double x = 0.0) {
  SoftBodySettings s = settingsAt({x, height, 0});
  setSprings(s, 2000, 5);
  s.pointRadius = kRadius;
  return *system.createBody(closedCubeNetwork(), s);
}

std::vector<btPersistentManifold*> manifoldsOf(BulletWorld& bullet, const btCollisionObject* object) {
  std::vector<btPersistentManifold*> found;
  for (int i = 0; i < bullet.dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold* m = bullet.dispatcher.getManifoldByIndexInternal(i);
    if (m->getBody0() == object || m->getBody1() == object) found.push_back(m);
  }
  return found;
}

TEST(ReportedManifolds, noneAreShownUnlessAskedFor) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  SoftBody* cube = addReportedCube(bullet.system, 0.5 + kRadius);
  bullet.simulate(0.5);
  EXPECT_FALSE(cube->contacts().empty());
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 0);
  bullet.system.reportManifolds(true);
  bullet.tick();
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 1);
  bullet.system.reportManifolds(false);
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 0);
}

TEST(ReportedManifolds, aManifoldBearsTheWeightAndLeadsBackToTheTriangle) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  bullet.system.reportManifolds(true);
  SoftBody* cube = addReportedCube(bullet.system, 0.5 + kRadius);
  cube->point(0)->setActivationState(DISABLE_DEACTIVATION);
  bullet.simulate(8.0);
  const auto manifolds = manifoldsOf(bullet, cube->surfaceObject());
  ASSERT_EQ(manifolds.size(), 1u);
  EXPECT_EQ(manifolds[0]->getBody1(), floor);
  ASSERT_EQ(manifolds[0]->getNumContacts(), 4);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    const SoftContact c = readContact(*manifolds[0], i);
    EXPECT_EQ(c.body, cube);
    EXPECT_EQ(c.other, floor);
    sum += c.normalImpulse;
    ASSERT_LT(c.side.triangle, cube->network().surface.size());
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      point += c.side.weights[static_cast<int>(k)] * cube->position(c.side.points[k]);
    // a corner of the cube, one radius above the floor; positions of 1 m in floats
    EXPECT_NEAR(c.side.weights.maxCoeff(), 1.0, 1e-5);
    EXPECT_NEAR(point.y() - double(c.position.y()), kRadius, 1e-5);
    EXPECT_NEAR(double(c.normal.y()), 1.0, 1e-6);
    EXPECT_NEAR(c.distance, 0.0, 1e-5);
    EXPECT_EQ(surfaceHit(cube->surfaceObject(), manifolds[0]->getContactPoint(i).m_index0, c.position).body,
              cube);
  }
  EXPECT_NEAR(sum, 9.81 * kTick, 1e-3 * 9.81 * kTick);
}

/// Returns the states of a mixed scene. It includes rigid bodies that only Bullet's solver steps.
std::vector<double> run(bool report, int ticks) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  bullet.system.reportManifolds(report);
  SoftBody* cubes[] = {addReportedCube(bullet.system, 0.6), addReportedCube(bullet.system, 1.7),
                       addReportedCube(bullet.system, 0.7, 3.0)};
  std::vector<btRigidBody*> boxes;
  for (int i = 0; i < 6; ++i)
    boxes.push_back(
        bullet.addBox(vec(0.2, 0.2, 0.2), 0.5, vec(i < 3 ? 0.1 * i : 6.0, 3.0 + 0.45 * i, 0.05 * i)));
  std::vector<double> states;
  for (int t = 0; t < ticks; ++t) {
    bullet.tick();
    for (const SoftBody* cube : cubes) states.push_back(static_cast<double>(cube->stateHash() >> 11));
    for (const btRigidBody* box : boxes)
      for (int axis = 0; axis < 3; ++axis)
        states.push_back(double(box->getWorldTransform().getOrigin()[axis]));
  }
  return states;
}

TEST(ReportedManifolds, changeNothing) { EXPECT_EQ(run(false, 600), run(true, 600)); }

TEST(ReportedManifolds, twoSoftBodiesShareAManifold) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  bullet.system.reportManifolds(true);
  SoftBody* lower = addReportedCube(bullet.system, 0.5 + kRadius);
  SoftBody* upper = addReportedCube(bullet.system, 1.5 + 3 * kRadius);
  bullet.simulate(1.0);
  const auto manifolds = manifoldsOf(bullet, upper->surfaceObject());
  ASSERT_EQ(manifolds.size(), 1u);
  const SoftContact c = readContact(*manifolds[0], 0);
  EXPECT_EQ(c.body, lower);
  EXPECT_EQ(c.otherBody, upper);
  EXPECT_LT(c.otherSide.triangle, upper->network().surface.size());
  EXPECT_NEAR(c.otherSide.weights.sum(), 1.0, 1e-9);
}

int contactsEnded;
void countEnd(btPersistentManifold* const&) { ++contactsEnded; }

TEST(ReportedManifolds, BulletsCallbacksAreNotCalled) {
  SoftWorld bullet;
  bullet.addBoxFloor();
  bullet.system.reportManifolds(true);
  addReportedCube(bullet.system, 0.5 + kRadius);
  contactsEnded = 0;
  gContactEndedCallback = countEnd;
  bullet.simulate(0.5);
  bullet.system.removeAll();
  gContactEndedCallback = nullptr;
  EXPECT_EQ(contactsEnded, 0);
}

TEST(ReportedManifolds, noManifoldNamesWhatHasLeftTheWorld) {
  SoftWorld bullet;
  btRigidBody* floor = bullet.addBoxFloor();
  bullet.system.reportManifolds(true);
  SoftBody* cube = addReportedCube(bullet.system, 0.5 + kRadius);
  SoftBody* second = addReportedCube(bullet.system, 0.5 + kRadius, 3.0);
  bullet.simulate(0.5);
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 2);
  bullet.system.destroyBody(second);
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 1);
  bullet.world->removeRigidBody(floor);
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 0);
  delete bullet.bodies.back().release();
  bullet.bodies.pop_back();
  bullet.simulate(0.1);
  EXPECT_LT(cube->centerOfMass().y(), 0.52);
  EXPECT_EQ(bullet.dispatcher.getNumManifolds(), 0);
}

TEST(ReportedManifolds, worldSystemAndBodiesGoInAnyOrder) {
  for (int order = 0; order < 4; ++order) {
    auto bullet = std::make_unique<BulletWorld>();
    bullet->addBoxFloor();
    auto system = std::make_unique<SoftBodySystem>(*bullet->world);
    system->reportManifolds(true);
    SoftBody* cube = addReportedCube(*system, 0.5 + kRadius);
    addReportedCube(*system, 1.5 + 3 * kRadius);
    bullet->simulate(0.5);
    EXPECT_GE(bullet->dispatcher.getNumManifolds(), 2);
    if (order == 0) bullet.reset();
    if (order == 1) system.reset();
    if (order == 2) {
      btRigidBody* object = cube->surfaceObject();
      bullet->world->removeCollisionObject(object);
      delete object;
      bullet->tick();
    }
    if (order == 3) system->removeAll();
    if (bullet) bullet->tick();
    system.reset();
    if (bullet) {
      EXPECT_EQ(bullet->dispatcher.getNumManifolds(), 0);
    }
  }
}

}  // namespace
}  // namespace limber::test
