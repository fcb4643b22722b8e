// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

namespace limber::scenes {

/// No two closed soft bodies are in one another by more than `metres`.
Check checkSoftApart(double metres);

/// No soft body and no rigid one, static or not, are in one another by more than `metres`.
Check checkRigidApart(double metres);

/// Watches what moves from now on, tick by tick: no such body and no soft one may ever be in one another by
/// more than `metres`, nor a ball by more than 0.3 of its radius. It takes the scene's afterTick.
void watchMovablesApart(Scene& scene, double metres);

/// No dynamic body moves faster than so many m/s.
Check checkMovablesCalm(double speed);

/// m, mean of a body's points.
Eigen::Vector3d middleOf(const SoftBody& body);

}  // namespace limber::scenes
