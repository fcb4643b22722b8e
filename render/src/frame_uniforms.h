// SPDX-License-Identifier: Zlib
#pragma once

#include <array>

#include "limber/render/renderer.h"
#include "mat4.h"

namespace limber::render {

/// The uniform block of frame.glsl, in its memory layout.
struct FrameUniforms {
  using Vec4 = std::array<float, 4>;

  Mat4 viewProjection;
  Mat4 worldToShadow;
  Vec4 eye{};
  Vec4 towardsLight{};
  Vec4 sun{};
  Vec4 sky{};
  Vec4 ground{};
  Vec4 backgroundTop{};
  Vec4 backgroundBottom{};
  Vec4 viewport{};
};

struct PictureSize {
  int width = 0;
  int height = 0;
  int shadowMapSize = 0;
};

FrameUniforms makeFrameUniforms(const Camera& camera, const Light& light, const DrawOptions& options,
                                const PictureSize& size);

}  // namespace limber::render
