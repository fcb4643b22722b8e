// SPDX-License-Identifier: Zlib
#pragma once

#include "scene/rigid_bodies.h"

#include <limber/mesh.h>

namespace limber::bench {

/// The behaviour of bodies in a scene.
enum class Role : std::uint8_t { Airborne, Landing, Rest, Asleep, Cloth, Pile, Dense };

/// Number of bodies of the scenes with cubes. Quick runs have fewer of each.
enum class Crowd : std::uint8_t {
  Small,    ///< 64, and the stiff cloth
  Middle,   ///< 512, and the soft cloth
  Large,    ///< 4096, and the stiffest cloth
  RealTime  ///< 2560, at rest only
};

/// A situation whose cost is measured, the same for all engines.
struct ContactScene : Scenario {
  Role role = Role::Rest;
  Crowd crowd = Crowd::Small;
  std::function<double(const Eigen::Vector3d&)>
      distance;          ///< m, of a point from the rigid bodies; negative inside
  double size = 1.0;     ///< m, of a body
  int settleTicks = 10;  ///< ticks before the first measured one
  int measuredTicks = 60;
  int turn = 20;             ///< ticks of an engine before the next engine runs
  bool withOthers = true;    ///< false: Limber and loose spheres only
  bool withBudgets = false;  ///< Limber also with limited numbers of substeps

  bool sleeps() const { return role == Role::Asleep; }
  /// Whether all bodies are at rest during the measurement.
  bool rests() const { return role != Role::Airborne && role != Role::Landing; }
};

constexpr double kContactTick = 1.0 / 60;  // s
constexpr const char* kLooseSpheres = "loose spheres";

const char* nameOf(Role role);

std::vector<ContactScene> allContactScenes(bool quick);

/// Returns the outer triangles of side x side x side points in the order of latticeNetwork(), facing outward.
/// `side` is at least 2.
std::vector<Triangle> boxSurface(int side);

}  // namespace limber::bench
