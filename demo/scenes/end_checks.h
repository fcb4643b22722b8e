// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"

#include <limber/soft_body.h>

#include <Eigen/Core>

#include <vector>

namespace limber::scenes {

/// Difference of a deformed shape from its shape at rest, independent of position and rotation.
struct ShapeError {
  double relativeRms = 0.0;  ///< RMS distance of the points after the best rigid motion, relative to the size
  bool mirrored = false;     ///< a reflection fits better than any rotation: the body is inside out
};

/// Returns the largest extent of the points along an axis, m.
double sizeOf(const std::vector<Eigen::Vector3d>& points);

/// Returns the error after the best proper rigid motion from `rest` to `now`, by the singular values of their
/// correlation (Kabsch 1976). Both have #points entries, at least one.
ShapeError shapeError(const std::vector<Eigen::Vector3d>& rest, const std::vector<Eigen::Vector3d>& now);

/// Returns the rest points of a body at its scale.
std::vector<Eigen::Vector3d> restShape(const SoftBody& body);

ShapeError shapeError(const SoftBody& body);

/// Checks that all coordinates are finite.
std::string checkFinite(const Scene& scene);

/// Checks that no point is more than its radius below the top of the floor at y = 0.
std::string checkAboveFloor(const Scene& scene);

/// Checks that no point has recently moved more than `metres`, see RestWatch.
Check checkCalm(double metres);

/// The same, but a body may roll or slide as a whole if it neither falls nor changes its shape.
Check checkCalmOrRolling(double metres);

/// Checks that all bodies sleep.
std::string checkAsleep(const Scene& scene);

/// Checks that the RMS error of each solid's shape is at most `relative` of its size, and that it is not
/// inside out. `remedy` ends the message.
Check checkShapes(double relative, const std::string& remedy = "");

/// Checks that no point is farther than `metres` from the origin.
Check checkWithin(double metres);

/// Checks that no edge of a drawn surface is longer than `factor` times its length at rest.
Check checkSpikes(double factor);

/// Checks that no structural spring is longer than its rest length by more than the fraction `relative`.
Check checkStretch(double relative);

/// Checks that no point is deeper than `metres` inside the ball.
Check checkOutsideBall(const Eigen::Vector3d& centre, double radius, double metres);

/// Checks that no two closed soft bodies penetrate each other by more than `metres`.
Check checkSoftApart(double metres);

/// Checks that no soft and rigid body (static or not) penetrate each other by more than `metres`.
Check checkRigidApart(double metres);

/// Adds a check of every tick from now on: no movable rigid body and soft body may penetrate each other by
/// more than `metres`, and no ball by more than 0.3 of its radius. It sets the scene's afterTick.
void watchMovablesApart(Scene& scene, double metres);

/// Checks that no dynamic rigid body is faster than `speed`, m/s.
Check checkMovablesCalm(double speed);

/// Returns the mean of a body's points, m.
Eigen::Vector3d middleOf(const SoftBody& body);

}  // namespace limber::scenes
