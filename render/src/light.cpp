// SPDX-License-Identifier: Zlib
#include "limber/render/light.h"

#include <algorithm>

#include "mat4.h"

namespace limber::render {

Light lightBox(Vec3 min, Vec3 max, Light light) {
  light.shadowCentre = 0.5f * (min + max);
  light.shadowRadius = std::max(1.02f * 0.5f * length(max - min), 1e-3f);
  return light;
}

}  // namespace limber::render
