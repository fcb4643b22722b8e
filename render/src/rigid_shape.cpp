// SPDX-License-Identifier: Zlib
#include "limber/render/rigid_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace limber::render {
namespace {

float largestCoordinate(const std::vector<float>& points) {
  float largest = 0.0f;
  for (const float x : points) {
    largest = std::max(largest, std::abs(x));
  }
  return largest > 0.0f ? largest : 1.0f;
}

}  // namespace

// With p0 the origin and p1 to p3 at `reach` along the axes, a place (x, y, z) of the scenery is
//   p0 + (x / reach) (p1 - p0) + (y / reach) (p2 - p0) + (z / reach) (p3 - p0).
// Measured by its own size a surface has weights of at most 4, so that little is lost far from the
// world's origin.
RigidShape makeRigid(const Scenery& scenery) {
  RigidShape rigid{scenery.shape, largestCoordinate(scenery.points)};
  rigid.shape.pointCount = 4;
  Skin& skin = rigid.shape.skin;
  skin.first = {0};
  for (std::size_t i = 0; i + 2 < scenery.points.size(); i += 3) {
    const float x = scenery.points[i] / rigid.reach;
    const float y = scenery.points[i + 1] / rigid.reach;
    const float z = scenery.points[i + 2] / rigid.reach;
    skin.points.insert(skin.points.end(), {0, 1, 2, 3});
    skin.weights.insert(skin.weights.end(), {1.0f - x - y - z, x, y, z});
    skin.first.push_back(static_cast<std::uint32_t>(skin.weights.size()));
  }
  return rigid;
}

void writeFrame(float reach, const Frame& frame, float* xyz) {
  const Vec3 o = frame.origin;
  for (const Vec3 axis : {Vec3{}, frame.x, frame.y, frame.z}) {
    *xyz++ = o.x + reach * axis.x;
    *xyz++ = o.y + reach * axis.y;
    *xyz++ = o.z + reach * axis.z;
  }
}

}  // namespace limber::render
