// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/triangle_mesh.h>

#include <Eigen/Core>

#include <vector>

namespace limber {

/// Of what a closed surface encloses, filled evenly with a mass of 1.
struct SolidMoments {
  double volume = 0.0;                               ///< m^3, below 0 where the surface faces inward
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< m^2, about the centre
};

/// #points is the number of columns. Neither centre nor second moments are finite where the volume is 0.
SolidMoments solidMoments(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          const std::vector<Triangle>& surface);

}  // namespace limber
