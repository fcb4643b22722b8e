// SPDX-License-Identifier: Zlib
#pragma once

#include "support/bullet_measures.h"
#include "support/bullet_world.h"
#include "support/constants.h"
#include "support/networks.h"
#include "support/tested_way.h"

#include <limber/limber.h>

#include <gtest/gtest.h>

namespace limber::test {

// What the tests in worlds need: worlds, bodies and measurements.

/// A Bullet world with a system of soft bodies.
struct SoftWorld : BulletWorld {
  using BulletWorld::BulletWorld;

  /// Adds a body that must be valid.
  SoftBody* addSoft(const SharedNetwork& network, const SoftBodySettings& settings = testedSettings()) {
    const Result<SoftBody*> body = system.createBody(network, settings);
    EXPECT_TRUE(body) << (body ? "" : body.error());
    return *body;
  }

  SoftBodySystem system{*world};
};

}  // namespace limber::test
