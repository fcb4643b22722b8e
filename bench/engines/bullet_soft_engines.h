// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// The stiffness of btSoftBody's links.
enum class LinkStiffness : std::uint8_t {
  Full,       ///< kLST = 1, Bullet's default: the stiffness depends on the iterations
  Calibrated  ///< kLST for which the iterations of a tick act like implicit Euler on a single spring
};

/// The colliding parts of a btSoftBody: its points with rigid bodies through their distance fields and with
/// the faces of other soft bodies, or convex clusters of points with either.
enum class SoftContacts : std::uint8_t {
  Points,             ///< SDF_RS
  PointsAndFaces,     ///< SDF_RS | VF_SS
  PointsAndClusters,  ///< SDF_RS | CL_SS, at most 8 clusters
  Clusters            ///< CL_RS | CL_SS, at most 8 clusters
};

/// kKHR of the bodies: the share of the overlap with a static or kinematic object that an iteration removes.
/// With Bullet's default of 0.1 bodies sink in; 1 costs the same. It made one scene worse, a stack of soft
/// cubes.
constexpr double kHardContacts = 1.0, kBulletsHardness = 0.1;

/// Returns "1 iteration" or "4 iterations".
std::string iterationsText(int count);

/// Creates Bullet's position-based soft body. Bodies without faces collide with their points.
std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness,
                                           SoftContacts contacts = SoftContacts::PointsAndFaces,
                                           double hardness = kHardContacts);

/// Creates Bullet's deformable body with btDeformableMassSpringForce. It supports two spring constants: that
/// of the body, and that of its bending springs.
std::unique_ptr<Engine> makeDeformableEngine(bool implicit);

}  // namespace limber::bench
