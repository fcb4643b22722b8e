// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_scene.h"

#include <optional>

namespace limber::bench {

/// The results of one engine's run of a scene. Empty if the engine failed.
struct ContactRow {
  std::string scene, engine;
  Role role = Role::Rest;
  Crowd crowd = Crowd::Small;
  std::size_t bodies = 0, points = 0;
  int repeats = 0;
  double tickMedian = 0.0, tickWorst = 0.0;  ///< ms of the thread
  double wallMedian = 0.0;                   ///< ms
  std::optional<double> toSoftBody;  ///< relative to btSoftBody's median with 4 iterations in the same repeat
  std::optional<double> toSpheres;   ///< relative to the loose spheres' median
  double penetration = 0.0;          ///< as a share of the body's size
  double residualSpeed = 0.0;        ///< m/s
  double asleep = 0.0;               ///< share of the movable objects
  double stretch = 0.0;              ///< root mean square strain of the springs along edges
  bool hasSprings = true;
  std::string error;  ///< reason for missing results, or empty

  bool ran() const { return error.empty(); }
  double microsecondsPerPoint() const { return 1e3 * tickMedian / static_cast<double>(points); }
};

std::vector<std::string> contactColumns();
std::vector<std::string> contactCells(const ContactRow& row);

}  // namespace limber::bench
