// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/arrangement.h"

#include <limber/cook.h>
#include <limber/limber.h>
#include <limber/soft_body_system.h>

#include <btBulletDynamicsCommon.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace limber::scenes {

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return btVector3(btScalar(v.x()), btScalar(v.y()), btScalar(v.z()));
}

inline Eigen::Vector3d fromBullet(const btVector3& v) {
  return {double(v.x()), double(v.y()), double(v.z())};
}

/// A plain Bullet world with earth's gravity and its rigid bodies.
struct SceneWorld {
  // the world is the last member, so that it is destroyed before its bodies
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> statics;
  std::vector<std::unique_ptr<btRigidBody>> movables;  ///< dynamic and kinematic ones
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};

  SceneWorld() { dynamics.setGravity(btVector3(0, btScalar(-9.81), 0)); }
  SceneWorld(const SceneWorld&) = delete;
  SceneWorld& operator=(const SceneWorld&) = delete;
};

/// Adds an immovable body of the given shape and friction.
btRigidBody& addStatic(SceneWorld& world, std::unique_ptr<btCollisionShape> shape,
                       const Eigen::Vector3d& centre, double friction);

/// Adds a body of that mass in kg; with mass 0 a kinematic one, which the scene moves.
btRigidBody& addMovable(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, double mass,
                        const Eigen::Vector3d& centre, double friction);

/// Moves a kinematic body; it arrives at the end of the next tick.
void moveTo(btRigidBody& body, const Eigen::Vector3d& centre);

/// Measures how far points have moved recently. It uses positions, because the velocities of a body that
/// rests on a floor depend on the phase of its substeps.
///
/// It keeps the bounding box of each point's positions, for the present half second and for the one before.
class RestWatch {
 public:
  static constexpr std::int64_t kWindowTicks = 30;

  /// Reads the positions; call it once after every tick.
  void look(const SoftBodySystem& soft);

  /// Returns the largest diagonal of the box of a point of the body in the last 0.5 to 1 s, m; infinite in
  /// the first half second and for points that are not finite.
  double largestMotion(std::size_t body) const;

 private:
  using Boxes = std::vector<Eigen::AlignedBox3d>;

  std::vector<std::size_t> firstPoint_;  // #bodies + 1
  Boxes present_, before_;               // #points of all bodies
  std::int64_t ticks_ = 0;
};

constexpr std::int64_t kTicksPerSecond = 60;

/// The times of the pictures of a run. Frame k shows the time k / fps: the state after the first tick that
/// ends at or after that time, or, if it ends later, a state between this tick and the one before. Integers
/// only, so that no rounding adds or drops a tick.
struct Timeline {
  std::int64_t ticks = 0;            ///< of the run
  std::int64_t framesPerSecond = 1;  ///< at least 1

  /// Returns the number of ticks before frame k.
  std::int64_t ticksFor(std::int64_t frame) const;
  /// Returns the position of frame k in the last of these ticks: above 0, and 1 at its end.
  double tickFraction(std::int64_t frame) const;
  /// Returns the number of frames from time 0 to the end of the run, both included.
  std::int64_t frameCount() const;
};

/// Returns a timeline of at least `seconds`.
Timeline timelineOf(double seconds, int framesPerSecond);

/// Materials of meshes: Material::jelly() and so on.
enum class Feel { Jelly, Rubber, Foam, Stiff };
Material materialOf(Feel feel);
/// Returns the feels by their names on the command line.
const std::map<std::string, Feel>& feels();

/// The user's choices. The scene chooses the missing ones.
struct SceneOptions {
  std::uint64_t seed = 1;
  std::optional<std::uint32_t> count;  ///< bodies, 1 or more
  std::optional<double> stiffness;     ///< N/m of each spring
  std::optional<double> damping;       ///< N s/m of each spring
  std::optional<double> mass;          ///< kg of each body
  std::optional<double> scale;         ///< times the size of each body

  // of the scene "mesh"
  std::string meshFile;
  Feel feel = Feel::Rubber;
  CookSettings cook;
  std::string cacheFolder;  ///< of cooked bodies; empty: none
};

/// How a surface reflects light, as the renderer knows it.
enum class Finish { Rubber, Jelly, Cloth, Metal };

/// Appearance of a body; plain data, so that scenes need no renderer.
struct BodyLook {
  Eigen::Vector3f colour = Eigen::Vector3f(0.85f, 0.47f, 0.32f);  ///< sRGB, 0 to 1
  bool smooth = false;                                            ///< shaded as a curved surface
  bool checkered = false;
  Finish finish = Finish::Rubber;
};

struct RigidLook {
  const btRigidBody* body;
  Eigen::Vector3f colour;  ///< sRGB, 0 to 1
  Finish finish = Finish::Rubber;
};

/// The view of a picture: a box, seen along -direction.
struct View {
  Eigen::AlignedBox3d box;
  Eigen::Vector3d direction = Eigen::Vector3d(0.5, 0.45, 1.0);
  bool follows = false;  ///< the picture grows with bodies that have landed and roll away
};

struct Scene;
/// Returns the reason why a check has failed, or an empty string.
using Check = std::function<std::string(const Scene&)>;

/// A world with soft bodies, its appearance, and its end checks.
struct Scene {
  std::unique_ptr<SceneWorld> world = std::make_unique<SceneWorld>();
  std::unique_ptr<SoftBodySystem> soft = std::make_unique<SoftBodySystem>(world->dynamics);

  std::vector<BodyLook> looks;        ///< #bodies, in the order of soft->body(i)
  std::vector<RigidLook> rigidLooks;  ///< of all rigid bodies except the floor
  double floorHalfSize = 10.0;        ///< m, of the grid on it
  View view;

  std::vector<Check> endChecks;    ///< the first failure is reported
  std::vector<std::string> notes;  ///< messages to the user before the run
  RestWatch watch;

  std::int64_t ticks = 0;                  ///< so far
  std::function<void(Scene&)> beforeTick;  ///< moves kinematic bodies, or empty
  std::function<void(Scene&)> afterTick;   ///< checks every tick, or empty
};

using SceneResult = Result<std::unique_ptr<Scene>>;

/// Radius (m) of points of bodies about 1 m large: little is to be seen between a body and the floor.
constexpr double kThinRadius = 0.004;

/// Adds the floor: a box with its top at y = 0. Its grid ends at `halfSize` (m), the box ten times farther.
/// Point masses are spheres, so a resting surface is one radius above the floor: see kThinRadius.
void addFloor(Scene& scene, double halfSize, double friction = 0.5);

/// Adds the floor below bodies of this size and radius (m) that fall in a grid, and frames them.
void addDropFloor(Scene& scene, const DropGridSettings& grid, double size, double radius);

/// Adds a body. Returns the reason of a failure, or an empty string.
std::string addBody(Scene& scene, SharedNetwork network, const SoftBodySettings& settings,
                    const BodyLook& look);

/// Builds the network of a cloth of this size (m) and so many cells; see buildCloth().
Result<SharedNetwork> clothNetwork(double width, double depth, std::uint32_t columns, std::uint32_t rows);

/// Returns the look of a cloth.
BodyLook clothLook(const Eigen::Vector3f& colour, bool checkered = true);

/// Adds an immovable body and its colour.
btRigidBody& addStatic(Scene& scene, std::unique_ptr<btCollisionShape> shape, const Eigen::Vector3d& centre,
                       double friction, const Eigen::Vector3f& colour);

/// Add a movable body and its colour; mass in kg, 0: kinematic.
btRigidBody& addBall(Scene& scene, const Eigen::Vector3d& centre, double radius, double mass,
                     const Eigen::Vector3f& colour);
btRigidBody& addBox(Scene& scene, const Eigen::Vector3d& centre, const Eigen::Vector3d& halfExtents,
                    double mass, const Eigen::Vector3f& colour);

/// Adds a note if bodies of this size (m) are outside the range in which contacts work best.
void noteOddSize(Scene& scene, double size);

/// Overwrites the settings that the user has chosen.
void apply(const SceneOptions& options, SoftBodySettings& settings);

/// Durations of a tick, ms.
struct TickTimes {
  double total = 0.0;
  TickProfile soft;  ///< the plugin's part
};

/// Steps the world by 1/60 s.
TickTimes tick(Scene& scene);

/// Returns the reason of the first end check that fails, or an empty string.
std::string checkEnd(const Scene& scene);

/// Returns a hash of the exact state of all bodies.
std::uint64_t stateHash(const Scene& scene);

std::size_t pointCount(const Scene& scene);
std::size_t springCount(const Scene& scene);

}  // namespace limber::scenes
