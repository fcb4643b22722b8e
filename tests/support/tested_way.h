// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_settings.h>

namespace limber::test {

// The tests of tests/bullet are built twice: once for each way in which a body can live in a world.
#if defined(LIMBER_TEST_SURFACE)
constexpr Collision kTestedWay = Collision::Surface;
#else
constexpr Collision kTestedWay = Collision::Points;
#endif
constexpr bool kSurface = kTestedWay == Collision::Surface;

/// The defaults, for bodies that live in the way this program tests.
inline SoftBodySettings testedSettings() {
  SoftBodySettings s;
  s.collision = kTestedWay;
  return s;
}

}  // namespace limber::test
