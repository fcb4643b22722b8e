// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/accuracy_row.h"
#include "row_progress.h"

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

/// Plays the scene with all engines that support it, at each length of ticks. The engines take turns of a few
/// ticks, so that the load of the machine is the same for all. In ordered scenes Limber is also run with 2, 4
/// and 8 times the substeps that it needs to be stable.
std::vector<AccuracyRow> measureScene(const Scene& scene, const std::vector<double>& ticks,
                                      RowProgress& progress);

}  // namespace limber::bench
