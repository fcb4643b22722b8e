// SPDX-License-Identifier: Zlib
#pragma once

#include "network/material.h"

#include <Eigen/Core>

/// Measurements of elastic bodies, for tests and bench.
namespace limber::test {

/// Returns the stiffness (N/m) against opening, for example of an L or a horseshoe: the force between two
/// parts of the surface over the change of their distance. The parts are the points within `radius` (m) of
/// the two positions. The force is spread evenly over the area of each part, along the line between their
/// centres. 0 if either part is empty.
double openingStiffness(const ElasticBody& body, const Eigen::Vector3d& positionA,
                        const Eigen::Vector3d& positionB, double radius);

/// Returns a closed box of this size (m) around the origin, 12 triangles.
TriangleMesh boxMesh(const Eigen::Vector3d& size);

/// Young's moduli (Pa) that a beam of a material with Poisson ratio 1/4 would have by its measured response.
struct BeamModuli {
  double tension = 0.0;
  double bending = 0.0;  ///< mean of the two directions
  double torsion = 0.0;
};

/// Measures a beam of square section along x, centred at the origin: its middle half, where the response does
/// not depend on how the ends are loaded (Saint-Venant). The ends are pulled by a uniform stress, bent by one
/// that is linear across the section, and twisted by shear stresses that are linear in the section. Beam
/// theory: strain F / (E a^2), curvature 12 M / (E a^4), twist per length T / (G 0.1406 a^4) with
/// G = E / 2.5 (S. Timoshenko, J. Goodier, "Theory of Elasticity", section 109).
BeamModuli measureBeam(const ElasticBody& body);

}  // namespace limber::test
