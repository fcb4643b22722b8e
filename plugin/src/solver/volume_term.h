// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"
#include "solver/volume_kernel.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <string>
#include <vector>

namespace limber {

/// What volumeFrequencyBoundSquared found for a shape, see kept_volume_bound.h.
struct KeptVolumeBound {
  Points shape;        ///< 3 x #points, m
  double value = 0.0;  ///< rad^2/s^2; 0: nothing is kept
};

/// The closed surfaces of one body, each with the energy  K/2 (V - V0)^2 / V0  of its signed volume, which
/// also tells a body from its mirror image, and the pressure of the gas in it. Empty: no volume term.
struct VolumeArrays {
  std::vector<Triangle> triangles;           ///< of all components, one component after the other
  std::vector<std::uint32_t> firstTriangle;  ///< #components + 1
  std::vector<std::uint32_t> componentOf;    ///< #points; 0 for points of none
  std::vector<double> restVolume;            ///< #components, m^3, above 0
  double modulus = 0.0;                      ///< Pa, K
  double pressure = 0.0;                     ///< Pa above the outside at rest; P V0 / V at volume V
  double timeStep = 0.0;                     ///< s, of Verlet's substep; 0: of an implicit stepper
  double shortestEdge = 0.0;                 ///< m, at rest

  bool restless = false;        ///< in this tick some volume is, or may come, far from that at rest
  Points gradient;              ///< 3 x #points, scratch
  std::vector<double> sums;     ///< 4 x #components, scratch
  std::vector<double> rowSums;  ///< #points, scratch
  KeptVolumeBound kept;

  bool empty() const { return restVolume.empty(); }
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

}  // namespace limber
