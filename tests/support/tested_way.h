// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_settings.h>

#include <cstdlib>
#include <string_view>

namespace limber::test {

/// The tests of tests/bullet run twice, once for each representation of a body in Bullet's world
/// (limber::Collision). The environment variable LIMBER_TESTED_WAY selects it: points, or surface (the
/// default).
inline bool testsSurfaces() {
  const char* way = std::getenv("LIMBER_TESTED_WAY");
  return !way || std::string_view(way) != "points";
}
inline const bool kSurface = testsSurfaces();

/// Returns the default settings with the selected representation, without drag: closed forms need ropes and
/// cloths that conserve energy.
inline SoftBodySettings testedSettings() {
  SoftBodySettings s;
  s.collision = kSurface ? Collision::Surface : Collision::Points;
  s.flow.drag = s.flow.linearDrag = 0.0;
  return s;
}

/// Returns the same for a body with its origin at `position` (m).
inline SoftBodySettings settingsAt(const Eigen::Vector3d& position) {
  SoftBodySettings s = testedSettings();
  s.position = position;
  return s;
}

/// Sets the stiffness (N/m) in both directions and the damping (N s/m) of all springs.
inline void setSprings(SoftBodySettings& s, double stiffness, double damping) {
  s.extensionStiffness = s.compressionStiffness = stiffness;
  s.damping = damping;
}

}  // namespace limber::test
