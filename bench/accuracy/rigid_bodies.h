// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

enum class Floor : std::uint8_t { Plane, Box, Hull, TriangleMesh };

/// A floor whose top is y = 0. btSoftBody does not see planes.
void addFloor(RigidBodies& rigid, btDiscreteDynamicsWorld& world, Floor floor, double friction);

/// A box with its centre there; mass 0: it does not move.
void addBox(RigidBodies& rigid, btDiscreteDynamicsWorld& world, const Eigen::Vector3d& halfSize, double mass,
            const Eigen::Vector3d& centre, double friction);

}  // namespace limber::bench
