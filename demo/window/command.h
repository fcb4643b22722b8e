// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/result.h>

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

namespace limber::demo {

/// What a user can do with a scene. Everything that changes a scene or its view is a command, so that a
/// recording of commands repeats a run.
enum class Action {
  Camera,   ///< yaw, pitch, distance, target
  Grab,     ///< ray: holds the body that it hits
  Drag,     ///< ray: moves what is held to the ray
  Release,  ///< lets it go
  Shoot,    ///< ray: a ball flies along it
  Cut,      ///< eye, two directions: cuts all bodies between these rays
  Pin,      ///< ray: pins the nearest point, or unpins it
  Set,      ///< name and value of a setting
  Show,     ///< name of a layer and 1 or 0
  Restart,  ///< the scene again, with the present settings
  Scene,    ///< another scene
  Pause,    ///< 1, or 0: goes on
  Tick,     ///< one tick while paused
  Speed,    ///< simulated seconds a second, up to 1
  Wait      ///< 1/60 s of a pause that have passed; changes nothing
};

struct Command {
  Action action = Action::Release;
  std::vector<double> numbers;  ///< as many as the action has
  std::string word;             ///< a name, or empty
};

/// Returns the command as one line, which parseCommand() reads to the same bits.
std::string textOf(const Command& command);

/// Errors: an unknown action or name, a wrong count of numbers, a number that is not finite or outside the
/// range of its setting.
Result<Command> parseCommand(const std::string& text);

// --- settings ----------------------------------------------------------------------------------------------

enum class Setting {
  Stiffness,
  Damping,
  Pressure,
  Gravity,
  Wind,
  WindDirection,
  MaxSubsteps,
  Tolerance,
  BulletIterations,  ///< from here on those of btSoftBody, see bullet_soft::TwinSettings
  BulletStiffness,
  BulletDamping,
  BulletPressure,
  BulletFriction,
  BulletMargin
};
constexpr std::size_t kSettingCount = 14;
constexpr bool isOfBullet(Setting setting) { return setting >= Setting::BulletIterations; }

struct SettingInfo {
  const char* name;   ///< in commands
  const char* label;  ///< in the panel
  double low, high, start;
  bool logarithmic;
  bool whole;  ///< only whole numbers
};

const std::array<SettingInfo, kSettingCount>& settingList();

/// The values of the settings, by Setting.
struct Settings {
  std::array<double, kSettingCount> values;

  Settings();
  double& operator[](Setting setting) { return values[static_cast<std::size_t>(setting)]; }
  double operator[](Setting setting) const { return values[static_cast<std::size_t>(setting)]; }
};

// --- layers of the picture ---------------------------------------------------------------------------------

enum class Layer {
  Strain,
  Contacts,
  Boxes,
  Velocities,
  Constraints,
  Shadows,
  Islands,
  Gallery,
  Panel,
  Split
};
constexpr std::size_t kLayerCount = 10;

struct LayerInfo {
  const char* name;
  char key;  ///< that toggles it
  bool start;
};

const std::array<LayerInfo, kLayerCount>& layerList();

// --- rays --------------------------------------------------------------------------------------------------

struct Ray {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();      ///< m
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit

  Eigen::Vector3d at(double distance) const { return origin + distance * direction; }
};

/// Returns a command whose numbers are the ray.
Command rayCommand(Action action, const Ray& ray);
/// Returns the ray of such a command.
Ray rayOf(const Command& command);

}  // namespace limber::demo
