// SPDX-License-Identifier: Zlib
// Contacts of points with static surfaces.
#include "solver/plane_contacts.h"

#include <gtest/gtest.h>

namespace limber {
namespace {

/// A force gives a resting point a high approach speed within a substep. Rounding must not turn this into an
/// impact.
TEST(Bounce, whatIsPressedOnFromRestRests) {
  const double approach = 3.5, restitution = 0.5, slow = 0.02, dt = 2e-3;  // m/s, s
  for (const double gap : {-1e-17, 0.0, 1e-17})
    for (const double before : {-1e-17, 0.0, 1e-17})
      EXPECT_TRUE(bounceOf(gap, approach, before, restitution, slow, dt).rests) << gap << ", " << before;
}

TEST(Bounce, whatComesFastParts) {
  const double speed = 3.5, restitution = 0.5;
  const Bounce bounce = bounceOf(0.0, speed, speed, restitution, 0.02, 2e-3);
  EXPECT_FALSE(bounce.rests);
  EXPECT_NEAR(bounce.mean, restitution * speed, 1e-12);
}

}  // namespace
}  // namespace limber
