// SPDX-License-Identifier: Zlib
#pragma once

#include "core/point_state.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <vector>

namespace limber {

/// The volume term of a body of tetrahedra. Each has the energy  K/2 (V - V0)^2 / V0  of its signed volume V,
/// which adds K to the first Lame constant of the material and nothing to its shear modulus, and, when it is
/// crushed to less than kCrushed of its volume or turned over,  G/2 (kCrushed V0 - V)^2 / V0  besides:
/// springs alone are at rest in a tetrahedron that is inside out. The changes that push are limited as in
/// volume_kernel.h.
struct TetrahedronVolumes {
  std::vector<Tetrahedron> tetrahedra;  ///< oriented as at the body's scale
  std::vector<double> restVolume;       ///< #tetrahedra, m^3, above 0
  double modulus = 0.0;                 ///< Pa, K
  double crushModulus = 0.0;            ///< Pa, G: Young's modulus of the springs together

  bool empty() const { return tetrahedra.empty(); }
};

/// Share of its volume below which a tetrahedron counts as crushed: no part of common deformations.
constexpr double kCrushed = 0.3;

/// Of a body with these settings; empty if the network has no tetrahedra. A negative volumeModulus stands for
/// that of the springs together, 0 for none beside the push against crushing.
TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Adds to `state.force`. The forces of a tetrahedron sum to zero and have no torque.
void addTetrahedronForces(const TetrahedronVolumes& volumes, PointState& state);

/// J.
double tetrahedronEnergy(const TetrahedronVolumes& volumes, const Points& position);

/// rad^2/s^2 that the volume term can add to the square of the body's fastest oscillation, at these
/// positions.
///
/// The Hessian of a tetrahedron's energy is  s g g^T - p H  with its stiffness s and push p, the gradient g
/// and the second derivatives H of its volume, whose 3 x 3 blocks are cross products with a sixth of the edge
/// that two corners do not have. Row sums of block norms, times inverse masses, bound the eigenvalues:
///     max over points i of  w_i sum over its tetrahedra ( s |g_i| sum_j |g_j|  +  |p| sum of edges / 6 ),
/// the edges being those of the face opposite to i. `rowSums` is scratch, resized to #points.
double tetrahedronFrequencyBoundSquared(const TetrahedronVolumes& volumes, const PointState& state,
                                        std::vector<double>& rowSums);

}  // namespace limber
