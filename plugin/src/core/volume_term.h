// SPDX-License-Identifier: Zlib
#pragma once

#include "core/point_state.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <string>
#include <vector>

namespace limber {

/// The closed surfaces of one body, each with the energy  K/2 (V - V0)^2 / V0  of its signed volume, which
/// also tells a body from its mirror image, and the pressure of the gas in it. Empty: no volume term.
struct VolumeArrays {
  std::vector<Triangle> triangles;           ///< of all components, one component after the other
  std::vector<std::uint32_t> firstTriangle;  ///< #components + 1
  std::vector<double> restVolume;            ///< #components, m^3, above 0
  double modulus = 0.0;                      ///< Pa, K
  double pressure = 0.0;                     ///< Pa above the outside at rest; P V0 / V at volume V

  bool empty() const { return restVolume.empty(); }
};

/// Pa: the Young's modulus of a spring network that fills `volume` (m^3) evenly,  sum k L^2 / (6 V)
/// (Cauchy-Born).
double networkModulus(const SpringNetwork& network, const Eigen::Vector3d& scale, double stiffness,
                      double volume);

/// m^3, signed, of a closed surface; relative to one of its points, so that far from the origin it loses
/// nothing.
double enclosedVolume(const Triangle* triangles, std::size_t count, const Points& position);

/// The volume term of a body with these settings; empty if they ask for none or the surface is not closed.
VolumeArrays makeVolumes(const SpringNetwork& network, const SoftBodySettings& settings);

/// Why the settings' volume modulus or pressure cannot be had with this network, or an empty string.
std::string checkVolume(const SpringNetwork& network, const SoftBodySettings& settings);

/// Adds to `state.force`. The forces of a component sum to zero and have no torque.
void addVolumeForces(const VolumeArrays& volumes, PointState& state);

/// J.
double volumeEnergy(const VolumeArrays& volumes, const Points& position);

}  // namespace limber
