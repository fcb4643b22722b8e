// SPDX-License-Identifier: Zlib

// This file saves the state of a body as bytes, and restores it. A state is one list of numbers, which
// transferState() declares for the writer and the reader.

#include "bullet/body_in_world.h"
#include "bullet/contact_report.h"
#include "bullet/linked_group.h"
#include "bullet/tick_contacts.h"
#include "mesh/bytes.h"

#include <type_traits>

namespace limber {

// what ByteReader needs to know of the settings' types
static constexpr Stepper lastOf(Stepper) { return Stepper::Newton; }
static constexpr Collision lastOf(Collision) { return Collision::Surface; }

inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr SealedFormat kStateFormat = {
    {0x89, 'L', 'I', 'M', 'S', 'T', '\r', '\n'}, "a saved state", "the saved state", 11, 11};

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
  stream.value("searchDistance", s.searchDistance);
}

template <class Stream, class Settings>
void transferLimit(Stream& stream, Settings& s) {
  stream.value("stiffenStrain", s.stiffenStrain);
  stream.value("stiffenFactor", s.stiffenFactor);
  stream.value("yieldStrain", s.yieldStrain);
  stream.value("yieldMaximum", s.yieldMaximum);
  stream.value("breakStrain", s.breakStrain);
  transferFlag(stream, "tear", s.tear);
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
  stream.resize("groups", s.groups, 6 * sizeof(double));
  for (auto& group : s.groups) {
    stream.array("letters of a group's name", group.name);
    stream.value("stiffness of a group", group.stiffness);
    stream.value("damping of a group", group.damping);
    stream.value("limitStrain of a group", group.limitStrain);
    stream.value("restLength of a group", group.restLength);
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
  transferFlag(stream, "hollow", s.hollow);
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
struct BodyState : MotionMemory {
  std::uint64_t network = 0;  ///< hash
  SoftBodySettings settings;
  std::vector<double> position, velocity, startPosition;  ///< 3 x #points
  std::vector<double> startVelocity;                      ///< 3 x #points, or empty
  std::vector<double> mass;                               ///< #points, kg; of pinned points, that before
  std::vector<std::uint8_t> pinned;                       ///< #points
  std::vector<double> pinTarget;                          ///< 3 x #points, m; 0 where not pinned
  std::vector<double> yieldedLength;                      ///< #springs, in the network's order, m, or empty
  std::vector<std::uint8_t> broken;                       ///< #springs, likewise, or empty
  Eigen::Quaterniond frame = Eigen::Quaterniond::Identity();
  bool asleep = false, freed = false;
  double softenedTo = 0.0;
  std::vector<double> softenedMass;  ///< 3 x #points, inverse masses for which it was softened, or empty
  int overlapTicks = 0;
  Eigen::Vector3d lastWind = Eigen::Vector3d::Zero();  ///< m/s, see BodyMedium
  std::vector<double> otherForces;                     ///< 3, N/kg, BodyMedium::others, or empty
  std::vector<std::uint64_t> touched, key;  ///< #impulses: index in the world of the partner, features
  std::vector<double> impulse;              ///< 4 x #impulses, N s
  std::vector<std::uint64_t> near;          ///< #held partners, their index in the world
  std::vector<double> nearBox;              ///< 6 x #held partners, m, HeldPartner::box
  std::vector<std::uint64_t> other;         ///< #contacts(), index in the world of the other object
  std::vector<std::uint32_t> sides;         ///< 8 x #contacts(), two sides' triangle and points
  std::vector<double> contact;              ///< 20 x #contacts(), see numbersOf()
};

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
  transferFlag(stream, "release", s.freed);
  stream.value("overlap", s.overlapTicks);
  stream.value("budget", s.resolvedBy);
  for (auto* number : {&s.calmTime, &s.softenedTo, &s.resolved, &s.errorPerSecond, &s.errorCoefficient})
    stream.value("measures", *number);
  stream.array("inverse masses", s.softenedMass);
  for (auto* rates : {&s.rateHistory.now, &s.rateHistory.before})
    for (auto* rate : {&rates->boundSquared, &rates->fastestSquared, &rates->turnRate})
      stream.value("rates", *rate);
  stream.value("age", s.rateHistory.age);
  for (auto* flag : {&s.energyLimit.on, &s.energyLimit.persists, &s.energyLimit.forceScaled})
    transferFlag(stream, "energy limit", *flag);
  stream.value("energy limit", s.energyLimit.bound);
  for (auto* number : {&s.energyLimit.atEnd, &s.energyLimit.tick, &s.energyLimit.unsteady})
    stream.value("energy limit", *number);
  stream.value("substeps", s.substeps);
  stream.value("stepper", s.stepper);
  transferFlag(stream, "stepper", s.prefersImplicit);
  stream.value("restorations", s.restorations);
  transferVector(stream, "wind", s.lastWind);
  stream.array("forces in water", s.otherForces);
  stream.array("touched objects", s.touched);
  stream.array("touched features", s.key);
  stream.array("impulses", s.impulse);
  stream.array("objects near", s.near);
  stream.array("boxes of objects near", s.nearBox);
  stream.array("objects in contact", s.other);
  stream.array("sides of contacts", s.sides);
  stream.array("contacts", s.contact);
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
  body.surface.release = 0.0;
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
    if (!body.masses.bodies[i]) continue;  // deleted by the application
    const PointMass& point = *body.masses.bodies[i];
    s.pinned[i] = point.isKinematicObject();
    const btScalar mass = presentMass(point, s.mass[i]);
    if (mass != static_cast<btScalar>(s.mass[i])) s.mass[i] = double(mass);
    for (int axis = 0; axis < 3 && s.pinned[i]; ++axis)
      s.pinTarget[3 * std::size_t{i} + static_cast<std::size_t>(axis)] =
          double(point.getWorldTransform().getOrigin()[axis]);
  }
}

void saveSprings(const SoftBodyData& body, BodyState& s) {
  if (const SpringConstants* own = body.springs.yielded.get()) {
    s.yieldedLength.resize(body.springs.size());
    s.broken.resize(body.springs.size());
    for (std::size_t i = 0; i < body.springs.size(); ++i) {
      const std::uint32_t spring = own->division.order[i];
      s.yieldedLength[spring] = own->restLength[i];
      s.broken[spring] = isBroken(body.springs, i);
    }
  }
  if (!body.softening) return;
  s.softenedTo = body.softening->largest;
  s.softenedMass = numbersOf(body.softening->inverseMass);
}

/// Adds the index of an object in the world. Returns false if it has left the world; then it may be deleted.
bool addIndex(const SoftBodyData& body, const btCollisionObject* object,
              std::vector<std::uint64_t>& indices) {
  const btCollisionObjectArray& objects = body.world->getCollisionObjectArray();
  const int index = objects.findLinearSearch(const_cast<btCollisionObject*>(object));
  if (index >= objects.size()) return false;
  indices.push_back(static_cast<std::uint64_t>(index));
  return true;
}

/// Returns the object with this index in the world, or nullptr.
btCollisionObject* objectAt(const SoftBodyData& body, std::uint64_t index) {
  const btCollisionObjectArray& objects = body.world->getCollisionObjectArray();
  if (index >= static_cast<std::uint64_t>(objects.size())) return nullptr;
  btCollisionObject* object = objects[static_cast<int>(index)];
  return object->getBroadphaseHandle() ? object : nullptr;
}

void saveImpulses(const SoftBodyData& body, BodyState& s) {
  for (const StoredImpulse& stored : body.storedImpulses) {
    if (!addIndex(body, stored.object, s.touched)) continue;
    s.key.push_back(stored.key);
    const ContactImpulse& j = stored.impulse;
    s.impulse.insert(s.impulse.end(), {j.along, j.across.x(), j.across.y(), j.across.z()});
  }
}

/// Saves where static and kinematic objects near the body were: those that come are tested for overlaps.
void saveNear(const SoftBodyData& body, BodyState& s) {
  for (const HeldPartner& held : body.heldPartners) {
    if (!addIndex(body, held.handle.object, s.near)) continue;
    for (const Eigen::Vector3d& corner : {held.box.min(), held.box.max()})
      s.nearBox.insert(s.nearBox.end(), corner.data(), corner.data() + 3);
  }
}

constexpr std::size_t kContactNumbers = 20, kSideNumbers = 8;

/// Calls visit(number) for each floating-point number of a contact.
template <class Contact, class Visit>
void forEachNumber(Contact& c, Visit visit) {
  for (auto* vector : {&c.position, &c.normal, &c.impulse, &c.frictionImpulse})
    for (int i = 0; i < 3; ++i) visit((*vector)[i]);
  for (auto* number : {&c.distance, &c.normalImpulse}) visit(*number);
  for (auto* side : {&c.side, &c.otherSide})
    for (int i = 0; i < 3; ++i) visit(side->weights[i]);
}

/// Contacts with objects that have left the world are left out.
void saveContacts(SoftBodyData& body, BodyState& s) {
  const std::vector<SoftContact>& contacts = readReport(body);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SoftContact& c = contacts[i];
    if (!addIndex(body, c.other, s.other)) continue;
    for (const ContactSide* side : {&c.side, &c.otherSide}) {
      s.sides.push_back(side->triangle);
      s.sides.insert(s.sides.end(), side->points.begin(), side->points.end());
    }
    forEachNumber(c, [&](double number) { s.contact.push_back(number); });
  }
}

BodyState stateOf(SoftBodyData& body) {
  readFromBullet(body);
  BodyState s;
  s.network = hashOf(*body.model->network);
  s.settings = body.settings;
  savePoints(body, s);
  saveSprings(body, s);
  if (isAlive(body)) saveImpulses(body, s), saveNear(body, s), saveContacts(body, s);
  s.frame = body.surface.frame;
  s.asleep = body.asleep;
  s.freed = body.surface.freed;
  s.overlapTicks = body.surface.overlapTicks;
  static_cast<MotionMemory&>(s) = body;
  if (body.medium) s.lastWind = body.medium->lastWind;
  if (body.medium && body.medium->others) s.otherForces = numbersOf(*body.medium->others);
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
      (!s.startVelocity.empty() && s.startVelocity.size() != 3 * n) ||
      (!s.otherForces.empty() && s.otherForces.size() != 3) || s.touched.size() != s.key.size() ||
      4 * s.touched.size() != s.impulse.size() || 6 * s.near.size() != s.nearBox.size() ||
      kSideNumbers * s.other.size() != s.sides.size() || kContactNumbers * s.other.size() != s.contact.size())
    return "the saved state has arrays of different sizes";
  for (const auto* array :
       {&s.position, &s.velocity, &s.startPosition, &s.pinTarget, &s.mass, &s.yieldedLength, &s.softenedMass,
        &s.impulse, &s.startVelocity, &s.otherForces, &s.contact})
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
  for (std::size_t i = 0; i < s.broken.size(); ++i) {
    const std::uint32_t spring = body.springs->division.order[i];
    body.springs.yielded->restLength[i] = s.yieldedLength[spring];
    if (s.broken[spring]) breakSpring(body.springs, i);
  }
}

void restoreImpulses(SoftBodyData& body, const BodyState& s) {
  body.storedImpulses.clear();
  for (std::size_t i = 0; i < s.touched.size(); ++i) {
    const btCollisionObject* object = objectAt(body, s.touched[i]);
    if (!object) continue;
    const double* j = s.impulse.data() + 4 * i;
    body.storedImpulses.push_back(
        {idOf(*object), object, s.key[i], ContactImpulse{j[0], Eigen::Vector3d(j[1], j[2], j[3])}});
  }
  sortImpulses(body.storedImpulses);
}

void restoreNear(SoftBodyData& body, const BodyState& s) {
  body.contacts.clear();
  body.heldPartners.clear();
  for (std::size_t i = 0; i < s.near.size(); ++i) {
    const btCollisionObject* object = objectAt(body, s.near[i]);
    if (!object) continue;
    const Eigen::Map<const Eigen::Vector3d> low(s.nearBox.data() + 6 * i), high(low.data() + 3);
    HeldPartner& held = body.heldPartners.emplace_back();
    held.handle = handleOf(*object);
    held.box = {Eigen::Vector3d(low), Eigen::Vector3d(high)};
  }
}

/// Returns whether the contact's sides are in this body and in the other one.
bool hasValidSides(const SoftBodyData& body, const SoftContact& c) {
  const auto isValid = [](const SoftBodyData* of, const ContactSide& side) {
    if (!of) return side.weights.isZero(0.0);
    const auto isPoint = [&](std::uint32_t i) { return i < pointCount(*of); };
    return (side.triangle == ContactSide::kNone || side.triangle < of->model->network->surface.size()) &&
           std::all_of(side.points.begin(), side.points.end(), isPoint);
  };
  return isValid(&body, c.side) && isValid(c.otherBody ? &dataOf(*c.otherBody) : nullptr, c.otherSide);
}

void restoreContacts(SoftBodyData& body, const BodyState& s) {
  ContactReport& report = body.report;
  report = ContactReport();
  report.hasTriangles = true;
  for (std::size_t i = 0; i < s.other.size(); ++i) {
    SoftContact c;
    c.body = body.handle;
    c.other = objectAt(body, s.other[i]);
    if (!c.other) continue;
    if (const SoftBodyData* other = ownerOf(*c.other)) c.otherBody = other->handle;
    const std::uint32_t* at = s.sides.data() + kSideNumbers * i;
    for (ContactSide* side : {&c.side, &c.otherSide}) {
      side->triangle = *at++;
      for (std::uint32_t& point : side->points) point = *at++;
    }
    const double* number = s.contact.data() + kContactNumbers * i;
    forEachNumber(
        c, [&](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(*number++); });
    if (!hasValidSides(body, c)) continue;
    report.contacts.push_back(c);
    report.partners.push_back(handleOf(*c.other));
  }
}

void restoreFrom(SoftBodyData& body, const BodyState& s) {
  forgetMotion(body);
  wakeBody(body, false);
  restorePins(body, s);
  body.state.position = pointsOf(s.position);
  body.state.velocity = pointsOf(s.velocity);
  body.masses.startPosition = pointsOf(s.startPosition);
  body.masses.placed = true;
  body.startVelocity = pointsOf(s.startVelocity);
  restoreSprings(body, s);
  restoreImpulses(body, s);
  body.surface.frame = s.frame;
  static_cast<MotionMemory&>(body) = s;
  mediumOf(body).lastWind = s.lastWind;
  body.medium->others.reset();
  if (!s.otherForces.empty()) body.medium->others = Eigen::Map<const Eigen::Vector3d>(s.otherForces.data());
  body.rolledBack = true;
  forgetCaches(body);
  writeToBullet(body);
  updateQueryBoxes(body);
  // writing has iterated further
  body.surface.frame = s.frame;
  body.surface.freed = s.freed;
  body.surface.overlapTicks = s.overlapTicks;
  if (s.asleep) putToSleep(body);
  restoreNear(body, s);
  restoreContacts(body, s);
}

Result<BodyState> readState(const Bytes& bytes) {
  BodyState s;
  const auto transfer = [](ByteReader& reader, BodyState& state) { transferState(reader, state); };
  if (std::string reason = readSealed(kStateFormat, bytes.data(), bytes.size(), s, transfer); !reason.empty())
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

}  // namespace

Bytes saveStateOf(SoftBodyData& body) {
  Bytes bytes = sealedBytes(kStateFormat, [&](ByteWriter& writer) {
    const BodyState state = stateOf(body);
    transferState(writer, state);
  });
  if (!isAlive(body)) return bytes;  // the world may be gone
  forgetCaches(body);
  // the boxes of points are from the last tick
  if (!isSurfaceBody(body)) updateQueryBoxes(body);
  return bytes;
}

Result<SoftBodySettings> settingsIn(const Bytes& bytes) {
  Result<BodyState> state = readState(bytes);
  if (!state) return Error{state.error()};
  return state->settings;
}

Result<void> checkStateFor(SoftBodyData& body, const Bytes& bytes) {
  const Result<BodyState> state = readState(body, bytes);
  return state ? checkChange(body, state->settings) : Error{state.error()};
}

Result<void> restoreStateOf(SoftBodyData& body, const Bytes& bytes) {
  if (!isAlive(body)) return notAlive();
  Result<BodyState> state = readState(body, bytes);
  if (!state) return Error{state.error()};
  if (Result<void> changed = changeSettings(body, state->settings); !changed) return changed;
  // a change keeps the place and velocities at the start
  body.settings = state->settings;
  restoreFrom(body, *state);
  return {};
}

// --- the user's functions ----------------------------------------------------------------------------------

Bytes SoftBody::saveState() { return saveStateOf(*data_); }

Result<void> SoftBody::restoreState(const Bytes& bytes) {
  if (!isAlive(*data_)) return notAlive();
  if (Result<void> valid = checkStateFor(*data_, bytes); !valid) return valid;
  wakeNeighbours(*data_, false);  // it may go elsewhere
  return restoreStateOf(*data_, bytes);
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
