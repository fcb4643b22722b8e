// SPDX-License-Identifier: Zlib
#pragma once

#include "scenes/scene.h"
#include "window/command.h"

#include <limber/grab.h>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <optional>

namespace limber::demo {

/// What a ray hits: a point of a soft body, or a dynamic rigid body.
struct Pick {
  SoftBody* soft = nullptr;                         ///< nullptr: a rigid body
  std::uint32_t point = 0;                          ///< of the soft body
  btRigidBody* rigid = nullptr;                     ///< nullptr: a soft body
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< m, of the point, or of the hit on the rigid body
  double distance = 0.0;                            ///< m along the ray
};

/// Returns the first body on the ray that can move. Thin bodies count that the ray narrowly misses.
std::optional<Pick> pick(const scenes::Scene& scene, const Ray& ray);

/// Returns the index of a soft body in its scene.
std::size_t indexOf(const scenes::Scene& scene, const SoftBody* body);

/// Holds a body with a spring to a place, as a hand does. The scene must outlive it.
class Hand {
 public:
  Hand() = default;
  ~Hand() { release(); }
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;

  /// Returns the reason why it does not hold the body, or an empty string.
  std::string grab(scenes::Scene& scene, const Pick& pick);
  /// Moves the place to the ray, at the distance at which the body was grabbed.
  void drag(const Ray& ray);
  void release();

  bool holds() const { return grab_.holds() || joint_ != nullptr; }
  Eigen::Vector3d place() const { return place_; }       ///< m, where it pulls to
  Eigen::Vector3d held() const;                          ///< m, of the point of the body
  std::uint32_t point() const { return grab_.point(); }  ///< of soft()
  SoftBody* soft() const { return grab_.body(); }        ///< nullptr: holds none

 private:
  void grabRigid(scenes::Scene& scene, const Pick& pick);

  Grab grab_;
  std::unique_ptr<btPoint2PointConstraint> joint_;
  btDiscreteDynamicsWorld* world_ = nullptr;
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();
  double distance_ = 0.0;
};

}  // namespace limber::demo
