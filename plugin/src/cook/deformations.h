// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

#include <limber/network_analysis.h>

#include <cstdint>

namespace limber {

/// The rest points after run `run` of this kind of deformation, in a direction, and with a point, that
/// depend on (kind, seed, run) alone. Every point is moved by up to a further 1e-4 of the size, so that a
/// body is never exactly in an unstable equilibrium.
Points deform(const Points& rest, Deformation kind, std::uint64_t seed, std::uint64_t run);

}  // namespace limber
