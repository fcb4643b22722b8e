// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/reference.h"
#include "scene/scene.h"

namespace limber::bench {

/// Impacts make every scheme first order, so scenes with contacts are evaluated separately from free motion.
enum class Kind : std::uint8_t { Free, Contact };

/// The state of all bodies after a tick (or before the first).
struct Frame : BodyStates {
  std::vector<Eigen::Vector3d> boxes;  ///< centres of the scene's movable rigid bodies
  double contactImpulse = 0.0;         ///< N s, of all contacts during the tick
};

/// The result of a run: its last frames, dt apart. The last one is at the scene's end.
struct Trace {
  double dt = 0.0;
  std::vector<Frame> frames;

  const Frame& last() const { return frames.back(); }
};

/// Returns the values of read(frame).
template <class Read>
Signal signalOf(const Trace& trace, Read read) {
  Signal signal{trace.dt, {}};
  for (const Frame& frame : trace.frames) signal.samples.push_back(read(frame));
  return signal;
}

/// A kind of error.
struct Measure {
  std::string name;
  std::function<double(const Trace&)> error;  ///< NaN: the engine has no such measure
};

/// A situation with a known outcome, for any engine.
struct Scene : Scenario {
  Kind kind = Kind::Free;
  double seconds = 1.0;
  double keepSeconds = 1e9;       ///< length of the last part, which the measures need
  std::vector<Measure> measures;  ///< the main one first
  bool ordered = false;  ///< errors shrink with the step: an order is fitted, and finer substeps are run
  int finest = 8;        ///< Limber is run with 1, 2, 4 ... up to this many times the substeps that it needs;
                         ///< beyond 8 only at 60 ticks a second
  double periodTolerance = 0.0;  ///< above 0: Limber is also run with this value
  int copies = 1;                ///< of all bodies, far apart; times are per copy, the first copy is judged
  bool limberOnly = false;       ///< the other engines do not support it
  std::string remark;            ///< printed with the results, for orientation
};

/// Computes a scene and its reference solution when it is played.
struct SceneMaker {
  std::string name;
  std::function<Scene()> make;
};

/// With `quick` they are few and short.
std::vector<SceneMaker> freeScenes(bool quick);     // free_scenes.cpp: springs, chains, waves, shapes
std::vector<SceneMaker> contactScenes(bool quick);  // contact_scenes.cpp: impacts, rest, rigid partners

}  // namespace limber::bench
