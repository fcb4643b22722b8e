// SPDX-License-Identifier: Zlib
#pragma once

#include "fuzz/story.h"

#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace limber::fuzz {

/// A law that does not hold, and how.
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
  double energy = 0.0;     ///< J, of all that is not held; heights count from y = 0
  bool near = false;       ///< a soft body is near a dynamic rigid one
  int rigidPairs = 0;      ///< how many pairs of rigid objects touched, at most, in its ticks
  std::uint64_t hash = 0;  ///< of all state, bit for bit
};

struct Run {
  std::vector<Frame> frames;
  std::optional<Failure> failure;  ///< the first
};

struct PlayOptions {
  bool softBodies = true;  ///< without them it is the rigid twin
  double nudge = 0.0;      ///< m, how far each soft body and each of its points starts from where it should
  int nudgeNumber = 0;     ///< other directions
};

Run play(const Story& story, const PlayOptions& options = {});

}  // namespace limber::fuzz
