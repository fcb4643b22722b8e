// SPDX-License-Identifier: Zlib
#pragma once

#include "engines/engine.h"

#include <limber/parallel.h>

namespace limber::bench {

// --- Limber ---

/// Changes a scene's settings before Limber's body is made, for example to force a stepper.
using TuneSettings = std::function<void(SoftBodySettings&)>;

std::unique_ptr<Engine> makeLimberEngine(TuneSettings tune = {});

/// Returns an engine whose soft bodies are stepped by this function; see SoftBodySystem::setParallelFor().
std::unique_ptr<Engine> makeLimberEngine(ParallelFor parallelFor);

/// Forces a stepper.
std::unique_ptr<Engine> makeLimberEngine(Stepper stepper);

/// Returns the number of Verlet substeps that the body takes in a tick of dt seconds with its own settings.
int stableSubsteps(const BodySetup& setup, double dt);

// --- Bullet's soft bodies ---

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

// --- loose spheres ---

/// Plain Bullet with a separate sphere for each point, of its mass, radius and friction and without rotation:
/// Bullet's own cost of so many bodies. There are no springs.
std::unique_ptr<Engine> makeBareEngine();

}  // namespace limber::bench
