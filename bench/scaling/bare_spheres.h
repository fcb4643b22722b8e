// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <memory>
#include <vector>

namespace limber::bench {

/// Loose spheres over a floor: what Bullet itself asks for so many bodies.
struct BareSpheres {
  // the world comes last, so that it goes first, while what is in it still exists
  std::unique_ptr<btSphereShape> shape;
  std::vector<std::unique_ptr<btRigidBody>> spheres;
  scenes::SceneWorld world;
};

/// A sphere of the same radius, mass and friction for each point mass of a scene of like bodies, where that
/// point is, over the same floor. Nothing holds the upper ones up, so all of them come to lie on the floor.
std::unique_ptr<BareSpheres> makeBareSpheres(const scenes::Scene& scene);

/// Of all positions and velocities, bit for bit.
std::uint64_t stateHash(const BareSpheres& bare);

}  // namespace limber::bench
