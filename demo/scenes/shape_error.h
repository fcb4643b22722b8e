// SPDX-License-Identifier: Zlib
#pragma once

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

}  // namespace limber::scenes
