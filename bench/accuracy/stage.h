// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/scene.h"

namespace limber::bench {

/// One engine that plays one scene, and the time it takes.
class Stage {
 public:
  /// Throws std::runtime_error when the engine cannot have what is in the scene.
  Stage(const Scene& scene, const EngineChoice& choice, double dt);

  bool over() const { return lost_ || tick_ >= ticks_; }
  void advance(int ticks);

  const Trace& trace() const { return trace_; }
  bool lost() const { return lost_; }  ///< something has left for infinity
  std::uint64_t hash() const;          ///< of the present state, bit for bit
  const std::vector<double>& tickMicroseconds() const { return tickMicroseconds_; }
  const std::vector<double>& stepMicroseconds() const {
    return stepMicroseconds_;
  }  ///< empty: not told apart

 private:
  Frame look() const;
  void record();

  const Scene& scene_;
  RigidBodies rigid_;  // before the engine: its world refers to them
  std::unique_ptr<Engine> engine_;
  double dt_;
  int tick_ = 0, ticks_;
  bool lost_ = false;
  Trace trace_;
  std::vector<double> tickMicroseconds_, stepMicroseconds_;
};

}  // namespace limber::bench
