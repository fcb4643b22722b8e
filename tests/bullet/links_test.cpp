// SPDX-License-Identifier: Zlib
// Springs between any bodies, pins, and points attached to rigid bodies.
#include "support/soft_world.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace limber::test {
namespace {

void keepAwake(SoftBody& body) { body.point(0)->setActivationState(DISABLE_DEACTIVATION); }

// --- springs -----------------------------------------------------------------------------------------------

TEST(Spring, twoRigidBodiesSwingWithTheReducedMass) {
  SoftWorld bullet(0.0);
  btRigidBody* a = bullet.addBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, 0, 0));
  btRigidBody* b = bullet.addBox(vec(0.1, 0.1, 0.1), 3.0, vec(1.1, 0, 0));
  a->setActivationState(DISABLE_DEACTIVATION);
  b->setActivationState(DISABLE_DEACTIVATION);
  SpringSettings s;
  s.restLength = 1.0;
  s.stiffness = 30.0;
  ASSERT_TRUE(bullet.system.addSpring({a}, {b}, s));
  const double period = 2 * M_PI * std::sqrt(0.75 / 30.0);
  double before = 0.1, last = 0;
  int crossings = 0;
  for (int i = 1; crossings < 11 && i < 2000; ++i) {
    bullet.tick();
    const double x =
        double(b->getWorldTransform().getOrigin().x() - a->getWorldTransform().getOrigin().x()) - 1.0;
    if (before > 0 && x <= 0) {
      last = (i - 1 + before / (before - x)) * kTick;
      ++crossings;
    }
    before = x;
  }
  // default tolerance: (omega dt)^2/24 = 0.05 at most; here omega h = 0.1 and the error 5e-4
  EXPECT_NEAR((last - period / 4) / 10, period, 1e-3 * period);
  EXPECT_LT((momentumOf(*a) + momentumOf(*b)).norm(), 1e-5);
}

TEST(Spring, offCentrePivotsKeepLinearAndAngularMomentum) {
  SoftWorld bullet(0.0);
  // cubes: with equal moments of inertia a free body has a constant angular velocity, as Bullet assumes
  btRigidBody* a = bullet.addBox(vec(0.3, 0.3, 0.3), 2.0, vec(0, 0, 0));
  btRigidBody* b = bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(2, 0.5, 0));
  for (btRigidBody* body : {a, b}) body->setActivationState(DISABLE_DEACTIVATION);
  a->setAngularVelocity(btVector3(0, 1, 2));
  SpringSettings s;
  s.stiffness = 20;
  s.restLength = 1.2;
  s.damping = 0.5;
  ASSERT_TRUE(bullet.system.addSpring({a, vec(0.3, 0.2, 0)}, {b, vec(-0.2, 0, 0.1)}, s));
  const Eigen::Vector3d p = momentumOf(*a) + momentumOf(*b),
                        l = angularMomentumOf(*a) + angularMomentumOf(*b);
  double worst = 0, scale = 0;
  for (int i = 0; i < 120; ++i) {
    bullet.tick();
    scale = std::max(scale, angularMomentumOf(*a).norm());
    worst = std::max(worst, (angularMomentumOf(*a) + angularMomentumOf(*b) - l).norm());
  }
  EXPECT_LT((momentumOf(*a) + momentumOf(*b) - p).norm(), 1e-4);
  // kicks and drifts keep it exactly; Bullet moves bodies in floats, 1e-7 of 1 m times some kg m/s per tick
  EXPECT_LT(worst, 1e-4 * scale);
}

TEST(Spring, joinsTwoSoftBodiesAndGoesAgain) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  SoftBody* a = bullet.addSoft(cubeNetwork(), s);
  s.position = {2, 0, 0};
  s.linearVelocity = {1, 0, 0};
  SoftBody* b = bullet.addSoft(cubeNetwork(), s);
  keepAwake(*a);
  keepAwake(*b);
  SpringSettings link;
  link.stiffness = 200;
  SpringConstraint* spring = *bullet.system.addSpring({a->point(1)}, {b->point(0)}, link);
  EXPECT_NEAR(*spring->settings().restLength, 1.0, 1e-6) << "the present distance";
  bullet.simulate(3.0);
  EXPECT_GT(a->linearMomentum().x(), 0.2) << "pulled along";
  // both bodies are in one island with a state in double precision: exact to rounding
  EXPECT_NEAR(a->linearMomentum().x() + b->linearMomentum().x(), 1.0, 1e-6);
  bullet.system.removeSpring(spring);
  bullet.tick();
  const double alone = b->linearMomentum().x();
  bullet.simulate(1.0);
  EXPECT_NEAR(b->linearMomentum().x(), alone, 1e-9);
}

TEST(Spring, actsOnOneSideOnlyWhenTold) {
  for (SpringAction action : {SpringAction::ExtensionOnly, SpringAction::CompressionOnly}) {
    SoftWorld bullet(0.0);
    btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 1.0, vec(0, 0, 0));
    SpringSettings s;
    s.restLength = 1.0;
    s.action = action;
    s.damping = 5;
    ASSERT_TRUE(
        bullet.system.addSpring({box}, {nullptr, vec(0.5, 0, 0)}, s));  // compressed to half its length
    bullet.simulate(0.1);
    const double speed = std::abs(double(box->getLinearVelocity().x()));
    if (action == SpringAction::ExtensionOnly)
      EXPECT_EQ(speed, 0.0) << "slack";
    else
      EXPECT_GT(speed, 1.0) << "pushed away";
  }
}

TEST(Spring, stiffOnesStayStableAtAnyStiffnessAndDamping) {
  for (double k : {1e2, 1e4, 1e6})
    for (double c : {0.0, 1.0, 1e3, 1e6}) {
      SoftWorld bullet;
      btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 0.1, vec(0.3, -1, 0));
      SpringSettings s;
      s.stiffness = k;
      s.damping = c;
      ASSERT_TRUE(bullet.system.addSpring({box, vec(0.1, 0.1, 0.1)}, {nullptr, btVector3(0, 0, 0)}, s));
      bullet.simulate(2.0);
      const Eigen::Vector3d x = eigen(box->getWorldTransform().getOrigin());
      // the box swings below the fixed end, and k = 100 extends the spring by some centimetres at most
      EXPECT_LT(x.norm(), 1.6) << "k " << k << " c " << c;
    }
}

TEST(Spring, hangsARigidBodyAtMgOverKAlsoAfterAChange) {
  SoftWorld bullet;
  btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 2.0, btVector3(0, 0, 0));
  SpringSettings s;
  s.restLength = 1.0;
  s.stiffness = 5e3;
  s.damping = 40;
  // from the centre of the box to a point of the world one metre above
  SpringConstraint* spring = *bullet.system.addSpring({box}, {nullptr, btVector3(0, 1, 0)}, s);
  bullet.simulate(5.0);
  const double sag = 2.0 * 9.81 / 5e3;
  EXPECT_NEAR(heightOf(*box), -sag, 1e-5);
  EXPECT_NEAR(spring->force(), 2.0 * 9.81, 1e-2);
  EXPECT_NEAR(double(spring->length()), 1.0 + sag, 1e-5);
  s.restLength.reset();  // keep
  s.stiffness = 1000;
  ASSERT_TRUE(bullet.system.changeSpring(spring, s));
  EXPECT_DOUBLE_EQ(*spring->settings().restLength, 1.0);
  bullet.simulate(4.0);
  EXPECT_NEAR(heightOf(*box), -2.0 * 9.81 / 1000, 1e-4);
}

/// A cube that sleeps on four cables, and what then changes them.
double fallAfter(
    const std::function<void(SoftBodySystem&, const std::vector<SpringConstraint*>&, btRigidBody&)>& change) {
  SoftWorld bullet;
  btRigidBody* crane = bullet.addBox(vec(1, 0.1, 1), 0.0, vec(0, 3, 0));
  SoftBodySettings s = testedSettings();
  s.damping = 20.0;
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  SpringSettings cable;
  cable.stiffness = 500.0;
  cable.damping = 20.0;
  std::vector<SpringConstraint*> cables;
  for (std::uint32_t i = 0; i < body->pointCount(); ++i) {
    const Eigen::Vector3d x = body->position(i);
    if (x.y() > 0.0)
      cables.push_back(*bullet.system.addSpring({crane, vec(x.x(), -0.1, x.z())}, {body->point(i)}, cable));
  }
  for (int i = 0; i < 1200 && !body->sleeping(); ++i) bullet.tick();
  EXPECT_TRUE(body->sleeping());
  const double before = body->centerOfMass().y();
  change(bullet.system, cables, *crane);
  bullet.simulate(0.5);
  return before - body->centerOfMass().y();
}

TEST(Spring, changesAndRemovalWakeWhatItHolds) {
  using Cables = std::vector<SpringConstraint*>;
  EXPECT_NEAR(fallAfter([](SoftBodySystem&, const Cables&, btRigidBody&) {}), 0.0, 1e-9);
  const auto keep = [](SoftBodySystem& system, const Cables& cables, btRigidBody&) {
    for (SpringConstraint* cable : cables) EXPECT_TRUE(system.changeSpring(cable, cable->settings()));
  };
  EXPECT_NEAR(fallAfter(keep), 0.0, 1e-9) << "the same settings change nothing";
  const auto remove = [](SoftBodySystem& system, const Cables& cables, btRigidBody&) {
    for (SpringConstraint* cable : cables) EXPECT_TRUE(system.removeSpring(cable));
  };
  EXPECT_GT(fallAfter(remove), 1.0);
  const auto forget = [](SoftBodySystem& system, const Cables&, btRigidBody& crane) { system.forget(crane); };
  EXPECT_GT(fallAfter(forget), 1.0);
  const auto winch = [](SoftBodySystem& system, const Cables& cables, btRigidBody&) {
    for (SpringConstraint* cable : cables) {
      SpringSettings shorter = cable->settings();
      *shorter.restLength -= 0.1;
      EXPECT_TRUE(system.changeSpring(cable, shorter));
    }
  };
  EXPECT_LT(fallAfter(winch), -0.05);
}

TEST(Spring, badOnesAreRefusedWithTheReason) {
  SoftWorld bullet;
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 0, 0));
  SpringSettings s;
  s.stiffness = -1;
  EXPECT_EQ(bullet.system.addSpring({box}, {nullptr}, s).error(), "stiffness is -1, must be from 0 to 1e12");
  EXPECT_EQ(bullet.system.addSpring({nullptr}, {nullptr}).error(),
            "a spring needs a body at one of its ends");
  EXPECT_EQ(bullet.system.addSpring({box}, {box}).error(),
            "both ends of the spring are the same place of one body");
  EXPECT_EQ(bullet.system.springCount(), 0u);
  EXPECT_EQ(bullet.system.hookState(), HookState::Idle);
}

// --- pins --------------------------------------------------------------------------------------------------

TEST(Pin, holdsAPointAndLetsGo) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork());
  keepAwake(*body);
  body->pin(7);
  EXPECT_TRUE(body->pinned(7));
  const Eigen::Vector3d start = body->position(7);
  bullet.simulate(1.0);
  EXPECT_LT((body->position(7) - start).norm(), 1e-6);
  EXPECT_GT(body->centerOfMass().y(), -1.5);
  body->unpin(7);
  bullet.simulate(1.0);
  EXPECT_LT(body->centerOfMass().y(), -4.0) << "falls";
  EXPECT_NEAR(body->totalMass(), 1.0, 1e-6);
}

TEST(Pin, keepsTheMassThatTheUserHasGivenAPoint) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(cubeNetwork());
  body->point(0)->setMassProps(btScalar(2), btVector3(0, 0, 0));
  EXPECT_TRUE(body->pin(0));
  EXPECT_TRUE(body->unpin(0));
  EXPECT_NEAR(body->totalMass(), 0.875 + 2.0, 1e-6) << "given before it was pinned";
  EXPECT_TRUE(body->pin(0));
  bullet.tick();
  body->point(0)->setMassProps(btScalar(3), btVector3(0, 0, 0));
  bullet.tick();
  EXPECT_TRUE(body->unpin(0));
  bullet.tick();
  EXPECT_NEAR(body->totalMass(), 0.875 + 3.0, 1e-6) << "given while it was pinned";
}

/// In the same pause between two ticks. What the user has moved is where it is.
TEST(Pin, holdsAndLetsGoWhereAPointWasMoved) {
  for (const bool pinnedBefore : {false, true}) {
    SoftWorld bullet(0.0);
    SoftBody* body = bullet.addSoft(cubeNetwork());
    if (pinnedBefore) body->pin(7);
    bullet.tick();
    const Eigen::Vector3d start = body->position(7);
    for (std::uint32_t i = 0; i < body->pointCount(); ++i)
      body->point(i)->getWorldTransform().getOrigin() += vec(0.5, 0, 0);
    ASSERT_TRUE(pinnedBefore ? body->unpin(7) : body->pin(7));
    bullet.tick();
    EXPECT_NEAR((body->position(7) - start).x(), 0.5, 1e-6) << pinnedBefore;
    EXPECT_LT(energyOf(*body), 1e-6) << pinnedBefore;
  }
}

TEST(Pin, moveAlongAPathDragsTheBody) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.damping = 5;
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  for (std::uint32_t i : {0u, 2u, 4u, 6u}) body->pin(i);
  for (int t = 1; t <= 120; ++t) {
    for (std::uint32_t i : {0u, 2u, 4u, 6u})
      body->movePin(i, body->point(i)->getWorldTransform().getOrigin() + vec(1.0 / 60, 0, 0));
    bullet.tick();
  }
  EXPECT_NEAR(body->position(0).x(), -0.5 + 2.0, 1e-4);
  EXPECT_NEAR(body->position(1).x(), 0.5 + 2.0, 0.05);
  for (std::uint32_t i : {0u, 2u, 4u, 6u}) body->unpin(i);
  EXPECT_NEAR(body->velocity(0).x(), 1.0, 1e-3) << "lets go with the speed it was moved with";
}

TEST(Pin, aPinPushesRigidBodies) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.pointRadius = 0.1;
  SoftBody* body = bullet.addSoft(pairNetwork(), s);
  body->pin(0);
  btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(0, 0.4, 0));
  for (int t = 1; t <= 30; ++t) {
    body->movePin(0, vec(0, t / 60.0, 0));
    bullet.tick();
  }
  EXPECT_GT(heightOf(*box), 0.7);
}

// --- attached points ---------------------------------------------------------------------------------------

TEST(Attach, pointsFollowARigidBodyAndCarryIt) {
  SoftWorld bullet;
  SoftBodySettings s = testedSettings();
  s.damping = 100;
  SoftBody* rope = bullet.addSoft(chainNetwork(8), s);
  btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 2.0, vec(0, -1.1, 0));
  rope->pin(0);
  ASSERT_TRUE(bullet.system.attach(rope, 8, *box));
  double worst = 0;
  for (int i = 0; i < 1200; ++i) {
    bullet.tick();
    const btVector3 pivot = box->getWorldTransform() * vec(0, 0.1, 0);
    worst = std::max(worst, (rope->position(8) - eigen(pivot)).norm());
  }
  // exact in the substeps; the remaining error is the rounding of the box's transform in Bullet
  EXPECT_LT(worst, 1e-5);
  // each of the 8 springs carries the box, the end point and the part of the rope below it
  const double m = 1.0 / 9, k = 1000;
  double sag = 0;
  for (int i = 1; i <= 8; ++i) sag += (2.0 + m * (9 - i)) * 9.81 / k;
  EXPECT_NEAR(rope->position(8).y(), -1.0 - sag, 1e-3 * sag);
}

TEST(Attach, dampingDoesNotMoveTheEquilibrium) {
  // between kick and constraint an attached point and its body differ in velocity, which dampers must ignore
  double first = 0;
  for (double damping : {10.0, 30.0, 100.0, 1000.0}) {
    SoftWorld bullet;
    SoftBodySettings s = testedSettings();
    s.damping = damping;
    SoftBody* rope = bullet.addSoft(chainNetwork(8), s);
    btRigidBody* box = bullet.addAwakeBox(vec(0.1, 0.1, 0.1), 2.0, vec(0, -1.1, 0));
    rope->pin(0);
    ASSERT_TRUE(bullet.system.attach(rope, 8, *box));
    bullet.simulate(40.0);
    if (damping == 10.0) first = rope->position(8).y();
    EXPECT_NEAR(rope->position(8).y(), first, 2e-5) << "damping " << damping;
  }
}

TEST(Attach, isMomentumConserving) {
  SoftWorld bullet(0.0);
  SoftBodySettings s = testedSettings();
  s.linearVelocity = {1, 0, 0};
  SoftBody* body = bullet.addSoft(cubeNetwork(), s);
  btRigidBody* box = bullet.addAwakeBox(vec(0.5, 0.5, 0.5), 0.5, vec(-1, 0, 0));
  for (std::uint32_t i : {0u, 2u, 4u, 6u}) ASSERT_TRUE(bullet.system.attach(body, i, *box));
  bullet.simulate(3.0);
  EXPECT_NEAR(body->linearMomentum().x() + momentumOf(*box).x(), 1.0, 1e-5);
  EXPECT_NEAR(double(box->getLinearVelocity().x()), 1.0 / 1.5, 0.05) << "towed along";
}

TEST(Attach, toAKinematicBodyFollowsItsMotion) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(pairNetwork());
  btRigidBody* hand = bullet.addBox(vec(0.1, 0.1, 0.1), 0, vec(-0.2, 0, 0));
  hand->setCollisionFlags(hand->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  hand->setActivationState(DISABLE_DEACTIVATION);
  ASSERT_TRUE(bullet.system.attach(body, 0, *hand, vec(0.2, 0, 0)));
  for (int t = 1; t <= 90; ++t) {
    btTransform pose(btQuaternion(btVector3(0, 0, 1), btScalar(t * 0.02)), vec(-0.2, t / 120.0, 0));
    hand->setWorldTransform(pose);
    bullet.tick();
    EXPECT_LT((body->position(0) - eigen(pose * vec(0.2, 0, 0))).norm(), 1e-5) << t;
  }
}

TEST(Attach, doesNotCollideWithItsRigidBody) {
  SoftWorld bullet(0.0);
  SoftBody* body = bullet.addSoft(pairNetwork());
  btRigidBody* box = bullet.addBox(vec(0.2, 0.2, 0.2), 1.0, vec(0, 0, 0));  // point 0 is inside the box
  ASSERT_TRUE(bullet.system.attach(body, 0, *box));
  bullet.simulate(1.0);
  EXPECT_LT(eigen(box->getLinearVelocity()).norm(), 1e-6);
  ASSERT_TRUE(bullet.system.detach(body, 0));
  if (kSurface) return;  // only points in the world collide with dynamic bodies
  bullet.simulate(0.5);
  EXPECT_GT((body->position(0) - eigen(box->getWorldTransform().getOrigin())).norm(), 0.05)
      << "no longer attached, Bullet pushes it out";
}

/// A plank of 3 kg between two ropes, a box without equal moments of inertia that tumbles.
struct TumblingPlank {
  BulletWorld bullet{0.0};
  SoftBodySystem system{*bullet.world};
  btRigidBody* plank = bullet.addBox(vec(0.11, 0.03, 0.5), 3.0, vec(0, 0.05, 0));
  std::vector<SoftBody*> ropes;

  explicit TumblingPlank(const btVector3& spin) {
    SoftBodySettings s = testedSettings();
    s.totalMass = 0.2;
    setSprings(s, 2e4, 5.0);
    s.collisionMask = 0;
    for (const double z : {-0.5, 0.5}) {
      s.position = {-0.25, 0.0, z};
      ropes.push_back(*system.createBody(ropeNetwork(2, 0.5), s));
      for (const std::uint32_t end : {0u, 2u}) EXPECT_TRUE(ropes.back()->pin(end));
      EXPECT_TRUE(system.attach(ropes.back(), 1, *plank));
    }
    plank->setActivationState(DISABLE_DEACTIVATION);
    plank->setAngularVelocity(spin);
  }

  double energy() const {
    double sum = kineticEnergyOf(*plank);
    for (const SoftBody* rope : ropes) sum += energyOf(*rope);
    return sum;
  }

  /// The largest distance of a point from the place on the plank to which it is attached.
  double gap() const {
    double largest = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      const btVector3 place = plank->getWorldTransform() * vec(0, -0.05, k == 0 ? -0.5 : 0.5);
      largest = std::max(largest, (ropes[k]->position(1) - eigen(place)).norm());
    }
    return largest;
  }
};

/// Bullet turns a body by an eighth of a turn in a tick at most, and its gyroscopic impulses do not converge
/// for turns of a radian. The anchors were off by centimetres, and 47 J became 2e9 J.
TEST(Attach, toABodyThatTumblesFasterThanBulletTurnsItHolds) {
  for (const double tick : {1.0 / 30, 1.0 / 60})
    for (const double spin : {40.0, 100.0, 200.0}) {
      TumblingPlank s(vec(0.06 * spin, -0.04 * spin, 0.9 * spin));
      const double start = s.energy();
      for (double time = 0.0; time < 2.0; time += tick) {
        s.bullet.tick(tick);
        ASSERT_LT(s.energy(), 1.001 * start) << tick << ", " << spin << " at " << time;
        ASSERT_LT(s.gap(), 0.01) << tick << ", " << spin << " at " << time;
      }
    }
}

/// A slender handle between two ropes spins about its own axis while it swings: its axis turns with the spin
/// in each substep. Anchors that expected it to turn with a constant angular velocity made 12 kJ of 1.5 J at
/// 60 rad/s.
TEST(Attach, toASlenderHandleThatSpinsItGainsNoEnergy) {
  for (const double spin : {30.0, 60.0, 100.0}) {
    SoftWorld bullet;
    btRigidBody* handle = bullet.addBox(btVector3(btScalar(0.015), btScalar(0.07), btScalar(0.015)),
                                        btScalar(0.2), vec(0, -0.57, 0));
    SoftBodySettings s = testedSettings();
    setSprings(s, 1e3, 0.0);
    s.collisionMask = 0;
    s.rotation = Eigen::AngleAxisd(-0.5 * kPi, Eigen::Vector3d::UnitZ());
    SoftBody* upper = bullet.addSoft(ropeNetwork(4, 0.5), s);
    s.position = {0, -0.64, 0};
    SoftBody* lower = bullet.addSoft(ropeNetwork(4, 0.5), s);
    upper->pin(0);
    ASSERT_TRUE(bullet.system.attach(upper, 4, *handle));
    ASSERT_TRUE(bullet.system.attach(lower, 0, *handle));
    handle->setAngularVelocity(vec(0, spin, 0));
    lower->setVelocity(btVector3(1, 0, 0));
    const auto energy = [&] {
      double sum = energyOf(*handle, kGravity);
      for (const SoftBody* body : {upper, lower}) sum += energyOf(*body, kGravity);
      return sum;
    };
    const double start = energy();
    for (double time = 0.0; time < 5.0; time += kTick) {
      bullet.tick();
      // of 1 J that moves; the step's own energy swings by a tenth of that
      ASSERT_LT(energy(), start + 0.1) << spin << " rad/s at " << time;
    }
  }
}

TEST(Attach, badOnesAreRefusedWithTheReason) {
  SoftWorld bullet;
  SoftBody* body = bullet.addSoft(pairNetwork());
  btRigidBody* box = bullet.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  EXPECT_EQ(bullet.system.attach(body, 7, *box).error(), "there is no point 7");
  ASSERT_TRUE(bullet.system.attach(body, 0, *box));
  EXPECT_EQ(bullet.system.attach(body, 0, *box).error(), "point 0 is already attached");
  body->pin(1);
  EXPECT_EQ(bullet.system.attach(body, 1, *box).error(), "point 1 is pinned");
  body->unpin(1);
  EXPECT_FALSE(bullet.system.attach(body, 1, *body->point(0)));
}

TEST(Links, bodiesOfOtherWorldsAreRefused) {
  BulletWorld bullet, other;
  SoftBodySystem system(*bullet.world);
  SoftBody* body = *system.createBody(pairNetwork(), testedSettings());
  btRigidBody* stranger = other.addBox(btVector3(1, 1, 1), 1, btVector3(0, 5, 0));
  const std::string reason = "the rigid body is in another world";
  EXPECT_EQ(system.attach(body, 0, *stranger).error(), reason);
  EXPECT_EQ(system.addSpring({body->point(0)}, {stranger}).error(), reason);
  EXPECT_EQ(system.addSpring({stranger}, {nullptr, btVector3(0, 8, 0)}).error(), reason);
  EXPECT_EQ(system.springCount(), 0u);
  // in no world it may be attached before it is added to this one
  other.world->removeRigidBody(stranger);
  EXPECT_TRUE(system.attach(body, 0, *stranger));
  EXPECT_TRUE(system.addSpring({body->point(1)}, {stranger}));
  bullet.tick();
  system.forget(*stranger);
  other.world->addRigidBody(stranger);
}

}  // namespace
}  // namespace limber::test
