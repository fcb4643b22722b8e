// SPDX-License-Identifier: Zlib
#pragma once

namespace limber::render {

/// Three floats: a position or direction in metres, or a colour.
struct Vec3 {
  float x = 0.0f;
  float y = 0.0f;
  float z = 0.0f;
};

}  // namespace limber::render
