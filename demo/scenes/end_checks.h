// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <limber/soft_body.h>

#include <Eigen/Core>

#include <vector>

namespace limber::scenes {

/// How a deformed shape differs from its shape at rest, wherever it lies and however it is turned.
struct ShapeError {
  double relativeRms =
      0.0;                ///< RMS distance of the points after the best rigid motion, per size of the shape
  bool mirrored = false;  ///< a reflection would fit better than any rotation: the body is inside out
};

/// Largest extent of the points along an axis, m.
double sizeOf(const std::vector<Eigen::Vector3d>& points);

/// Best proper rigid motion from `rest` to `now` by the singular values of their correlation (Kabsch 1976).
/// Both have #points entries, one or more.
ShapeError shapeError(const std::vector<Eigen::Vector3d>& rest, const std::vector<Eigen::Vector3d>& now);

/// The rest points of a body at its own scale.
std::vector<Eigen::Vector3d> restShape(const SoftBody& body);

ShapeError shapeError(const SoftBody& body);

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
