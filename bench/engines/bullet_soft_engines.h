// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// How btSoftBody's links are as stiff as the springs they stand for.
enum class LinkStiffness : std::uint8_t {
  Full,       ///< kLST = 1, Bullet's default: as stiff as the iterations make it
  Calibrated  ///< kLST such that the iterations of a tick do what implicit Euler does to a single spring
};

/// Bullet's position-based soft body.
std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness);

/// Bullet's deformable body with btDeformableMassSpringForce. It knows two spring constants: that of the
/// body, and that of its bending springs.
std::unique_ptr<Engine> makeDeformableEngine(bool implicit);

}  // namespace limber::bench
