// SPDX-License-Identifier: Zlib

// This header declares what surrounds the bodies of a system, and the forces of it in a tick.

#pragma once

#include "solver/medium.h"
#include "solver/springs.h"

#include <limber/bullet_precision.h>

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

struct SoftBodyData;

/// A field that acts on one body, or on all of a system.
struct ActingField {
  std::uint64_t id;
  ForceField act;
  const SoftBodyData* body;  ///< nullptr: all
};

/// What surrounds the bodies of a system.
struct Surroundings {
  Air air;
  std::optional<Water> water;
  std::vector<ActingField> fields;
  std::uint64_t lastField = 0;  ///< id of the last field that was added
  double time = 0.0;            ///< s, sum of the ticks
};

/// A body in the media around it. Made when something first acts on the body.
struct BodyMedium {
  PointDrag drag;
  Points wind;                            ///< 3 x #points, m/s, scratch
  Points predicted;                       ///< 3 x #points, m, scratch: positions in the middle of the tick
  Points force;                           ///< 3 x #points, N, scratch
  Points velocity;                        ///< 3 x #points, m/s, scratch
  std::vector<double> masses;             ///< #points, kg, scratch of fields
  std::optional<Eigen::Vector3d> others;  ///< N/kg, all forces but buoyancy and drag in the last tick, per
                                          ///< mass of the body alone, if it had the water's mass
  Points inverseMass;                     ///< 3 x #points, 1/kg, of the body alone, while `hasWaterMass`
  bool hasWaterMass = false;  ///< PointState::inverseMass counts the water that moves with the body
  Eigen::Vector3d lastWind = Eigen::Vector3d::Zero();  ///< m/s, at point 0 in the last tick awake
};

/// Returns the body's medium, which is made if there is none.
BodyMedium& mediumOf(SoftBodyData& body);

/// Returns the parts of a network that a flow acts on. Closed triangles face outward at this scale.
WettedParts wettedParts(const SpringNetwork& network, const SoftBodySettings& settings,
                        const SpringConstants& springs);

/// Adds the buoyancy to the accelerations of an awake body, at the start of a tick, after all other forces.
/// Returns its drag in the tick, or nullptr if there is none.
PointDrag* surroundBody(SoftBodyData& body, double tick);

/// Gives the body its own mass again. Call it after the step.
void removeWaterMass(SoftBodyData& body, double tick);

/// Calls all fields for an awake body.
void applyFields(SoftBodyData& body, double tick);

/// Returns whether air acts on the body.
bool hasDragInAir(const SoftBodyData& body);

/// Returns whether the wind at a sleeping body has changed so much since it fell asleep that it must wake.
bool isBlownAwake(const SoftBodyData& body);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
