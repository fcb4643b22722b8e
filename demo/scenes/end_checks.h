// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

namespace limber::scenes {

/// Every coordinate is a finite number.
std::string checkFinite(const Scene& scene);

/// No point is more than its radius below the floor's top at y = 0.
std::string checkAboveFloor(const Scene& scene);

/// No point has moved more than `metres` of late, see RestWatch.
Check checkCalm(double metres);

/// The same, but a body may roll or slide away as a whole, neither falling nor changing its shape.
Check checkCalmOrRolling(double metres);

/// Every body sleeps.
std::string checkAsleep(const Scene& scene);

/// Every body has its shape up to an RMS error of `relative` of its size, and is not inside out.
Check checkShapes(double relative);

/// No spring of the mesh or grid (braces, shear and bending aside) is more than `relative` longer than at
/// rest.
Check checkStretch(double relative);

/// No point is inside the ball by more than `metres`.
Check checkOutsideBall(const Eigen::Vector3d& centre, double radius, double metres);

}  // namespace limber::scenes
