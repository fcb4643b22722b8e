// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/bullet_twin.h"
#include "scenes/scene.h"
#include "window/command.h"
#include "window/orbit_camera.h"
#include "window/picking.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limber::demo {

/// How many ticks a frame has, so that a scene runs at the speed of the clock, or slower.
class Pace {
 public:
  bool paused = false;
  double speed = 1.0;  ///< simulated seconds a second, above 0 to 1

  /// Asks for one tick while paused.
  void step() { ++steps_; }

  /// Returns the number of ticks of a frame after so many seconds. A machine that is too slow for the speed
  /// gets few ticks a frame, so that it stays usable.
  int ticksDue(double seconds);

  /// Returns the position between the last two ticks: 0 to 1.
  double tickFraction() const { return paused ? 1.0 : remainder_; }

 private:
  int steps_ = 0;
  double remainder_ = 1.0;  // ticks
};

/// Returns the next slower speed, or full speed after the slowest.
double slowerThan(double speed);

/// Where a window shows the scene: all of it, or with the split two views of one size, right of the panel if
/// there is space.
struct ViewLayout {
  int left = 0;     ///< pixels before the first view
  WindowSize view;  ///< of each view
  bool split = false;

  /// Returns the pixel of a view for one of the window.
  Pixel inFirst(Pixel window) const { return {window.x - left, window.y}; }
  Pixel inSecond(Pixel window) const { return {window.x - left - view.width, window.y}; }
  bool isSecond(Pixel window) const { return split && window.x >= left + view.width; }
};

/// Pixels that the panel takes from the left, in coordinates of the mouse.
constexpr int kPanelStrip = 326;

/// Returns the layout of a window; `scale` is the number of its pixels for one of the mouse's coordinates.
inline ViewLayout layoutOf(const WindowSize& window, bool split, bool panel, double scale = 1.0) {
  constexpr int kNarrow = 3;  // the panel leaves two thirds of the window
  ViewLayout layout;
  layout.view = window;
  layout.split = split;
  if (!split) return layout;
  const int strip = static_cast<int>(kPanelStrip * scale);
  if (panel && window.width >= kNarrow * strip) layout.left = strip;
  layout.view.width = std::max(1, (window.width - layout.left) / 2);
  return layout;
}

/// A scene of the list and its options.
struct SceneChoice {
  std::string name = "cubes";
  scenes::SceneOptions options;
};

/// Figures of all soft bodies.
struct Diagnostics {
  double kinetic = 0.0, elastic = 0.0, potential = 0.0;  ///< J; potential energy above y = 0
  double error = 0.0;                                    ///< m/s, the largest SoftBody::errorPerSecond()
};

/// A scene that a user plays with. It changes only by perform() and tick(), and the same calls in the same
/// order give the same states, to the bit. It needs neither a window nor OpenGL.
class Session {
 public:
  /// Is called for each command that was performed, with what came of it.
  using Listener = std::function<void(const Command&, const std::string& outcome)>;

  /// Errors: those of the scene.
  static Result<std::unique_ptr<Session>> create(const SceneChoice& choice, const WindowSize& size);
  ~Session();

  void setListener(Listener listener) { listener_ = std::move(listener); }

  /// Performs a command. Returns what came of it in words: "body 3 point 0", "nothing there".
  std::string perform(const Command& command);
  /// Steps the world by 1/60 s, also while paused.
  scenes::TickTimes tick();
  /// Returns the number of ticks of a frame after so many seconds, see Pace.
  int ticksDue(double seconds) { return pace_.ticksDue(seconds); }

  scenes::Scene& scene() { return *scene_; }
  const scenes::Scene& scene() const { return *scene_; }
  /// Is another number after each restart and change of the scene.
  int sceneNumber() const { return sceneNumber_; }
  const SceneChoice& choice() const { return choice_; }
  const Settings& settings() const { return settings_; }
  const Settings& startSettings() const { return start_; }  ///< that the scene begins with
  bool shows(Layer layer) const { return layers_[static_cast<std::size_t>(layer)]; }
  const OrbitCamera& camera() const { return camera_; }
  const Hand& hand() const { return hand_; }
  const Pace& pace() const { return pace_; }
  /// The same scene with Bullet's own soft bodies; nullptr without the split, or if there is bulletProblem().
  const bullet_soft::BulletTwin* bulletTwin() const { return twin_.get(); }
  /// Returns why btSoftBody does not play the scene, or an empty string.
  std::string bulletProblem() const;
  ViewLayout layout(const WindowSize& window) const;
  std::int64_t ticks() const { return ticks_; }  ///< of all scenes so far
  Diagnostics diagnostics() const;
  /// Returns a hash of the exact state of all bodies, with the split also of btSoftBody's.
  std::uint64_t stateHash() const;

 private:
  Session() = default;

  std::string create(const SceneChoice& choice);
  void createTwin();
  void tickTwin();
  std::string show(const Command& command);
  std::string act(const Command& command);
  std::string grab(const Ray& ray);
  std::string shoot(const Ray& ray);
  std::string cut(const std::vector<double>& numbers);
  std::string pin(const Ray& ray);
  std::string set(const Command& command);
  std::string restart();
  std::string nextScene(const std::string& name);
  std::string apply(Setting setting);
  std::string changeBodies(bool tellPressure);
  void applyGravity();

  SceneChoice choice_;
  WindowSize size_;
  std::unique_ptr<scenes::Scene> scene_;
  std::vector<SoftBodySettings> made_;  // settings of each body as the scene made it
  Settings start_, settings_;           // of the scene, and at present
  std::array<bool, kLayerCount> layers_{};
  OrbitCamera camera_;
  Pace pace_;
  Hand hand_;  // is destroyed before the scene
  std::unique_ptr<bullet_soft::BulletTwin> twin_;
  std::string twinProblem_;  // why there is no twin
  std::int64_t ticks_ = 0;
  int sceneNumber_ = 0;
  Listener listener_;
};

/// Returns the camera that frames the scene.
OrbitCamera framedCamera(const scenes::Scene& scene, const WindowSize& size);

}  // namespace limber::demo
