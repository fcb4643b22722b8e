// SPDX-License-Identifier: Zlib
#pragma once

#include <limber/limber.h>
#include <limber/soft_body_system.h>

#include <btBulletDynamicsCommon.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
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

/// A plain Bullet world under earth's gravity with the rigid bodies in it.
struct SceneWorld {
  // the world comes last, so that it goes first, while what is in it still exists
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

/// Adds a body of that mass in kg, or, with mass 0, a kinematic one, which the scene moves.
btRigidBody& addMovable(SceneWorld& world, std::unique_ptr<btCollisionShape> shape, double mass,
                        const Eigen::Vector3d& centre, double friction);

/// Moves a kinematic body; it gets there during the next tick.
void moveTo(btRigidBody& body, const Eigen::Vector3d& centre);

/// How far points have moved of late. Positions tell whether a body is calm; velocities do not: those of a
/// body that rests on a floor carry the phase of its substeps.
///
/// Keeps the box each point has stayed in, for the present half second and for the one before it.
class RestWatch {
 public:
  static constexpr std::int64_t kWindowTicks = 30;

  /// Call once after every tick.
  void look(const SoftBodySystem& soft);

  /// m, the largest diagonal of a point's box in the last half to whole second; infinite before the first
  /// half second is over, and for points that are not finite.
  double largestMotion() const;
  /// The same for the points of one body.
  double largestMotion(std::size_t body) const;

 private:
  using Boxes = std::vector<Eigen::AlignedBox3d>;

  std::vector<std::size_t> firstPoint_;  // #bodies + 1
  Boxes present_, before_;               // #points of all bodies
  std::int64_t ticks_ = 0;
};

constexpr std::int64_t kTicksPerSecond = 60;

/// When pictures are taken of a run of whole ticks. Frame k shows time k / fps: the world after the first
/// tick that does not end before it, or, if that ends later, between this tick and the one before. Integers
/// only, so that no rounding ever adds or drops a tick.
struct Timeline {
  std::int64_t ticks = 0;            ///< of the whole run
  std::int64_t framesPerSecond = 1;  ///< at least 1

  /// Ticks to do before frame k is drawn.
  std::int64_t ticksFor(std::int64_t frame) const;
  /// Where in the last of them frame k lies: above 0, and 1 at its end.
  double tickFraction(std::int64_t frame) const;
  /// Frames from time 0 to the end of the run, both included.
  std::int64_t frameCount() const;
};

/// The timeline of at least `seconds`.
Timeline timelineOf(double seconds, int framesPerSecond);

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
