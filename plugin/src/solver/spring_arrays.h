// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

#include <cstdint>
#include <vector>

namespace limber {

/// The springs of one body, one entry per spring of its network, in the order of spring_order.h.
struct SpringArrays {
  std::vector<std::uint32_t> a, b;           ///< point indices
  std::vector<double> restLength;            ///< m
  std::vector<double> extensionStiffness;    ///< N/m while longer than restLength
  std::vector<double> compressionStiffness;  ///< N/m while shorter
  std::vector<double> damping;               ///< N s/m
  bool damped = false;                       ///< whether any spring has damping

  double shortest = 0.0;  ///< m, the smallest rest length above 0

  ElasticLimit limit;
  bool limited = false;                ///< whether any part of `limit` is on
  std::vector<double> originalLength;  ///< m, the rest length before any yielding; empty if not limited
  std::size_t broken = 0;              ///< springs that have broken so far

  // Written by the step.
  Points direction;              ///< 3 x #springs, unit vector from a to b, 0 while the spring is slack
  std::vector<double> dampHalf;  ///< kg, impulse per closing speed over half a substep
  std::vector<double> dampFull;  ///< the same over a whole one
  double damperTime = 0.0;       ///< s, the substep they hold for; 0 when an inverse mass has changed since
  unsigned revision = 1;         ///< counts the changes of everything but `direction`

  std::size_t size() const { return a.size(); }
};

/// The springs of a body with these settings. Rest lengths are those of the rest points times the scale.
SpringArrays makeSprings(const SpringNetwork& network, const SoftBodySettings& settings);

}  // namespace limber
