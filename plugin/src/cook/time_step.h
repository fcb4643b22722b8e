// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

namespace limber {

/// Substeps of velocity Verlet; dampers do not change them, see verlet_step.h.
struct TimeSteps {
  double critical =
      0.0;            ///< s: 2 / omega of the stiffest oscillation about the rest shape. Longer ones blow up
  double safe = 0.0;  ///< s: from Gershgorin's bound of omega, which holds at any deformation of the springs;
                      ///< the volume terms' part is that at rest
};

/// Of a body with the settings' masses, stiffness, scale and volume modulus; infinite where nothing is stiff.
TimeSteps timeSteps(const SpringNetwork& network, const SoftBodySettings& settings);

}  // namespace limber
