// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/scenery.h"
#include "limber/render/shape_desc.h"
#include "limber/render/vec3.h"

namespace limber::render {

/// A surface that moves only as a whole. It is a skin on four points: an instance streams 48 bytes a frame,
/// however detailed it is. It can be moved, rotated, stretched and sheared.
struct RigidShape {
  ShapeDesc shape;     ///< 4 points; the places of its skin are the points of the scenery.
  float reach = 1.0f;  ///< Distance from the first point to each other point, m.
};

RigidShape makeRigid(const Scenery& scenery);

/// Position of a shape's origin and directions of its axes.
struct Frame {
  Vec3 origin{0.0f, 0.0f, 0.0f};
  Vec3 x{1.0f, 0.0f, 0.0f};
  Vec3 y{0.0f, 1.0f, 0.0f};
  Vec3 z{0.0f, 0.0f, 1.0f};
};

/// Writes the 4 points (12 floats) of an instance with this RigidShape::reach, moved by `frame`. Writes in
/// order and does not read the memory.
void writeFrame(float reach, const Frame& frame, float* xyz);

}  // namespace limber::render
