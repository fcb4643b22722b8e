// SPDX-License-Identifier: Zlib
#pragma once

#include "support/bullet_world.h"

namespace limber::test {

/// Ways to make one flat floor of Bullet's shapes.
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

/// A static floor, cut into pieces of 1 m (the fine mesh: 0.1 m), through the origin: from x = -2 m to 8 m
/// and 2 m to both sides. It falls towards x by `slope` (rad).
void addTiledFloor(BulletWorld& bullet, FloorKind kind, double friction, double slope = 0.0);

}  // namespace limber::test
