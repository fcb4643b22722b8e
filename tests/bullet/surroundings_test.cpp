// SPDX-License-Identifier: Zlib
// Air and fields against closed forms; stability; sleep.
#include "support/surroundings.h"
#include "support/small_meshes.h"
#include "support/soft_world.h"

#include <cmath>
#include <limits>

namespace limber::test {
namespace {

using Eigen::Vector3d;

/// Adds a plate of 0.5 kg and 1 m x 1 m, broadside to its fall.
SoftBody* addPlate(SurroundingsTest& world) {
  SoftBodySettings s = stiffSolid(0.5);
  s.scale = {1.0, 0.05, 1.0};
  s.flow.drag = 1.17;
  s.flow.friction = 0.0;
  return world.add(bracedNetwork(small_meshes::cube(2)), s);
}

SoftBodySettings clothSettings(double mass) {
  SoftBodySettings s = usualSettings();
  s.totalMass = mass;
  setSprings(s, 2000.0 * mass, mass);
  s.flow.friction = 0.0;
  s.flow.linearDrag = 0.0;
  return s;
}

// --- drag --------------------------------------------------------------------------------------------------

/// Returns where the points of a cloth in air are that has swung on one edge for a second.
Eigen::Matrix3Xd swungCloth(double tick) {
  SoftWorld bullet;
  SoftBodySettings s = clothSettings(0.5);
  s.position = {0, 2, 0};
  SoftBody* body = bullet.addSoft(squareCloth(8), s);
  for (std::uint32_t i = 0; i < 9; ++i) body->pin(i);
  bullet.simulate(1.0, tick);
  return placesOf(*body);
}

/// Drag by the speeds of the last tick and the directions at the start of this one would differ by 9 mm.
TEST(SurroundedCloth, swingsAlikeInShortTicks) {
  const Eigen::Matrix3Xd usual = swungCloth(1.0 / 60.0), fine = swungCloth(1.0 / 240.0);
  EXPECT_LT((usual - fine).colwise().norm().maxCoeff(), 2e-3);
}

TEST_F(SurroundingsTest, aFallWithLinearDragIsExponential) {
  SoftBodySettings s = usualSettings();
  s.flow.linearDrag = 0.7;
  const SoftBody* body = add(cubeNetwork(), s);
  const double end = kGravity / 0.7;
  for (int tick = 1; tick <= 240; ++tick) {
    bullet.tick();
    const double t = tick / 60.0;
    ASSERT_NEAR(fallOf(*body), end * (1.0 - std::exp(-0.7 * t)), 2e-3 * end);
    ASSERT_NEAR(-heightOf(*body), end * (t - (1.0 - std::exp(-0.7 * t)) / 0.7), 2e-3 * end * t);
  }
}

TEST_F(SurroundingsTest, aPlateBroadsideFallsAtItsTerminalSpeed) {
  const SoftBody* body = addPlate(*this);
  bullet.simulate(5.0);
  EXPECT_NEAR(fallOf(*body), std::sqrt(2.0 * 0.5 * kGravity / (1.2 * 1.17)), 0.01);
}

/// With the terminal speed w the speed is  w tanh(g t / w).  Drag is applied once a substep, which is 0.4 %
/// of w off. With the speed in the middle of the last tick it would be 1.6 %.
TEST_F(SurroundingsTest, aPlateBroadsideGetsFasterByTheClosedForm) {
  const SoftBody* body = addPlate(*this);
  const double terminal = std::sqrt(2.0 * 0.5 * kGravity / (1.2 * 1.17));
  for (int tick = 1; tick <= 90; ++tick) {
    bullet.tick();
    const double exact = terminal * std::tanh(kGravity * tick / 60.0 / terminal);
    ASSERT_NEAR(fallOf(*body), exact, 5e-3 * terminal) << tick;
  }
}

/// Its points have the masses of their shares of the area. Otherwise its border would overtake its middle.
TEST_F(SurroundingsTest, aClothFallsFlatAtItsTerminalSpeed) {
  SoftBodySettings s = usualSettings();
  s.flow.drag = 1.17;
  s.flow.linearDrag = 0.0;
  const SoftBody* cloth = add(squareCloth(16), s);
  bullet.simulate(5.0);
  EXPECT_NEAR(fallOf(*cloth), std::sqrt(2.0 * s.totalMass * kGravity / (1.2 * 1.17)), 0.01);
}

TEST_F(SurroundingsTest, aBallFallsAtItsTerminalSpeed) {
  const TriangleMesh mesh = small_meshes::icosphere(2);
  double frontal = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vector3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    frontal += 0.25 * std::abs((b - a).cross(c - a).y());
  }
  EXPECT_NEAR(frontal, kPi, 0.1);
  SoftBodySettings s = stiffSolid(2.0);
  s.flow.drag = 0.47;
  s.flow.friction = 0.0;
  const SoftBody* body = add(bracedNetwork(mesh), s);
  bullet.simulate(6.0);  // twelve times the time in which the speed grows
  EXPECT_NEAR(fallOf(*body), std::sqrt(2.0 * 2.0 * kGravity / (1.2 * 0.47 * frontal)), 0.05);
}

TEST_F(SurroundingsTest, aFlagHangsAtTheAngleOfItsLoads) {
  // gravity sigma g and the pressure 1/2 rho C w^2 cos(angle) along the normal give a plane cloth
  for (const double wind : {1.0, 2.0, 3.0}) {
    const double mass = 0.4;
    SoftBodySettings s = clothSettings(mass);
    setSprings(s, 4000.0, 2.0);
    s.rotation = Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitX());
    SoftBody* flag = add(squareCloth(8), s);
    for (std::uint32_t i = 0; i <= 8; ++i) ASSERT_TRUE(flag->pin(i));
    setWind({0, 0, wind});
    bullet.simulate(20.0);
    const Vector3d along = flag->position(8 * 9 + 4) - flag->position(4);
    const double angle = std::atan2(along.z(), -along.y());
    const double expected = std::atan(0.5 * 1.2 * 1.2 * wind * wind / (mass * kGravity));
    EXPECT_NEAR(angle, expected, 0.003) << wind;
    ASSERT_TRUE(system.destroyBody(flag));
  }
}

/// Returns the mean force (N) along the wind on the pole of a light flag.
double forceOfFlag(double tick) {
  constexpr std::uint32_t kCells = 8;
  SoftWorld bullet;
  Air air;
  air.wind = {15, 0, 0};
  EXPECT_TRUE(bullet.system.setAir(air));
  SoftBodySettings s = usualSettings();
  s.totalMass = 0.075;
  setSprings(s, 5000.0, 0.5);
  s.rotation = Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitX());
  SoftBody* flag = bullet.addSoft(squareCloth(kCells), s);
  for (std::uint32_t row = 0; row <= kCells; ++row) flag->pin(row * (kCells + 1));
  double sum = 0.0;
  int ticks = 0;
  for (double time = 0.0; time < 3.0; time += tick) {
    bullet.tick(tick);
    if (time < 1.0) continue;
    ++ticks;
    for (std::uint32_t row = 0; row <= kCells; ++row) sum -= double(flag->pinForce(row * (kCells + 1)).x());
  }
  return sum / ticks;
}

/// It turns in the wind several times within a tick. By the lift at the starts of the ticks alone it would
/// whip: 6 times the force at 30 Hz.
TEST(SurroundedCloth, aFlagOfAnyTickPullsAlikeAtItsPole) {
  const double usual = forceOfFlag(1.0 / 60.0);
  EXPECT_NEAR(forceOfFlag(1.0 / 30.0) / usual, 1.0, 0.05);
  EXPECT_NEAR(forceOfFlag(1.0 / 240.0) / usual, 1.0, 0.05);
}

TEST_F(SurroundingsTest, aRopeFallsAtTheTerminalSpeedOfACylinder) {
  SoftBodySettings s = usualSettings();
  s.totalMass = 0.1;
  s.pointRadius = 0.01;
  s.damping = 0.1;
  s.flow.linearDrag = 0.0;
  const SoftBody* rope = add(*buildRope(), s);
  bullet.simulate(20.0);
  EXPECT_NEAR(fallOf(*rope), std::sqrt(2.0 * 0.1 * kGravity / (1.2 * 1.2 * 0.02)), 0.05);
}

TEST_F(SurroundingsTest, aHurricaneNeverMakesALooseClothFasterThanItself) {
  bullet.world->setGravity(btVector3(0, 0, 0));
  const Vector3d wind(60, 10, -30);
  setWind(wind);
  for (const double tick : {1.0 / 60.0, 1.0 / 15.0})
    for (const double mass : {0.01, 1.0}) {
      SoftBodySettings s = clothSettings(mass);
      s.flow.lift = 0.0;
      SoftBody* cloth = add(squareCloth(6), s);
      double energy = 0.5 * mass * wind.squaredNorm();
      for (int i = 0; i < 60; ++i) {
        bullet.tick(tick);
        const double relative = cloth->kineticEnergy() + 0.5 * mass * wind.squaredNorm() -
                                cloth->linearMomentum().dot(wind) + cloth->elasticEnergy();
        ASSERT_LE(relative, energy * (1.0 + 1e-6) + 1e-9) << i;
        energy = relative;
      }
      EXPECT_LT(energy, 0.4 * 0.5 * mass * wind.squaredNorm());
      ASSERT_TRUE(system.destroyBody(cloth));
    }
}

TEST_F(SurroundingsTest, aPinnedClothStaysFiniteInAHurricane) {
  Air air;
  air.wind = {0, 0, 70};
  air.windAt = gusts(air.wind, 20.0, 2.0);
  ASSERT_TRUE(system.setAir(air));
  SoftBody* cloth = add(squareCloth(8), clothSettings(0.05));
  ASSERT_TRUE(cloth->pin(0));
  ASSERT_TRUE(cloth->pin(8));
  for (int i = 0; i < 300; ++i) {
    bullet.tick(1.0 / 15.0);
    ASSERT_LT(cloth->kineticEnergy(), 0.5 * 0.05 * 300.0 * 300.0) << i;
  }
  EXPECT_EQ(cloth->restorations(), 0u);
}

TEST_F(SurroundingsTest, aPinnedClothStaysFiniteInTheStrongestFlow) {
  Air air;
  air.density = 1e9;
  air.wind = {1e6, -1e6, 1e6};
  ASSERT_TRUE(system.setAir(air));
  for (const bool pinned : {true, false}) {
    SoftBody* cloth = add(squareCloth(4), clothSettings(0.05));
    if (pinned) {
      ASSERT_TRUE(cloth->pin(0));
    }
    for (int i = 0; i < 20; ++i) bullet.tick();
    EXPECT_TRUE(std::isfinite(cloth->kineticEnergy()) && cloth->centerOfMass().allFinite()) << pinned;
  }
}

TEST_F(SurroundingsTest, aClothOnTwoPinsComesToRest) {
  SoftBody* cloth = add(*buildCloth(), usualSettings());
  ASSERT_TRUE(cloth->pin(0));
  ASSERT_TRUE(cloth->pin(16));
  double seconds = 0.0;
  for (; seconds < 30.0 && !cloth->sleeping(); seconds += 1.0 / 60.0) bullet.tick();
  EXPECT_LT(seconds, 20.0);
}

TEST_F(SurroundingsTest, solidsAndVacuumHaveNoDrag) {
  setWind({10, 0, 0});
  const SoftBody* cube = add(closedCubeNetwork(), usualSettings());
  bullet.simulate(1.0);
  EXPECT_NEAR(cube->linearMomentum().x(), 0.0, 1e-9);
  setWind({10, 0, 0}, 0.0);
  const SoftBody* cloth = add(*buildCloth(), usualSettings());
  bullet.simulate(1.0);
  EXPECT_NEAR(cloth->linearMomentum().x(), 0.0, 1e-9);
}

// --- fields ------------------------------------------------------------------------------------------------

TEST_F(SurroundingsTest, aConstantFieldIsLikeGravity) {
  const auto fall = [](bool asField) {
    BulletWorld world(asField ? 0.0 : -kGravity);
    SoftBodySystem soft(*world.world);
    const auto pull = [](const FieldPoints& p) {
      for (std::size_t i = 0; i < p.count; ++i) p.accelerations[3 * i + 1] -= kGravity;
    };
    if (asField) {
      EXPECT_TRUE(soft.addField(pull));
    }
    world.addPlaneFloor();
    SoftBodySettings s = usualSettings();
    s.position = {0, 1.5, 0};
    const SoftBody* body = *soft.createBody(closedCubeNetwork(), s);
    world.simulate(0.4);
    return body->centerOfMass().y();
  };
  EXPECT_NEAR(fall(true), fall(false), 1e-5);
}

TEST_F(SurroundingsTest, aFieldOfPlacesGainsNoEnergy) {
  for (const double w : {1.0, 5.0, 20.0}) {
    BulletWorld world(0.0);
    SoftBodySystem soft(*world.world);
    EXPECT_TRUE(soft.addField([w](const FieldPoints& p) {
      for (std::size_t i = 0; i < 3 * p.count; ++i) p.accelerations[i] -= w * w * p.positions[i];
    }));
    SoftBodySettings s = usualSettings();
    s.position = {2, 0, 0};
    s.linearVelocity = {0, 1, 0};
    s.sleepingSpeed = 0.0;
    const SoftBody* body = *soft.createBody(closedCubeNetwork(), s);
    const auto energy = [&] {
      return 0.5 * (body->linearMomentum() / body->totalMass()).squaredNorm() +
             0.5 * w * w * body->centerOfMass().squaredNorm();
    };
    const double start = energy();
    for (int i = 0; i < 6000; ++i) {
      world.tick();
      // leapfrog keeps  v^2 + w^2 x^2 / (1 - (w h / 2)^2)  or its reciprocal
      const double ripple = std::pow(0.5 * w / 60.0, 2) / (1.0 - std::pow(0.5 * w / 60.0, 2));
      ASSERT_NEAR(energy(), start, (1.1 * ripple + 1e-4) * start) << w << ", tick " << i;
    }
  }
}

TEST_F(SurroundingsTest, fieldsActOnTheirBodyAloneAndEndWithIt) {
  SoftBodySettings s = usualSettings();
  SoftBody* pushed = add(cubeNetwork(), s);
  s.position = {5, 0, 0};
  const SoftBody* other = add(cubeNetwork(), s);
  int calls = 0;
  const Result<std::uint64_t> field = system.addField(
      [&](const FieldPoints& p) {
        ++calls;
        EXPECT_EQ(p.count, 8u);
        EXPECT_DOUBLE_EQ(p.masses[0], 0.125);
        for (std::size_t i = 0; i < p.count; ++i) p.accelerations[3 * i] += 2.0;
      },
      pushed);
  ASSERT_TRUE(field);
  bullet.simulate(1.0);
  EXPECT_EQ(calls, 60);
  EXPECT_NEAR(pushed->linearMomentum().x(), 2.0, 1e-4);
  EXPECT_NEAR(other->linearMomentum().x(), 0.0, 1e-9);
  ASSERT_TRUE(system.destroyBody(pushed));
  EXPECT_FALSE(system.removeField(*field));
}

TEST_F(SurroundingsTest, aFieldThatIsNotFiniteIsLeftOut) {
  system.onWarning([](const std::string&) {});
  const SoftBody* body = add(cubeNetwork(), usualSettings());
  ASSERT_TRUE(system.addField([](const FieldPoints& p) { p.accelerations[4] = std::nan(""); }));
  bullet.simulate(0.5);
  EXPECT_NEAR(fallOf(*body), 0.5 * kGravity, 1e-3);
  EXPECT_EQ(body->restorations(), 30u);
}

// --- steppers ----------------------------------------------------------------------------------------------

TEST(SurroundedSteppers, haveTheSameTerminalSpeed) {
  for (const Stepper stepper : {Stepper::Verlet, Stepper::ImplicitMidpoint, Stepper::Newton}) {
    SoftWorld bullet;
    SoftBodySettings s = clothSettings(0.5);
    s.stepping.stepper = stepper;
    const SoftBody* cloth = bullet.addSoft(squareCloth(4), s);
    bullet.simulate(8.0);
    EXPECT_EQ(cloth->stepper(), stepper);
    EXPECT_NEAR(fallOf(*cloth), std::sqrt(2.0 * 0.5 * kGravity / (1.2 * 1.2)), 0.02) << int(stepper);
  }
}

// --- sleep -------------------------------------------------------------------------------------------------

TEST_F(SurroundingsTest, bodiesSleepInSteadySurroundingsAndWakeWhenTheyChange) {
  bullet.addBoxFloor();
  SoftBodySettings s = usualSettings();
  s.position = {0, 0.52, 0};
  s.flow.drag = 1.0;
  s.friction = 1.0;
  SoftBody* cube = add(closedCubeNetwork(), s);
  ASSERT_TRUE(system.addField([](const FieldPoints& p) {
    for (std::size_t i = 0; i < p.count; ++i) p.accelerations[3 * i] += 0.5;
  }));
  setWind({1, 0, 0});
  const auto settles = [&] {
    bullet.simulate(12.0);
    return cube->sleeping();
  };
  ASSERT_TRUE(settles());
  setWind({1, 0, 0});
  EXPECT_TRUE(cube->sleeping()) << "the same wind wakes nothing";
  setWind({1.1, 0, 0});
  EXPECT_FALSE(cube->sleeping());
  ASSERT_TRUE(settles());
  setWater(-1.0);
  EXPECT_FALSE(cube->sleeping());
  ASSERT_TRUE(settles());
  const Result<std::uint64_t> field = system.addField([](const FieldPoints&) {});
  EXPECT_FALSE(cube->sleeping());
  ASSERT_TRUE(settles());
  ASSERT_TRUE(system.removeField(*field));
  EXPECT_FALSE(cube->sleeping());
}

TEST_F(SurroundingsTest, aGustWakesASleepingBody) {
  bullet.addBoxFloor();
  SoftBodySettings s = usualSettings();
  s.position = {0, 0.52, 0};
  s.flow.drag = 1.0;
  SoftBody* cube = add(closedCubeNetwork(), s);
  Air air;
  air.windAt = [](const Vector3d&, double time) { return Vector3d(time > 10.0 ? 3.0 : 0.0, 0, 0); };
  ASSERT_TRUE(system.setAir(air));
  bullet.simulate(9.5);
  ASSERT_TRUE(cube->sleeping());
  bullet.simulate(1.0);
  EXPECT_FALSE(cube->sleeping());
}

// --- errors ------------------------------------------------------------------------------------------------

TEST_F(SurroundingsTest, errorsNameTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Air air;
  air.density = -1;
  EXPECT_EQ(system.setAir(air).error(), "air: density is -1, must be from 0 to 1e9");
  air.density = 1.2;
  air.wind.y() = nan;
  EXPECT_EQ(system.setAir(air).error(), "air: wind.y is nan, must be from -1e6 to 1e6");
  Water water;
  water.density = 0.0;
  EXPECT_EQ(system.setWater(water).error(), "water: density is 0, must be from 1e-15 to 1e9");
  EXPECT_EQ(system.addField(nullptr).error(), "the field is an empty function");
  EXPECT_EQ(system.removeField(7).error(), "there is no field 7");
  SoftBodySettings s = usualSettings();
  s.flow.drag = 0.5;
  s.flow.lift = 0.6;
  EXPECT_EQ(system.createBody(cubeNetwork(), s).error(),
            "settings: flow.lift is 0.6, must be from 0 to drag");
}

}  // namespace
}  // namespace limber::test
