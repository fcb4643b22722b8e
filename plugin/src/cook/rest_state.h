// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

#include <limber/soft_body_settings.h>
#include <limber/spring_network.h>

namespace limber {

/// The points of a body of the settings' scale and mass, at rest about the network's origin.
PointState restState(const SpringNetwork& network, const SoftBodySettings& settings);

}  // namespace limber
