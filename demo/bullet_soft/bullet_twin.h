// SPDX-License-Identifier: Zlib
#pragma once

#include "bullet_soft/bullet_soft_body.h"
#include "scenes/scene.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// A scene played by Bullet's own soft bodies.

namespace limber::bullet_soft {

/// The settings of btSoftBody, beside what it takes from the scene.
struct TwinSettings {
  int iterations = 10;     ///< piterations
  double stiffness = 0.0;  ///< kLST of all links; 0: for each link that of its spring, see calibrateLinks()
  double damping = 0.0;    ///< is added to kDP, which has the scene's linear drag
  double pressure = 0.0;   ///< Pa, of closed bodies, is added to that of the scene: kPR / volume at rest
  double friction = 1.0;   ///< kDF, times the friction of the scene
  double margin = 1.0;     ///< of collision, times the radius of the scene's points

  bool operator==(const TwinSettings& other) const;
};

/// A point that the mouse holds.
struct HeldPoint {
  std::size_t body = 0;
  std::uint32_t point = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< m, where it is pulled to
};

/// What can be compared of two engines: computed alike for both from places and velocities.
struct SpringFigures {
  double kinetic = 0.0, elastic = 0.0;  ///< J, elastic: of the springs alone
  double stretch = 0.0, largest = 0.0;  ///< RMS and largest strain of springs that do not act against bending
};

/// The second of two equal scenes. It takes the rigid bodies of a scene of its own, which moves them, and has
/// a btSoftBody for each soft body: a node for each point, a link for each spring, a face for each triangle,
/// the same masses, places, velocities and pins. Gravity, wind, stiffness and pins follow the other scene.
class BulletTwin {
 public:
  /// Returns which feature of the scene btSoftBody has no counterpart of, or an empty string.
  static std::string problemOf(const scenes::Scene& scene);
  /// Errors: those of problemOf().
  static Result<std::unique_ptr<BulletTwin>> create(std::unique_ptr<scenes::Scene> scene);
  ~BulletTwin();
  BulletTwin(const BulletTwin&) = delete;
  BulletTwin& operator=(const BulletTwin&) = delete;

  /// Steps it by 1/60 s, after `other`, the scene that it follows. It stops for good where it cannot follow.
  void tick(const scenes::Scene& other, const TwinSettings& settings, const std::optional<HeldPoint>& held);
  /// Takes the rigid bodies that have been added to scene().
  void takeRigidBodies();

  /// The scene of its rigid bodies and looks. Its soft bodies stay as they were made.
  scenes::Scene& scene() { return *scene_; }
  const scenes::Scene& scene() const { return *scene_; }
  const btSoftRigidDynamicsWorld& world() const { return world_; }
  std::size_t bodyCount() const { return bodies_.size(); }
  const btSoftBody& body(std::size_t b) const { return *bodies_[b].soft.body; }
  std::uint32_t pointCount(std::size_t b) const {
    return static_cast<std::uint32_t>(bodies_[b].pinned.size());
  }
  bool isPinned(std::size_t b, std::uint32_t i) const { return bodies_[b].pinned[i]; }
  Eigen::Vector3d position(std::size_t b, std::uint32_t i) const;  ///< m
  Eigen::Vector3d center(std::size_t b) const;                     ///< m, mean of the points
  /// Writes the places of the points of a body at a time between the last two ticks, x y z for each.
  void writePositions(std::size_t b, float* xyz, double tickFraction) const;

  /// Returns why it has stopped, or an empty string.
  const std::string& problem() const { return problem_; }
  /// Returns what btSoftBody does not have of this scene, for people; the scene is played without it.
  const std::vector<std::string>& notes() const { return notes_; }
  double tickMs() const { return tickMs_; }  ///< of the last tick
  SpringFigures figures() const;
  /// The same of the other scene, whose points have the same numbers.
  SpringFigures figuresOf(const scenes::Scene& other) const;
  /// Returns a hash of all places and velocities, to the bit.
  std::uint64_t stateHash() const;

 private:
  struct Body {
    BulletSoftBody soft;
    BodyStart start;
    double linearDrag = 0.0;   // 1/s
    double volume = 0.0;       // m^3 at rest; 0: it encloses none
    double stiffness = 0.0;    // N/m, that the links have
    std::vector<bool> pinned;  // #points
  };

  explicit BulletTwin(std::unique_ptr<scenes::Scene> scene);
  void addBody(const SoftBody& body);
  void follow(const scenes::Scene& other);
  void followBody(Body& body, const SoftBody& other);
  void apply(const TwinSettings& settings);
  void stiffen(Body& body);
  void pull(const HeldPoint& held);
  void blow(const scenes::Scene& other);
  bool isFinite() const;

  std::unique_ptr<scenes::Scene> scene_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<Body> bodies_;
  TwinSettings settings_;
  std::vector<std::string> notes_;
  std::string problem_;
  std::size_t staticsTaken_ = 0, movablesTaken_ = 0;
  double tickMs_ = 0.0;
};

}  // namespace limber::bullet_soft
