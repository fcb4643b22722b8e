// SPDX-License-Identifier: Zlib
#pragma once

// The volume terms of a body: of its closed surfaces, and of its tetrahedra.

#include "solver/point_state.h"
#include "solver/shared_constants.h"
#include "solver/verlet_kernel.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <string>
#include <vector>

namespace limber {

/// m, 3 x #points.
Points scaledRest(const SpringNetwork& network, const Eigen::Vector3d& scale);

// --- closed surfaces ---------------------------------------------------------------------------------------

/// What volumeFrequencyBoundSquared found for a shape, see keptVolumeBoundSquared().
struct KeptVolumeBound {
  Points shape;        ///< 3 x #points, m
  double value = 0.0;  ///< rad^2/s^2; 0: nothing is kept
};

/// The constants of closed surfaces, each with the energy  K/2 (V - V0)^2 / V0  of its signed volume, which
/// also tells a body from its mirror image, and the pressure of the gas in it.
struct VolumeConstants {
  std::vector<Triangle> triangles;           ///< of all components, one component after the other
  std::vector<std::uint32_t> firstTriangle;  ///< #components + 1
  std::vector<std::uint32_t> componentOf;    ///< #points; 0 for points of none
  std::vector<double> restVolume;            ///< #components, m^3, above 0
  double modulus = 0.0;                      ///< Pa, K
  double pressure = 0.0;                     ///< Pa above the outside at rest; P V0 / V at volume V
  double shortestEdge = 0.0;                 ///< m, at rest
};

/// The closed surfaces of one body. `->` leads to their constants. Empty: no volume term.
struct VolumeArrays {
  SharedConstants<VolumeConstants> constants;
  double timeStep = 0.0;        ///< s, of Verlet's substep; 0: of an implicit stepper
  bool farFromRest = false;     ///< in this tick some volume is, or may come, far from that at rest
  Points gradient;              ///< 3 x #points, scratch
  std::vector<double> sums;     ///< 4 x #components, scratch
  std::vector<double> rowSums;  ///< #points, scratch
  KeptVolumeBound kept;

  const VolumeConstants* operator->() const { return &*constants; }
  bool empty() const { return constants->restVolume.empty(); }
};

/// Pa: the Young's modulus of a network of springs with the constant `stiffness` (N/m) that fills `volume`
/// (m^3) evenly in all directions,  sum k L^2 / (6 V)  (Cauchy-Born).
double networkModulus(const SpringNetwork& network, const Eigen::Vector3d& scale, double stiffness,
                      double volume);

/// Why the settings' volume modulus or pressure cannot be had with this network, or an empty string.
std::string checkVolume(const SpringNetwork& network, const SoftBodySettings& settings);

/// The volume term of a body with these settings, of each component of its surface that is closed; empty if
/// there is none or the settings ask for none.
VolumeArrays makeVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// As kernel::addVolumeForces takes it.
kernel::Volumes<double> kernelVolumes(VolumeArrays& volumes);

/// Adds to `state.force`. The forces of a component sum to zero and have no torque.
void addVolumeForces(VolumeArrays& volumes, PointState& state);

/// Whether the push of some component is held back in substeps of dt seconds, see kernel::stablePush.
bool isHeldBack(VolumeArrays& volumes, const PointState& state, double dt);

/// J.
double volumeEnergy(const VolumeArrays& volumes, const Points& position);

/// m^3, signed, of all components together.
double enclosedVolume(const VolumeArrays& volumes, const Points& position);

/// rad^2/s^2 that the volume term can add to the square of a body's fastest oscillation in the coming tick.
///
/// The Hessian of its energy is  K/V0 g g^T - push H,  g the gradient of the volume and H its second
/// derivatives. The first has one eigenvalue,  K/V0 sum w |g|^2  (with the masses); the second's are at most
/// the largest row sum of block norms: triangles that meet at an edge have a block of a sixth of the distance
/// of their third corners, so a triangle gives each corner at most a third of its longest edge. Edges are as
/// long as their ends make them that fly on as they do, and the push is as large as a body becomes that grows
/// by as much.
/// Sets volumes.restless. With `slack` (m) it also holds for each shape whose points are no farther than that
/// from where they are.
double volumeFrequencyBoundSquared(VolumeArrays& volumes, const PointState& state, double tick,
                                   double slack = 0.0);

/// Of a component: its volume, the gradient of that (3 x #points, m^2, 0 for held points and those of
/// others), and how fast its push falls with the volume (Pa/m^3), 0 where that has reached its limit.
struct VolumeSlope {
  double volume, stiffness;
};
VolumeSlope volumeSlope(const VolumeArrays& volumes, std::size_t component, const PointState& state,
                        Points& gradient);

/// Whether some component is so far from its rest volume that the curvature of its volume matters.
bool isFarFromRest(const VolumeArrays& volumes, const Points& position);

/// As volumeFrequencyBoundSquared(), which costs about as much as a substep: its last value for as long as
/// the body keeps its shape, for which that was made a little larger. `kept.value` has to be set to 0 when
/// masses change.
double keptVolumeBoundSquared(VolumeArrays& volumes, const PointState& state, double tick);

// --- tetrahedra --------------------------------------------------------------------------------------------

/// The constants of the volume term of a body of tetrahedra. Each has the energy  K/2 (V - V0)^2 / V0  of its
/// signed volume V, which adds K to the first Lame constant of the material and nothing to its shear modulus,
/// and, when it is crushed to less than kCrushed of its volume or turned over,  G/2 (kCrushed V0 - V)^2 / V0
/// besides: springs alone are at rest in a tetrahedron that is inside out. The changes that push are limited
/// as in verlet_kernel.h.
///
/// Along its gradient g a tetrahedron oscillates with at most  omega^2 = (K + G)/V0 w sum |g|^2, w the
/// largest of its corners' inverse masses, which has no bound while the body is torn apart. Beyond omega^2
/// dt^2 = kLargestCornerPhaseSquared the force is scaled down to the largest stable one: `stabilityScale` is
/// (K + G) w dt^2 / (36 V0 kLargestCornerPhaseSquared), for 36 |g|^2.
struct TetrahedronConstants {
  std::vector<Tetrahedron> tetrahedra;  ///< oriented as at the body's scale
  std::vector<double> restVolume;       ///< #tetrahedra, m^3, above 0
  std::vector<double> inverseRest;      ///< #tetrahedra, 1/m^3: 1 / (6 restVolume)
  Eigen::Array4Xd restGradientSquares;  ///< 4 x #tetrahedra, m^4, of the volume by the corners
  std::vector<double> valence;          ///< #tetrahedra, n: most tetrahedra around one of its corners
  double modulus = 0.0;                 ///< Pa, K
  double crushModulus = 0.0;            ///< Pa, G: Young's modulus of the springs together
  bool edgesAreSprings = false;         ///< all of them
};

/// The tetrahedra of one body. `->` leads to their constants. Empty: no volume term.
struct TetrahedronVolumes {
  SharedConstants<TetrahedronConstants> constants;
  std::vector<double> stabilityScale;  ///< #tetrahedra, 1/m^4, set by prepareTetrahedra
  bool farFromRest = false;            ///< far from rest, as of tetrahedronFrequencyBoundSquared
  std::vector<double> rowSums;         ///< #points, scratch

  const TetrahedronConstants* operator->() const { return &*constants; }
  bool empty() const { return constants->tetrahedra.empty(); }
};

/// Below Verlet's limit of 4, and above what bodies in their shape come to even at half that limit.
constexpr double kLargestCornerPhaseSquared = 2.5;

/// Of a body with these settings; empty if the network has no tetrahedra. Without a volumeModulus it is that
/// of the springs together, 0 for none beside the push against crushing.
TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Sets `stabilityScale` for substeps of dt seconds that must be stable; for 0 nothing is held back.
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
/// positions. Sets `farFromRest`, also where it may come far from rest in a tick of so many seconds.
///
/// The Hessian of a tetrahedron's energy is  s g g^T - p H  with its stiffness s and push p, the gradient g
/// and the second derivatives H of its volume, whose 3 x 3 blocks are cross products with a sixth of the edge
/// that two corners do not have. Row sums of block norms, times inverse masses, bound the eigenvalues:
///     max over points i of  w_i sum over its tetrahedra ( s |g_i| sum_j |g_j|  +  |p| sum of edges / 6 ),
/// the edges being those of the face opposite to i.
double tetrahedronFrequencyBoundSquared(TetrahedronVolumes& volumes, const PointState& state,
                                        double tick = 0.0);

}  // namespace limber
