// SPDX-License-Identifier: Zlib
#pragma once

#include "cook/relaxed_body.h"

#include <functional>

namespace limber {

/// Relaxes `count` starts. `start(i)` gives the positions that run i is let go from, at rest; `finish(i, x)`
/// takes those it has come to rest at, in any order, and returns false to end early.
///
/// Each run is lightly damped dynamics (drag of 0.05 per unit mass and second at unit spring constants) until
/// nearly all kinetic energy is gone, then descent to the minimum of the energy. What run i ends in depends
/// on its start alone.
void relax(RelaxedBody& body, std::size_t count, const std::function<Points(std::size_t)>& start,
           const std::function<bool(std::size_t, const Points&)>& finish);

/// Whether the steps that the body's fastest oscillation allows lead anywhere in a time that is worth waiting
/// for. If not, relax() ends, but where it ends in says nothing about the body.
bool canRelax(RelaxedBody& body);

}  // namespace limber
