// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/vec3.h"

namespace limber::render {

/// One sun, plus ambient light that blends from ground to sky by the normal's height (y up).
/// Intensities are linear: 1 lights a facing white surface to white.
struct Light {
  Vec3 towards{0.45f, 0.8f, 0.4f};  ///< From the scene to the sun; need not be a unit vector.
  Vec3 sun{0.86f, 0.82f, 0.75f};
  Vec3 sky{0.36f, 0.40f, 0.46f};
  Vec3 ground{0.20f, 0.18f, 0.16f};

  bool shadows = true;
  /// Shadows are computed inside this sphere (metres); smaller is sharper.
  Vec3 shadowCentre{0.0f, 0.0f, 0.0f};
  float shadowRadius = 8.0f;
};

/// Returns `light` with its shadow sphere around a bounding box.
Light lightBox(Vec3 min, Vec3 max, Light light = {});

}  // namespace limber::render
