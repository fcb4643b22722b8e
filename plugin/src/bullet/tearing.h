// SPDX-License-Identifier: Zlib

// This header declares the tearing and cutting of bodies. Both give the body a network of its own, between
// ticks.

#pragma once

#include "bullet/soft_body_data.h"
#include "solver/split.h"

#include <limber/result.h>

#include <cstdint>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

/// Gives a living body the network that its own separates into. Positions, velocities and masses stay; so
/// does the energy, except that of springs that are left out. Errors, with nothing changed: a point that
/// would get too small a mass.
Result<void> takeSplit(SoftBodyData& body, const SplitNetwork& split);

/// Returns whether the body tears where its springs are too long.
bool mayTear(const SoftBodyData& body);

/// Divides points at which springs are longer than ElasticLimit::breakStrain allows, see ElasticLimit::tear.
/// At the start of a tick, before bodies are read.
void tearBody(SoftBodyData& body);

/// Makes the cuts that were asked for within the last tick.
void makePendingCuts(SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
