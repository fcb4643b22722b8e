// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

namespace limber::bench {

/// How btSoftBody's links are as stiff as the springs they stand for.
enum class LinkStiffness : std::uint8_t {
  Full,       ///< kLST = 1, Bullet's default: as stiff as the iterations make it
  Calibrated  ///< kLST such that the iterations of a tick do what implicit Euler does to a single spring
};

/// What btSoftBody collides: its points with rigid bodies through their distance fields, and with the faces
/// of other soft bodies; or convex clusters of points, with either.
enum class SoftContacts : std::uint8_t {
  Points,             ///< SDF_RS
  PointsAndFaces,     ///< SDF_RS | VF_SS
  PointsAndClusters,  ///< SDF_RS | CL_SS, 8 clusters at most
  Clusters            ///< CL_RS | CL_SS, 8 clusters at most
};

/// Bullet's position-based soft body. Bodies without faces collide as their points.
std::unique_ptr<Engine> makeSoftBodyEngine(double dt, int iterations, LinkStiffness stiffness,
                                           SoftContacts contacts = SoftContacts::PointsAndFaces);

/// Bullet's deformable body with btDeformableMassSpringForce. It knows two spring constants: that of the
/// body, and that of its bending springs.
std::unique_ptr<Engine> makeDeformableEngine(bool implicit);

}  // namespace limber::bench
