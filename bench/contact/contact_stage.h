// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_scene.h"

namespace limber::bench {

/// A scene in one engine. Times are those of the thread, without those of other processes.
class ContactStage {
 public:
  /// Throws std::runtime_error with the reason if the engine does not support the scene.
  ContactStage(const ContactScene& scene, const EngineChoice& choice);
  ~ContactStage();
  ContactStage(const ContactStage&) = delete;
  ContactStage& operator=(const ContactStage&) = delete;

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

}  // namespace limber::bench
