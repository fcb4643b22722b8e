// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_engines.h"

namespace limber::bench {

/// A scene in one engine. Times are the thread's own: what others take of the machine is not in them.
class ContactStage {
 public:
  /// Throws std::runtime_error with the reason when the engine cannot have the scene.
  ContactStage(const ContactScene& scene, const ContactEngine& engine);
  ~ContactStage();
  ContactStage(const ContactStage&) = delete;
  ContactStage& operator=(const ContactStage&) = delete;

  /// So many ticks, or fewer where the scene ends; gives up where they take longer than `timeLimit` in all
  /// or than two seconds each.
  void advance(int ticks, double timeLimit);
  bool over() const { return !error_.empty() || done_ >= scene_.settleTicks + scene_.measuredTicks; }
  /// Why it did not come to its end, or empty.
  const std::string& error() const { return error_; }

  std::size_t points() const { return points_; }
  const std::vector<double>& ticks() const { return ticks_; }          ///< ms, those measured
  const std::vector<double>& wallTicks() const { return wallTicks_; }  ///< ms by the clock on the wall
  double asleep() const { return asleepShare(engine_->world()); }      ///< share of what can move
  double deepestPenetration() const;  ///< m, of points' spheres in rigid bodies, or of bodies in one another
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
