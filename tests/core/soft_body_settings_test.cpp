// SPDX-License-Identifier: Zlib
#include <limber/soft_body_settings.h>

#include "support/networks.h"

#include <gtest/gtest.h>

#include <cmath>

namespace limber {
namespace {

TEST(SoftBodySettings, defaultsAndThePapersAreValid) {
  EXPECT_EQ(validate(SoftBodySettings()).error(), "");
  const SoftBodySettings paper = SoftBodySettings::paper();
  EXPECT_EQ(validate(paper).error(), "");
  EXPECT_EQ(paper.extensionStiffness, 20.0);
  EXPECT_EQ(paper.compressionStiffness, 20.0);
  EXPECT_EQ(paper.damping, 0.2);
  SoftBodySettings fast;
  fast.stepping = Stepping::fast();
  EXPECT_EQ(validate(fast).error(), "");
}

/// The bounds that the comments of the fields promise.
TEST(SoftBodySettings, areAcceptedBetweenTheirBounds) {
  using Settings = SoftBodySettings;
  const auto expectBounds = [](auto field, double low, double high) {
    Settings s;
    for (const double inside : {low, high}) {
      field(s) = inside;
      EXPECT_TRUE(validate(s)) << validate(s).error();
    }
    for (const double outside : {low - 1e-12, std::nextafter(high, 1e300)}) {
      field(s) = outside;
      EXPECT_FALSE(validate(s)) << low << " to " << high;
    }
  };
  for (auto field : {&Settings::extensionStiffness, &Settings::compressionStiffness, &Settings::damping,
                     &Settings::pressure, &Settings::ambientPressure})
    expectBounds([&](Settings& s) -> double& { return s.*field; }, 0, 1e12);
  for (auto field : {&Settings::friction, &Settings::sleepingSpeed})
    expectBounds([&](Settings& s) -> double& { return s.*field; }, 0, 1e6);
  for (auto field : {&Stepping::tolerance, &Stepping::relativeTolerance})
    expectBounds([&](Settings& s) -> double& { return s.stepping.*field; }, 0, 1e6);
  for (auto field : {&ElasticLimit::stiffenStrain, &ElasticLimit::yieldStrain, &ElasticLimit::breakStrain})
    expectBounds([&](Settings& s) -> double& { return s.elasticLimit.*field; }, 0, 1e6);
  expectBounds([](Settings& s) -> double& { return s.elasticLimit.stiffenFactor; }, 1, 1e6);
  expectBounds([](Settings& s) -> double& { return s.elasticLimit.yieldMaximum; }, 0, 0.999);
  expectBounds([](Settings& s) -> double& { return s.stepping.periodTolerance; }, 1e-8, 1);
  expectBounds([](Settings& s) -> double& { return s.stepping.searchDistance; }, 0.01, 0.25);
  expectBounds([](Settings& s) -> double& { return s.totalMass; }, 1e-9, 1e12);
  expectBounds([](Settings& s) -> double& { return s.restitution; }, 0, 1);
  expectBounds([](Settings& s) -> double& { return s.volumeModulus.emplace(); }, 0, 1e15);
  expectBounds([](Settings& s) -> double& { return s.pointRadius.emplace(); }, 1e-9, 1e4);
}

template <class Change>
std::string reasonAfter(Change change) {
  SoftBodySettings s;
  change(s);
  return validate(s).error();
}

TEST(SoftBodySettings, everyBadOneIsNamedWithItsValueAndRule) {
  EXPECT_EQ(reasonAfter([](auto& s) { s.scale.y() = 0; }), "scale.y is 0, must be other than 0");
  EXPECT_EQ(reasonAfter([](auto& s) { s.position.x() = std::nan(""); }), "position.x is nan, must be finite");
  EXPECT_EQ(reasonAfter([](auto& s) { s.linearVelocity.z() = INFINITY; }),
            "linearVelocity.z is inf, must be finite");
  EXPECT_EQ(reasonAfter([](auto& s) { s.rotation = Eigen::Quaterniond(2, 0, 0, 0); }),
            "length of rotation is 2, must be 1");
  EXPECT_EQ(reasonAfter([](auto& s) { s.extensionStiffness = -1; }),
            "extensionStiffness is -1, must be from 0 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.compressionStiffness = std::nan(""); }),
            "compressionStiffness is nan, must be from 0 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.damping = -0.5; }), "damping is -0.5, must be from 0 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.totalMass = 0; }), "totalMass is 0, must be from 1e-9 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.pointRadius = -1; }), "pointRadius is -1, must be from 1e-9 to 1e4");
  EXPECT_EQ(reasonAfter([](auto& s) { s.restitution = 1.5; }), "restitution is 1.5, must be from 0 to 1");
  EXPECT_EQ(reasonAfter([](auto& s) { s.stepping.minSubsteps = 0; }),
            "stepping.minSubsteps is 0, must be from 1 to 10000");
  EXPECT_EQ(reasonAfter([](auto& s) { s.stepping.periodTolerance = 0; }),
            "stepping.periodTolerance is 0, must be from 1e-8 to 1");
  EXPECT_EQ(reasonAfter([](auto& s) { s.stepping.stepper = static_cast<Stepper>(9); }),
            "stepping.stepper is 9, must be one of Stepper's");
  EXPECT_EQ(reasonAfter([](auto& s) { s.collision = static_cast<Collision>(7); }),
            "collision is 7, must be one of Collision's");
}

TEST(SoftBodySettings, whatIsBeyondABoundIsNamed) {
  EXPECT_EQ(reasonAfter([](auto& s) { s.totalMass = 1e-40; }),
            "totalMass is 1e-40, must be from 1e-9 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.totalMass = 1.1e12; }),
            "totalMass is 1.1e+12, must be from 1e-9 to 1e12");
  EXPECT_EQ(reasonAfter([](auto& s) { s.position.y() = 1.1e6; }),
            "position.y is 1.1e+06, must be from -1e6 to 1e6");
  EXPECT_EQ(reasonAfter([](auto& s) { s.linearVelocity.x() = 1e200; }),
            "linearVelocity.x is 1e+200, must be from -1e5 to 1e5");
  EXPECT_EQ(reasonAfter([](auto& s) { s.angularVelocity.z() = -1.1e5; }),
            "angularVelocity.z is -110000, must be from -1e5 to 1e5");
  EXPECT_EQ(reasonAfter([](auto& s) { s.scale.x() = 1001.0; }),
            "largest over smallest axis of scale is 1001, must be at most 1000");
  EXPECT_EQ(reasonAfter([](auto& s) { s.stepping.maxSubsteps = 10001; }),
            "stepping.maxSubsteps is 10001, must be from 0 to 10000");
}

TEST(SoftBodySettings, negativeScaleMirrorsAndIsAllowed) {
  EXPECT_EQ(reasonAfter([](auto& s) { s.scale = {-1, 2, 0.5}; }), "");
}

TEST(SoftBodySettings, pointRadiusFollowsTheShortestSpringAndTheScale) {
  SoftBodySettings s;
  EXPECT_DOUBLE_EQ(pointRadius(*test::cubeNetwork(), s), 0.02);
  s.scale = {1, -0.1, 1};
  EXPECT_DOUBLE_EQ(pointRadius(*test::cubeNetwork(), s), 0.002);
  s.pointRadius = 0.3;
  EXPECT_EQ(pointRadius(*test::cubeNetwork(), s), 0.3);
}

TEST(SpringSettings, badOnesAreNamed) {
  SpringSettings s;
  EXPECT_EQ(validate(s).error(), "");
  s.damping = -1;
  EXPECT_EQ(validate(s).error(), "damping is -1, must be from 0 to 1e12");
  s = SpringSettings();
  s.action = static_cast<SpringAction>(3);
  EXPECT_EQ(validate(s).error(), "action is 3, must be one of SpringAction's");
}

}  // namespace
}  // namespace limber
