// SPDX-License-Identifier: Zlib
#pragma once

#include <vector>

#include "limber/render/renderer.h"

namespace limber::render::test {

/// Returns the normals (for tubes: the side vectors) of an instance that were computed in the last frame:
/// 3 floats per point, or per skinned point if it has a skin. Throws std::runtime_error for flat shapes.
std::vector<float> readNormals(Renderer& renderer, InstanceId instance);

/// Returns the skinned points of an instance in the last frame: 3 floats each. Throws std::runtime_error
/// without a skin.
std::vector<float> readSkinnedPoints(Renderer& renderer, InstanceId instance);

}  // namespace limber::render::test
