// SPDX-License-Identifier: Zlib

// This header declares how a body is made, changed, divided and saved, added to the world and removed from
// it, put to sleep and woken. Each function handles both Collision::Points and Collision::Surface.

#pragma once

#include "bullet/soft_body_data.h"

#include <map>
#include <memory>
#include <utility>
#include <vector>

class btSerializer;

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

// --- a new body --------------------------------------------------------------------------------------------

/// The models of the living bodies, by network and settings. Equal bodies share one.
class SharedModels {
 public:
  /// Returns the model for a network and settings, which must be valid. An error names the setting that does
  /// not suit the network.
  Result<std::shared_ptr<const BodyModel>> of(const SharedNetwork& network, const SoftBodySettings& settings);

 private:
  using Key = std::pair<const SpringNetwork*, std::vector<double>>;
  std::map<Key, std::weak_ptr<const BodyModel>> models_;  // a living model keeps its network's address
};

/// Makes a body at its starting position, which is not yet in a world. Has the errors of
/// SoftBodySystem::createBody.
Result<std::unique_ptr<SoftBodyData>> makeBodyData(const SharedNetwork& network,
                                                   const SoftBodySettings& settings, SharedModels& models);

/// m, m/s: largest coordinate and speed that users may give points. Twice the largest position of the
/// settings, and ten times the largest speed.
constexpr double kMaxCoordinate = 2e6, kMaxPointSpeed = 1e6;

/// Returns why a point cannot be at a place (m), or an empty text.
std::string checkPlace(std::size_t point, const Eigen::Vector3d& place);

/// The error of all changes of a body that is not alive.
inline Error notAlive() { return {"the soft body is disabled, see alive()"}; }

/// Returns the centre of mass (m) of a body with the masses of the settings whose points are at `position`.
Eigen::Vector3d centerOfMass(const BodyModel& model, const Points& position);

/// Sets positions and velocities to those of a new body.
void placeAsCreated(SoftBodyData& body);

/// Returns the diagonal (m) of the bounding box of points.
inline double extentOf(const Points& x) { return (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm(); }

/// Brings the state up to date with the user's changes of Bullet's objects.
void readFromBullet(SoftBodyData& body);

/// Returns the elastic energy (J) of springs and volumes at the present positions.
double elasticEnergy(const SoftBodyData& body);

/// Returns the forces (3 x #points, N) of springs and volumes at the present positions. They are computed on
/// copies, since the next step goes on from what the last one has written.
Points elasticForces(const SoftBodyData& body);

/// Writes the state to Bullet's objects. Pins keep their targets unless they are moved, too.
void writeToBullet(SoftBodyData& body, bool pinsMoved = false);

/// Gives the body the springs and volumes of its new model. Springs that may have yielded or broken continue:
/// carry(springs) takes that over from the present ones, on which body.springs still is.
void takeConstants(SoftBodyData& body, const std::function<void(SpringArrays&)>& carry);

/// Gives the body the constants of its model again, instead of softened ones, and resets what depends on
/// them.
void forgetConstants(SoftBodyData& body);

/// Applies settings to a living body, see SoftBody::change().
Result<void> changeSettings(SoftBodyData& body, const SoftBodySettings& settings);

/// Returns the errors that changeSettings() would have, before anything changes.
Result<void> checkChange(SoftBodyData& body, const SoftBodySettings& settings);

// --- in the world ------------------------------------------------------------------------------------------

// These functions call those of point_masses.h or surface_body.h, depending on the body's settings.

void addToWorld(SoftBodyData& body);
void removeFromWorld(SoftBodyData& body);

/// Returns whether any of the body's objects is in a world that still exists.
bool anyInWorld(const SoftBodyData& body);

/// See SoftBody::alive(). Revives a body whose objects the user has taken out of the world and added again.
bool isAlive(SoftBodyData& body);

/// Makes Bullet's queries find a body that was moved between ticks at its new place, before the next tick.
void updateQueryBoxes(SoftBodyData& body);

/// Wakes the rigid bodies to which points are attached.
void wakeAnchored(SoftBodyData& body, bool insideTick);

/// Wakes what is near the body and may rest on it, and what is attached to it, before the body leaves its
/// place. `insideTick`: see wakeBody().
void wakeNeighbours(SoftBodyData& body, bool insideTick);

/// Wakes the body. `insideTick`: also applies the gravity of this step, which it missed while asleep.
void wakeBody(SoftBodyData& body, bool insideTick);

/// Puts a body to sleep that was asleep before.
void putToSleep(SoftBodyData& body);

/// Returns whether the body moves too fast to sleep, see anyPointMoves().
bool movesTooFast(SoftBodyData& body, btScalar tick);

// --- tears and cuts ----------------------------------------------------------------------------------------

// Both give the body a network of its own, between ticks.

/// Returns whether the body tears where its springs are too long.
bool mayTear(const SoftBodyData& body);

/// Divides points at which springs are longer than ElasticLimit::breakStrain allows, see ElasticLimit::tear.
/// At the start of a tick, before bodies are read.
void tearBody(SoftBodyData& body);

/// Makes the cuts that were asked for within the last tick.
void makePendingCuts(SoftBodyData& body);

// --- saved states ------------------------------------------------------------------------------------------

// SoftBody::saveState() says what they contain.

std::vector<std::uint8_t> saveStateOf(SoftBodyData& body);
Result<void> restoreStateOf(SoftBodyData& body, const std::vector<std::uint8_t>& bytes);

/// Returns the settings in a saved state. Errors: bytes that are no such state.
Result<SoftBodySettings> settingsIn(const std::vector<std::uint8_t>& bytes);

/// Returns the errors of restoreStateOf(), without changing anything.
Result<void> checkStateFor(SoftBodyData& body, const std::vector<std::uint8_t>& bytes);

/// Writes a chunk that has the body's network, settings and state to one of Bullet's files.
void writeChunk(SoftBodyData& body, btSerializer& serializer);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
