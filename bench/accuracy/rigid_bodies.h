// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

enum class Floor : std::uint8_t { Plane, Box, Hull, TriangleMesh };

/// Adds a floor whose top is y = 0. btSoftBody does not collide with planes.
void addFloor(RigidBodies& rigid, btDiscreteDynamicsWorld& world, Floor floor, double friction);

/// Adds a box with this centre; with mass 0 it is static.
void addBox(RigidBodies& rigid, btDiscreteDynamicsWorld& world, const Eigen::Vector3d& halfSize, double mass,
            const Eigen::Vector3d& centre, double friction);

}  // namespace limber::bench
