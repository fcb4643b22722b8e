// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/point_state.h"

namespace limber {

/// Takes `excess` J out of the motion of a free body's points relative to its rigid motion, by scaling
/// it, so that linear and angular momentum stay (the projection of Dinev, Liu, Li, Thomaszewski, Kavan 2018
/// restricted to velocities). A body with held points has no rigid motion of its own: all of it is scaled.
/// Returns what was not there to be taken, J.
double removeKineticEnergy(PointState& state, double excess);

/// kg m^2/s: angular momentum about the centre of mass.
Eigen::Vector3d spinOf(const PointState& state);

/// Turns the whole body so much faster or slower that spinOf(state) becomes `spin`.
void setSpin(PointState& state, const Eigen::Vector3d& spin);

}  // namespace limber
