// SPDX-License-Identifier: Zlib
#pragma once

// The volume terms of a body: for its closed surfaces and for its tetrahedra.

#include "solver/springs.h"

#include <string>
#include <vector>

namespace limber {

/// Returns the rest points times the scale (m, 3 x #points).
Points scaledRest(const SpringNetwork& network, const Eigen::Vector3d& scale);

// --- closed surfaces ---------------------------------------------------------------------------------------

/// A result of volumeFrequencyBoundSquared() and its shape, see keptVolumeBoundSquared().
struct KeptVolumeBound {
  Points shape;        ///< 3 x #points, m
  double value = 0.0;  ///< rad^2/s^2; 0: not valid
};

/// The constants of closed surfaces and of the gas in them. Each surface has the energy  K/2 (V - V0)^2 / V0
/// and that of its gas at constant temperature,  -P V0 ln(V / V0) + A (V - V0).  Its volume V is signed,
/// which distinguishes a body from its mirror image.
struct VolumeConstants {
  std::vector<Triangle> triangles;           ///< of all components, one component after the other
  std::vector<std::uint32_t> firstTriangle;  ///< #components + 1
  std::vector<std::uint32_t> componentOf;    ///< #points; 0 for points of no component
  std::vector<double> restVolume;            ///< #components, m^3, above 0
  double modulus = 0.0;                      ///< Pa, K
  double gasPressure = 0.0;                  ///< Pa, P at the rest volume; it is P V0 / V at volume V
  double ambient = 0.0;                      ///< Pa, A, the outside's; less than P in a balloon
  double shortestEdge = 0.0;                 ///< m, at rest
};

/// The closed surfaces of one body. `->` accesses their constants. Empty: no volume term.
struct VolumeArrays {
  SharedConstants<VolumeConstants> constants;
  double timeStep = 0.0;        ///< s, Verlet's substep; 0 for an implicit stepper
  bool farFromRest = false;     ///< some volume is, or may become in this tick, far from its rest volume
  Points gradient;              ///< 3 x #points, scratch
  std::vector<double> sums;     ///< 4 x #components, scratch
  std::vector<double> rowSums;  ///< #points, scratch
  KeptVolumeBound kept;

  const VolumeConstants* operator->() const { return &*constants; }
  bool empty() const { return constants->restVolume.empty(); }
};

/// Returns the Young's modulus (Pa) of an isotropic network that fills `volume` (m^3) evenly:
/// sum k L^2 / (6 V)  (Cauchy-Born). `stiffness` (N/m) is the constant of its springs.
double networkModulus(const SpringNetwork& network, const Eigen::Vector3d& scale, double stiffness,
                      double volume);

/// Returns the reason why the settings' volume modulus or pressure is impossible with this network, or an
/// empty string.
std::string checkVolume(const SpringNetwork& network, const SoftBodySettings& settings);

/// Returns the closed surfaces of a solid, also of one of tetrahedra, without modulus and gas. Components
/// that enclose almost nothing are left out.
VolumeConstants closedSurfaces(const SpringNetwork& network, const Points& rest);

/// Makes the volume term of a body with these settings: for each closed component of its surface. The result
/// is empty if there is no such component, or if volumeModulus and pressure are 0.
VolumeArrays makeVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Returns the argument of kernel::addVolumeForces().
kernel::Volumes<double> kernelVolumes(VolumeArrays& volumes);

/// Adds the forces to `state.force`. The forces of a component sum to zero and have no torque.
void addVolumeForces(VolumeArrays& volumes, PointState& state);

/// Whether the force of some component is scaled down in substeps of dt seconds, see kernel::stablePush().
bool isHeldBack(VolumeArrays& volumes, const PointState& state, double dt);

/// Returns the energy (J) of the volume term.
double volumeEnergy(const VolumeArrays& volumes, const Points& position);

/// Returns an upper bound (rad^2/s^2) of the volume term's contribution to the square of the body's highest
/// angular frequency in the coming tick.
///
/// The Hessian of the energy is  K/V0 g g^T - push H,  with the gradient g of the volume and its second
/// derivatives H. The first term has one eigenvalue,  K/V0 sum w |g|^2  (with the masses). The eigenvalues of
/// the second term are at most the largest row sum of block norms. Two triangles with a common edge have a
/// block of a sixth of the distance of their third corners, so a triangle adds to each of its corners at most
/// a third of its longest edge. The bound assumes that the points keep their velocities during the tick:
/// edges grow accordingly, and so does the volume, which determines the push.
/// Sets volumes.farFromRest. With `slack` (m) the bound also holds for shapes whose points are at most
/// `slack` from the present positions.
double volumeFrequencyBoundSquared(VolumeArrays& volumes, const PointState& state, double tick,
                                   double slack = 0.0);

/// The volume of a component (m^3), and the decrease of its push per increase of the volume (Pa/m^3). A part
/// of the push that has reached its limit does not count.
struct VolumeSlope {
  double volume, stiffness;
};
/// Computes the slope of a component. Sets `gradient` to the gradient of its volume (3 x #points, m^2, 0 for
/// held points and those of other components).
VolumeSlope volumeSlope(const VolumeArrays& volumes, std::size_t component, const PointState& state,
                        Points& gradient);

/// Whether the volume of some component is so far from rest that its second derivatives matter.
bool isFarFromRest(const VolumeArrays& volumes, const Points& position);

/// Returns the last result of volumeFrequencyBoundSquared() while the body keeps its shape; otherwise
/// computes it again, with some slack. That function costs about as much as a substep. Set `kept.value` to 0
/// when masses change.
double keptVolumeBoundSquared(VolumeArrays& volumes, const PointState& state, double tick);

// --- tetrahedra --------------------------------------------------------------------------------------------

/// The constants of the volume term of a body of tetrahedra. Each tetrahedron has the energy
/// K/2 (V - V0)^2 / V0  of its signed volume V, which adds K to the first Lame constant of the material and
/// nothing to its shear modulus. Its push is limited at kLargestCompression. A tetrahedron that is crushed to
/// less than kCrushed of its volume, or inverted, also has the energy  C/2 (kCrushed V0 - V)^2 / V0,  because
/// springs alone are at rest in an inverted tetrahedron. The volume changes that cause the push are limited
/// as in verlet_kernel.h. C is the Young's modulus G of all springs together where K is 0. It falls to half
/// of that for K >= G, whose push helps to turn a tetrahedron over: the less push, the fewer tangled limbs
/// are held in their tangle.
///
/// All tetrahedra together oscillate along their gradients g with at most
///     omega^2 = max over tetrahedra of  s sum over corners of  w m |g|^2,
/// where s is a stiffness over V0, w the inverse mass of a corner, and m the largest eigenvalue of  sum e e^T
/// over the tetrahedra at the corner, with the unit vectors e = g / |g|: |sum of forces f e|^2 <= m sum f^2.
/// With max(K, C) as stiffness this has no bound while the body is torn apart. Where omega^2 dt^2 then
/// exceeds kLargestCornerPhaseSquared, the force is scaled down to the largest stable one: `stabilityScale`
/// is mobility max(K, C) dt^2 / (36 V0 kLargestCornerPhaseSquared),  to be multiplied by 36 sum |g|^2.
struct TetrahedronConstants {
  Division division;                    ///< #tetrahedra
  std::vector<Tetrahedron> tetrahedra;  ///< in its order, oriented for the body's scale
  std::vector<double> restVolume;       ///< #tetrahedra, m^3, above 0
  std::vector<double> inverseRest;      ///< #tetrahedra, 1/m^3: 1 / (6 restVolume)
  Eigen::Array4Xd restGradientSquares;  ///< 4 x #tetrahedra, m^4, |dV / d corner|^2
  double modulus = 0.0;                 ///< Pa, K
  double crushModulus = 0.0;            ///< Pa, C
  bool edgesAreSprings = false;         ///< whether a spring runs along every edge
};

/// Memory of tetrahedronFrequencyBoundSquared().
struct TetrahedronScratch {
  Eigen::Array4Xd squares;                  ///< 4 x #tetrahedra, m^4, |g|^2
  std::vector<double> stiffness;            ///< #tetrahedra, s, Pa/m^3
  std::vector<Eigen::Matrix3d> directions;  ///< #points, sum of e e^T
  std::vector<double> rates;                ///< #points, w m, 1/kg
  std::vector<double> rowSums;              ///< #points, N/m, of the second derivatives
};

/// The tetrahedra of one body. `->` accesses their constants. Empty: no volume term.
struct TetrahedronVolumes {
  SharedConstants<TetrahedronConstants> constants;
  std::vector<double> stabilityScale;  ///< #tetrahedra, 1/m^4, set by prepareTetrahedra
  /// #tetrahedra, 1/kg, the mean of w m of the corners weighted by |g|^2; this and the next are set by
  /// tetrahedronFrequencyBoundSquared()
  std::vector<double> mobility;
  bool farFromRest = false;
  TetrahedronScratch scratch;

  const TetrahedronConstants* operator->() const { return &*constants; }
  bool empty() const { return constants->tetrahedra.empty(); }
};

/// Largest omega^2 dt^2 of tetrahedra. It is below Verlet's limit of 4, and above the values of bodies in the
/// substeps that substepCount() chooses for them.
constexpr double kLargestCornerPhaseSquared = 2.5;

/// Makes the volume term of a body with these settings; empty if the network has no tetrahedra. The default
/// of volumeModulus is the Young's modulus of all springs together. With 0 only crushing is resisted.
TetrahedronVolumes makeTetrahedronVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Sets `stabilityScale` for stable substeps of dt seconds, from the last tetrahedronFrequencyBoundSquared().
/// With 0, or without that, no force is scaled down.
void prepareTetrahedra(TetrahedronVolumes& volumes, double dt);

/// Whether the force of some tetrahedron is scaled down at these positions in substeps of dt seconds, with
/// the `mobility` of the last tetrahedronFrequencyBoundSquared().
bool isHeldBack(TetrahedronVolumes& volumes, const PointState& state, double dt);

kernel::Tetrahedra<double> kernelTetrahedra(const TetrahedronVolumes& volumes);

/// Adds the forces to `state.force`. The forces of a tetrahedron sum to zero and have no torque.
void addTetrahedronForces(const TetrahedronVolumes& volumes, PointState& state);

/// Returns the energy (J) of the volume term.
double tetrahedronEnergy(const TetrahedronVolumes& volumes, const Points& position);

/// A tetrahedron in the form of a spring whose length is its volume.
struct TetrahedronSlope {
  Eigen::Matrix<double, 3, 4> gradient;  ///< m^2, of the volume with respect to the corners
  double stiffness;                      ///< Pa/m^3, 0 where the push has reached its limit
};

TetrahedronSlope tetrahedronSlope(const TetrahedronVolumes& volumes, std::size_t tetrahedron,
                                  const Points& position);

/// Returns an upper bound (rad^2/s^2) of the volume term's contribution to the square of the body's highest
/// angular frequency at these positions. Sets `mobility`, and `farFromRest`: whether a tetrahedron is far
/// from its rest volume, or may become so within `tick` seconds.
///
/// The Hessian of a tetrahedron's energy is  s g g^T - p H,  with its stiffness s, its push p, the gradient g
/// and the second derivatives H of its volume. The first part is bounded as TetrahedronConstants tells. The
/// 3 x 3 block of two corners in H is the cross product with a sixth of the opposite edge. Row sums of block
/// norms, times inverse masses, bound the second part:
///     max over points i of  w_i sum over its tetrahedra |p| sum of edges / 6,
/// with the edges of the face opposite to i.
double tetrahedronFrequencyBoundSquared(TetrahedronVolumes& volumes, const PointState& state,
                                        double tick = 0.0);

}  // namespace limber
