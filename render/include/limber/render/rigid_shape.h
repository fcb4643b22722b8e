// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/scenery.h"
#include "limber/render/shape_desc.h"
#include "limber/render/vec3.h"

namespace limber::render {

/// A surface that moves only as a whole, as a skin on four points: an instance streams 48 bytes a frame
/// however detailed it is, and may be moved, turned, stretched and sheared.
struct RigidShape {
  ShapeDesc shape;     ///< 4 points; its places are the points of the scenery it was made of.
  float reach = 1.0f;  ///< Metres from the first point to the others.
};

RigidShape makeRigid(const Scenery& scenery);

/// Where the origin comes to, and the three unit vectors.
struct Frame {
  Vec3 origin{0.0f, 0.0f, 0.0f};
  Vec3 x{1.0f, 0.0f, 0.0f};
  Vec3 y{0.0f, 1.0f, 0.0f};
  Vec3 z{0.0f, 0.0f, 1.0f};
};

/// Writes the points of an instance with `reach`, moved by `frame`: 4 x 3 floats; only writes, in order.
void writeFrame(float reach, const Frame& frame, float* xyz);

}  // namespace limber::render
