// SPDX-License-Identifier: Zlib
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limber::fuzz {

/// Kinds of steps. The first group builds the scene, the second is the user's actions.
enum class Kind : std::uint8_t {
  World,
  Time,
  Floor,
  Rigid,
  Soft,
  Joint,
  MultiBody,
  Ghost,
  Character,
  Vehicle,
  Spring,
  ChangeSpring,
  Attach,
  Detach,
  Forget,
  Pin,
  MovePin,
  Unpin,
  Push,
  Velocity,
  Teleport,
  Destroy,
  Leave,
  Enter,
  Flags,
  Mass,
  Material,
  Filter,
  OverlapFilter,
  Shape,
  Scaling,
  Gravity,
  Listener,
  Report,
  Look,
  Ray,
  Sleep,
  Sync,
  Hook,
  Clock,
  System,
  Surround,
  Change
};
inline constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::Change) + 1;

/// Time of a user's step: between two calls of stepSimulation(), or in a callback of Bullet or Limber.
enum class Phase : std::uint8_t { Between, PreTick, Tick, Listener, Action };
inline constexpr std::size_t kPhases = 5;

/// Exponents of a field's unit, for laws that rescale them.
struct Unit {
  int kg = 0, m = 0, s = 0;
};

/// How a field changes when the scene is moved, rotated or mirrored.
enum class Role : std::uint8_t {
  Number,
  Choice,     ///< index of one of `choices`
  Reference,  ///< id of an object, 0: none
  Place,      ///< a position in the world
  Vector,     ///< a direction in the world
  Axial,      ///< an angular velocity or a torque
  Rotation,   ///< a rotation vector
  Sizes       ///< three numbers along the axes of an object
};

struct Field {
  std::string name;
  Role role = Role::Number;
  Unit unit;
  std::array<double, 3> standard{};  ///< default; toText() leaves it out
  std::vector<std::string> choices;
  std::size_t offset = 0;  ///< of its first number in Step::values

  std::size_t size() const { return role >= Role::Place ? 3 : 1; }
};

const std::string& nameOf(Kind kind);
const std::string& nameOf(Phase phase);
const std::vector<Field>& fieldsOf(Kind kind);

/// One step: numbers, one or three for each field of its kind. A step that refers to an object that does not
/// exist does nothing, so any step may be removed from a story.
struct Step {
  Kind kind = Kind::World;
  int id = 0;   ///< of the object that it creates, 0: none
  int at = -1;  ///< frame in which it is done; -1: before the first
  Phase phase = Phase::Between;
  std::vector<double> values;

  explicit Step(Kind of, int frame = -1);
  double operator[](const char* field) const;
  int whole(const char* field) const;
  bool is(const char* field) const { return (*this)[field] != 0.0; }
  Eigen::Vector3d vec(const char* field) const;
  const std::string& choice(const char* field) const;
  Step& set(const char* field, double value);
  Step& set(const char* field, const Eigen::Vector3d& value);
  Step& choose(const char* field, const std::string& choice);
};

/// A scene and the user's actions in it, in order.
struct Story {
  std::uint64_t seed = 0;
  std::vector<Step> steps;

  /// Returns the first step of a kind, or one with the standard values if there is none.
  Step first(Kind kind) const;
};

std::string toText(const Story& story);
/// Reads the text of toText(). Throws std::runtime_error with the first invalid line.
Story fromText(const std::string& text);

}  // namespace limber::fuzz
