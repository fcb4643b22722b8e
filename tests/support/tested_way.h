// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_settings.h>

#include <cstdlib>
#include <string_view>

namespace limber::test {

/// The tests of tests/bullet run twice: once for each way in which a body can live in a world, named by the
/// environment variable LIMBER_TESTED_WAY: points, or surface as without it.
inline bool testsSurfaces() {
  const char* way = std::getenv("LIMBER_TESTED_WAY");
  return !way || std::string_view(way) != "points";
}
inline const bool kSurface = testsSurfaces();

/// The defaults, for bodies that live in the way this program tests.
inline SoftBodySettings testedSettings() {
  SoftBodySettings s;
  s.collision = kSurface ? Collision::Surface : Collision::Points;
  return s;
}

}  // namespace limber::test
