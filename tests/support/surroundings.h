// SPDX-License-Identifier: Zlib
#pragma once

#include "support/bullet_world.h"
#include "support/tested_way.h"

#include <limber/limber.h>

#include <gtest/gtest.h>

namespace limber::test {

/// With the default drag.
inline SoftBodySettings usualSettings() {
  SoftBodySettings s = test::testedSettings();
  s.flow = FlowCoefficients();
  return s;
}

inline SoftBodySettings stiffSolid(double mass) {
  SoftBodySettings s = usualSettings();
  s.extensionStiffness = s.compressionStiffness = 1e4 * mass;
  s.damping = 20.0 * mass;
  s.totalMass = mass;
  return s;
}

/// A world for bodies in air, water and fields.
struct SurroundingsTest : testing::Test {
  SoftBody* add(const SharedNetwork& network, const SoftBodySettings& s) {
    const Result<SoftBody*> body = system.createBody(network, s);
    EXPECT_TRUE(body) << (body ? "" : body.error());
    return *body;
  }
  void setWind(const Eigen::Vector3d& wind, double density = 1.2) {
    Air air;
    air.wind = wind;
    air.density = density;
    ASSERT_TRUE(system.setAir(air));
  }
  Water setWater(double level) {
    Water water;
    water.level = level;
    EXPECT_TRUE(system.setWater(water));
    return water;
  }

  BulletWorld bullet;
  SoftBodySystem system{*bullet.world};
};

inline double heightOf(const SoftBody& body) { return body.centerOfMass().y(); }
inline double fallOf(const SoftBody& body) { return -body.linearMomentum().y() / body.totalMass(); }

}  // namespace limber::test
