// SPDX-License-Identifier: Zlib
#pragma once

#include "support/bullet_world.h"

namespace limber::test {

/// The shapes that one flat floor can consist of.
enum class FloorKind {
  Plane,
  Box,
  BoxTiles,
  Compound,
  HullTiles,
  CoarseMesh,
  FineMesh,
  MeshTiles,
  HeightField
};

inline constexpr FloorKind kFloorKinds[] = {
    FloorKind::Plane,    FloorKind::Box,       FloorKind::BoxTiles,
    FloorKind::Compound, FloorKind::HullTiles, FloorKind::CoarseMesh,
    FloorKind::FineMesh, FloorKind::MeshTiles, FloorKind::HeightField};

const char* nameOf(FloorKind kind);

/// Adds a static floor, cut into pieces of 1 m (the fine mesh: 0.1 m). Before the tilt it is at y = 0, from x
/// = -2 m to 8 m and from z = -2 m to 2 m. It falls towards x by `slope` (rad).
void addTiledFloor(BulletWorld& bullet, FloorKind kind, double friction, double slope = 0.0);

}  // namespace limber::test
