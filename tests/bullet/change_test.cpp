// SPDX-License-Identifier: Zlib
// Settings, place and motion of a body change while it lives. What does not change keeps its energy.
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace limber::test {
namespace {

/// Relative tolerance of what Bullet's floats hold: positions, velocities and masses have 24 bits.
constexpr double kFloat = 1e-5;

struct World : SoftWorld {
  explicit World(double gravity = 0.0, SoftBodySettings s = testedSettings(),
                 const SharedNetwork& network = closedCubeNetwork())
      : SoftWorld(gravity) {
    s.damping = 0.0;
    body = addSoft(network, s);
  }
  void change(const std::function<void(SoftBodySettings&)>& edit) {
    SoftBodySettings s = body->settings();
    edit(s);
    const Result<void> changed = body->change(s);
    EXPECT_TRUE(changed) << changed.error();
  }
  double energy() const { return body->kineticEnergy() + body->elasticEnergy(); }

  SoftBody* body;
};

/// A cube that spins and oscillates.
World& stirred(World& world) {
  EXPECT_TRUE(world.body->setVelocity(vec(1, 2, 3), vec(1, -2, 0.5)));
  EXPECT_TRUE(world.body->applyImpulse(vec(0.3, 0.1, 0), 0u));
  world.simulate(0.3);
  return world;
}

// --- settings ----------------------------------------------------------------------------------------------

TEST(Change, theSameSettingsChangeNothing) {
  World changed, plain;
  stirred(changed);
  stirred(plain);
  changed.change([](SoftBodySettings&) {});
  EXPECT_EQ(changed.body->stateHash(), plain.body->stateHash());
  EXPECT_DOUBLE_EQ(changed.energy(), plain.energy());
}

TEST(Change, aStiffnessActsAtThePresentStrains) {
  SoftBodySettings s = testedSettings();
  s.volumeModulus = 0.0;
  World world(0.0, s);
  stirred(world);
  const double elastic = world.body->elasticEnergy(), kinetic = world.body->kineticEnergy();
  const Eigen::Vector3d momentum = world.body->linearMomentum(), spin = world.body->angularMomentum();
  world.change([](SoftBodySettings& t) { t.extensionStiffness = t.compressionStiffness = 3000.0; });
  EXPECT_NEAR(world.body->elasticEnergy(), 3.0 * elastic, 1e-12);
  EXPECT_NEAR(world.body->kineticEnergy(), kinetic, 1e-12);
  const double energy = world.energy();
  world.simulate(2.0);
  // Verlet at the default tolerance keeps the energy to a thousandth
  EXPECT_NEAR(world.energy(), energy, 3e-3 * energy);
  EXPECT_LT((world.body->linearMomentum() - momentum).norm(), kFloat);
  EXPECT_LT((world.body->angularMomentum() - spin).norm(), kFloat);
}

TEST(Change, aChangedBodyMovesLikeOneMadeSo) {
  const auto edit = [](SoftBodySettings& s) {
    s.extensionStiffness = 400.0;
    s.compressionStiffness = 700.0;
    s.damping = 2.0;
    s.volumeModulus = 500.0;
    s.pressure = 10.0;
    s.totalMass = 3.0;
    s.friction = 0.9;
    s.restitution = 0.7;
    s.pointRadius = 0.03;
    s.stepping.minSubsteps = 17;
  };
  SoftBodySettings made = settingsAt({0, 0.8, 0});
  made.damping = 0.0;
  World changed(-9.81, made);
  changed.addBoxFloor();
  changed.change(edit);
  edit(made);
  SoftWorld bullet(-9.81);
  SoftBody* body = bullet.addSoft(closedCubeNetwork(), made);
  bullet.addBoxFloor();
  for (int i = 0; i < 60; ++i) {
    bullet.tick();
    changed.tick();
    ASSERT_EQ(changed.body->stateHash(), body->stateHash()) << "tick " << i;
  }
}

TEST(Change, massKeepsVelocitiesAndScalesMomentum) {
  World world;
  stirred(world);
  const Eigen::Vector3d momentum = world.body->linearMomentum();
  world.change([](SoftBodySettings& s) { s.totalMass = 4.0; });
  EXPECT_NEAR(world.body->totalMass(), 4.0, 4.0 * kFloat);
  EXPECT_LT((world.body->linearMomentum() - 4.0 * momentum).norm(), 4.0 * kFloat * momentum.norm());
  EXPECT_TRUE(world.body->pin(0));
  world.change([](SoftBodySettings& s) { s.totalMass = 8.0; });
  EXPECT_NEAR(world.body->totalMass(), 7.0, 7.0 * kFloat);
  EXPECT_TRUE(world.body->unpin(0));
  EXPECT_NEAR(world.body->totalMass(), 8.0, 8.0 * kFloat);
}

TEST(Change, scaleKeepsCentreAndStrains) {
  SoftBodySettings s = settingsAt({5, 6, 7});
  s.volumeModulus = 0.0;
  World world(0.0, s);
  world.body->setVelocity(vec(0, 0, 0), vec(0, 3, 0));
  world.simulate(0.4);
  const Eigen::Vector3d center = world.body->centerOfMass();
  const double energy = world.body->elasticEnergy();
  world.change([](SoftBodySettings& t) { t.scale = Eigen::Vector3d::Constant(2.0); });
  EXPECT_LT((world.body->centerOfMass() - center).norm(), 10.0 * kFloat);
  // equal strains of springs twice as long; in Bullet's floats
  EXPECT_NEAR(world.body->elasticEnergy(), 4.0 * energy, 1e-3 * energy + 1e-4);
}

TEST(Change, aRotatedBodyIsScaledAlongItsOwnAxes) {
  World world;
  const btTransform turned(btQuaternion(btVector3(0, 0, 1), SIMD_HALF_PI), vec(1, 2, 3));
  ASSERT_TRUE(world.body->setTransform(turned));
  world.change([](SoftBodySettings& s) { s.scale = {3.0, 1.0, 1.0}; });
  btVector3 low = vec(1e9, 1e9, 1e9), high = -low;
  for (std::uint32_t i = 0; i < world.body->pointCount(); ++i) {
    const Eigen::Vector3d p = world.body->position(i);
    low.setMin(vec(p.x(), p.y(), p.z()));
    high.setMax(vec(p.x(), p.y(), p.z()));
  }
  EXPECT_NEAR(double(high.x() - low.x()), 1.0, 1e-4);
  EXPECT_NEAR(double(high.y() - low.y()), 3.0, 1e-4);
  EXPECT_LT(world.body->elasticEnergy(), 1e-3);
}

TEST(Change, friction) {
  World world(-9.81);
  btRigidBody* floor = world.addBoxFloor();
  floor->setFriction(1.0);
  world.body->setTransform(btTransform(btQuaternion::getIdentity(), vec(0, 0.53, 0)));
  world.change([](SoftBodySettings& s) { s.friction = 0.0, s.damping = 5.0; });
  world.simulate(1.0);
  world.body->setVelocity(vec(2, 0, 0));
  world.simulate(1.0);
  EXPECT_NEAR(world.body->linearMomentum().x(), 2.0, 0.02) << "slides without friction";
  world.change([](SoftBodySettings& s) { s.friction = 0.8; });
  world.simulate(1.0);
  EXPECT_NEAR(world.body->linearMomentum().x(), 0.0, 0.02) << "stops with it";
}

TEST(Change, radiusAndSleep) {
  World world(-9.81);
  world.addBoxFloor()->setRestitution(btScalar(1));
  world.change([](SoftBodySettings& s) { s.damping = 5.0, s.pointRadius = 0.02, s.sleepingSpeed = 0.0; });
  ASSERT_TRUE(world.body->reset(btTransform(btQuaternion::getIdentity(), vec(0, 0.55, 0))));
  world.simulate(4.0);
  EXPECT_NEAR(lowest(*world.body), 0.02, 1e-3) << "rests a radius above the floor";
  EXPECT_FALSE(world.body->sleeping()) << "0: never";
  world.change([](SoftBodySettings& s) { s.pointRadius = 0.05; });
  world.simulate(4.0);
  EXPECT_NEAR(lowest(*world.body), 0.05, 1e-3);
  world.change([](SoftBodySettings& s) { s.sleepingSpeed = 0.1; });
  world.simulate(4.0);
  EXPECT_TRUE(world.body->sleeping());
  world.change([](SoftBodySettings& s) { s.friction = 0.1; });
  EXPECT_FALSE(world.body->sleeping()) << "a change wakes";
}

TEST(Change, filters) {
  World world(-9.81);
  world.addBoxFloor();
  world.body->setTransform(btTransform(btQuaternion::getIdentity(), vec(0, 0.6, 0)));
  world.simulate(0.5);
  EXPECT_GT(world.body->centerOfMass().y(), 0.3);
  world.change([](SoftBodySettings& s) { s.collisionMask = 0; });
  world.simulate(0.5);
  EXPECT_LT(world.body->centerOfMass().y(), -0.5) << "falls through what it no longer collides with";
}

TEST(Change, gravityFactor) {
  for (const double factor : {0.0, -0.5, 0.25}) {
    SoftBodySettings s = testedSettings();
    s.gravityFactor = factor;
    World made(-10.0, s), changed(-10.0);
    changed.change([&](SoftBodySettings& t) { t.gravityFactor = factor; });
    for (int i = 0; i < 60; ++i) made.tick(), changed.tick();
    for (World* world : {&made, &changed})
      EXPECT_NEAR(world->body->linearMomentum().y(), -10.0 * factor, 1e-3) << factor;
    changed.change([](SoftBodySettings& t) { t.gravityFactor = 1.0; });
    const double before = changed.body->linearMomentum().y();
    for (int i = 0; i < 60; ++i) changed.tick();
    EXPECT_NEAR(changed.body->linearMomentum().y(), before - 10.0, 1e-3) << factor;
  }
}

TEST(Change, whatYieldedStaysYielded) {
  SoftBodySettings s = testedSettings();
  s.elasticLimit.yieldStrain = 0.02;
  World world(0.0, s, pairNetwork());
  world.body->pin(0);
  world.body->pin(1);
  world.body->movePin(1, vec(1.2, 0, 0));
  world.simulate(0.1);
  world.body->unpin(1);
  const double energy = world.body->elasticEnergy();
  world.change([](SoftBodySettings& t) { t.extensionStiffness = t.compressionStiffness = 500.0; });
  EXPECT_NEAR(world.body->elasticEnergy(), 0.5 * energy, 1e-6 * energy);
  world.change([](SoftBodySettings& t) { t.damping = 5.0; });
  world.simulate(5.0);
  // a spring that was stretched by 20 % and yields beyond 2 % is 18 % longer at rest
  EXPECT_NEAR((world.body->position(1) - world.body->position(0)).norm(), 1.18, 1e-3);
  ASSERT_TRUE(world.body->reset());
  world.simulate(5.0);
  EXPECT_NEAR((world.body->position(1) - world.body->position(0)).norm(), 1.0, 1e-3);
}

TEST(PresentNetwork, aDentIsTheRestShapeOfAnotherBody) {
  SoftBodySettings s = testedSettings();
  s.elasticLimit.yieldStrain = 0.02;
  s.damping = 5.0;
  s.scale = {1.0, 2.0, 0.5};
  s.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  World world(0.0, s);
  for (std::uint32_t i = 0; i < world.body->pointCount(); ++i) world.body->pin(i);
  world.body->movePin(0, world.body->point(0)->getWorldTransform().getOrigin() + vec(0.2, 0.2, 0.2));
  world.simulate(0.5);
  for (std::uint32_t i = 0; i < world.body->pointCount(); ++i) world.body->unpin(i);
  world.simulate(5.0);
  const auto dented = world.body->presentNetwork();
  ASSERT_TRUE(dented) << dented.error();
  const double change = ((*dented)->restPoints[0] - (*dented)->restPoints[1]).norm() -
                        (world.body->network().restPoints[0] - world.body->network().restPoints[1]).norm();
  EXPECT_GT(std::abs(change), 0.01);
  SoftBody* other = *world.system.createBody(*fromBytes(toBytes(**dented).data(), toBytes(**dented).size()),
                                             world.body->settings());
  ASSERT_TRUE(other->reset(world.body->transform()));
  EXPECT_LT(other->elasticEnergy(), 1e-6);
  for (std::uint32_t i = 0; i < other->pointCount(); ++i)
    EXPECT_LT((other->position(i) - world.body->position(i)).norm(), 1e-4) << i;
}

TEST(PresentNetwork, brokenSpringsAreMissing) {
  SoftBodySettings s = testedSettings();
  s.elasticLimit.breakStrain = 0.1;
  World world(0.0, s, *withGroup(*closedCubeNetwork(), "all", {0, 1, 2, 3, 4, 5, 6, 7}));
  world.body->pin(0);
  world.body->pin(1);
  world.body->movePin(1, world.body->point(1)->getWorldTransform().getOrigin() + vec(0.5, 0.5, 0.5));
  world.simulate(0.2);
  const auto present = world.body->presentNetwork();
  ASSERT_TRUE(present) << present.error();
  const std::size_t left = (*present)->springs.size();
  EXPECT_LT(left, world.body->network().springs.size());
  ASSERT_EQ((*present)->groups[0].springs.size(), left);
  for (std::uint32_t i = 0; i < left; ++i) EXPECT_EQ((*present)->groups[0].springs[i], i);
}

TEST(Change, errorsChangeNothing) {
  World world;
  const auto errorOf = [&](const std::function<void(SoftBodySettings&)>& edit) {
    SoftBodySettings s = world.body->settings();
    edit(s);
    return world.body->change(s).error();
  };
  EXPECT_EQ(errorOf([](SoftBodySettings& s) { s.totalMass = -1.0; }),
            "settings: totalMass is -1, must be from 1e-9 to 1e12");
  EXPECT_EQ(errorOf([](SoftBodySettings& s) { s.scale.x() = -1.0; }),
            "settings: scale.x cannot change its sign while the body lives");
  EXPECT_EQ(errorOf([](SoftBodySettings& s) {
              s.collision = s.collision == Collision::Surface ? Collision::Points : Collision::Surface;
            }),
            "settings: collision cannot change while the body lives");
  EXPECT_EQ(errorOf([](SoftBodySettings& s) { s.groups.push_back({"arms"}); }),
            "groups[0].name is arms, but the network has no groups");
  EXPECT_EQ(errorOf([](SoftBodySettings& s) { s.scale.setConstant(1e8); }),
            "settings: point 0 would have a coordinate of 5e+07 m, must be at most 2e6");
  EXPECT_DOUBLE_EQ(world.body->settings().totalMass, 1.0);
  EXPECT_DOUBLE_EQ(world.body->settings().scale.x(), 1.0);
  EXPECT_TRUE(world.body->settings().groups.empty());
}

/// In the tick after the application has removed an object, and before it.
TEST(Change, bodiesThatAreNotAliveRefuseAllChanges) {
  World world;
  SoftBody* body = world.body;
  ASSERT_TRUE(body->pin(0));
  btRigidBody* object = body->surfaceObject() ? body->surfaceObject() : body->point(3);
  world.world->removeRigidBody(object);
  ASSERT_FALSE(body->alive());
  SoftBodySettings heavier = body->settings();
  heavier.totalMass = 5.0;
  const btVector3 up(0, 1, 0);
  const btTransform place(btQuaternion::getIdentity(), up);
  for (const Result<void>& result :
       {body->change(heavier), body->reset(), body->reset(place), body->setTransform(place),
        body->setVelocity(up, up), body->applyForce(up), body->applyForce(up, 1), body->applyTorque(up),
        body->applyImpulse(up), body->applyImpulse(up, 1), body->applyTorqueImpulse(up),
        body->applyBlast(up, 1, 1), body->pin(1), body->movePin(0, up), body->teleportPin(0, up),
        body->unpin(0), body->restoreState(body->saveState())})
    EXPECT_EQ(result.error(), "the soft body is disabled, see alive()");
  btRigidBody* box = world.addBox(vec(1, 1, 1), 1.0, vec(5, 0, 0));
  EXPECT_EQ(world.system.attach(body, 1, *box).error(), "the soft body is disabled, see alive()");
  EXPECT_EQ(grab(world.system, body, 1).error(), "the soft body is disabled, see alive()");
  EXPECT_EQ(body->cut(up, up).error(), "the soft body is disabled, see alive()");
  EXPECT_DOUBLE_EQ(body->settings().totalMass, 1.0);
  EXPECT_TRUE(body->pinned(0));
}

// --- groups ------------------------------------------------------------------------------------------------

TEST(ChangeOfGroups, factorsApplyToTheirSpringsAndPoints) {
  const SharedNetwork network = *withGroup(*chainNetwork(4), "end", {3, 4});
  ASSERT_EQ(network->groups[0].springs.size(), 1u);
  World world(0.0, testedSettings(), network);
  const double mass = world.body->totalMass();
  world.change([](SoftBodySettings& s) { s.groups = {{"end", 10.0, 1.0, 1.0, 3.0}}; });
  EXPECT_NEAR(world.body->totalMass(), mass * (1.0 + 2.0 * 2.0 / 5.0), mass * kFloat);
  // hangs by its first point from 4 springs in a row, the last of which is ten times as stiff
  world.world->setGravity(vec(0, -1, 0));
  world.body->pin(0);
  world.change([](SoftBodySettings& s) { s.damping = 3.0, s.sleepingSpeed = 0.0; });
  world.simulate(20.0);
  const double k = world.body->settings().extensionStiffness, m = mass / 5.0;
  const auto stretch = [&](std::uint32_t i) {
    return (world.body->position(i + 1) - world.body->position(i)).norm() - 0.25;
  };
  EXPECT_NEAR(stretch(2), 6.0 * m / k, 1e-5) << "carries two points of three times the mass";
  EXPECT_NEAR(stretch(3), 3.0 * m / (10.0 * k), 1e-5);
}

TEST(ChangeOfGroups, aSeamBreaksFirst) {
  const SharedNetwork network = *withGroup(*chainNetwork(4), "seam", {1, 2});
  SoftBodySettings s = testedSettings();
  s.elasticLimit.breakStrain = 0.2;
  s.groups = {{"seam", 1.0, 1.0, 0.25, 1.0}};
  World world(0.0, s, network);
  world.body->pin(0);
  world.body->pin(4);
  world.change([](SoftBodySettings& t) { t.damping = 1.0; });
  EXPECT_TRUE(world.body->brokenSprings().empty());
  for (int i = 0; i < 200; ++i) {
    world.body->movePin(4, vec(0, -1.0 - 0.1 * i / 200.0, 0));
    world.tick();
  }
  EXPECT_GT((world.body->position(2) - world.body->position(1)).norm(), 0.3);
  EXPECT_LT((world.body->position(1) - world.body->position(0)).norm(), 0.26);
  const std::vector<std::uint32_t> broken = world.body->brokenSprings();
  ASSERT_EQ(broken.size(), 1u);
  const NetworkSpring& spring = network->springs[broken[0]];
  EXPECT_EQ(spring.a, 1u);
  EXPECT_EQ(spring.b, 2u);
}

/// A muscle: two points on a spring of three halves of its strength.
TEST(ChangeOfGroups, aMusclePullsByItsRestLength) {
  const SharedNetwork network = *withGroup(*chainNetwork(4), "muscle", {1, 2});
  World world(0.0, testedSettings(), network);
  world.body->pin(1);
  world.body->pin(2);
  world.change([](SoftBodySettings& s) { s.groups = {{"muscle", 1.5, 1.0, 1.0, 1.0, 0.8}}; });
  EXPECT_NEAR((world.body->position(2) - world.body->position(1)).norm(), 0.25, kFloat)
      << "nothing moves at once";
  world.simulate(0.1);
  const double force = 1.5 * world.body->settings().extensionStiffness * 0.2 * 0.25;
  EXPECT_NEAR(double(world.body->pinForce(1).length()), force, 1e-4 * force);
  // let go it becomes as long as it wants to be, with the rest of the chain
  world.body->unpin(2);
  world.change([](SoftBodySettings& s) { s.damping = 3.0, s.sleepingSpeed = 0.0; });
  world.simulate(20.0);
  EXPECT_NEAR((world.body->position(2) - world.body->position(1)).norm(), 0.8 * 0.25, 1e-5);
  EXPECT_NEAR((world.body->position(3) - world.body->position(2)).norm(), 0.25, 1e-5);
}

TEST(ChangeOfGroups, namesAndIndicesAreChecked) {
  const SharedNetwork chain = chainNetwork(4);
  const SpringNetwork& network = *chain;
  EXPECT_EQ(withGroup(network, "end", {3, 9}).error(), "group 0 (end) has point 9 of 5");
  EXPECT_EQ(withGroup(network, "", {3}).error(), "group 0 () has no name");
  EXPECT_EQ(withGroup(**withGroup(network, "end", {3}), "end", {2}).error(),
            "group 1 (end) has the name of an earlier one");
  const SharedNetwork two = *withGroup(**withGroup(network, "end", {3, 4}), "top", {0});
  World world(0.0, testedSettings(), two);
  SoftBodySettings s = world.body->settings();
  s.groups = {{"arm"}};
  EXPECT_EQ(world.body->change(s).error(), "groups[0].name is arm, must be one of the network's: end, top");
  s.groups = {{"end", -1.0}};
  EXPECT_EQ(world.body->change(s).error(), "settings: groups[0].stiffness is -1, must be from 0 to 1e6");
}

// --- place and motion --------------------------------------------------------------------------------------

TEST(Place, aTeleportCarriesNoVelocity) {
  World world;
  stirred(world);
  const Eigen::Vector3d momentum = world.body->linearMomentum();
  const double energy = world.energy();
  const btTransform there(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(1.3)), vec(40, -7, 90));
  ASSERT_TRUE(world.body->setTransform(there));
  EXPECT_LT((world.body->transform().getOrigin() - there.getOrigin()).length(), 1e-4);
  EXPECT_LT(world.body->transform().getRotation().angleShortestPath(there.getRotation()), 1e-3);
  EXPECT_LT((world.body->linearMomentum() - momentum).norm(), kFloat * momentum.norm());
  EXPECT_NEAR(world.energy(), energy, 1e-3 * energy);
  world.simulate(0.5);
  EXPECT_LT((world.body->linearMomentum() - momentum).norm(), 1e-4);
  EXPECT_NEAR(world.energy(), energy, 3e-3 * energy);
}

TEST(Place, pinsMoveWithTheBodyAndAreStill) {
  World world;
  ASSERT_TRUE(world.body->pin(2));
  world.simulate(0.1);
  const Eigen::Vector3d pin = world.body->position(2);
  btTransform there = world.body->transform();
  there.setOrigin(there.getOrigin() + vec(30, 0, 0));
  ASSERT_TRUE(world.body->setTransform(there));
  world.simulate(1.0);
  EXPECT_LT((world.body->position(2) - pin - Eigen::Vector3d(30, 0, 0)).norm(), 1e-4);
  EXPECT_LT(world.energy(), 1e-6);
}

TEST(Place, aFarPinTargetIsReachedAtTheSpeedAllowed) {
  SoftBodySettings s = testedSettings();
  s.maxPinSpeed = 30.0;
  World world(0.0, s);
  ASSERT_TRUE(world.body->pin(0));
  world.tick();
  const Eigen::Vector3d start = world.body->position(0);
  const double energy = world.body->elasticEnergy();
  ASSERT_TRUE(world.body->movePin(0, vec(start.x() + 2.0, start.y(), start.z())));
  EXPECT_EQ(world.body->position(0), start) << "it goes in the next tick";
  EXPECT_EQ(world.body->elasticEnergy(), energy);
  EXPECT_LT(world.body->pinForce(0).length(), 1e-3);
  world.tick();
  EXPECT_NEAR((world.body->position(0) - start).norm(), 0.5, 1e-6);
  for (int i = 0; i < 3; ++i) world.tick();
  EXPECT_NEAR((world.body->position(0) - start).norm(), 2.0, 1e-5);
  world.tick();
  EXPECT_NEAR((world.body->position(0) - start).norm(), 2.0, 1e-5);
}

TEST(Place, aTeleportedPinHasNoVelocity) {
  World world;
  ASSERT_TRUE(world.body->pin(0));
  world.tick();
  const Eigen::Vector3d start = world.body->position(0);
  ASSERT_TRUE(world.body->teleportPin(0, vec(start.x(), start.y() + 0.1, start.z())));
  EXPECT_LT(world.body->velocity(0).norm(), 1e-9);
  EXPECT_NEAR(world.body->position(0).y(), start.y() + 0.1, 1e-6);
  world.tick();
  EXPECT_NEAR(world.body->position(0).y(), start.y() + 0.1, 1e-6);
  EXPECT_LT(world.body->velocity(0).norm(), 1e-4);
}

TEST(Place, resetIsTheStart) {
  World world, fresh;
  stirred(world);
  ASSERT_TRUE(world.body->reset());
  EXPECT_EQ(world.body->stateHash(), fresh.body->stateHash());
  EXPECT_EQ(world.body->elasticEnergy(), fresh.body->elasticEnergy());
  const btTransform there(btQuaternion(btVector3(0, 1, 0), btScalar(0.7)), vec(1, 2, 3));
  ASSERT_TRUE(world.body->reset(there));
  EXPECT_LT(world.energy(), 1e-6);
  EXPECT_LT((world.body->transform().getOrigin() - there.getOrigin()).length(), 1e-5);
  EXPECT_LT(world.body->transform().getRotation().angleShortestPath(there.getRotation()), 1e-3);
}

// --- pushes ------------------------------------------------------------------------------------------------

TEST(Push, impulsesChangeMomentumBySoMuch) {
  World world;
  ASSERT_TRUE(world.body->applyImpulse(vec(1, 2, 3)));
  EXPECT_LT((world.body->linearMomentum() - Eigen::Vector3d(1, 2, 3)).norm(), kFloat);
  EXPECT_LT(world.body->angularMomentum().norm(), kFloat);
  ASSERT_TRUE(world.body->applyTorqueImpulse(vec(0.1, -0.2, 0.3)));
  EXPECT_LT((world.body->angularMomentum() - Eigen::Vector3d(0.1, -0.2, 0.3)).norm(), kFloat);
  ASSERT_TRUE(world.body->applyImpulse(vec(0, 0, 1), 5u));
  const Eigen::Vector3d arm = world.body->position(5), expected(0.1, -0.2, 0.3);
  EXPECT_LT((world.body->angularMomentum() - expected - arm.cross(Eigen::Vector3d::UnitZ())).norm(), kFloat);
}

TEST(Push, aForceActsInOneStep) {
  for (const bool asleep : {false, true}) {
    World world;
    if (asleep) {
      world.simulate(4.0);
      ASSERT_TRUE(world.body->sleeping());
    }
    ASSERT_TRUE(world.body->applyForce(vec(6, 0, 0)));
    world.world->stepSimulation(btScalar(2.00001 * kTick), 4, btScalar(kTick));
    world.world->stepSimulation(btScalar(2.00001 * kTick), 4, btScalar(kTick));
    EXPECT_NEAR(world.body->linearMomentum().x(), 6.0 * 2.0 * kTick, 1e-5) << asleep;
    ASSERT_TRUE(world.body->applyTorque(vec(0, 6, 0)));
    world.tick();
    world.tick();
    // rounded to floats about an axis a small distance away
    const Eigen::Vector3d center = world.body->centerOfMass();
    const Eigen::Vector3d spin = world.body->angularMomentum() - center.cross(world.body->linearMomentum());
    EXPECT_NEAR(spin.y(), 6.0 * kTick, 1e-4) << asleep;
  }
}

TEST(Push, aHitOnTheSurfaceIsPushedThere) {
  if (!kSurface) GTEST_SKIP() << "needs a surface";
  World world;
  TriangleRay hits(vec(0.2, 5, 0.1), vec(0.2, -5, 0.1));
  world.world->rayTest(vec(0.2, 5, 0.1), vec(0.2, -5, 0.1), hits);
  ASSERT_TRUE(hits.hasHit());
  const SurfaceHit hit = surfaceHit(hits.m_collisionObject, hits.triangle, hits.m_hitPointWorld);
  ASSERT_EQ(hit.body, world.body);
  ASSERT_TRUE(world.body->applyImpulse(vec(0, -2, 0), hit));
  const Eigen::Vector3d arm(0.2, 0.5, 0.1);
  EXPECT_LT((world.body->linearMomentum() - Eigen::Vector3d(0, -2, 0)).norm(), kFloat);
  EXPECT_LT((world.body->angularMomentum() - arm.cross(Eigen::Vector3d(0, -2, 0))).norm(), 1e-4);
  World other;
  EXPECT_EQ(other.body->applyImpulse(vec(0, 1, 0), hit).error(), "the hit is not on this soft body");
  ASSERT_TRUE(world.body->setVelocity(vec(0, 0, 0)));
  ASSERT_TRUE(world.body->applyForce(vec(0, -6, 0), hit));
  world.tick();
  EXPECT_NEAR(world.body->linearMomentum().y(), -6.0 * kTick, 1e-6);
}

TEST(Push, aBlastPushesOutwards) {
  World world;
  ASSERT_TRUE(world.body->applyBlast(vec(0, 0, 0), 2, 4));
  for (std::uint32_t i = 0; i < world.body->pointCount(); ++i) {
    const Eigen::Vector3d x = world.body->position(i);
    EXPECT_LT((world.body->velocity(i) - 4.0 * (1.0 - x.norm() / 2.0) * x.normalized()).norm(), 1e-5);
  }
  EXPECT_LT(world.body->linearMomentum().norm(), 1e-5);
}

TEST(Push, badValuesAreNamed) {
  World world;
  const btScalar nan = btScalar(std::nan(""));
  EXPECT_EQ(world.body->applyForce(btVector3(nan, 0, 0)).error(), "the force is not finite, or beyond 1e18");
  EXPECT_EQ(world.body->applyImpulse(vec(0, 1, 0), 99u).error(), "there is no point 99");
  EXPECT_EQ(world.body->setVelocity(vec(2e6, 0, 0)).error(), "the velocity is beyond 1e6");
  EXPECT_EQ(world.body->applyBlast(vec(0, 0, 0), 0, 1).error(), "the radius of the blast is not above 0");
  btTransform skewed = btTransform::getIdentity();
  skewed.getBasis()[0][0] = 2;
  EXPECT_EQ(world.body->setTransform(skewed).error(), "the transform's basis is no rotation");
  EXPECT_LT(world.energy(), 1e-12);
}

}  // namespace
}  // namespace limber::test
