// SPDX-License-Identifier: Zlib
#pragma once

#include "network/material.h"

#include <Eigen/Core>

#include <array>

/// Measurements of elastic bodies, for tests and bench.
namespace limber::test {

/// Returns the stiffness (N/m) against opening, for example of an L or a horseshoe: the force between two
/// parts of the surface over the change of their distance. The parts are the points within `radius` (m) of
/// the two positions. The force is spread evenly over the area of each part, along the line between their
/// centres. 0 if either part is empty.
double openingStiffness(const ElasticBody& body, const Eigen::Vector3d& positionA,
                        const Eigen::Vector3d& positionB, double radius);

/// Returns the Young's moduli (Pa) of a body in bending, for six stresses of 1 Pa/m:
///     s_aa = x_b - centre_b
/// along each axis a, varying along each other axis b. Such a stress is in equilibrium without forces inside.
/// On a homogeneous isotropic solid of any shape it does the work
///     1/E integral of (x_b - centre_b)^2,
/// so all six moduli equal its Young's modulus. Networks are calibrated by uniform stresses; their
/// deviation here is the error of discretisation. The order of ab is xy xz yz yx zx zy. The network must have
/// a closed surface.
std::array<double, 6> measureBendingModuli(const ElasticBody& body);

}  // namespace limber::test
