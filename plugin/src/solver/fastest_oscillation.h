// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/springs.h"
#include "solver/volumes.h"

namespace limber {

/// rad^2/s^2: the largest eigenvalue of M^-1/2 K M^-1/2, K being the stiffness matrix at the state's
/// positions: the square of the stiffest of the oscillations about them. Springs count with the larger of
/// their two constants, and stiffen across their direction when they are stretched. Too small by about the
/// square of `tolerance`; 0.03 takes some 16 products with K.
double fastestOscillationSquared(const SpringArrays& springs, const VolumeArrays& volumes,
                                 const TetrahedronVolumes& tetrahedra, const PointState& state,
                                 double tolerance);

}  // namespace limber
