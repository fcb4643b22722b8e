// SPDX-License-Identifier: Zlib

// This file saves the state of bodies and systems as bytes, and restores it. A state is one list of numbers,
// which transferState() declares for the writer and the reader.

#include "bullet/saved_state.h"

#include "bullet/body_in_world.h"
#include "bullet/bullet_objects.h"
#include "bullet/linked_group.h"
#include "bullet/point_masses.h"
#include "bullet/soft_body_data.h"
#include "bullet/surface_body.h"
#include "bullet/system_impl.h"
#include "bullet/tick_contacts.h"
#include "mesh/bytes.h"

#include <limber/soft_body.h>
#include <limber/soft_body_system.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace limber {

// what ByteReader needs to know of the settings' types
static constexpr Stepper lastOf(Stepper) { return Stepper::BandedNewton; }
static constexpr Collision lastOf(Collision) { return Collision::Surface; }
static constexpr SpringAction lastOf(SpringAction) { return SpringAction::CompressionOnly; }

inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr SealedFormat kStateFormat = {
    {0x89, 'L', 'I', 'M', 'S', 'T', '\r', '\n'}, "a saved state", "the saved state", 1};
constexpr SealedFormat kSystemFormat = {
    {0x89, 'L', 'I', 'M', 'S', 'Y', '\r', '\n'}, "a saved state of a system", "the saved state", 1};
constexpr SealedFormat kBodiesFormat = {
    {0x89, 'L', 'I', 'M', 'B', 'D', '\r', '\n'}, "a file of soft bodies", "the file", 1};

// --- settings ----------------------------------------------------------------------------------------------

template <class Stream, class Number>
void transferOptional(Stream& stream, const char* name, Number& number) {
  std::vector<double> value;
  if (number) value.push_back(*number);
  stream.array(name, value);
  if constexpr (!std::is_const_v<Number>) {
    number.reset();
    if (!value.empty()) number = value.front();
  }
}

template <class Stream, class Flag>
void transferFlag(Stream& stream, const char* name, Flag& flag) {
  std::uint8_t byte = flag ? 1 : 0;
  stream.value(name, byte);
  if constexpr (!std::is_const_v<Flag>) flag = byte != 0;
}

template <class Stream, class Vector>
void transferVector(Stream& stream, const char* name, Vector& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) stream.value(name, v[i]);
}

template <class Stream, class Settings>
void transferStepping(Stream& stream, Settings& s) {
  stream.value("stepper", s.stepper);
  stream.value("minSubsteps", s.minSubsteps);
  stream.value("periodTolerance", s.periodTolerance);
  stream.value("tolerance", s.tolerance);
  stream.value("relativeTolerance", s.relativeTolerance);
  stream.value("maxSubsteps", s.maxSubsteps);
}

template <class Stream, class Settings>
void transferLimit(Stream& stream, Settings& s) {
  stream.value("stiffenStrain", s.stiffenStrain);
  stream.value("stiffenFactor", s.stiffenFactor);
  stream.value("yieldStrain", s.yieldStrain);
  stream.value("yieldMaximum", s.yieldMaximum);
  stream.value("breakStrain", s.breakStrain);
}

template <class Stream, class Settings>
void transferMaterial(Stream& stream, Settings& s) {
  stream.value("extensionStiffness", s.extensionStiffness);
  stream.value("compressionStiffness", s.compressionStiffness);
  stream.value("damping", s.damping);
  stream.value("totalMass", s.totalMass);
  transferOptional(stream, "volumeModulus", s.volumeModulus);
  stream.value("pressure", s.pressure);
  stream.value("ambientPressure", s.ambientPressure);
  stream.value("friction", s.friction);
  stream.value("restitution", s.restitution);
  transferLimit(stream, s.elasticLimit);
  stream.resize("groups", s.groups, 5 * sizeof(double));
  for (auto& group : s.groups) {
    stream.array("letters of a group's name", group.name);
    stream.value("stiffness of a group", group.stiffness);
    stream.value("damping of a group", group.damping);
    stream.value("limitStrain of a group", group.limitStrain);
    stream.value("mass of a group", group.mass);
  }
}

template <class Stream, class Flow>
void transferFlow(Stream& stream, Flow& flow) {
  for (auto* coefficient : {&flow.drag, &flow.lift, &flow.linearDrag})
    transferOptional(stream, "flow", *coefficient);
  stream.value("flow", flow.friction);
  stream.value("flow", flow.displacedVolume);
}

template <class Stream, class Settings>
void transferSettings(Stream& stream, Settings& s) {
  transferVector(stream, "position", s.position);
  transferVector(stream, "rotation", s.rotation.coeffs());
  transferVector(stream, "scale", s.scale);
  transferVector(stream, "linearVelocity", s.linearVelocity);
  transferVector(stream, "angularVelocity", s.angularVelocity);
  transferMaterial(stream, s);
  stream.value("collision", s.collision);
  transferFlag(stream, "selfCollision", s.selfCollision);
  transferOptional(stream, "pointRadius", s.pointRadius);
  stream.value("collisionGroup", s.collisionGroup);
  stream.value("collisionMask", s.collisionMask);
  transferFlag(stream, "continuousCollision", s.continuousCollision);
  stream.value("sleepingSpeed", s.sleepingSpeed);
  stream.value("gravityFactor", s.gravityFactor);
  stream.value("maxPinSpeed", s.maxPinSpeed);
  transferFlow(stream, s.flow);
  transferStepping(stream, s.stepping);
}

// --- the state of a body -----------------------------------------------------------------------------------

/// What continues a body's motion, but for what is computed anew in each tick.
struct BodyState {
  std::uint64_t network = 0;  ///< hash
  SoftBodySettings settings;
  std::vector<double> position, velocity, startPosition;  ///< 3 x #points
  std::vector<double> startVelocity;                      ///< 3 x #points, or empty
  std::vector<double> mass;                               ///< #points, kg; of pinned points, that before
  std::vector<std::uint8_t> pinned;                       ///< #points
  std::vector<double> pinTarget;                          ///< 3 x #points, m; 0 where not pinned
  std::vector<double> yieldedLength;                      ///< #springs, m, or empty
  std::vector<std::uint8_t> broken;                       ///< #springs, or empty
  Eigen::Quaterniond frame = Eigen::Quaterniond::Identity();
  bool asleep = false;
  double calmTime = 0.0, softenedTo = 0.0, errorPerSecond = 0.0, errorCoefficient = 0.0;
  std::vector<double> softenedMass;  ///< 3 x #points, inverse masses for which it was softened, or empty
  RateHistory rates;
  EnergyLimit energy;
  int substeps = 0;
  Stepper stepper = Stepper::Verlet;
  bool prefersImplicit = false;
  std::uint32_t restorations = 0;
  Eigen::Vector3d lastWind = Eigen::Vector3d::Zero();  ///< m/s, see BodyMedium
  std::vector<std::uint64_t> touched, key;  ///< #impulses: index in the world of the partner, features
  std::vector<double> impulse;              ///< 4 x #impulses, N s
};

template <class Stream, class Rates>
void transferRates(Stream& stream, Rates& rates) {
  stream.value("rates", rates.boundSquared);
  stream.value("rates", rates.fastestSquared);
  stream.value("rates", rates.turnRate);
}

template <class Stream, class State>
void transferState(Stream& stream, State& s) {
  stream.value("network", s.network);
  transferSettings(stream, s.settings);
  stream.array("positions", s.position);
  stream.array("velocities", s.velocity);
  stream.array("earlier positions", s.startPosition);
  stream.array("earlier velocities", s.startVelocity);
  stream.array("masses", s.mass);
  stream.array("pins", s.pinned);
  stream.array("targets of pins", s.pinTarget);
  stream.array("yielded lengths", s.yieldedLength);
  stream.array("broken springs", s.broken);
  transferVector(stream, "frame", s.frame.coeffs());
  transferFlag(stream, "sleep", s.asleep);
  for (auto* number : {&s.calmTime, &s.softenedTo, &s.errorPerSecond, &s.errorCoefficient})
    stream.value("measures", *number);
  stream.array("inverse masses", s.softenedMass);
  transferRates(stream, s.rates.now);
  transferRates(stream, s.rates.before);
  stream.value("age", s.rates.age);
  for (auto* flag : {&s.energy.on, &s.energy.persists, &s.energy.forceScaled})
    transferFlag(stream, "energy limit", *flag);
  stream.value("energy limit", s.energy.bound);
  stream.value("energy limit", s.energy.atEnd);
  stream.value("substeps", s.substeps);
  stream.value("stepper", s.stepper);
  transferFlag(stream, "stepper", s.prefersImplicit);
  stream.value("restorations", s.restorations);
  transferVector(stream, "wind", s.lastWind);
  stream.array("touched objects", s.touched);
  stream.array("touched features", s.key);
  stream.array("impulses", s.impulse);
}

/// Returns a hash of the points and springs of a network.
std::uint64_t hashOf(const SpringNetwork& network) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.array("points", network.restPoints);
  for (const NetworkSpring& spring : network.springs) {
    writer.value("a", spring.a);
    writer.value("b", spring.b);
  }
  return hashPayload(bytes.data(), bytes.size());
}

std::vector<double> numbersOf(const Points& points) {
  return std::vector<double>(points.data(), points.data() + points.size());
}

Points pointsOf(const std::vector<double>& numbers) {
  return Eigen::Map<const Points>(numbers.data(), 3, static_cast<Eigen::Index>(numbers.size() / 3));
}

// --- saving ------------------------------------------------------------------------------------------------

/// Discards what a restored body does not have either, so that both continue with the same bits.
void forgetCaches(SoftBodyData& body) {
  forgetSearches(body);
  body.implicit.reset();
  body.volumes.kept.value = 0.0;
  body.surface.sweptBounds.tick = 0.0;
  body.sumsValid = false;
  body.frequencyStale = true;
  *body.groupsStale = true;
  btOverlappingPairCache* pairs = body.world->getBroadphase()->getOverlappingPairCache();
  for (PointMass* point : body.masses.bodies)
    if (point && point->isInWorld())
      pairs->cleanProxyFromPairs(point->getBroadphaseHandle(), body.world->getDispatcher());
}

void savePoints(const SoftBodyData& body, BodyState& s) {
  s.position = numbersOf(body.state.position);
  s.velocity = numbersOf(body.state.velocity);
  s.startPosition = numbersOf(body.masses.startPosition);
  s.startVelocity = numbersOf(body.startVelocity);
  s.mass = body.model->masses;
  s.pinned.assign(pointCount(body), 0);
  s.pinTarget.assign(std::size_t{3} * pointCount(body), 0.0);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    const PointMass& point = *body.masses.bodies[i];
    s.pinned[i] = point.isKinematicObject();
    const btScalar own = static_cast<btScalar>(body.model->masses[i]);
    const btScalar mass = s.pinned[i] ? point.massBeforePin : point.getMass();
    // setMassProps() and getMass() round
    if (mass != own && point.getInvMass() != btScalar(1) / own) s.mass[i] = double(mass);
    for (int axis = 0; axis < 3 && s.pinned[i]; ++axis)
      s.pinTarget[3 * std::size_t{i} + static_cast<std::size_t>(axis)] =
          double(point.getWorldTransform().getOrigin()[axis]);
  }
}

void saveSprings(const SoftBodyData& body, BodyState& s) {
  if (const SpringConstants* own = body.springs.yielded.get()) {
    s.yieldedLength = own->restLength;
    for (std::size_t i = 0; i < body.springs.size(); ++i) s.broken.push_back(isBroken(body.springs, i));
  }
  if (!body.softening) return;
  s.softenedTo = body.softening->largest;
  s.softenedMass = numbersOf(body.softening->inverseMass);
}

void saveImpulses(const SoftBodyData& body, BodyState& s) {
  const btCollisionObjectArray& objects = body.world->getCollisionObjectArray();
  for (const StoredImpulse& stored : body.storedImpulses) {
    const int index = objects.findLinearSearch(const_cast<btCollisionObject*>(stored.object));
    if (index >= objects.size()) continue;
    s.touched.push_back(static_cast<std::uint64_t>(index));
    s.key.push_back(stored.key);
    const ContactImpulse& j = stored.impulse;
    s.impulse.insert(s.impulse.end(), {j.along, j.across.x(), j.across.y(), j.across.z()});
  }
}

BodyState stateOf(SoftBodyData& body) {
  readFromBullet(body);
  BodyState s;
  s.network = hashOf(*body.model->network);
  s.settings = body.settings;
  savePoints(body, s);
  saveSprings(body, s);
  saveImpulses(body, s);
  s.frame = body.surface.frame;
  s.asleep = body.asleep;
  s.calmTime = body.calmTime;
  s.errorPerSecond = body.errorPerSecond;
  s.errorCoefficient = body.errorCoefficient;
  s.rates = body.rateHistory;
  s.energy = body.energyLimit;
  s.substeps = body.substeps;
  s.stepper = body.stepper;
  s.prefersImplicit = body.prefersImplicit;
  s.restorations = body.restorations;
  if (body.medium) s.lastWind = body.medium->lastWind;
  return s;
}

// --- restoring ---------------------------------------------------------------------------------------------

/// Returns why a state does not suit a body, or an empty string.
std::string checkState(const SoftBodyData& body, const BodyState& s) {
  const std::size_t n = pointCount(body), springs = body.springs.size();
  if (s.network != hashOf(*body.model->network)) return "the saved state is of a body of another network";
  for (const auto* array : {&s.position, &s.velocity, &s.startPosition, &s.pinTarget})
    if (array->size() != 3 * n) return "the saved state has arrays of different sizes";
  if (s.mass.size() != n || s.pinned.size() != n || s.yieldedLength.size() != s.broken.size() ||
      (!s.broken.empty() && s.broken.size() != springs) ||
      (!s.softenedMass.empty() && s.softenedMass.size() != 3 * n) ||
      (!s.startVelocity.empty() && s.startVelocity.size() != 3 * n) || s.touched.size() != s.key.size() ||
      4 * s.touched.size() != s.impulse.size())
    return "the saved state has arrays of different sizes";
  for (const auto* array : {&s.position, &s.velocity, &s.startPosition, &s.pinTarget, &s.mass,
                            &s.yieldedLength, &s.softenedMass, &s.impulse, &s.startVelocity})
    for (const double number : *array)
      if (!(std::abs(number) <= kMaxSound)) return "the saved state has a number that is not finite";
  if (!(std::abs(s.frame.norm() - 1.0) < 1e-6)) return "the saved state has a frame that is no rotation";
  if (s.settings.collision != body.settings.collision)
    return "the saved state is of a body with another kind of collision";
  return {};
}

void restorePins(SoftBodyData& body, const BodyState& s) {
  const auto differs = [&](std::uint32_t i) {
    return s.mass[i] != body.model->masses[i] || s.pinned[i] != 0;
  };
  bool any = false;
  for (std::uint32_t i = 0; i < pointCount(body); ++i) any = any || differs(i);
  if (any && isSurfaceBody(body)) exposePoints(body);
  for (std::uint32_t i = 0; i < body.masses.bodies.size(); ++i) {
    PointMass& point = *body.masses.bodies[i];
    if (point.isKinematicObject() != (s.pinned[i] != 0)) setPinned(body, i, s.pinned[i] != 0);
    const auto mass = static_cast<btScalar>(s.mass[i]);
    if (s.pinned[i])
      point.massBeforePin = mass;
    else if (point.getInvMass() != btScalar(1) / mass)
      point.setMassProps(mass, btVector3(0, 0, 0));
    if (!s.pinned[i]) continue;
    const double* target = s.pinTarget.data() + 3 * std::size_t{i};
    point.getWorldTransform().setOrigin(toBullet({target[0], target[1], target[2]}));
    remember(body.masses, i);
  }
  absorbOutsideChanges(body);
}

void restoreSprings(SoftBodyData& body, const BodyState& s) {
  forgetConstants(body);
  body.springs.yielded.reset();
  body.springs.broken = 0;
  if (s.softenedTo > 0.0) softenTo(body, s.softenedTo, pointsOf(s.softenedMass));
  if (s.broken.empty()) return;
  body.springs.yielded = std::make_shared<SpringConstants>(*body.springs.original);
  body.springs.yielded->restLength = s.yieldedLength;
  for (std::size_t i = 0; i < s.broken.size(); ++i)
    if (s.broken[i]) breakSpring(body.springs, i);
}

void restoreImpulses(SoftBodyData& body, const BodyState& s) {
  body.storedImpulses.clear();
  const btCollisionObjectArray& objects = body.world->getCollisionObjectArray();
  for (std::size_t i = 0; i < s.touched.size(); ++i) {
    if (s.touched[i] >= static_cast<std::uint64_t>(objects.size())) continue;
    const btCollisionObject* object = objects[static_cast<int>(s.touched[i])];
    if (!object->getBroadphaseHandle()) continue;
    const double* j = s.impulse.data() + 4 * i;
    body.storedImpulses.push_back({object->getBroadphaseHandle()->m_uniqueId, object, s.key[i],
                                   ContactImpulse{j[0], Eigen::Vector3d(j[1], j[2], j[3])}});
  }
  sortImpulses(body.storedImpulses);
}

void restoreFrom(SoftBodyData& body, const BodyState& s) {
  forgetMotion(body);
  wakeBody(body, false);
  restorePins(body, s);
  body.state.position = pointsOf(s.position);
  body.state.velocity = pointsOf(s.velocity);
  body.masses.startPosition = pointsOf(s.startPosition);
  body.startVelocity = pointsOf(s.startVelocity);
  restoreSprings(body, s);
  restoreImpulses(body, s);
  body.surface.frame = s.frame;
  body.calmTime = s.calmTime;
  body.errorPerSecond = s.errorPerSecond;
  body.errorCoefficient = s.errorCoefficient;
  body.rateHistory = s.rates;
  body.energyLimit = s.energy;
  body.substeps = s.substeps;
  body.stepper = s.stepper;
  body.prefersImplicit = s.prefersImplicit;
  body.restorations = s.restorations;
  mediumOf(body).lastWind = s.lastWind;
  forgetCaches(body);
  writeToBullet(body);
  // writing has iterated further
  body.surface.frame = s.frame;
  if (s.asleep) putToSleep(body);
}

template <class State>
Bytes sealedBytes(const SealedFormat& format, const State& write) {
  Bytes bytes;
  bytes.resize(kHeaderBytes);
  ByteWriter writer(bytes);
  write(writer);
  seal(format, format.version, bytes);
  return bytes;
}

/// Reads what transfer(reader, state) declares from sealed bytes. Returns why it cannot, or an empty string.
template <class State, class Transfer>
std::string readSealed(const SealedFormat& format, const Bytes& bytes, State& state, Transfer transfer) {
  if (std::string reason = checkSealed(format, bytes.data(), bytes.size()); !reason.empty()) return reason;
  ByteReader reader(bytes.data() + kHeaderBytes, bytes.size() - kHeaderBytes);
  transfer(reader, state);
  if (!reader.problem().empty()) return reader.problem();
  return reader.bytesLeft() > 0 ? "bytes follow the end of its contents" : std::string();
}

Result<BodyState> readState(const Bytes& bytes) {
  BodyState s;
  const auto transfer = [](ByteReader& reader, BodyState& state) { transferState(reader, state); };
  if (std::string reason = readSealed(kStateFormat, bytes, s, transfer); !reason.empty())
    return Error{std::move(reason)};
  if (Result<void> valid = validate(s.settings); !valid) return Error{"settings: " + valid.error()};
  return s;
}

/// Also checks that the state suits the body, before anything of the body changes.
Result<BodyState> readState(const SoftBodyData& body, const Bytes& bytes) {
  Result<BodyState> state = readState(bytes);
  if (!state) return state;
  if (std::string reason = checkState(body, *state); !reason.empty()) return Error{std::move(reason)};
  return state;
}

Bytes saveStateOf(SoftBodyData& body) {
  Bytes bytes = sealedBytes(kStateFormat, [&](ByteWriter& writer) {
    const BodyState state = stateOf(body);
    transferState(writer, state);
  });
  forgetCaches(body);
  return bytes;
}

Result<void> restoreStateOf(SoftBodyData& body, const Bytes& bytes) {
  if (!body.alive) return Error{"the soft body is disabled, see alive()"};
  Result<BodyState> state = readState(body, bytes);
  if (!state) return Error{state.error()};
  if (Result<void> changed = changeSettings(body, state->settings); !changed) return changed;
  // a change keeps the place and velocities at the start
  body.settings = state->settings;
  restoreFrom(body, *state);
  return {};
}

}  // namespace

// --- the user's functions ----------------------------------------------------------------------------------

Bytes SoftBody::saveState() { return saveStateOf(*data_); }

Result<void> SoftBody::restoreState(const Bytes& bytes) { return restoreStateOf(*data_, bytes); }

namespace {

template <class Stream, class Settings>
void transferSpring(Stream& stream, Settings& s) {
  transferOptional(stream, "restLength", s.restLength);
  stream.value("stiffness", s.stiffness);
  stream.value("damping", s.damping);
  stream.value("action", s.action);
}

/// The state of a system: of its bodies and single springs, in order of creation.
struct SystemState {
  double time = 0.0;  ///< s, of wind and fields
  std::vector<Bytes> bodies;
  std::vector<SpringSettings> springs;
};

template <class Stream, class State>
void transferSystem(Stream& stream, State& state) {
  stream.value("time", state.time);
  stream.resize("bodies", state.bodies, sizeof(std::uint64_t));
  for (auto& body : state.bodies) stream.array("bytes of a body", body);
  stream.resize("springs", state.springs, sizeof(std::uint64_t));
  for (auto& spring : state.springs) transferSpring(stream, spring);
}

/// Returns why a state does not suit a system, or an empty string.
std::string checkCount(const char* what, std::size_t saved, std::size_t present) {
  if (saved == present) return {};
  return "the saved state has " + std::to_string(saved) + " " + what + ", the system " +
         std::to_string(present);
}

}  // namespace

Bytes SoftBodySystem::saveState() {
  SystemState state;
  state.time = impl_->surroundings.time;
  for (const auto& body : impl_->bodies) state.bodies.push_back(saveStateOf(*body->data_));
  for (const auto& spring : impl_->springs) state.springs.push_back(spring->settings());
  return sealedBytes(kSystemFormat,
                     [&](ByteWriter& writer) { transferSystem(writer, std::as_const(state)); });
}

Result<void> SoftBodySystem::restoreState(const Bytes& bytes) {
  SystemState state;
  const auto transfer = [](ByteReader& reader, SystemState& s) { transferSystem(reader, s); };
  if (std::string reason = readSealed(kSystemFormat, bytes, state, transfer); !reason.empty())
    return Error{std::move(reason)};
  std::string reason = checkCount("bodies", state.bodies.size(), impl_->bodies.size());
  if (reason.empty()) reason = checkCount("springs", state.springs.size(), impl_->springs.size());
  for (std::size_t i = 0; i < state.springs.size() && reason.empty(); ++i)
    if (Result<void> valid = validate(state.springs[i]); !valid)
      reason = "spring " + std::to_string(i) + ": " + valid.error();
  for (std::size_t i = 0; i < state.bodies.size() && reason.empty(); ++i)
    if (const auto read = readState(*impl_->bodies[i]->data_, state.bodies[i]); !read)
      reason = "body " + std::to_string(i) + ": " + read.error();
  if (reason.empty() && !(std::abs(state.time) <= kMaxSound)) reason = "its time is not finite";
  if (!reason.empty()) return Error{std::move(reason)};
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Result<void> restored = impl_->bodies[i]->restoreState(state.bodies[i]);
    if (!restored) return Error{"body " + std::to_string(i) + ": " + restored.error()};
  }
  impl_->surroundings.time = state.time;
  for (std::size_t i = 0; i < state.springs.size(); ++i) impl_->springs[i]->settings_ = state.springs[i];
  impl_->step->groupsStale = true;
  return {};
}

Result<SoftBody*> SoftBodySystem::clone(SoftBody* body, const btTransform& transform) {
  if (!impl_->step->owns(body)) return Error{"the soft body is not, or no longer, in this world"};
  const Bytes state = body->saveState();
  Result<SoftBody*> copy = createBody(body->sharedNetwork(), body->settings());
  if (!copy) return copy;
  Result<void> done = (*copy)->restoreState(state);
  if (done) done = (*copy)->setTransform(transform);
  if (done) return copy;
  destroyBody(*copy);
  return Error{done.error()};
}

// --- bodies with their networks ----------------------------------------------------------------------------

namespace {

/// Everything of a body, to create it in another world.
struct WholeBody {
  Bytes network, state;
  std::string name;
};

template <class Stream, class Bodies>
void transferBodies(Stream& stream, Bodies& bodies) {
  stream.resize("bodies", bodies, 3 * sizeof(std::uint64_t));
  for (auto& body : bodies) {
    stream.array("bytes of a network", body.network);
    stream.array("bytes of a state", body.state);
    stream.array("letters of a name", body.name);
  }
}

Bytes bytesOf(const std::vector<WholeBody>& bodies) {
  return sealedBytes(kBodiesFormat, [&](ByteWriter& writer) { transferBodies(writer, bodies); });
}

WholeBody wholeBodyOf(SoftBodyData& body) {
  return {toBytes(*body.model->network), saveStateOf(body), body.name};
}

/// The code of chunks of soft bodies in Bullet's files, and the start of such a file: "BULLETf" or "BULLETd",
/// '-' for 8-byte pointers, 'v' for little-endian numbers.
constexpr char kChunkCode[] = {'L', 'I', 'M', 'B'}, kBulletFile[] = {'B', 'U', 'L', 'L', 'E', 'T'};
constexpr std::size_t kBulletHeader = 12;

/// Returns the contents of the chunks of soft bodies. A chunk has a header of its code, length, pointer, type
/// and number.
std::vector<Bytes> chunksOf(const Bytes& file) {
  std::vector<Bytes> chunks;
  const std::size_t pointer = file[7] == '-' ? 8 : 4, header = 16 + pointer;
  for (std::size_t at = kBulletHeader; at + header <= file.size();) {
    const std::size_t length = readLittleEndian<std::uint32_t>(&file[at + 4]);
    if (length > file.size() - at - header) break;
    const std::uint8_t* begin = file.data() + at + header;
    if (std::equal(kChunkCode, kChunkCode + 4, &file[at]) && length >= kHeaderBytes)
      // without the padding
      chunks.emplace_back(begin, begin + std::min(length, sealedSize(begin)));
    at += header + length;
  }
  return chunks;
}

bool isBulletFile(const Bytes& bytes) {
  return bytes.size() >= kBulletHeader &&
         std::equal(std::begin(kBulletFile), std::end(kBulletFile), bytes.begin());
}

/// Adds the bodies in the bytes to `bodies`. Returns why they cannot be read, or an empty string.
std::string readBodies(const Bytes& bytes, std::vector<WholeBody>& bodies) {
  if (isBulletFile(bytes)) {
    if (bytes[8] != 'v') return "the .bullet file has big-endian numbers";
    for (const Bytes& chunk : chunksOf(bytes))
      if (std::string reason = readBodies(chunk, bodies); !reason.empty()) return reason;
    return {};
  }
  std::vector<WholeBody> read;
  const auto transfer = [](ByteReader& reader, std::vector<WholeBody>& all) { transferBodies(reader, all); };
  std::string reason = readSealed(kBodiesFormat, bytes, read, transfer);
  bodies.insert(bodies.end(), read.begin(), read.end());
  return reason;
}

using Networks = std::map<Bytes, SharedNetwork>;

/// Makes a body. Equal networks are read once.
Result<SoftBody*> makeFrom(SoftBodySystem& system, const WholeBody& saved, Networks& networks) {
  SharedNetwork& network = networks[saved.network];
  if (!network) {
    Result<SharedNetwork> read = fromBytes(saved.network.data(), saved.network.size());
    if (!read) return Error{read.error()};
    network = *read;
  }
  const Result<BodyState> state = readState(saved.state);
  if (!state) return Error{state.error()};
  Result<SoftBody*> body = system.createBody(network, state->settings);
  if (!body) return body;
  const Result<void> restored = (*body)->restoreState(saved.state);
  if (restored) return body;
  system.destroyBody(*body);
  return Error{restored.error()};
}

}  // namespace

void writeChunk(SoftBodyData& body, btSerializer& serializer) {
  Bytes bytes = bytesOf({wholeBodyOf(body)});
  // Bullet reads the chunks that follow as numbers of 8 bytes
  bytes.resize((bytes.size() + 7) / 8 * 8);
  btChunk* chunk = serializer.allocate(bytes.size(), 1);
  std::memcpy(chunk->m_oldPtr, bytes.data(), bytes.size());
  int code = 0;
  std::memcpy(&code, kChunkCode, sizeof code);
  serializer.finalizeChunk(chunk, "char", code, &body);
}

Bytes SoftBodySystem::saveBodies() {
  std::vector<WholeBody> bodies;
  for (const auto& body : impl_->bodies)
    if (body->alive()) bodies.push_back(wholeBodyOf(*body->data_));
  return bytesOf(bodies);
}

Result<std::vector<SoftBody*>> SoftBodySystem::loadBodies(const Bytes& bytes) {
  std::vector<WholeBody> bodies;
  if (std::string reason = readBodies(bytes, bodies); !reason.empty()) return Error{std::move(reason)};
  Networks networks;
  std::vector<SoftBody*> made;
  std::string reason;
  for (std::size_t i = 0; i < bodies.size() && reason.empty(); ++i) {
    Result<SoftBody*> body = makeFrom(*this, bodies[i], networks);
    if (body) {
      (*body)->setName(bodies[i].name);
      made.push_back(*body);
    } else {
      reason = "body " + std::to_string(i) + ": " + body.error();
    }
  }
  if (reason.empty()) return made;
  for (SoftBody* body : made) destroyBody(body);
  return Error{std::move(reason)};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
