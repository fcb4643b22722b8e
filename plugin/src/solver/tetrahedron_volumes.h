// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/tetrahedron_kernel.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <vector>

namespace limber {

/// The volume term of a body of tetrahedra. Each has the energy  K/2 (V - V0)^2 / V0  of its signed volume V,
/// which adds K to the first Lame constant of the material and nothing to its shear modulus, and, when it is
/// crushed to less than kCrushed of its volume or turned over,  G/2 (kCrushed V0 - V)^2 / V0  besides:
/// springs alone are at rest in a tetrahedron that is inside out. The changes that push are limited as in
/// volume_kernel.h.
///
/// Along its gradient g a tetrahedron oscillates with at most  omega^2 = (K + G)/V0 w sum |g|^2, w the
/// largest of its corners' inverse masses, which has no bound while the body is torn apart. Beyond omega^2
/// dt^2 = kLargestCornerPhaseSquared the push is divided by what it is too large: `hold` is (K + G) w dt^2 /
/// (36 V0 kLargestCornerPhaseSquared), for 36 |g|^2.
struct TetrahedronVolumes {
  std::vector<Tetrahedron> tetrahedra;  ///< oriented as at the body's scale
  std::vector<double> restVolume;       ///< #tetrahedra, m^3, above 0
  std::vector<double> inverseRest;      ///< #tetrahedra, 1/m^3: 1 / (6 restVolume)
  Eigen::Array4Xd restGradientSquares;  ///< 4 x #tetrahedra, m^4, of the volume by the corners
  std::vector<double> crowd;            ///< #tetrahedra, n: most tetrahedra around one of its corners
  std::vector<double> hold;             ///< #tetrahedra, 1/m^4, set by prepareTetrahedra
  double modulus = 0.0;                 ///< Pa, K
  double crushModulus = 0.0;            ///< Pa, G: Young's modulus of the springs together
  bool edgesAreSprings = false;         ///< all of them
  bool restless = false;                ///< far from rest, as of tetrahedronFrequencyBoundSquared

  std::vector<double> rowSums;  ///< #points, scratch

  bool empty() const { return tetrahedra.empty(); }
};

/// Below Verlet's limit of 4, and above what bodies in their shape come to even at half that limit.
constexpr double kLargestCornerPhaseSquared = 2.5;

/// Of a body with these settings; empty if the network has no tetrahedra. A negative volumeModulus stands for
/// that of the springs together, 0 for none beside the push against crushing.
TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Sets `hold` for substeps of dt seconds that must be stable; for 0 nothing is held back.
void prepareTetrahedra(TetrahedronVolumes& volumes, const Points& inverseMass, double dt);

/// Whether that of some tetrahedron holds its push back at these positions.
bool isHeldBack(TetrahedronVolumes& volumes, const PointState& state, double dt);

kernel::Tetrahedra<double> kernelTetrahedra(const TetrahedronVolumes& volumes);

/// Adds to `state.force`. The forces of a tetrahedron sum to zero and have no torque.
void addTetrahedronForces(const TetrahedronVolumes& volumes, PointState& state);

/// J.
double tetrahedronEnergy(const TetrahedronVolumes& volumes, const Points& position);

/// A tetrahedron as a spring whose length is its volume.
struct TetrahedronSlope {
  Eigen::Matrix<double, 3, 4> gradient;  ///< m^2, of the volume by its corners
  double stiffness;                      ///< Pa/m^3, 0 where the push no longer grows
};

TetrahedronSlope tetrahedronSlope(const TetrahedronVolumes& volumes, std::size_t tetrahedron,
                                  const Points& position);

/// rad^2/s^2 that the volume term can add to the square of the body's fastest oscillation, at these
/// positions. Sets `restless`, also where it may come far from rest in a tick of so many seconds.
///
/// The Hessian of a tetrahedron's energy is  s g g^T - p H  with its stiffness s and push p, the gradient g
/// and the second derivatives H of its volume, whose 3 x 3 blocks are cross products with a sixth of the edge
/// that two corners do not have. Row sums of block norms, times inverse masses, bound the eigenvalues:
///     max over points i of  w_i sum over its tetrahedra ( s |g_i| sum_j |g_j|  +  |p| sum of edges / 6 ),
/// the edges being those of the face opposite to i.
double tetrahedronFrequencyBoundSquared(TetrahedronVolumes& volumes, const PointState& state, double tick = 0.0);

}  // namespace limber
