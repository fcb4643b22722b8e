// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/scene.h"

#include <limber/mesh.h>

#include <optional>

namespace limber::bench {

// --- scenes ---

/// The behaviour of bodies in a scene.
enum class Role : std::uint8_t { Airborne, Landing, Rest, Asleep, Cloth, Pile, Dense };

/// A situation whose cost is measured, the same for all engines.
struct ContactScene : Scenario {
  Role role = Role::Rest;
  std::function<double(const Eigen::Vector3d&)>
      distance;          ///< m, of a point from the rigid bodies; negative inside
  double size = 1.0;     ///< m, of a body
  int settleTicks = 10;  ///< ticks before the first measured one
  int measuredTicks = 60;
  int turn = 20;             ///< ticks of an engine before the next engine runs
  bool withOthers = true;    ///< false: Limber and loose spheres only
  bool withBudgets = false;  ///< Limber also with limited numbers of substeps

  bool sleeps() const { return role == Role::Asleep; }
  /// Whether all bodies are at rest during the measurement.
  bool rests() const { return role != Role::Airborne && role != Role::Landing; }
};

constexpr double kContactTick = 1.0 / 60;  // s
constexpr const char* kLooseSpheres = "loose spheres";

const char* nameOf(Role role);

std::vector<ContactScene> allContactScenes(bool quick);

/// Returns the outer triangles of side x side x side points in the order of latticeNetwork(), facing outward.
/// `side` is at least 2.
std::vector<Triangle> boxSurface(int side);

// --- a scene in an engine ---

/// A scene in one engine. Times are those of the thread, without those of other processes.
class ContactStage {
 public:
  /// Throws std::runtime_error with the reason if the engine does not support the scene.
  ContactStage(const ContactScene& scene, const EngineChoice& choice);

  /// Runs `ticks` ticks, or fewer at the end of the scene. Gives up if all ticks take longer than `timeLimit`
  /// (s) or more than two seconds each.
  void advance(int ticks, double timeLimit);
  bool over() const { return !error_.empty() || done_ >= scene_.settleTicks + scene_.measuredTicks; }
  /// Returns the reason why the scene did not finish, or an empty string.
  const std::string& error() const { return error_; }

  std::size_t points() const { return points_; }
  const std::vector<double>& ticks() const { return ticks_; }          ///< ms, measured ticks only
  const std::vector<double>& wallTicks() const { return wallTicks_; }  ///< ms, wall-clock time
  double asleep() const { return asleepShare(engine_->world()); }      ///< share of the movable objects
  double deepestPenetration() const;  ///< m, of points' spheres in rigid bodies, or of bodies in each other
  double stretch() const;             ///< root mean square strain of the springs along edges
  double residualSpeed() const;       ///< m/s over the last tick, root mean square over the points

 private:
  void tick();
  void checkPlaces();

  const ContactScene& scene_;
  bool solids_;
  RigidBodies rigid_;  // outlives the engine's world
  std::unique_ptr<Engine> engine_;
  std::size_t points_ = 0;
  int done_ = 0;
  double seconds_ = 0.0, laterSeconds_ = 0.0;
  std::vector<double> ticks_, wallTicks_;
  std::vector<Eigen::Matrix3Xd> before_;  // the last tick, #bodies
  std::string error_;
};

// --- engines and memory ---

/// Returns Limber with its default, with Collision::Points, and within budgets of substeps; btSoftBody with
/// 1, 4 (the reference) and 10 iterations; btDeformable; loose spheres.
///
/// btSoftBody's flags are the cheapest ones without loss, as measured by --set flags=yes (4 iterations, times
/// relative to SDF_RS | VF_SS, depth in the pile as a share of a body's size):
///
///                   512 cubes at rest   cloth   dense body   pile of 200, and how deep
///   SDF_RS                0.97          0.81       0.97       0.20   50 %: nothing holds them apart
///   SDF_RS | VF_SS        1             1          1          1      47 %
///   SDF_RS | CL_SS        1.9           0.82       0.98       4.4    42 %
///   CL_RS | CL_SS         3.7           0.67       1.06       4.5    23 %
///
/// SDF_RS is used where bodies do not touch each other, and SDF_RS | VF_SS in the pile. With CL_RS the cloth
/// is cheaper, but slips off the ball.
std::vector<EngineChoice> contactEngines();

/// Returns Limber as users have it: with the default volume term of closed bodies, which other benches omit.
EngineChoice usersLimber(const std::string& setting, const TuneSettings& tune = {},
                         const ParallelFor& parallelFor = {});

/// Bytes of Limber's bodies in a world after some ticks of free flight, with Bullet's objects for the points
/// and the overhead of the allocator, without the network, which bodies share.
struct MemoryUse {
  double perPoint = 0.0, perSpring = 0.0, perBody = 0.0;
  double networkPerSpring = 0.0;  ///< of a network, which all bodies of one shape share
};

/// Measures bodies that differ only in points or springs. Empty if the C library cannot report it (not
/// glibc).
std::optional<MemoryUse> measureMemory(bool quick);

}  // namespace limber::bench
