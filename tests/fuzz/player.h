// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/story.h"

#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace limber::fuzz {

/// A law that does not hold, and the reason.
struct Failure {
  std::string law;
  std::string detail;
};

struct RigidPose {
  Eigen::Vector3d position;
  Eigen::Quaterniond rotation;
  bool dynamic = false;
};

/// The world after a call of stepSimulation().
struct Frame {
  std::map<int, Eigen::Matrix3Xd> soft;  ///< m, points of the soft bodies by id
  std::map<int, RigidPose> rigid;
  double energy = 0.0;     ///< J, of all dynamic bodies; heights are measured from y = 0
  bool near = false;       ///< a soft body is near a dynamic rigid one
  int rigidPairs = 0;      ///< largest number of touching pairs of rigid objects in its ticks
  std::uint64_t hash = 0;  ///< of the whole state, all bits
};

struct Run {
  std::vector<Frame> frames;
  std::optional<Failure> failure;  ///< the first
};

struct PlayOptions {
  bool softBodies = true;  ///< false: only the rigid objects, as "rigid twin" of the scene
  double nudge = 0.0;      ///< m, displacement of each soft body and of each of its points at the start
  int nudgeNumber = 0;     ///< selects the directions
  unsigned threads = 1;    ///< on which the soft bodies are stepped; 1: without setParallelFor()
};

Run play(const Story& story, const PlayOptions& options = {});

}  // namespace limber::fuzz
