// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// Plays one scene with one engine and measures the time of its ticks.
class Stage {
 public:
  /// Throws std::runtime_error if the engine does not support the scene.
  Stage(const Scene& scene, const EngineChoice& choice, double dt);

  bool over() const { return lost_ || tick_ >= ticks_; }
  void advance(int ticks);

  const Trace& trace() const { return trace_; }
  bool lost() const { return lost_; }  ///< a point has flown to infinity
  std::uint64_t hash() const;          ///< of the last frame, bit for bit
  const std::vector<double>& tickMicroseconds() const { return tickMicroseconds_; }
  const std::vector<double>& stepMicroseconds() const { return stepMicroseconds_; }  ///< empty if unknown

 private:
  Frame currentFrame() const;
  void record();

  const Scene& scene_;
  RigidBodies rigid_;  // declared before the engine, whose world refers to them
  std::unique_ptr<Engine> engine_;
  double dt_;
  int tick_ = 0, ticks_;
  bool lost_ = false;
  Trace trace_;
  std::vector<double> tickMicroseconds_, stepMicroseconds_;
};

}  // namespace limber::bench
