// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/rest_watch.h"
#include "scenes/scene_world.h"

#include <limber/limber.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace limber::scenes {

/// What a user may choose. What is left out is the scene's own choice.
struct SceneOptions {
  std::uint64_t seed = 1;
  std::optional<std::uint32_t> count;  ///< bodies, 1 or more
  std::optional<double> stiffness;     ///< N/m of each spring
  std::optional<double> damping;       ///< N s/m of each spring
  std::optional<double> mass;          ///< kg of each body
  std::optional<double> scale;         ///< times the size of each body
  std::string meshFile;                ///< of the scene "mesh"
};

/// How a body is drawn; plain data, so that scenes need no renderer.
struct BodyLook {
  Eigen::Vector3f colour = Eigen::Vector3f(0.85f, 0.47f, 0.32f);  ///< sRGB, 0 to 1
  bool smooth = false;                                            ///< shaded as a curved surface
  bool checkered = false;
};

struct RigidLook {
  const btRigidBody* body;
  Eigen::Vector3f colour;  ///< sRGB, 0 to 1
};

struct FloorProp {
  double height = 0.0;     ///< m, as drawn
  double halfSize = 10.0;  ///< m
};

/// What a picture should show: a box, looked at along -direction.
struct View {
  Eigen::AlignedBox3d box;
  Eigen::Vector3d direction = Eigen::Vector3d(0.5, 0.45, 1.0);
};

struct Scene;
/// Why the state is not as it should be, or an empty string.
using Check = std::function<std::string(const Scene&)>;

/// A world with soft bodies, how to look at it, and what must hold when all has come to rest.
struct Scene {
  std::unique_ptr<SceneWorld> world = std::make_unique<SceneWorld>();
  std::unique_ptr<SoftBodySystem> soft = std::make_unique<SoftBodySystem>(world->dynamics);

  std::vector<BodyLook> looks;        ///< #bodies, in the order of soft->body(i)
  std::vector<RigidLook> rigidLooks;  ///< of all rigid bodies but the floor
  FloorProp floor;
  View view;

  std::vector<Check> endChecks;    ///< in the order in which they are worth reporting
  std::vector<std::string> notes;  ///< what the user should know before the run
  RestWatch watch;

  std::int64_t ticks = 0;                  ///< so far
  std::function<void(Scene&)> beforeTick;  ///< what the scene drives, or empty
  std::function<void(Scene&)> afterTick;   ///< what is watched all along, or empty
};

using SceneResult = Result<std::unique_ptr<Scene>>;

/// Adds the floor: a box with its top at y = 0, and its picture `drawnHeight` above. Point masses are
/// spheres, so a resting surface is one radius above what it rests on; drawing the floor there closes the
/// gap.
void addFloor(Scene& scene, double halfSize, double drawnHeight, double friction = 0.5);

/// Adds a body. Returns the reason why that cannot be done, or an empty string.
std::string addBody(Scene& scene, SharedNetwork network, const SoftBodySettings& settings,
                    const BodyLook& look);

/// Add what moves and how it is drawn; mass in kg, 0: kinematic.
btRigidBody& addBall(Scene& scene, const Eigen::Vector3d& centre, double radius, double mass,
                     const Eigen::Vector3f& colour);
btRigidBody& addBox(Scene& scene, const Eigen::Vector3d& centre, const Eigen::Vector3d& halfExtents,
                    double mass, const Eigen::Vector3f& colour);

/// Overwrites what the user has chosen.
void apply(const SceneOptions& options, SoftBodySettings& settings);

/// Slows the points of all bodies as air does: a share of about `perSecond` of their velocity per second.
void addAirDrag(Scene& scene, double perSecond);

/// What a tick took, milliseconds.
struct TickTimes {
  double total = 0.0;
  TickProfile soft;  ///< the plugin's own part of it
};

/// Adds the times and work of one step to a sum.
void add(TickProfile& sum, const TickProfile& step);

/// Steps the world by 1/60 s.
TickTimes tick(Scene& scene);

/// The first end check that fails, or an empty string.
std::string checkEnd(const Scene& scene);

/// Of all bodies, bit for bit.
std::uint64_t stateHash(const Scene& scene);

std::size_t pointCount(const Scene& scene);
std::size_t springCount(const Scene& scene);

}  // namespace limber::scenes
