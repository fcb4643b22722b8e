// SPDX-License-Identifier: Zlib
#pragma once

#include "demo_options.h"

#include <limber/render/camera.h>
#include <limber/render/light.h>

namespace limber::demo {

/// The camera at a share (0 to 1) of the run: as the options ask, or one that frames what the scene is about.
render::Camera cameraAt(const scenes::View& view, const DemoOptions& options, double share);

render::Light lightOf(const scenes::View& view);

}  // namespace limber::demo
